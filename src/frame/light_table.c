#include "light_table.h"

#include "../core/parallel.h"
#include "light_refinement.h"
#include "source_state.h"

#include <string.h>

static void add_field(
    rsv_field_sum *sum, const rsv_elements *elements, const rsv_rgb *value, float sign)
{
    if (elements && value) sum->part[sum->count++] = (rsv_stored_field){ elements, value, sign };
}

static void add_direct(rsv_field_sum *sum, const rsv_light_view *s)
{
    if (!s->fine.direct) {
        add_field(sum, s->elements, s->source, 1);
        return;
    }
    add_field(sum, s->elements, s->gathered, 1);
    add_field(sum, s->caustics.elements, s->caustics.caustic, 1);
    add_field(sum, s->fine.elements, s->fine.direct, 1);
}

static bool shows_direct(uint32_t layer) { return layer == RSV_NONE || layer == 1; }

static rsv_field_sum shown_fields(const rsv_light_view *s, uint32_t layer)
{
    rsv_field_sum sum = { .count = 0 };
    if (shows_direct(layer)) add_direct(&sum, s);
    if (layer == RSV_NONE) add_field(&sum, s->elements, s->indirect, 1);
    if (layer > 1 && layer - 1 < s->order_count)
        add_field(&sum, s->elements, s->order[layer - 1], 1);
    return sum;
}

/// The same of translucent surfaces: diffused.
static rsv_field_sum diffused_fields(const rsv_light_view *s, uint32_t layer)
{
    const rsv_diffused_level *d = &s->diffused;
    rsv_field_sum sum = { .count = 0 };
    if (shows_direct(layer)) add_field(&sum, d->elements, d->order[0], 1);
    if (layer == RSV_NONE) add_field(&sum, d->elements, d->indirect, 1);
    if (layer > 1 && layer - 1 < s->order_count)
        add_field(&sum, d->elements, d->order[layer - 1], 1);
    return sum;
}

/// The part of direct light that the diffused level does not resolve.
static rsv_field_sum detail_fields(const rsv_light_view *s, uint32_t layer)
{
    rsv_field_sum sum = { .count = 0 };
    if (!shows_direct(layer) || !s->fine.direct) return sum;
    add_direct(&sum, s);
    add_field(&sum, s->diffused.elements, s->diffused.entered, -1);
    return sum;
}

// ---- sides --------------------------------------------------------------------------------------

static bool is_stored(const rsv_light_view *s, uint32_t material)
{
    const rsv_bsdf *bsdf = &s->bsdf[material];
    bool translucent = s->diffused.material && s->diffused.material[material];
    if (rsv_hides_emission(bsdf)) return false;
    return bsdf->lambert && bsdf->opacity >= 1 && !translucent &&
           !s->scene.view->material_varies[material];
}

/// Cells before those of faces: a black one, then one for the emission of each material.
static uint32_t first_face_cell(const rsv_light_view *s)
{
    return 1 + (uint32_t)s->scene.view->material_count;
}

/// Whether rsv_glossy_material describes a side. Sides of bare metal have no face, nor have the insides of bodies, which
/// it does not describe.
static bool is_glossy(const rsv_light_table *t, uint32_t material, uint32_t face, bool back)
{
    const rsv_bsdf *bsdf = &t->solution->bsdf[material];
    if (!t->glossy || !t->glossy->material[material].plain) return false;
    bool seen = !back || (bsdf->double_sided && !bsdf->solid);
    return (face != RSV_NONE || bsdf->diffuse == 0) && seen;
}

static rsv_shown_side shown_side(const rsv_light_table *t, uint32_t triangle, bool back)
{
    const rsv_light_view *s = t->solution;
    uint32_t material = s->scene.view->triangle_material[triangle];
    uint32_t face = s->elements->face_of[back][triangle];
    if (is_glossy(t, material, face, back))
        return face == RSV_NONE
                   ? (rsv_shown_side){ 0, 0, RSV_SHOWN_GLOSSY }
                   : (rsv_shown_side){ t->face_cell[face], t->face_level[face], RSV_SHOWN_GLOSSY };
    if (!is_stored(s, material)) return (rsv_shown_side){ 1 + material, 0, RSV_SHOWN_CHAIN };
    if (back && !s->bsdf[material].double_sided) return (rsv_shown_side){ 0, 0, RSV_SHOWN_STORED };
    if (face == RSV_NONE) return (rsv_shown_side){ 1 + material, 0, RSV_SHOWN_STORED };
    return (rsv_shown_side){ t->face_cell[face], t->face_level[face], RSV_SHOWN_STORED };
}

static void fill_sides(rsv_light_table *t)
{
    for (int back = 0; back < 2; back++) {
        for (uint32_t k = 0; k < t->triangle_count; k++)
            t->side[k][back] = shown_side(t, k, back);
        bool sky = t->solution->lights->environment != NULL;
        t->side[t->triangle_count][back] =
            (rsv_shown_side){ 0, 0, sky ? RSV_SHOWN_SKY : RSV_SHOWN_STORED };
    }
}

static rsv_status number_cells(rsv_light_table *t)
{
    const rsv_light_view *s = t->solution;
    rsv_face_walk walk = rsv_face_walk_begin(s);
    uint32_t next = first_face_cell(s);
    for (uint32_t face = 0; face < s->elements->face_count; face++) {
        t->face_cell[face] = next;
        t->face_level[face] = (uint8_t)rsv_face_grid_level(&walk, face);
        next = rsv_face_walk_cells(&walk, face, t->face_level[face], next);
        if (next > INT32_MAX)
            return rsv_fail(RSV_ERROR_UNSUPPORTED, "frames: the scene has too many light cells");
    }
    t->face_cell[s->elements->face_count] = next;
    t->cell_count = next;
    return RSV_OK;
}

static uint32_t material_of_face(const rsv_light_view *s, uint32_t face)
{
    return s->scene.view->triangle_material[s->elements->face_triangle[face]];
}

bool rsv_holds_irradiance(const rsv_light_table *t, uint32_t face)
{
    return !is_stored(t->solution, material_of_face(t->solution, face));
}

rsv_status rsv_light_table_create(
    const rsv_light_view *s, const rsv_glossy_materials *glossy, rsv_light_table *t)
{
    rsv_status status = RSV_ERROR_MEMORY;
    *t = (rsv_light_table){ .context = s->context, .solution = s, .glossy = glossy };
    t->triangle_count = (uint32_t)s->scene.view->triangle_count;
    t->face_cell = rsv_alloc(s->context, s->elements->face_count + 1, sizeof *t->face_cell);
    t->face_level = rsv_alloc(s->context, s->elements->face_count, sizeof *t->face_level);
    t->side = rsv_alloc(s->context, (size_t)t->triangle_count + 1, sizeof *t->side);
    if (!t->face_cell || !t->face_level || !t->side) goto cleanup;
    RSV_TRY(number_cells(t));
    status = RSV_ERROR_MEMORY;
    t->cell = rsv_alloc(s->context, t->cell_count, sizeof *t->cell);
    t->child = rsv_alloc(s->context, t->cell_count, sizeof *t->child);
    if (!t->cell || !t->child) goto cleanup;
    fill_sides(t);
    rsv_light_table_bake(t, RSV_NONE);
    for (size_t k = 0; k < t->cell_count; k++) // the same in every layer and light
        t->child[k] = rsv_light_cell_child(&t->cell[k]);
    return RSV_OK;
cleanup:
    rsv_light_table_destroy(t);
    return status;
}

void rsv_light_table_destroy(rsv_light_table *t)
{
    if (!t->context) return;
    rsv_free(t->context, t->side);
    rsv_free(t->context, t->face_cell);
    rsv_free(t->context, t->face_level);
    rsv_free(t->context, t->cell);
    rsv_free(t->context, t->child);
    *t = (rsv_light_table){ 0 };
}

/// About a hundredth of the mean radiance: changes of darker light are invisible.
static float least_seen(const rsv_field_sum *fields)
{
    double mean = 0;
    for (int f = 0; f < fields->count; f++) {
        const rsv_stored_field *part = &fields->part[f];
        double sum = 0;
        for (size_t k = 0; k < part->elements->node_count; k++)
            sum += (double)part->value[k].r + (double)part->value[k].g + (double)part->value[k].b;
        mean += (double)part->sign * sum / (3 * (double)part->elements->node_count + 1);
    }
    return 0.01f / RSV_PI * f_max((float)mean, 0);
}

/// @return by how much any has changed
static float bake_emission(rsv_light_table *t, float least)
{
    float change = 0;
    const rsv_bsdf *bsdf = t->solution->bsdf;
    for (uint32_t m = 0; m < t->solution->scene.view->material_count; m++) {
        bool shows = rsv_shows_emission(t) && (bsdf[m].emissive || bsdf[m].unlit);
        rsv_rgb e = shows ? bsdf[m].emission : rgb_gray(0);
        const float emission[3] = { e.r, e.g, e.b };
        change = f_max(change, rsv_light_change(t->cell[1 + m].corner[0], emission, least));
        for (int k = 0; k < 3; k++)
            memcpy(t->cell[1 + m].corner[k], emission, sizeof emission);
    }
    return change;
}

typedef struct bake_job {
    const rsv_light_table *table;
    rsv_field_sum fields, diffused, detail;
    float least;
    _Atomic double change; ///< by how much any has changed
} bake_job;

static rsv_face_walk walk_of(const bake_job *job, uint32_t face)
{
    const rsv_light_table *t = job->table;
    const rsv_light_view *s = t->solution;
    uint32_t material = material_of_face(s, face);
    rsv_face_walk walk = rsv_face_walk_begin(s);
    bool translucent = rsv_is_translucent(s, face);
    walk.least = job->least;
    walk.sum = translucent ? &job->diffused : &job->fields;
    walk.detail = translucent && job->detail.count ? &job->detail : NULL;
    walk.cell = t->cell;
    walk.scale = rgb_gray(1);
    walk.offset = rgb_gray(0);
    if (is_stored(s, material)) {
        walk.scale = rgb_scale(s->bsdf[material].base_color, 1 / RSV_PI);
        memcpy(&walk.offset, t->cell[1 + material].corner[0], sizeof walk.offset);
    }
    return walk;
}

static void bake_faces(void *user, rsv_span span)
{
    bake_job *job = user;
    const rsv_light_table *t = job->table;
    float change = 0;
    for (uint32_t face = (uint32_t)span.begin; face < span.end; face++) {
        rsv_face_walk walk = walk_of(job, face);
        rsv_face_walk_cells(&walk, face, t->face_level[face], t->face_cell[face]);
        change = f_max(change, walk.change);
    }
    rsv_atomic_max(&job->change, (double)change);
}

float rsv_light_table_bake(rsv_light_table *t, uint32_t layer)
{
    const rsv_light_view *s = t->solution;
    t->layer = layer;
    bake_job job = { .table = t,
        .fields = shown_fields(s, layer),
        .diffused = diffused_fields(s, layer),
        .detail = detail_fields(s, layer) };
    job.least = least_seen(&job.fields);
    rsv_atomic_max(&job.change, (double)bake_emission(t, job.least));
    uint32_t sources = rsv_source_state(s);
    if (sources != t->source_state) rsv_atomic_max(&job.change, 1);
    t->source_state = sources;
    rsv_parallel_for(t->context, s->elements->face_count, 64, bake_faces, &job);
    return (float)job.change;
}

rsv_rgb rsv_shown_reflected(
    const rsv_light_table *t, uint32_t face, rsv_rgb albedo, float u, float v)
{
    rsv_rgb held = rsv_radiance_at(t->cell, rsv_place_in_grid(rsv_face_grid(t, face), u, v));
    if (rsv_holds_irradiance(t, face)) return rgb_scale(rgb_mul(albedo, held), 1 / RSV_PI);
    const float *e = t->cell[1 + material_of_face(t->solution, face)].corner[0];
    return rgb_positive(rgb_sub(held, rgb(e[0], e[1], e[2])));
}
