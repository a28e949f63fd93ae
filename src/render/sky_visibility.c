#include "sky_visibility.h"

#include "../core/octahedral.h"
#include "../core/parallel.h"
#include "../core/team.h"

#include <string.h>

#define SIDE RSV_ESCAPE_SIDE
#define BINS (SIDE * SIDE)
/// How far squares reach from their middle, by level, in bins.
static const float reach[RSV_SKY_SQUARE_LEVELS] = { 1.5f, 2, 2 };

static uint32_t level_side(uint32_t level) { return SIDE >> level; }

/// Of the first square of a level.
static uint32_t level_begin(uint32_t level)
{
    uint32_t begin = 0;
    for (uint32_t k = 0; k < level; k++)
        begin += level_side(k) * level_side(k);
    return begin;
}

// ---- squares ------------------------------------------------------------------------------------

static rsv_sky_square make_square(const rsv_rgb *radiance, uint32_t level, uint32_t i, uint32_t j)
{
    float side = (float)level_side(level), half = reach[level] / SIDE, sum = 0;
    float x = ((float)i + 0.5f) / side, y = ((float)j + 0.5f) / side;
    uint32_t bins = 1u << level;
    for (uint32_t k = 0; k < bins * bins; k++)
        sum += rgb_luminance(radiance[(j * bins + k / bins) * SIDE + i * bins + k % bins]);
    return (rsv_sky_square){ rsv_octahedral_to_direction(x, y), f_min(f_max(x, half), 1 - half),
        f_min(f_max(y, half), 1 - half), half, sum / (float)(bins * bins) };
}

static void make_squares(const rsv_rgb *radiance, rsv_sky_square *square)
{
    for (uint32_t level = 0; level < RSV_SKY_SQUARE_LEVELS; level++)
        for (uint32_t k = 0; k < level_side(level) * level_side(level); k++)
            *square++ = make_square(radiance, level, k % level_side(level), k / level_side(level));
}

// ---- places -------------------------------------------------------------------------------------

/// Side of a cube, in requested distances between nodes.
#define CUBE_SPACINGS 4
/// Places whose squares are found together.
#define BATCH 1024

/// Cubes are looked up so far in front of a surface, in their sides, that it is unlikely to lie on their border.
#define CUBE_OFFSET 0.382f

/// A cube of the grid and the side of a cube that a normal points to.
static uint64_t place_key(float cube, rsv_vec3 position, rsv_vec3 normal)
{
    position = v3_mad(position, CUBE_OFFSET * cube, normal);
    const float at[3] = { position.x, position.y, position.z };
    const float along[3] = { normal.x, normal.y, normal.z };
    uint32_t axis = 0;
    uint64_t key = 0;
    for (uint32_t k = 0; k < 3; k++) {
        float cell = f_min(f_max(floorf(at[k] / cube), -0x1p19f), 0x1p19f);
        key = key << 20 | (uint64_t)((int64_t)cell & 0xfffff);
        if (fabsf(along[k]) > fabsf(along[axis])) axis = k;
    }
    return key << 3 | (2 * axis + (along[axis] < 0));
}

/// @param place out @return false when out of memory
static bool add_place(
    const rsv_light_view *s, rsv_sky_visibility *o, uint32_t node, uint32_t *place)
{
    uint32_t face, triangle;
    float u, v;
    rsv_elements_place_node(s->elements, node, &face, &u, &v);
    triangle = s->elements->face_triangle[face];
    *place = RSV_NONE;
    if (!s->bsdf[s->scene.view->triangle_material[triangle]].rough) return true;
    rsv_surface_point point =
        rsv_surface_point_at(s->scene.view, triangle, u, v, s->elements->face_back[face]);
    uint64_t key = place_key(o->cube, point.position, point.geometric);
    *place = rsv_index_map_insert(&o->places, key, (uint32_t)o->places.count);
    return *place != RSV_NONE;
}

/// A hanging node sees about what its strongest parent sees.
static uint32_t strongest_parent(const rsv_hanging *hanging)
{
    uint32_t strongest = 0;
    for (uint32_t p = 1; p < RSV_PARENTS; p++)
        if (hanging->weight[p] > hanging->weight[strongest]) strongest = p;
    return hanging->parent[strongest];
}

static rsv_status find_places(const rsv_light_view *s, rsv_sky_visibility *o)
{
    const rsv_elements *e = s->elements;
    for (uint32_t node = 0; node < e->node_count; node++) {
        o->place_of[node] = RSV_NONE;
        if (node >= rsv_elements_surface_nodes(e)) continue;
        if (s->transport->scale[node] > 0 && !add_place(s, o, node, &o->place_of[node]))
            return RSV_ERROR_MEMORY;
    }
    for (size_t h = 0; h < e->hanging_count; h++)
        o->place_of[e->hanging[h].node] = o->place_of[strongest_parent(&e->hanging[h])];
    return RSV_OK;
}

/// Visibility of the rows of a batch of places, over all processes. @param seen [BATCH][BINS] number of processes that
/// saw it
static void mark_batch(
    const rsv_light_view *s, const rsv_sky_visibility *o, uint32_t first, uint16_t (*seen)[BINS])
{
    memset(seen, 0, BATCH * sizeof *seen);
    for (size_t node = 0; node < s->elements->node_count; node++) {
        uint32_t place = o->place_of[node] - first; // of a hanging node, there is no row
        if (o->place_of[node] == RSV_NONE || place >= BATCH) continue;
        rsv_escapes_mark(&s->transport->escapes, node, seen[place]);
    }
    if (s->transport->division)
        rsv_team_sum(s->context, (int64_t *)(void *)seen, BATCH * sizeof *seen / sizeof(int64_t));
}

/// @param seen [BINS] @return false if a level has more squares than are kept
static bool list_level(const uint16_t *seen, uint32_t level, rsv_visible_sky *visible)
{
    uint8_t square[BINS] = { 0 };
    uint32_t side = level_side(level), begin = level_begin(level);
    for (uint32_t k = 0; k < BINS; k++)
        if (seen[k]) square[(k / SIDE >> level) * side + (k % SIDE >> level)] = 1;
    visible->count = 0;
    for (uint32_t k = 0; k < side * side; k++) {
        if (!square[k]) continue;
        if (visible->count == RSV_MOST_VISIBLE_SQUARES) return false;
        visible->square[visible->count++] = (uint16_t)(begin + k);
    }
    return true;
}

/// Squares of the finest level of which not too many are seen; of the coarsest, the first ones.
static rsv_visible_sky list_seen(const uint16_t *seen)
{
    rsv_visible_sky visible;
    for (uint32_t level = 0; level < RSV_SKY_SQUARE_LEVELS; level++)
        if (list_level(seen, level, &visible)) break;
    return visible;
}

typedef struct batch_job {
    const rsv_sky_visibility *visibility;
    uint32_t first;               ///< place
    const uint16_t (*seen)[BINS]; ///< by each from there on
} batch_job;

static void list_places(void *user, rsv_span span)
{
    const batch_job *job = user;
    for (size_t k = span.begin; k < span.end; k++)
        job->visibility->visible[job->first + k] = list_seen(job->seen[k]);
}

static rsv_status prepare(const rsv_light_view *s, rsv_sky_visibility *o)
{
    rsv_status status;
    o->square = rsv_alloc(s->context, level_begin(RSV_SKY_SQUARE_LEVELS), sizeof *o->square);
    o->place_of = rsv_alloc(s->context, s->elements->node_count, sizeof *o->place_of);
    RSV_TRY(o->square && o->place_of ? RSV_OK : RSV_ERROR_MEMORY);
    make_squares(s->bin_radiance, o->square);
    RSV_TRY(rsv_index_map_create(s->context, 1024, &o->places));
    RSV_TRY(find_places(s, o));
    o->visible = rsv_alloc(s->context, o->places.count, sizeof *o->visible);
    if (!o->visible) status = RSV_ERROR_MEMORY;
cleanup:
    return status;
}

static rsv_status find_visible(const rsv_light_view *s, rsv_sky_visibility *o)
{
    uint16_t(*seen)[BINS] = rsv_alloc(s->context, BATCH, sizeof *seen);
    rsv_status status = seen ? prepare(s, o) : RSV_ERROR_MEMORY;
    RSV_TRY(rsv_team_meet(s->context, status));
    uint32_t count = (uint32_t)o->places.count;
    for (uint32_t first = 0; first < count; first += BATCH) {
        batch_job job = { o, first, (const uint16_t(*)[BINS])seen };
        mark_batch(s, o, first, seen);
        rsv_parallel_for(
            s->context, count - first < BATCH ? count - first : BATCH, 0, list_places, &job);
    }
cleanup:
    rsv_free(s->context, seen);
    return status;
}

static bool wanted(const rsv_light_view *s)
{
    bool rough = false;
    for (size_t m = 0; m < s->scene.view->material_count; m++)
        rough = rough || s->bsdf[m].rough;
    return rough && s->lights->environment && s->lights->environment->gathered.pixel;
}

rsv_status rsv_sky_visibility_create(const rsv_light_view *s, rsv_sky_visibility **visibility)
{
    *visibility = NULL;
    if (!wanted(s)) return RSV_OK;
    rsv_sky_visibility *o = rsv_alloc(s->context, 1, sizeof *o);
    rsv_status status = rsv_team_meet(s->context, o ? RSV_OK : RSV_ERROR_MEMORY);
    if (status != RSV_OK) {
        rsv_free(s->context, o);
        return status;
    }
    o->context = s->context;
    o->elements = s->elements;
    o->cube = CUBE_SPACINGS * s->elements->spacing;
    RSV_TRY(find_visible(s, o));
    *visibility = o;
    o = NULL;
cleanup:
    rsv_sky_visibility_destroy(o);
    return status;
}

void rsv_sky_visibility_destroy(rsv_sky_visibility *o)
{
    if (!o) return;
    rsv_free(o->context, o->square);
    rsv_free(o->context, o->visible);
    rsv_free(o->context, o->place_of);
    rsv_index_map_destroy(&o->places);
    rsv_free(o->context, o);
}

static uint32_t nearest_node(const rsv_elements *e, uint32_t face, float u, float v)
{
    float weight[3];
    uint32_t cell = rsv_elements_locate(e, face, u, v, weight), k = weight[1] > weight[0];
    return e->cell_node[cell][weight[2] > weight[k] ? 2 : k];
}

const rsv_visible_sky *rsv_sky_visibility_at(
    const rsv_sky_visibility *o, const rsv_specular_path *path, const rsv_surface_point *point)
{
    uint32_t face = o->elements->face_of[path->back][path->triangle], place;
    if (face != RSV_NONE)
        place = o->place_of[nearest_node(o->elements, face, path->u, path->v)];
    else
        place =
            rsv_index_map_find(&o->places, place_key(o->cube, point->position, point->geometric));
    return place == RSV_NONE ? NULL : &o->visible[place];
}
