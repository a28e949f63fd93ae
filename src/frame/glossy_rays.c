#include "glossy_rays.h"

#include "../render/camera_path.h"
#include "../scene/material_at.h"
#include "../trace/packet.h"

#include <string.h>

/// Lobes narrower than this send more rays: they cannot share them.
#define NARROW_ALPHA 0.06f
/// Samples from which on a cell sends fewer rays, where its lobe shows much; fewer do where it shows less.
#define ENOUGH_SAMPLES 24.0f
#define LEAST_SAMPLES 4.0f
/// Narrow lobes and cells of few samples take every turn if they show more than the first share of their pixel, and
/// every fourth one below the second.
#define MUCH_SHOWN 0.25f
#define LITTLE_SHOWN 0.05f
/// Specular events behind a lobe's ray.
#define MOST_EVENTS 4
/// Events of the paths that lobes of rough glass are followed by: as in pictures, because light is often reflected within
/// bodies. Among frosted spheres, 4 events would miss 31 % of the light, 16 still 3 %.
#define WHOLE_EVENTS RSV_CAMERA_PATH_DEPTH
/// Highlights of punctual lights that reflections show are as of lobes wider by so much, radian^2: one ray stands for
/// several cells, and would otherwise spread the image of a highlight, small and hundreds of times as bright, over all
/// of them.
#define REFLECTED_VARIANCE 0.1f
/// Light counts as seen at least so much, however dark the lobe.
#define LEAST_SHARE 0.01f

void rsv_glossy_rays_create(
    const rsv_packet_kernels *kernels, const rsv_light_table *table, rsv_glossy_rays *r)
{
    memset(r, 0, sizeof *r);
    r->kernels = kernels;
    r->table = table;
    memset(r->packet.mask, 0xff, sizeof r->packet.mask);
}

static const rsv_transport_scene *scene_of(const rsv_glossy_rays *r)
{
    return &r->table->solution->scene;
}

/// Sources that are met are shown unless single layers without them are.
static bool shows_sources(const rsv_glossy_rays *r) { return rsv_shows_emission(r->table); }

// ---- hits ----------------------------------------------------------------------------------------

static rsv_specular_path path_of(const rsv_glossy_rays *r, uint32_t lane)
{
    const rsv_ray_packet *p = &r->packet;
    rsv_vec3 direction = v3(p->direction_x[lane], p->direction_y[lane], p->direction_z[lane]);
    rsv_specular_path path =
        rsv_specular_begin(scene_of(r), NULL, direction, rsv_packet_hit(p, lane));
    path.back = rsv_packet_meets_back(p, lane);
    path.events = 1;
    rsv_specular_set_spread(&path, 4 * RSV_GATHER_SPREAD, p->t_max[lane]);
    return path;
}

/// Emission of a surface, as far as it is not aimed at.
static rsv_rgb emission_met(
    const rsv_glossy_rays *r, uint32_t lane, const rsv_specular_path *path, rsv_rgb emission)
{
    if (rgb_is_black(emission) || !shows_sources(r)) return rgb_gray(0);
    return rgb_scale(emission, rsv_rough_emission_weight(scene_of(r), r->table->solution->lights,
                                   path, &r->departure[lane]));
}

static rsv_rgb looked_up(const rsv_glossy_rays *r, uint32_t lane)
{
    rsv_float4 light = rsv_light_in_cell(r->table->cell, rsv_packet_place(&r->places, lane));
    return rgb(light[0], light[1], light[2]);
}

/// A plain diffuse surface: the table has its emission, too.
static rsv_rgb stored_met(const rsv_glossy_rays *r, uint32_t lane)
{
    rsv_rgb shown = looked_up(r, lane);
    uint32_t material = scene_of(r)->view->triangle_material[r->packet.triangle[lane]];
    const rsv_bsdf *bsdf = &scene_of(r)->bsdf[material];
    if (!bsdf->emissive || !shows_sources(r)) return shown;
    rsv_specular_path path = path_of(r, lane);
    if (!rsv_side_shows_emission(bsdf, path.back)) return shown;
    rsv_rgb counted = emission_met(r, lane, &path, bsdf->emission);
    return rgb_add(rgb_positive(rgb_sub(shown, bsdf->emission)), counted);
}

/// A surface that a row of rsv_glossy_material describes, and the base colour.
static rsv_rgb glossy_met(const rsv_glossy_rays *r, uint32_t lane)
{
    const rsv_ray_packet *p = &r->packet;
    const rsv_scene_view *view = scene_of(r)->view;
    const rsv_glossy_material *m =
        &r->table->glossy->material[view->triangle_material[p->triangle[lane]]];
    rsv_vec3 normal = v3(p->normal_x[lane], p->normal_y[lane], p->normal_z[lane]);
    rsv_vec3 direction = v3(p->direction_x[lane], p->direction_y[lane], p->direction_z[lane]);
    float cos = fabsf(v3_dot(normal, direction)) / f_max(v3_length(normal), 1e-30f);
    const float *row = m->row[(int)(sqrtf(f_min(cos, 1)) * (RSV_TABLE_COS - 1) + 0.5f)];
    rsv_rgb color = rgb(m->base_color[0], m->base_color[1], m->base_color[2]);
    if (m->odd_color || rsv_glossy_has(m, RSV_GLOSSY_COLOR))
        color = rsv_base_color_at(view, p->triangle[lane], p->u[lane], p->v[lane],
            4 * RSV_GATHER_SPREAD * p->t_max[lane]);
    rsv_rgb sent =
        rgb(color.r * row[0] + row[4], color.g * row[1] + row[5], color.b * row[2] + row[6]);
    rsv_rgb shown = rgb_scale(rgb_mul(looked_up(r, lane), sent), 1 / RSV_PI);
    rsv_rgb emission = rgb(m->emission[0], m->emission[1], m->emission[2]);
    if (rgb_is_black(emission)) return shown;
    rsv_specular_path path = path_of(r, lane);
    return rgb_add(shown, emission_met(r, lane, &path, emission));
}

/// Light found by paths behind mirrors and glass.
typedef struct found {
    const rsv_glossy_rays *rays;
    rsv_rgb radiance;
} found;

static void add_diffuse(void *user, const rsv_specular_path *path, rsv_rgb weight)
{
    found *f = user;
    const rsv_light_table *table = f->rays->table;
    rsv_bsdf storage;
    uint32_t face = table->solution->elements->face_of[path->back][path->triangle];
    if (face == RSV_NONE) return;
    const rsv_bsdf *bsdf = rsv_specular_bsdf(scene_of(f->rays), path, &storage);
    rsv_rgb shown = rsv_shown_reflected(table, face, bsdf->base_color, path->u, path->v);
    f->radiance = rgb_add(f->radiance, rgb_mul(weight, shown));
}

/// The rest of a path, one by one. Branches that are faint to the eye play roulette. @param own emission of its first
/// surface is left out @param share of the light that the camera sees @param no_highlights see rsv_camera_setting
static rsv_rgb follow(const rsv_glossy_rays *r, const rsv_specular_path *path, uint32_t trail,
    rsv_rgb own, float share, bool no_highlights)
{
    const rsv_camera_setting setting = { .scene = scene_of(r),
        .lights = r->table->solution->lights,
        .max_events = path->events > 0 ? path->events + MOST_EVENTS : WHOLE_EVENTS,
        .widening = REFLECTED_VARIANCE,
        .no_highlights = no_highlights };
    found f = { r, rgb_gray(0) };
    rsv_specular_path seen = *path;
    seen.weight = rgb_scale(seen.weight, share);
    rsv_rgb sources = rsv_camera_path(&setting, seen, trail, NULL, add_diffuse, &f);
    sources = rgb_positive(rgb_sub(sources, rgb_scale(own, share)));
    if (shows_sources(r)) f.radiance = rgb_add(f.radiance, sources);
    return rgb_scale(f.radiance, 1 / share);
}

/// Fraction of a lane's light that the camera sees.
static float share_seen(const rsv_glossy_rays *r, uint32_t lane)
{
    return f_min(f_max(rgb_max(r->weight[lane]), LEAST_SHARE), 1);
}

/// A surface of any other kind.
static rsv_rgb other_met(const rsv_glossy_rays *r, uint32_t lane)
{
    rsv_bsdf storage;
    rsv_specular_path path = path_of(r, lane);
    const rsv_bsdf *bsdf = rsv_specular_bsdf(scene_of(r), &path, &storage);
    bool glows = rsv_side_shows_emission(bsdf, path.back);
    rsv_rgb emission = glows ? rgb_scale(bsdf->emission, bsdf->opacity) : rgb_gray(0);
    rsv_rgb shown = emission_met(r, lane, &path, emission);
    uint32_t face = r->table->solution->elements->face_of[path.back][path.triangle];
    if (face == RSV_NONE || bsdf->diffuse == 0 || bsdf->opacity < 1)
        return rgb_add(
            shown, follow(r, &path, r->trail[lane], emission, share_seen(r, lane), false));
    rsv_vec3 normal =
        v3(r->packet.normal_x[lane], r->packet.normal_y[lane], r->packet.normal_z[lane]);
    float cos = fabsf(v3_dot(normal, path.direction)) / f_max(v3_length(normal), 1e-30f);
    rsv_rgb base = rgb_scale(rgb_mul(bsdf->base_color, rsv_bsdf_exit(bsdf, cos)), bsdf->diffuse);
    rsv_rgb sent = rgb_add(base, rsv_glossy_albedo(bsdf, cos));
    rsv_rgb even = rsv_shown_reflected(r->table, face, rgb_gray(1), path.u, path.v);
    return rgb_add(shown, rgb_mul(sent, even));
}

/// Whether glossy_met describes a surface. Of metal, no light is stored, so the ray goes on from it; where textures
/// change what a lobe is, the mean of their product is not the product of their means.
static bool is_even(const rsv_glossy_rays *r, uint32_t lane)
{
    uint32_t material = scene_of(r)->view->triangle_material[r->packet.triangle[lane]];
    const rsv_glossy_material *m = &r->table->glossy->material[material];
    return !m->bare && !rsv_glossy_varies(m);
}

static rsv_rgb light_met(const rsv_glossy_rays *r, uint32_t lane)
{
    const rsv_ray_packet *p = &r->packet;
    if (p->triangle[lane] == RSV_NONE) {
        rsv_vec3 direction = v3(p->direction_x[lane], p->direction_y[lane], p->direction_z[lane]);
        if (!shows_sources(r)) return rgb_gray(0);
        return rsv_rough_sky(r->table->solution->lights, direction, &r->departure[lane]);
    }
    bool back = rsv_packet_meets_back(p, lane);
    switch (rsv_shown_side_of(r->table, p->triangle[lane], back)->kind) {
    case RSV_SHOWN_STORED:
        return stored_met(r, lane);
    case RSV_SHOWN_GLOSSY:
        return is_even(r, lane) ? glossy_met(r, lane) : other_met(r, lane);
    default:
        return other_met(r, lane);
    }
}

// ---- packets ------------------------------------------------------------------------------------

static void put_sample(
    const rsv_glossy_cells *cells, size_t cell, rsv_rgb light, rsv_rgb albedo, float reach)
{
    const rsv_glossy_light *to = &cells->fresh;
    to->r[cell] = light.r / albedo.r;
    to->g[cell] = light.g / albedo.g;
    to->b[cell] = light.b / albedo.b;
    bool finite = isfinite(to->r[cell] + to->g[cell] + to->b[cell]);
    to->count[cell] = finite ? 1 : 0;
    to->reach[cell] = f_min(reach, 1e4f);
}

static void trace(rsv_glossy_rays *r, const rsv_glossy_cells *cells)
{
    if (r->count == 0) return;
    for (uint32_t k = r->count; k < RSV_LANES; k++)
        r->packet.t_max[k] = -1;
    rsv_tracer_closest_packet(scene_of(r)->tracer, &r->packet, false);
    r->kernels->approach(r->table, &r->packet);
    r->kernels->locate(r->table, &r->packet, &r->places);
    r->kernels->descend(r->table, &r->places);
    for (uint32_t k = 0; k < r->count; k++) {
        rsv_rgb light = rgb_add(r->known[k], rgb_mul(r->weight[k], light_met(r, k)));
        put_sample(cells, r->cell[k], light, r->albedo[k], r->packet.t_max[k]);
    }
    r->rays += r->count;
    r->count = 0;
}

// ---- from a cell --------------------------------------------------------------------------------

rsv_specular_path rsv_glossy_path(const rsv_transport_scene *scene, const rsv_glossy_task *task,
    const rsv_glossy_tile *tile, uint32_t pixel, rsv_vec3 place)
{
    const rsv_camera *c = &task->aim->lens.camera;
    rsv_vec3 seen = c->forward;
    if (c->vertical_fov != 0) seen = v3_normalize(v3_sub(place, c->position));
    rsv_specular_path path = rsv_specular_begin(scene, NULL, seen,
        (rsv_hit){ tile->triangle[pixel], tile->depth[pixel], tile->u[pixel], tile->v[pixel] });
    rsv_specular_set_spread(&path, task->spread, tile->depth[pixel]);
    return path;
}

/// Of the lobes themselves.
static rsv_rgb albedo_of(const rsv_glossy_tile *tile, uint32_t pixel)
{
    float albedo[3];
    for (int c = 0; c < 3; c++)
        albedo[c] = f_min(tile->albedo[c][pixel], 1) / tile->passed[c][pixel];
    return rgb(albedo[0], albedo[1], albedo[2]);
}

/// Lobes that refract or let light pass are followed by whole paths.
static void sample_whole(rsv_glossy_rays *r, const rsv_glossy_task *task,
    const rsv_specular_path *path, uint32_t trail, size_t cell, rsv_rgb albedo)
{
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_specular_bsdf(scene_of(r), path, &storage);
    bool glows = rsv_side_shows_emission(bsdf, path->back);
    rsv_rgb own = glows ? rgb_scale(bsdf->emission, bsdf->opacity) : rgb_gray(0);
    found base = { r, rgb_gray(0) };
    rsv_bsdf_branches branches = rsv_specular_branches(scene_of(r), path);
    if (!rgb_is_black(branches.diffuse)) add_diffuse(&base, path, branches.diffuse);
    rsv_rgb light =
        rgb_sub(follow(r, path, trail, own, 1, task->highlights->count > 0), base.radiance);
    r->rays++;
    put_sample(task->cells, cell, rgb_positive(light), albedo, 0);
}

/// Variance of the normals of a cell's pixels. @param pixel one of them
static float pixels_variance(const rsv_glossy_tile *tile, uint32_t pixel)
{
    uint32_t first = pixel & ~(1u | RSV_TILE);
    rsv_vec3 sum = v3(0, 0, 0);
    float count = 0;
    for (uint32_t k = 0; k < 4; k++) {
        uint32_t at = first + (k & 1) + (k >> 1) * RSV_TILE;
        if (!(tile->depth[at] > 0)) continue;
        sum = v3_add(sum, v3(tile->normal[0][at], tile->normal[1][at], tile->normal[2][at]));
        count++;
    }
    return rsv_normals_variance(sum.x, sum.y, sum.z, count);
}

/// The shares of highlights that cells show.
static rsv_rgb left_to_cells(const rsv_glossy_task *task, const rsv_lights *lights,
    const rsv_rough_surface *surface, const rsv_highlight_point *at, const float u[3])
{
    const rsv_highlights *h = task->highlights;
    rsv_rgb sum = rgb_gray(0);
    rsv_rough_surface wide;
    rsv_rough_meet(surface->scene, surface->path, &wide);
    float variance = rsv_widen_highlights(&wide, task->moves, at->variance);
    for (uint32_t k = 0; k < h->count; k++)
        sum = rgb_mad(sum, rsv_highlight_left(&h->light[k], at, variance),
            rsv_rough_light_from(&wide, lights, k, u));
    return sum;
}

/// Light of sampled sources in a lobe. Highlights of punctual lights that pixels do not show by themselves are spread
/// over the cell, if they are smaller.
static rsv_rgb aimed_light(const rsv_glossy_rays *r, const rsv_glossy_task *task,
    const rsv_glossy_tile *tile, const rsv_rough_surface *surface, uint32_t pixel, const float u[3])
{
    const rsv_lights *lights = r->table->solution->lights;
    if (!shows_sources(r)) return rgb_gray(0);
    if (rsv_punctual_count(lights) == 0) return rsv_rough_light(surface, lights, false, u);
    float spread = pixels_variance(tile, pixel);
    if (task->highlights->count == 0) {
        rsv_rough_surface wide;
        rsv_rough_meet(surface->scene, surface->path, &wide);
        rsv_rough_widen(&wide, f_max(rsv_corners_variance(surface), spread));
        return rsv_rough_light_by(surface, &wide, lights, false, u);
    }
    const rsv_highlight_point at =
        rsv_highlight_point_of(tile, pixel, surface, task->moves ? RSV_PIXEL_VARIANCE * spread : 0);
    return rgb_add(rsv_rough_light_by(surface, NULL, lights, false, u),
        left_to_cells(task, lights, surface, &at, u));
}

/// Sends the ray of a cell, together with others. The next of `known` has its light of sampled sources.
static void sample_lobe(rsv_glossy_rays *r, const rsv_glossy_task *task,
    const rsv_rough_surface *surface, uint32_t trail, size_t cell, rsv_rgb albedo)
{
    const rsv_rough_numbers numbers = rsv_rough_numbers_of(trail, surface->path->triangle);
    rsv_rgb known = r->known[r->count];
    rsv_bsdf_event event = rsv_rough_draw(surface, numbers.direction);
    rsv_ray ray;
    if (!rsv_rough_goes_on(&event) || event.lobe != RSV_LOBE_REFLECT ||
        !rsv_specular_depart(&surface->point, false, event.direction, &ray)) {
        put_sample(task->cells, cell, known, albedo, 0);
        return;
    }
    uint32_t k = r->count++;
    rsv_packet_set_ray(&r->packet, k, ray);
    r->packet.t_min[k] = 0;
    r->cell[k] = cell;
    r->weight[k] = event.weight;
    r->known[k] = known;
    r->albedo[k] = albedo;
    r->departure[k] = rsv_rough_depart(surface, event.direction, 0);
    r->trail[k] = rsv_branch_trail(trail, false);
    if (r->count == RSV_LANES) trace(r, task->cells);
}

static void sample(rsv_glossy_rays *r, const rsv_glossy_task *task, const rsv_glossy_tile *tile,
    uint32_t pixel, size_t cell)
{
    const rsv_glossy_geometry *g = &task->cells->now;
    rsv_vec3 place = v3(g->x[cell], g->y[cell], g->z[cell]);
    rsv_specular_path path = rsv_glossy_path(scene_of(r), task, tile, pixel, place);
    uint32_t trail = rsv_hash3(task->seed, (uint32_t)cell, task->cells->frame);
    rsv_rgb albedo = albedo_of(tile, pixel);
    rsv_rough_surface surface;
    rsv_rough_meet(scene_of(r), &path, &surface);
    if (surface.bsdf->transmission > 0 || surface.bsdf->passed > 0)
        sample_whole(r, task, &path, trail, cell, albedo);
    else {
        const rsv_rough_numbers numbers = rsv_rough_numbers_of(trail, path.triangle);
        r->known[r->count] = aimed_light(r, task, tile, &surface, pixel, numbers.light);
        sample_lobe(r, task, &surface, trail, cell, albedo);
    }
}

/// Whether a cell has few samples, judged by its position in the previous frame.
static bool is_poor(const rsv_glossy_cells *c, size_t cell)
{
    const rsv_glossy_geometry *g = &c->now, *b = &c->before;
    if (c->kept_before.count[cell] * c->keep < RSV_GLOSSY_POOR) return true;
    float cos = g->nx[cell] * b->nx[cell] + g->ny[cell] * b->ny[cell] + g->nz[cell] * b->nz[cell];
    return cos < 0.5f || fabsf(g->alpha[cell] - b->alpha[cell]) > 0.5f * g->alpha[cell];
}

/// Fraction of a pixel's light that is due to its lobe: as bright as uniform light; all of it for a mirror.
static float share_shown(
    const rsv_glossy_cells *c, size_t cell, const rsv_glossy_tile *tile, uint32_t pixel)
{
    float albedo = 0, even = 0;
    for (int k = 0; k < 3; k++) {
        albedo = f_max(albedo, tile->albedo[k][pixel]);
        even += tile->even[k][pixel];
    }
    float light = 0;
    if (c->before.depth[cell] > 0) // empty cells hold anything
        light = c->kept_before.r[cell] + c->kept_before.g[cell] + c->kept_before.b[cell];
    return even > 0 ? f_min(albedo * f_max(light / even, 1), 1) : 1;
}

/// Turns for each that a cell takes.
static uint32_t turns_per_ray(float shown)
{
    return shown > MUCH_SHOWN ? 1 : shown > LITTLE_SHOWN ? 2 : 4;
}

/// Whether it is a cell's turn. Those in one block of 4x2 take turns, and skip one or three of four once they have
/// enough.
static bool has_turn(
    const rsv_glossy_cells *c, size_t cell, uint32_t column, uint32_t row, float shown)
{
    const uint32_t turn[2][4] = { { 0, 4, 2, 6 }, { 5, 1, 7, 3 } };
    uint32_t wait = turn[row & 1][column & 3] - c->frame;
    uint32_t turns = turns_per_ray(shown);
    bool poor = is_poor(c, cell);
    if (c->now.alpha[cell] < NARROW_ALPHA)
        return (wait & ((poor ? 2 : 4) * turns - 1) & (RSV_GLOSSY_TURN - 1)) == 0;
    if (poor) return (wait & (c->poor_turn * turns - 1) & (RSV_GLOSSY_TURN - 1)) == 0;
    if (wait & (RSV_GLOSSY_TURN - 1)) return false;
    float count = c->kept_before.count[cell];
    float enough = f_max(ENOUGH_SAMPLES * f_min(4 * shown, 1), LEAST_SAMPLES);
    uint32_t round = wait / RSV_GLOSSY_TURN + (column >> 2) + (row >> 1);
    return (round & (count < enough ? 0 : count < 2 * enough ? 1 : 3)) == 0;
}

void rsv_glossy_rays_of_tile(rsv_glossy_rays *r, const rsv_glossy_task *task,
    const rsv_glossy_tile *tile, uint32_t column, uint32_t row)
{
    const rsv_glossy_cells *c = task->cells;
    _Alignas(64) int speaker[RSV_LANES];
    for (uint32_t line = 0; line < RSV_TILE / 2; line++) {
        r->kernels->fill_cells(tile, task->aim, (rsv_cell_row){ column, row, line }, c, speaker);
        size_t at = c->first + (size_t)(row / 2 + line) * c->stride + column / 2;
        for (uint32_t k = 0; k < RSV_LANES; k++)
            if (speaker[k] >= 0) {
                r->poor += is_poor(c, at + k);
                float shown = share_shown(c, at + k, tile, (uint32_t)speaker[k]);
                if (has_turn(c, at + k, k, line, shown))
                    sample(r, task, tile, (uint32_t)speaker[k], at + k);
            }
    }
    trace(r, c);
}
