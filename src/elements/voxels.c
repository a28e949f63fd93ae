#include "voxels.h"

#include "../core/parallel.h"
#include "elements_constants.h"

#include <string.h>

#define CUBE(x) ((size_t)(x) * (x) * (x))

// ---- the grid -----------------------------------------------------------------------------------

/// Cells along an axis whose edge is about that: FEWEST_VOXELS at least.
static uint32_t divide(double extent, double edge)
{
    return (uint32_t)fmin(fmax(ceil(extent / edge), FEWEST_VOXELS), MOST_VOXELS);
}

static void lay_grid(rsv_voxels *v, rsv_vec3 low, rsv_vec3 high, size_t target)
{
    double x = (double)high.x - low.x, y = (double)high.y - low.y, z = (double)high.z - low.z;
    double edge = cbrt(x * y * z / (double)target);
    v->low = low;
    do { // flat boxes have more cells than cubes would fill
        v->side[0] = divide(x, edge);
        v->side[1] = divide(y, edge);
        v->side[2] = divide(z, edge);
        v->cell_count = (size_t)v->side[0] * v->side[1] * v->side[2];
        edge *= 1.2;
    } while (v->cell_count > FLAT_BOX * target + CUBE(FEWEST_VOXELS));
    v->size = v3((float)(x / v->side[0]), (float)(y / v->side[1]), (float)(z / v->side[2]));
}

/// @param share of the cell's edges, in [0, 1]
static rsv_vec3 place_in_cell(const rsv_voxels *v, size_t cell, rsv_vec3 share)
{
    float i = (float)(cell % v->side[0]), j = (float)(cell / v->side[0] % v->side[1]);
    float k = (float)(cell / v->side[0] / v->side[1]);
    return v3(v->low.x + (i + share.x) * v->size.x, v->low.y + (j + share.y) * v->size.y,
        v->low.z + (k + share.z) * v->size.z);
}

/// The points of a cell: a Latin cube, so that no wall along an axis passes all of them unseen.
static rsv_vec3 cell_point(const rsv_voxels *v, size_t cell, uint32_t k)
{
    static const uint8_t second[RSV_VOXEL_POINTS] = { 0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11,
        7, 15 };
    static const uint8_t third[RSV_VOXEL_POINTS] = { 5, 14, 10, 1, 15, 3, 7, 8, 11, 0, 4, 13, 2, 9,
        12, 6 };
    const float step = 1.0f / RSV_VOXEL_POINTS;
    return place_in_cell(v, cell,
        v3(((float)k + 0.5f) * step, ((float)second[k] + 0.5f) * step,
            ((float)third[k] + 0.5f) * step));
}

static uint32_t step_of(float place, float low, float size, uint32_t side)
{
    float step = (place - low) / size;
    return step > 0 ? (step < (float)side ? (uint32_t)step : side - 1) : 0;
}

static size_t cell_of(const rsv_voxels *v, rsv_vec3 p)
{
    size_t i = step_of(p.x, v->low.x, v->size.x, v->side[0]);
    size_t j = step_of(p.y, v->low.y, v->size.y, v->side[1]);
    size_t k = step_of(p.z, v->low.z, v->size.z, v->side[2]);
    return (k * v->side[1] + j) * v->side[0] + i;
}

// ---- walls --------------------------------------------------------------------------------------

static bool sees(const rsv_tracer *tracer, rsv_vec3 from, rsv_vec3 to)
{
    rsv_vec3 way = v3_sub(to, from);
    float distance = v3_length(way);
    if (!(distance > 0)) return true;
    rsv_ray ray = { from, v3_scale(way, 1 / distance), distance };
    return !rsv_tracer_occluded(tracer, &ray);
}

/// Points of a cell that are joined by lines of sight. @param part [RSV_VOXEL_POINTS] points of each part, bit by bit
/// @return how many parts
static uint32_t divide_cell(
    const rsv_voxels *v, const rsv_tracer *tracer, size_t cell, uint16_t *part, uint64_t *rays)
{
    uint32_t left = (1u << RSV_VOXEL_POINTS) - 1, count = 0;
    while (left) {
        uint32_t reached = left & -left, ahead = reached;
        left &= ~reached;
        while (ahead) {
            uint32_t from = (uint32_t)__builtin_ctz(ahead);
            ahead &= ahead - 1;
            for (uint32_t k = 0; k < RSV_VOXEL_POINTS; k++) {
                if (!(left >> k & 1)) continue;
                ++*rays;
                if (!sees(tracer, cell_point(v, cell, from), cell_point(v, cell, k))) continue;
                reached |= 1u << k;
                ahead |= 1u << k;
                left &= ~(1u << k);
            }
        }
        part[count++] = (uint16_t)reached;
    }
    return count;
}

typedef struct division {
    rsv_voxels *v;
    const rsv_tracer *tracer;
    uint16_t (*part)[RSV_VOXEL_POINTS]; ///< [cell_count]
    _Atomic uint64_t rays;
} division;

static void divide_span(void *user, rsv_span span)
{
    division *d = user;
    uint64_t rays = 0;
    for (size_t cell = span.begin; cell < span.end; cell++)
        d->v->begin[cell + 1] = divide_cell(d->v, d->tracer, cell, d->part[cell], &rays);
    atomic_fetch_add(&d->rays, rays);
}

/// @param part [cell_count][RSV_VOXEL_POINTS]
static void divide_cells(
    rsv_voxels *v, const rsv_tracer *tracer, uint16_t (*part)[RSV_VOXEL_POINTS], uint64_t *rays)
{
    division d = { v, tracer, part, 0 };
    rsv_parallel_for(v->context, v->cell_count, 64, divide_span, &d);
    for (size_t cell = 0; cell < v->cell_count; cell++)
        v->begin[cell + 1] += v->begin[cell];
    v->count = v->begin[v->cell_count];
    *rays += d.rays;
}

static rsv_status list_voxels(rsv_voxels *v, const uint16_t (*part)[RSV_VOXEL_POINTS])
{
    v->cell = rsv_alloc(v->context, v->count, sizeof *v->cell);
    v->points = rsv_alloc(v->context, v->count, sizeof *v->points);
    if (!v->cell || !v->points) return RSV_ERROR_MEMORY;
    for (size_t cell = 0; cell < v->cell_count; cell++)
        for (uint32_t k = v->begin[cell]; k < v->begin[cell + 1]; k++) {
            v->cell[k] = (uint32_t)cell;
            v->points[k] = part[cell][k - v->begin[cell]];
        }
    return RSV_OK;
}

// ---- places in cells that are cut ---------------------------------------------------------------

/// Place k of those that a cell is sampled at.
static rsv_vec3 sample_cell(const rsv_voxels *v, size_t cell, uint32_t k)
{
    uint32_t stream = rsv_hash2((uint32_t)cell, 0x7013u);
    rsv_vec3 share = { .z = rsv_sobol_1d(k, rsv_hash(stream)) };
    rsv_sobol_2d(k, stream, &share.x, &share.y);
    return place_in_cell(v, cell, share);
}

static bool is_cut(const rsv_voxels *v, size_t cell)
{
    return v->begin[cell + 1] - v->begin[cell] > 1;
}

/// @param owner [CUT_PLACES] the voxel of each place of the cell
static void find_owners(const rsv_voxels *v, const rsv_tracer *tracer, size_t cell, uint32_t *owner)
{
    for (uint32_t k = 0; k < CUT_PLACES; k++)
        owner[k] = rsv_voxels_find(v, tracer, sample_cell(v, cell, k));
}

/// @param owner [cell_count][CUT_PLACES] of those that are cut
static void sort_places(rsv_voxels *v, const uint32_t (*owner)[CUT_PLACES])
{
    for (size_t cell = 0; cell < v->cell_count; cell++)
        for (uint32_t k = 0; is_cut(v, cell) && k < CUT_PLACES; k++)
            v->place_begin[owner[cell][k] + 1]++;
    for (size_t n = 0; n < v->count; n++)
        v->place_begin[n + 1] += v->place_begin[n];
    // each voxel's end moves on as it fills, and is its own end again afterwards
    for (size_t cell = v->cell_count; cell-- > 0;)
        for (uint32_t k = CUT_PLACES; is_cut(v, cell) && k-- > 0;)
            v->place[--v->place_begin[owner[cell][k] + 1]] = sample_cell(v, cell, k);
    for (size_t n = 0; n < v->count; n++)
        v->place_begin[n] = v->place_begin[n + 1];
    v->place_begin[v->count] = (uint32_t)v->place_count;
}

typedef struct owner_search {
    const rsv_voxels *v;
    const rsv_tracer *tracer;
    uint32_t (*owner)[CUT_PLACES]; ///< [cell_count]
} owner_search;

static void find_owners_of_cells(void *user, rsv_span span)
{
    const owner_search *s = user;
    for (size_t cell = span.begin; cell < span.end; cell++)
        if (is_cut(s->v, cell)) find_owners(s->v, s->tracer, cell, s->owner[cell]);
}

static rsv_status place_cut(rsv_voxels *v, const rsv_tracer *tracer)
{
    size_t cut = 0;
    for (size_t cell = 0; cell < v->cell_count; cell++)
        cut += is_cut(v, cell);
    v->place_count = cut * CUT_PLACES;
    uint32_t(*owner)[CUT_PLACES] = rsv_reserve(v->context, v->cell_count, sizeof *owner);
    v->place_begin = rsv_alloc(v->context, v->count + 1, sizeof *v->place_begin);
    v->place = rsv_alloc(v->context, v->place_count, sizeof *v->place);
    bool complete = owner && v->place_begin && v->place;
    if (complete) {
        owner_search search = { v, tracer, owner };
        rsv_parallel_for(v->context, v->cell_count, 16, find_owners_of_cells, &search);
        sort_places(v, (const uint32_t(*)[CUT_PLACES])owner);
    }
    rsv_free(v->context, owner);
    return complete ? RSV_OK : RSV_ERROR_MEMORY;
}

rsv_status rsv_voxels_create(
    const rsv_transport_scene *scene, size_t target, uint64_t *rays, rsv_voxels **voxels)
{
    rsv_status status = RSV_ERROR_MEMORY;
    rsv_context *context = rsv_scene_get_context(scene->scene);
    uint16_t(*part)[RSV_VOXEL_POINTS] = NULL;
    rsv_voxels *v = rsv_alloc(context, 1, sizeof *v);
    if (!v) return status;
    v->context = context;
    lay_grid(v, scene->view->fog->bounds_min, scene->view->fog->bounds_max, target);
    v->begin = rsv_alloc(context, v->cell_count + 1, sizeof *v->begin);
    part = rsv_alloc(context, v->cell_count, sizeof *part);
    if (!v->begin || !part) goto cleanup;
    divide_cells(v, scene->tracer, part, rays);
    RSV_TRY(list_voxels(v, (const uint16_t(*)[RSV_VOXEL_POINTS])part));
    RSV_TRY(place_cut(v, scene->tracer));
    *voxels = v;
    v = NULL;
cleanup:
    rsv_free(context, part);
    rsv_voxels_destroy(v);
    return status;
}

void rsv_voxels_destroy(rsv_voxels *v)
{
    if (!v) return;
    rsv_free(v->context, v->begin);
    rsv_free(v->context, v->cell);
    rsv_free(v->context, v->points);
    rsv_free(v->context, v->place_begin);
    rsv_free(v->context, v->place);
    rsv_free(v->context, v->density);
    rsv_free(v->context, v->densest);
    rsv_free(v->context, v);
}

// ---- places -------------------------------------------------------------------------------------

float rsv_voxel_volume(const rsv_voxels *v, uint32_t voxel)
{
    uint32_t places = v->place_begin[voxel + 1] - v->place_begin[voxel];
    // of the thinnest slivers, none was met by chance
    float share = (places ? (float)places : 0.5f) / CUT_PLACES;
    if (rsv_voxel_is_whole(v, voxel)) share = 1;
    return share * v->size.x * v->size.y * v->size.z;
}

rsv_vec3 rsv_voxel_low(const rsv_voxels *v, uint32_t voxel)
{
    return place_in_cell(v, v->cell[voxel], v3(0, 0, 0));
}

rsv_vec3 rsv_voxel_centre(const rsv_voxels *v, uint32_t voxel)
{
    rsv_vec3 sum = v3(0, 0, 0);
    for (uint32_t left = v->points[voxel]; left; left &= left - 1)
        sum = v3_add(sum, cell_point(v, v->cell[voxel], (uint32_t)__builtin_ctz(left)));
    return v3_scale(sum, 1 / (float)__builtin_popcount(v->points[voxel]));
}

rsv_vec3 rsv_voxel_even_place(const rsv_voxels *v, uint32_t voxel, const float u[3])
{
    if (rsv_voxel_is_whole(v, voxel)) return place_in_cell(v, v->cell[voxel], v3(u[0], u[1], u[2]));
    uint32_t begin = v->place_begin[voxel], count = v->place_begin[voxel + 1] - begin;
    if (count == 0) return cell_point(v, v->cell[voxel], (uint32_t)__builtin_ctz(v->points[voxel]));
    return v->place[begin + (uint32_t)(u[0] * (float)count)];
}

/// The voxel of which a place sees a point; where it sees none, that of the nearest point.
static uint32_t find_part(
    const rsv_voxels *v, const rsv_tracer *tracer, size_t cell, rsv_vec3 place)
{
    uint32_t nearest = v->begin[cell];
    float least = INFINITY;
    for (uint32_t k = v->begin[cell]; k < v->begin[cell + 1]; k++)
        for (uint32_t left = v->points[k]; left; left &= left - 1) {
            rsv_vec3 point = cell_point(v, cell, (uint32_t)__builtin_ctz(left));
            float distance = v3_length(v3_sub(point, place));
            if (sees(tracer, place, point)) return k;
            if (distance < least) nearest = k, least = distance;
        }
    return nearest;
}

uint32_t rsv_voxels_find(const rsv_voxels *v, const rsv_tracer *tracer, rsv_vec3 place)
{
    size_t cell = cell_of(v, place);
    if (v->begin[cell + 1] - v->begin[cell] == 1) return v->begin[cell];
    return find_part(v, tracer, cell, place);
}

/// The next plane of the grid along one axis.
typedef struct plane_walk {
    double next, step; ///< metres along the ray
} plane_walk;

static plane_walk planes_ahead(double origin, double direction, double size, double at)
{
    if (direction == 0) return (plane_walk){ INFINITY, INFINITY };
    double place = (origin + at * direction) / size;
    double plane = direction > 0 ? floor(place) + 1 : ceil(place) - 1;
    return (plane_walk){ (plane * size - origin) / direction, size / fabs(direction) };
}

void rsv_voxels_walk_cells(const rsv_voxels *v, const rsv_ray *ray, const double range[2],
    rsv_voxel_cell_visitor visit, void *user)
{
    rsv_vec3 o = v3_sub(ray->origin, v->low), d = ray->direction;
    double at = range[0];
    plane_walk axis[3] = { planes_ahead(o.x, d.x, v->size.x, at),
        planes_ahead(o.y, d.y, v->size.y, at), planes_ahead(o.z, d.z, v->size.z, at) };
    while (at < range[1]) {
        int first = axis[0].next < axis[1].next ? 0 : 1;
        if (axis[2].next < axis[first].next) first = 2;
        double end = fmin(axis[first].next, range[1]);
        axis[first].next += axis[first].step;
        if (!(end > at)) continue;
        visit(user, cell_of(v, v3_mad(ray->origin, (float)(0.5 * (at + end)), d)), at, end);
        at = end;
    }
}

typedef struct voxel_walk {
    const rsv_voxels *voxels;
    const rsv_tracer *tracer;
    const rsv_ray *ray;
    rsv_voxel_visitor visit;
    void *user;
} voxel_walk;

static void visit_voxel(void *user, size_t cell, double begin, double end)
{
    const voxel_walk *w = user;
    const rsv_voxels *v = w->voxels;
    uint32_t voxel = v->begin[cell];
    if (is_cut(v, cell)) {
        rsv_vec3 middle = v3_mad(w->ray->origin, (float)(0.5 * (begin + end)), w->ray->direction);
        voxel = find_part(v, w->tracer, cell, middle);
    }
    w->visit(w->user, voxel, begin, end);
}

void rsv_voxels_walk(const rsv_voxels *v, const rsv_tracer *tracer, const rsv_ray *ray,
    const double range[2], rsv_voxel_visitor visit, void *user)
{
    voxel_walk walk = { v, tracer, ray, visit, user };
    rsv_voxels_walk_cells(v, ray, range, visit_voxel, &walk);
}

uint32_t rsv_elements_find_voxel(const rsv_elements *e, const rsv_tracer *tracer, rsv_vec3 place)
{
    if (!e->voxels) return RSV_NONE;
    return (uint32_t)rsv_elements_surface_nodes(e) + rsv_voxels_find(e->voxels, tracer, place);
}

// ---- nodes --------------------------------------------------------------------------------------

/// An array of nodes with room for those of voxels.
static void *lengthen(rsv_context *context, void *array, size_t count, size_t more, size_t size)
{
    char *longer = rsv_alloc(context, count + more, size);
    if (!longer) return NULL;
    if (count) memcpy(longer, array, count * size);
    rsv_free(context, array);
    return longer;
}

/// Area of a surface that receives as much uniform light as a voxel absorbs and scatters: 4 V sigma. G is then
/// symmetric in the product weighted by area and albedo, as for surfaces.
static float area_of(const rsv_elements *e, uint32_t voxel)
{
    rsv_rgb sigma = e->scene->fog->extinction;
    float area = 4 * rsv_voxel_volume(e->voxels, voxel) * (sigma.r + sigma.g + sigma.b) / 3;
    return area * rsv_voxel_mean_density(e->voxels, voxel);
}

#define LENGTHEN(field, more)                                                                      \
    do {                                                                                           \
        void *longer = lengthen(e->context, e->field, before + (more), count, sizeof *e->field);   \
        if (!longer) return RSV_ERROR_MEMORY;                                                      \
        e->field = longer;                                                                         \
    } while (0)

rsv_status rsv_elements_add_voxels(rsv_elements *e, rsv_voxels *voxels)
{
    size_t before = e->node_count, count = voxels->count;
    RSV_ASSERT(!e->voxels);
    e->voxels = voxels;
    rsv_status status = rsv_voxels_weigh(voxels, e->scene->fog->volume);
    if (status != RSV_OK) return status;
    LENGTHEN(node_face, 0);
    LENGTHEN(node_area, 0);
    LENGTHEN(node_hanging, 0);
    LENGTHEN(support_begin, 1);
    if (e->led_begin) LENGTHEN(led_begin, 1);
    if (e->node_draw) LENGTHEN(node_draw, 0);
    for (size_t n = before; n < before + count; n++) {
        e->node_face[n] = e->node_hanging[n] = RSV_NONE;
        e->node_area[n] = area_of(e, (uint32_t)(n - before));
        e->support_begin[n + 1] = e->support_begin[n];
        if (e->led_begin) e->led_begin[n + 1] = e->led_begin[n];
        if (e->node_draw) e->node_draw[n] = (uint32_t)n;
    }
    e->node_count = before + count;
    return RSV_OK;
}
