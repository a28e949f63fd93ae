#include "fog_front.h"

#include "../core/parallel.h"
#include "../elements/voxels.h"
#include "../media/fog_run.h"
#include "../specular/fog_flight.h"
#include "light_table.h"

#include <string.h>

enum { PARTS = 4, PLACES = PARTS * PARTS * PARTS };

// ---- voxels -------------------------------------------------------------------------------------

static void find_parts(const rsv_fog_shine *shine, size_t cell)
{
    const rsv_light_view *s = shine->solution;
    const rsv_voxels *v = s->elements->voxels;
    rsv_vec3 low = rsv_voxel_low(v, v->begin[cell]);
    for (uint32_t k = 0; k < PLACES; k++) {
        float x = ((float)(k % PARTS) + 0.5f) / PARTS,
              y = ((float)(k / PARTS % PARTS) + 0.5f) / PARTS;
        float z = ((float)(k / PARTS / PARTS) + 0.5f) / PARTS;
        rsv_vec3 place = v3_add(low, v3(x * v->size.x, y * v->size.y, z * v->size.z));
        shine->part[shine->cut[cell] + k] = rsv_voxels_find(v, s->tracer, place);
    }
}

static void find_parts_of_cells(void *job, rsv_span span)
{
    const rsv_fog_shine *shine = job;
    for (size_t cell = span.begin; cell < span.end; cell++)
        if (shine->cut[cell] != RSV_NONE) find_parts(shine, cell);
}

rsv_status rsv_fog_shine_create(const rsv_light_view *s, rsv_fog_shine *shine)
{
    const rsv_voxels *v = s->elements->voxels;
    const rsv_fog *fog = s->scene.view->fog;
    size_t cut = 0;
    *shine = (rsv_fog_shine){ .solution = s, .gray = fog && rsv_fog_is_gray(fog) };
    if (!v) return RSV_OK;
    shine->cut = rsv_alloc(s->context, v->cell_count, sizeof *shine->cut);
    shine->radiance = rsv_alloc(s->context, v->count, sizeof *shine->radiance);
    if (!shine->cut || !shine->radiance) return RSV_ERROR_MEMORY;
    for (size_t cell = 0; cell < v->cell_count; cell++) {
        bool whole = v->begin[cell + 1] - v->begin[cell] == 1;
        shine->cut[cell] = whole ? RSV_NONE : PLACES * (uint32_t)cut++;
    }
    shine->part = rsv_alloc(s->context, cut, PLACES * sizeof *shine->part);
    if (!shine->part) return RSV_ERROR_MEMORY;
    rsv_parallel_for(s->context, v->cell_count, 16, find_parts_of_cells, shine);
    rsv_fog_shine_refresh(shine, RSV_NONE);
    return RSV_OK;
}

void rsv_fog_shine_destroy(rsv_fog_shine *shine)
{
    if (!shine->solution) return;
    rsv_free(shine->solution->context, shine->part);
    rsv_free(shine->solution->context, shine->cut);
    rsv_free(shine->solution->context, shine->radiance);
}

/// @param layer 0 = emission, RSV_NONE = all
static rsv_rgb radiance_of(const rsv_light_view *s, uint32_t node, uint32_t layer)
{
    rsv_rgb glow = rsv_fog_glow(s->scene.view->fog);
    if (layer == 0) return glow;
    if (layer != RSV_NONE) return rsv_light_view_scattered(s, node, layer - 1, false);
    return rgb_add(glow, rgb_add(rsv_light_view_scattered(s, node, 0, false),
                             rsv_light_view_scattered(s, node, RSV_NONE, false)));
}

static void refresh_voxels(void *job, rsv_span span)
{
    const rsv_fog_shine *shine = job;
    const rsv_light_view *s = shine->solution;
    uint32_t first = (uint32_t)rsv_elements_surface_nodes(s->elements);
    for (uint32_t k = (uint32_t)span.begin; k < span.end; k++)
        shine->radiance[k] = radiance_of(s, first + k, shine->layer);
}

void rsv_fog_shine_refresh(rsv_fog_shine *shine, uint32_t layer)
{
    const rsv_light_view *s = shine->solution;
    shine->layer = layer;
    if (shine->radiance)
        rsv_parallel_for(s->context, s->elements->voxels->count, 0, refresh_voxels, shine);
}

/// exp(-x) for x >= 0, with a relative error of 3e-6: a power of two, and a Taylor series around the middle of the
/// remainder.
static float dimmed(float x)
{
    float power = f_max(-1.44269504f * x, -126), whole = floorf(power);
    float y = 0.69314718f * (power - whole - 0.5f);
    float series =
        1 + y * (1 + y * (1.0f / 2 + y * (1.0f / 6 + y * (1.0f / 24 + y * (1.0f / 120)))));
    uint32_t bits = (uint32_t)((int)whole + 127) << 23;
    float scale;
    memcpy(&scale, &bits, sizeof scale);
    return 1.41421356f * series * scale;
}

// ---- columns ------------------------------------------------------------------------------------

/// With one more beyond the last pixel.
static uint32_t columns_over(uint32_t pixels, uint32_t step) { return pixels / step + 2; }

/// Pixels from column to column.
static uint32_t step_for(uint32_t width, uint32_t height)
{
    uint32_t longer = width > height ? width : height;
    return (longer + RSV_FOG_COLUMNS - 1) / RSV_FOG_COLUMNS;
}

static uint32_t most_columns(uint32_t pixels)
{
    return columns_over(pixels < RSV_FOG_COLUMNS ? pixels : RSV_FOG_COLUMNS, 1);
}

rsv_status rsv_fog_front_create(
    rsv_context *context, uint32_t width, uint32_t height, rsv_fog_front *front)
{
    size_t columns = (size_t)most_columns(width) * most_columns(height);
    *front = (rsv_fog_front){ 0 };
    front->slice = rsv_alloc(context, columns, (RSV_FOG_SLICES + 1) * sizeof *front->slice);
    return front->slice ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_fog_front_destroy(rsv_context *context, rsv_fog_front *front)
{
    rsv_free(context, front->slice);
}

/// Metres to the farthest corner of the fog's box.
static float farthest(const rsv_fog *fog, rsv_vec3 eye)
{
    rsv_vec3 a = v3_sub(eye, fog->bounds_min), b = v3_sub(fog->bounds_max, eye);
    return v3_length(v3(f_max(fabsf(a.x), fabsf(b.x)), f_max(fabsf(a.y), fabsf(b.y)),
        f_max(fabsf(a.z), fabsf(b.z))));
}

void rsv_fog_front_begin(rsv_fog_front *front, const rsv_fog_shine *shine, const rsv_camera *camera,
    uint32_t width, uint32_t height)
{
    front->step = step_for(width, height);
    front->across = columns_over(width, front->step);
    front->down = columns_over(height, front->step);
    // rays of an orthographic camera start beside it
    float aside = camera->vertical_fov == 0
                      ? camera->vertical_extent * f_max(1, (float)width / (float)height)
                      : 0;
    front->far = farthest(shine->solution->scene.view->fog, camera->position) + aside + 1e-3f;
}

/// Finer near the eye.
static double slice_distance(const rsv_fog_front *front, uint32_t k)
{
    double share = (double)k / RSV_FOG_SLICES;
    return share * share * (double)front->far;
}

/// A column in the making.
typedef struct column_walk {
    const rsv_fog_front *front;
    const rsv_fog_shine *shine;
    const rsv_fog *fog;
    const rsv_ray *ray;
    rsv_fog_run run;
    rsv_fog_slice *slice;
    uint32_t next;  ///< slice
    rsv_rgb sum;    ///< radiance so far
    rsv_rgb passed; ///< by the fog so far
} column_walk;

static void set_slice(column_walk *w, rsv_rgb radiance, double column)
{
    w->slice[w->next++] = (rsv_fog_slice){ { radiance.r, radiance.g, radiance.b }, (float)column };
}

static rsv_rgb transmittance(const column_walk *w, double column)
{
    if (!w->shine->gray) return rsv_fog_transmittance(w->fog, column);
    return rgb_gray(dimmed(w->fog->extinction.r * (float)column));
}

/// Slices up to `end`, in clear air or of the fog before it.
static void set_slices_to(column_walk *w, double end, double column)
{
    while (w->next <= RSV_FOG_SLICES && slice_distance(w->front, w->next) <= end)
        set_slice(w, w->sum, column);
}

static void add_piece(column_walk *w, uint32_t voxel, double end)
{
    rsv_rgb shown = w->shine->radiance[voxel];
    double distance;
    while (w->next <= RSV_FOG_SLICES && (distance = slice_distance(w->front, w->next)) < end) {
        double column = rsv_fog_column(&w->run, distance);
        rsv_rgb taken = rgb_sub(w->passed, transmittance(w, column));
        set_slice(w, rgb_add(w->sum, rgb_mul(taken, shown)), column);
    }
    rsv_rgb passed = transmittance(w, rsv_fog_column(&w->run, end));
    w->sum = rgb_add(w->sum, rgb_mul(rgb_sub(w->passed, passed), shown));
    w->passed = passed;
}

/// The voxel of a place in a cell that is cut.
static uint32_t part_at(const column_walk *w, size_t cell, double distance)
{
    const rsv_voxels *v = w->shine->solution->elements->voxels;
    rsv_vec3 place = v3_sub(v3_mad(w->ray->origin, (float)distance, w->ray->direction),
        rsv_voxel_low(v, v->begin[cell]));
    const float share[3] = { place.x / v->size.x, place.y / v->size.y, place.z / v->size.z };
    uint32_t index = 0;
    for (int axis = 2; axis >= 0; axis--) {
        float step = f_min(f_max(share[axis] * PARTS, 0), PARTS - 1);
        index = PARTS * index + (uint32_t)step;
    }
    return w->shine->part[w->shine->cut[cell] + index];
}

static void visit_cell(void *user, size_t cell, double begin, double end)
{
    column_walk *w = user;
    if (w->shine->cut[cell] == RSV_NONE) {
        add_piece(w, w->shine->solution->elements->voxels->begin[cell], end);
        return;
    }
    double step = (end - begin) / PARTS;
    for (int k = 0; k < PARTS; k++) {
        double middle = begin + (k + 0.5) * step;
        add_piece(w, part_at(w, cell, middle), k == PARTS - 1 ? end : middle + 0.5 * step);
    }
}

static column_walk walk_along(const rsv_fog_shine *shine, const rsv_ray *ray)
{
    column_walk w = { .shine = shine,
        .fog = shine->solution->scene.view->fog,
        .ray = ray,
        .sum = rgb_gray(0),
        .passed = rgb_gray(1) };
    w.run = rsv_fog_run_of(w.fog, ray->origin, ray->direction, ray->t_max);
    return w;
}

static void walk(column_walk *w)
{
    const rsv_voxels *v = w->shine->solution->elements->voxels;
    const double range[2] = { w->run.begin, w->run.end };
    if (v && w->run.column > 0) rsv_voxels_walk_cells(v, w->ray, range, visit_cell, w);
}

rsv_rgb rsv_fog_shine_along(const rsv_fog_shine *shine, const rsv_ray *ray, rsv_rgb *passed)
{
    column_walk w = walk_along(shine, ray);
    w.next = RSV_FOG_SLICES + 1; // no slice is needed
    walk(&w);
    *passed = w.passed;
    return w.sum;
}

static void fill_column(const rsv_fog_front *front, const rsv_fog_shine *shine, const rsv_ray *ray,
    rsv_fog_slice *slice)
{
    column_walk w = walk_along(shine, ray);
    w.front = front;
    w.slice = slice;
    set_slices_to(&w, w.run.begin, 0);
    walk(&w);
    set_slices_to(&w, INFINITY, w.run.column);
}

void rsv_fog_front_fill(
    const rsv_fog_front *front, const rsv_fog_shine *shine, const rsv_lens *lens, uint32_t row)
{
    for (uint32_t column = 0; column < front->across; column++) {
        rsv_ray ray = rsv_lens_ray(lens, (float)(column * front->step), (float)(row * front->step));
        size_t index = (size_t)row * front->across + column;
        fill_column(front, shine, &ray, front->slice + index * (RSV_FOG_SLICES + 1));
    }
}

// ---- pixels -------------------------------------------------------------------------------------

/// Means of the columns around a place. @param k, z slice and share of the next one
static rsv_float4 interpolate(const rsv_fog_front *front, const float place[2], uint32_t k, float z)
{
    float x = place[0] / (float)front->step, y = place[1] / (float)front->step;
    uint32_t i = (uint32_t)x, j = (uint32_t)y;
    float right = x - (float)i, below = y - (float)j;
    const size_t next = RSV_FOG_SLICES + 1, line = next * front->across;
    const rsv_float4 *at = (const rsv_float4 *)front->slice + j * line + i * next + k;
    rsv_float4 above_left = at[0] + z * (at[1] - at[0]);
    rsv_float4 above_right = at[next] + z * (at[next + 1] - at[next]);
    rsv_float4 below_left = at[line] + z * (at[line + 1] - at[line]);
    rsv_float4 below_right = at[line + next] + z * (at[line + next + 1] - at[line + next]);
    rsv_float4 above = above_left + right * (above_right - above_left);
    return above + below * (below_left + right * (below_right - below_left) - above);
}

void rsv_fog_front_add(const rsv_fog_front *front, const rsv_fog_shine *shine, const float place[2],
    float distance, float radiance[4])
{
    const rsv_fog *fog = shine->solution->scene.view->fog;
    float z = RSV_FOG_SLICES * sqrtf(f_min(distance / front->far, 1));
    uint32_t k = (uint32_t)z;
    k = k < RSV_FOG_SLICES ? k : RSV_FOG_SLICES - 1;
    rsv_float4 found = interpolate(front, place, k, z - (float)k);
    float first = dimmed(fog->extinction.r * found[3]), passed[3] = { first, first, first };
    for (int c = 1; c < 3 && !shine->gray; c++)
        passed[c] = dimmed((&fog->extinction.r)[c] * found[3]);
    for (int c = 0; c < 3; c++)
        radiance[c] = radiance[c] * passed[c] + found[c];
}
