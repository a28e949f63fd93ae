#include "highlights.h"

#include "../render/camera_step.h"
#include "glossy_rays.h"

/// Luminaires with an opening are lit from a place on it at random: cells share these samples.
static rsv_highlight_light judged(const rsv_punctual_light *light)
{
    rsv_highlight_light l = { .is_nearby = !rsv_punctual_is_distant(light) };
    l.place = rsv_punctual_is_distant(light) ? v3_neg(light->direction) : light->position;
    if (rsv_punctual_is_extended(light)) return l;
    l.strength = rgb_luminance(light->intensity);
    if (light->kind == RSV_PUNCTUAL_LUMINAIRE) l.strength *= 1e20f; // times candelas
    return l;
}

void rsv_highlights_of(const rsv_lights *lights, rsv_highlights *h)
{
    h->count = lights->punctual_tree ? 0 : rsv_punctual_count(lights);
    if (h->count > RSV_SUMMED_LIGHTS) h->count = 0;
    for (uint32_t k = 0; k < h->count; k++)
        h->light[k] = judged(&lights->scene->light[lights->punctual[k]]);
}

float rsv_corners_variance(const rsv_rough_surface *s)
{
    const rsv_normal_change n = rsv_normal_change_of(s->scene->view, s->path->triangle);
    float squares = n.c * v3_dot(n.turn[0], n.turn[0]) - 2 * n.b * v3_dot(n.turn[0], n.turn[1]) +
                    n.a * v3_dot(n.turn[1], n.turn[1]);
    float per_metre = squares / n.squared_area;
    float cos = f_max(fabsf(v3_dot(s->point.geometric, s->wo)), 0.25f), pixel = s->path->width;
    return per_metre * pixel * pixel / (3 * cos); // two pixels wide, evenly seen
}

rsv_highlight_point rsv_highlight_point_of(
    const rsv_glossy_tile *t, uint32_t pixel, const rsv_rough_surface *surface, float variance)
{
    const rsv_rgb even = rgb(t->even[0][pixel], t->even[1][pixel], t->even[2][pixel]);
    return (rsv_highlight_point){ surface->point.position, surface->wo, surface->normal,
        t->alpha[pixel], rgb_luminance(even), variance };
}

float rsv_widen_highlights(rsv_rough_surface *s, bool moves, float variance)
{
    if (moves) variance = f_max(variance, RSV_PIXEL_VARIANCE * rsv_corners_variance(s));
    rsv_rough_widen(s, variance);
    return variance;
}

/// Cells have none of the highlights of lobes that transmit light: whole paths would have to spread them.
static bool transmits(const rsv_bsdf *bsdf) { return bsdf->transmission > 0 || bsdf->passed > 0; }

/// Pixels of a tile that show highlights.
typedef struct shown_tile {
    const rsv_light_view *solution;
    const rsv_glossy_task *task;
    const rsv_glossy_tile *tile;
    uint32_t column, row; ///< of its first pixel
    float (*radiance)[4];
} shown_tile;

/// Of a pixel, in a lane of `found`.
static rsv_rgb highlights_of(
    const shown_tile *t, uint32_t pixel, const rsv_highlight_lanes *found, uint32_t lane)
{
    const rsv_transport_scene *scene = &t->solution->scene;
    const rsv_highlights *h = t->task->highlights;
    rsv_vec3 place = v3(found->x[lane], found->y[lane], found->z[lane]);
    rsv_specular_path path = rsv_glossy_path(scene, t->task, t->tile, pixel, place);
    rsv_rough_surface surface;
    rsv_rgb sum = rgb_gray(0);
    rsv_rough_meet(scene, &path, &surface);
    bool all = transmits(surface.bsdf);
    const rsv_highlight_point at =
        rsv_highlight_point_of(t->tile, pixel, &surface, found->variance[lane]);
    float variance = rsv_widen_highlights(&surface, t->task->moves, at.variance);
    uint32_t row = t->row + pixel / RSV_TILE, column = t->column + pixel % RSV_TILE;
    uint32_t trail =
        rsv_hash3(rsv_pixel_seed(t->task->seed, row, column), 0x5f1bu, t->task->cells->frame);
    const rsv_rough_numbers numbers = rsv_rough_numbers_of(trail, path.triangle);
    for (uint32_t k = 0; k < h->count; k++)
        if (all || found->share[k][lane] < 1)
            sum = rgb_mad(sum, all ? 1 : 1 - rsv_highlight_left(&h->light[k], &at, variance),
                rsv_rough_light_from(&surface, t->solution->lights, k, numbers.light));
    return sum;
}

static void show_pixel(
    const shown_tile *t, uint32_t pixel, const rsv_highlight_lanes *found, uint32_t lane)
{
    const rsv_rgb sum = highlights_of(t, pixel, found, lane);
    const float light[3] = { sum.r, sum.g, sum.b };
    if (!isfinite(sum.r + sum.g + sum.b)) return;
    for (int c = 0; c < 3; c++)
        t->radiance[pixel][c] += t->tile->passed[c][pixel] * light[c];
}

/// Of sixteen pixels, those whose surface may transmit light.
static uint32_t transmitting(const shown_tile *t, uint32_t first)
{
    const rsv_transport_scene *scene = &t->solution->scene;
    uint32_t lanes = 0;
    for (uint32_t k = 0; k < RSV_LANES; k++)
        if (t->tile->depth[first + k] > 0) {
            uint32_t material = scene->view->triangle_material[t->tile->triangle[first + k]];
            lanes |= (uint32_t)transmits(&scene->bsdf[material]) << k;
        }
    return lanes;
}

void rsv_show_highlights(const rsv_glossy_rays *r, const rsv_glossy_task *task,
    const rsv_glossy_tile *tile, uint32_t column, uint32_t row, float (*radiance)[4])
{
    const shown_tile t = { r->table->solution, task, tile, column, row, radiance };
    rsv_highlight_lanes found;
    if (tile->count == 0 || task->highlights->count == 0) return;
    for (uint32_t first = 0; first < RSV_GLOSSY_TILE_PIXELS; first += RSV_LANES) {
        uint32_t lanes = r->kernels->find_highlights(task->highlights, tile, task->aim,
            (rsv_highlight_row){ column, row, first, task->moves }, &found);
        lanes |= transmitting(&t, first);
        for (; lanes; lanes &= lanes - 1) {
            uint32_t lane = (uint32_t)__builtin_ctz(lanes);
            show_pixel(&t, first + lane, &found, lane);
        }
    }
}
