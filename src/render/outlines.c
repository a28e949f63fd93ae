#include "outlines.h"

#include "../core/parallel.h"
#include "../trace/packet.h"

#include <math.h>
#include <string.h>

/// Rows of pixels that are found together.
#define BAND 16
/// Normals whose cosine is less belong to different surfaces.
#define SMOOTH 0.85f
/// So does a step out of both tangent planes by this part of the distance.
#define STEP 0.3f
/// Difference of the pixels on both sides, relative to the brighter one, from which an outline is visible. They count
/// as at least DARK times the picture's mean.
#define CONTRAST 0.2f
#define DARK 0.1f

/// What a camera ray meets.
typedef struct sight {
    rsv_vec3 place, normal;
    uint32_t object, material; ///< RSV_NONE = no surface
} sight;

typedef struct finder {
    const rsv_picture_job *job;
    const rsv_rgb *pixel;
    uint8_t *is_outline; ///< [height * width] out
    uint32_t width, height;
    float dark;
    rsv_share bands;
    _Atomic rsv_status result;
} finder;

/// Rows of pixels, and what their corners see.
typedef struct band {
    const finder *finder;
    sight *corner;  ///< [(BAND + 1) * (width + 1)]
    uint32_t first; ///< row
} band;

static sight sight_of(const finder *f, const rsv_ray_packet *packet, uint32_t lane)
{
    const rsv_scene_view *view = f->job->solution->scene.view;
    uint32_t triangle = packet->t_max[lane] < 0 ? RSV_NONE : packet->triangle[lane];
    sight s = { .object = RSV_NONE, .material = RSV_NONE };
    if (triangle == RSV_NONE) return s;
    s.place = rsv_packet_point(packet, lane);
    s.normal =
        v3_normalize(v3(packet->normal_x[lane], packet->normal_y[lane], packet->normal_z[lane]));
    s.object = view->triangle_object[triangle];
    s.material = view->triangle_material[triangle];
    return s;
}

static sight *corner_of(const band *b, uint32_t x, uint32_t y)
{
    return &b->corner[(size_t)(y - b->first) * (b->finder->width + 1) + x];
}

/// Traces up to a packet of corners.
static void look(const band *b, uint32_t x, uint32_t y)
{
    static const float middle[2] = { 0.5f, 0.5f };
    const finder *f = b->finder;
    uint32_t left = f->width + 1 - x, count = left < RSV_PACKET_WIDTH ? left : RSV_PACKET_WIDTH;
    rsv_ray_packet packet;
    memset(&packet, 0, sizeof packet);
    memset(packet.mask, 0xff, sizeof packet.mask);
    for (uint32_t k = 0; k < RSV_PACKET_WIDTH; k++) {
        rsv_ray ray = { .t_max = -1 };
        bool sees =
            k < count && rsv_film_ray(&f->job->film, (float)(x + k), (float)y, middle, &ray);
        if (!sees) ray.t_max = -1; // not traced
        rsv_packet_set_ray(&packet, k, ray);
    }
    rsv_tracer_closest_packet(f->job->solution->tracer, &packet, true);
    for (uint32_t k = 0; k < count; k++)
        *corner_of(b, x + k, y) = sight_of(f, &packet, k);
}

static bool is_apart(const sight *a, const sight *b)
{
    if (a->object != b->object || a->material != b->material) return true;
    if (a->object == RSV_NONE) return false;
    if (v3_dot(a->normal, b->normal) < SMOOTH) return true;
    rsv_vec3 way = v3_sub(b->place, a->place);
    float most = STEP * v3_length(way);
    return fabsf(v3_dot(way, a->normal)) > most && fabsf(v3_dot(way, b->normal)) > most;
}

/// Whether the corners of a pixel see different surfaces.
static bool is_crossed(const band *b, uint32_t x, uint32_t y)
{
    const sight *above = corner_of(b, x, y), *below = corner_of(b, x, y + 1);
    return is_apart(above, above + 1) || is_apart(below, below + 1) || is_apart(above, below) ||
           is_apart(above + 1, below + 1);
}

static float brightness(const finder *f, uint32_t x, uint32_t y)
{
    return rgb_luminance(f->pixel[(size_t)y * f->width + x]);
}

static bool differ(const finder *f, float a, float b)
{
    return fabsf(a - b) > CONTRAST * f_max(f_max(a, b), f->dark);
}

/// Whether there is visible contrast across a pixel: among its neighbours, as its own light must not choose its
/// samples.
static bool is_visible(const finder *f, uint32_t x, uint32_t y)
{
    uint32_t left = x > 0 ? x - 1 : 0, right = x + 1 < f->width ? x + 1 : x;
    uint32_t top = y > 0 ? y - 1 : 0, bottom = y + 1 < f->height ? y + 1 : y;
    return differ(f, brightness(f, left, y), brightness(f, right, y)) ||
           differ(f, brightness(f, x, top), brightness(f, x, bottom));
}

static void find_in_band(band *b, uint32_t index)
{
    const finder *f = b->finder;
    uint32_t end = (index + 1) * BAND < f->height ? (index + 1) * BAND : f->height;
    b->first = index * BAND;
    for (uint32_t y = b->first; y <= end; y++)
        for (uint32_t x = 0; x <= f->width; x += RSV_PACKET_WIDTH)
            look(b, x, y);
    for (uint32_t y = b->first; y < end; y++)
        for (uint32_t x = 0; x < f->width; x++)
            f->is_outline[(size_t)y * f->width + x] = is_crossed(b, x, y) && is_visible(f, x, y);
}

static void find_share(void *user, int worker)
{
    finder *f = user;
    rsv_context *context = f->job->solution->context;
    band b = { .finder = f };
    rsv_span span;
    b.corner = rsv_alloc(context, (BAND + 1) * ((size_t)f->width + 1), sizeof *b.corner);
    while (b.corner && rsv_share_take(&f->bands, worker, &span))
        find_in_band(&b, (uint32_t)span.begin);
    rsv_keep_failure(&f->result, b.corner ? RSV_OK : RSV_ERROR_MEMORY);
    rsv_free(context, b.corner);
}

static float mean_brightness(const finder *f)
{
    size_t pixels = (size_t)f->width * f->height;
    double sum = 0;
    for (size_t k = 0; k < pixels; k++)
        sum += (double)rgb_luminance(f->pixel[k]);
    return (float)(sum / (double)pixels);
}

rsv_status rsv_find_outlines(
    const rsv_picture_job *job, const rsv_image *picture, uint8_t *is_outline)
{
    finder f = { .job = job,
        .pixel = rsv_image_const_pixels(picture, 0),
        .is_outline = is_outline,
        .width = rsv_image_width(picture),
        .height = rsv_image_height(picture) };
    f.dark = DARK * mean_brightness(&f);
    f.bands = rsv_share_of((f.height + BAND - 1) / BAND, 1);
    rsv_parallel_workers(job->solution->context, f.bands.count, find_share, &f);
    return f.result;
}
