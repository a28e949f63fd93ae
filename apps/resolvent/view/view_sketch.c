#include "view_sketch.h"

#include "../parallel.h"
#include "view_still.h"

#include "resolvent/trace.h"

#include <math.h>
#include <stdlib.h>

/// Radiance of white surfaces that face the camera, and the share of that which others keep.
#define FACING 0.6f
#define GRAZING 0.35f

/// Steps of the table of codes, by square roots.
enum { CODE_STEPS = 1024 };

struct cli_sketch {
    rsv_tracer *tracer;
    const rsv_scene_view *scene;
    uint32_t threads;
    rsv_rgb *front; ///< [material_count] of surfaces that face the camera
    rsv_rgb *glow;  ///< [material_count]
};

static rsv_vec3 mad(rsv_vec3 a, float s, rsv_vec3 b)
{
    return (rsv_vec3){ a.x + s * b.x, a.y + s * b.y, a.z + s * b.z };
}

static void choose_colors(cli_sketch *s)
{
    for (size_t k = 0; k < s->scene->material_count; k++) {
        const rsv_material *m = &s->scene->material[k];
        rsv_rgb c = m->base_color;
        s->front[k] = (rsv_rgb){ FACING * c.r, FACING * c.g, FACING * c.b };
        s->glow[k] = m->emission;
    }
}

rsv_status cli_sketch_create(const rsv_scene *scene, uint32_t threads, cli_sketch **sketch)
{
    cli_sketch *s = calloc(1, sizeof *s);
    if (!s) return RSV_ERROR_MEMORY;
    s->scene = rsv_scene_get_view(scene);
    s->threads = threads;
    s->front = calloc(s->scene->material_count + 1, sizeof *s->front);
    s->glow = calloc(s->scene->material_count + 1, sizeof *s->glow);
    rsv_status status = s->front && s->glow ? RSV_OK : RSV_ERROR_MEMORY;
    if (status == RSV_OK) status = rsv_tracer_create(scene, &s->tracer);
    if (status != RSV_OK) {
        cli_sketch_destroy(s);
        return status;
    }
    choose_colors(s);
    *sketch = s;
    return RSV_OK;
}

void cli_sketch_destroy(cli_sketch *s)
{
    if (!s) return;
    rsv_tracer_destroy(s->tracer);
    free(s->front);
    free(s->glow);
    free(s);
}

// ---- rays ---------------------------------------------------------------------------------------

/// Vectors from the middle of the picture to its right and upper edge.
typedef struct lens {
    const rsv_camera *camera;
    rsv_vec3 right, up;
    bool parallel;
} lens;

static lens lens_of(const rsv_camera *c, float aspect)
{
    float half = c->vertical_fov > 0 ? tanf(0.5f * c->vertical_fov) : c->vertical_extent;
    rsv_vec3 zero = { 0 };
    return (lens){ c, mad(zero, half * aspect, c->right), mad(zero, half, c->up),
        !(c->vertical_fov > 0) };
}

/// Rays of sixteen pixels of a row. @param first column of the first one
static void aim(
    const lens *l, uint32_t first, uint32_t row, const cli_canvas *canvas, rsv_ray_packet *packet)
{
    float y = 1 - 2 * ((float)row + 0.5f) / (float)canvas->height;
    for (uint32_t k = 0; k < RSV_PACKET_WIDTH; k++) {
        float x = 2 * ((float)(first + k) + 0.5f) / (float)canvas->width - 1;
        rsv_vec3 off = mad(mad((rsv_vec3){ 0 }, x, l->right), y, l->up);
        rsv_vec3 from = l->parallel ? mad(l->camera->position, 1, off) : l->camera->position;
        rsv_vec3 to = l->parallel ? l->camera->forward : mad(l->camera->forward, 1, off);
        packet->origin_x[k] = from.x;
        packet->origin_y[k] = from.y;
        packet->origin_z[k] = from.z;
        packet->direction_x[k] = to.x;
        packet->direction_y[k] = to.y;
        packet->direction_z[k] = to.z;
        packet->t_min[k] = packet->time[k] = 0;
        packet->t_max[k] = first + k < canvas->width ? INFINITY : -1;
        packet->mask[k] = UINT32_MAX;
        packet->id[k] = packet->flags[k] = 0;
        packet->triangle[k] = packet->geometry[k] = packet->instance[k] = RSV_NONE;
    }
}

/// Cosine between a ray and the normal where it ends.
static float facing(const rsv_ray_packet *p, uint32_t k)
{
    float dot = p->normal_x[k] * p->direction_x[k] + p->normal_y[k] * p->direction_y[k] +
                p->normal_z[k] * p->direction_z[k];
    float normal = p->normal_x[k] * p->normal_x[k] + p->normal_y[k] * p->normal_y[k] +
                   p->normal_z[k] * p->normal_z[k];
    float direction = p->direction_x[k] * p->direction_x[k] +
                      p->direction_y[k] * p->direction_y[k] + p->direction_z[k] * p->direction_z[k];
    float length = sqrtf(normal * direction);
    return length > 0 ? fminf(fabsf(dot) / length, 1) : 0;
}

/// Codes of radiance up to the brightest, looked up instead of computed.
typedef struct tone {
    uint8_t code[CODE_STEPS + 1];
    float scale; ///< of radiance, to 0..1
} tone;

static tone tone_of(const cli_view_state *state)
{
    // how bright a scene is shown says nothing of a sketch
    float exposure = exp2f(state->exposure - state->own_exposure);
    float brightest = state->soft ? 64 : 1;
    tone t = { .scale = exposure / brightest };
    for (int k = 0; k <= CODE_STEPS; k++) {
        float root = (float)k / CODE_STEPS;
        t.code[k] = cli_tone_code(brightest * root * root, 1, state->soft);
    }
    return t;
}

static uint8_t code_of(const tone *t, float radiance)
{
    return t->code[(int)(CODE_STEPS * sqrtf(fminf(fmaxf(radiance * t->scale, 0), 1)) + 0.5f)];
}

static void shade(
    const cli_sketch *s, const rsv_ray_packet *p, uint32_t k, const tone *t, uint8_t pixel[4])
{
    rsv_rgb c = { 0 };
    if (p->triangle[k] != RSV_NONE) {
        uint32_t material = s->scene->triangle_material[p->triangle[k]];
        float light = GRAZING + (1 - GRAZING) * facing(p, k);
        rsv_rgb front = s->front[material], glow = s->glow[material];
        c = (rsv_rgb){ front.r * light + glow.r, front.g * light + glow.g,
            front.b * light + glow.b };
    }
    pixel[0] = code_of(t, c.r);
    pixel[1] = code_of(t, c.g);
    pixel[2] = code_of(t, c.b);
    pixel[3] = 255;
}

typedef struct drawing {
    const cli_sketch *sketch;
    tone tone;
    lens lens;
    const cli_canvas *canvas;
} drawing;

static void draw_row(const drawing *d, uint32_t row)
{
    rsv_ray_packet packet;
    const cli_canvas *canvas = d->canvas;
    uint8_t(*pixel)[4] = canvas->pixel + (size_t)row * canvas->width;
    for (uint32_t first = 0; first < canvas->width; first += RSV_PACKET_WIDTH) {
        aim(&d->lens, first, row, canvas, &packet);
        rsv_tracer_closest_packet(d->sketch->tracer, &packet, true);
        for (uint32_t k = 0; k < RSV_PACKET_WIDTH && first + k < canvas->width; k++)
            shade(d->sketch, &packet, k, &d->tone, pixel[first + k]);
    }
}

static void draw_rows(void *job, size_t begin, size_t end)
{
    for (size_t row = begin; row < end; row++)
        draw_row(job, (uint32_t)row);
}

void cli_sketch_draw(const cli_sketch *s, cli_view_state *state, cli_canvas *canvas)
{
    state->aspect = (float)canvas->width / (float)canvas->height;
    drawing d = { s, tone_of(state), lens_of(&state->camera, state->aspect), canvas };
    cli_parallel_for(s->threads, canvas->height, 8, draw_rows, &d);
}
