#include "weld.h"

#include "../core/index_map.h"
#include "elements_constants.h"

#include <string.h>

/// Corners at one position with one material and side form a list of smooth groups.
typedef struct smooth_group {
    rsv_vec3 position, normal;
    uint32_t material_side, next;
} smooth_group;

typedef struct welder {
    rsv_context *context;
    rsv_index_map heads; ///< hash of position, material and side -> first group
    smooth_group *group;
    size_t group_count, capacity;
} welder;

static uint64_t float_bits(float value)
{
    float canonical = value + 0.0f; // -0 and +0 are one place
    uint32_t bits;
    memcpy(&bits, &canonical, sizeof bits);
    return bits;
}

static uint64_t place_key(rsv_vec3 p, uint32_t material_side)
{
    uint64_t key = float_bits(p.x) * 0x9e3779b97f4a7c15u;
    key = (key ^ (key >> 29) ^ float_bits(p.y)) * 0xbf58476d1ce4e5b9u;
    key = (key ^ (key >> 31) ^ float_bits(p.z)) * 0x94d049bb133111ebu;
    return key ^ (key >> 30) ^ material_side;
}

static bool same_place(const smooth_group *group, rsv_vec3 p, uint32_t material_side)
{
    return group->position.x == p.x && group->position.y == p.y && group->position.z == p.z &&
           group->material_side == material_side;
}

/// Index of the smooth group of a corner; UINT32_MAX when out of memory.
static uint32_t find_group(welder *w, rsv_vec3 position, rsv_vec3 normal, uint32_t material_side)
{
    if (rsv_grow(w->context, (void **)&w->group, &w->capacity, w->group_count + 1,
            sizeof *w->group) != RSV_OK)
        return UINT32_MAX;
    uint32_t fresh = (uint32_t)w->group_count;
    uint32_t head = rsv_index_map_insert(&w->heads, place_key(position, material_side), fresh);
    if (head == UINT32_MAX) return UINT32_MAX;
    uint32_t last = RSV_NONE;
    if (head != fresh) {
        for (uint32_t g = head; g != RSV_NONE; g = w->group[g].next) {
            last = g;
            if (same_place(&w->group[g], position, material_side) &&
                v3_dot(w->group[g].normal, normal) > CREASE_COSINE)
                return g;
        }
    }
    w->group[fresh] = (smooth_group){ position, normal, material_side, RSV_NONE };
    if (last != RSV_NONE) w->group[last].next = fresh;
    w->group_count++;
    return fresh;
}

static rsv_status weld_corners(rsv_elements *e, welder *w)
{
    const rsv_scene_view *scene = e->scene;
    for (size_t face = 0; face < e->face_count; face++) {
        uint32_t triangle = e->face_triangle[face];
        uint32_t material_side = scene->triangle_material[triangle] * 2 + e->face_back[face];
        for (int k = 0; k < 3; k++) {
            uint32_t vertex = scene->triangle[triangle][k];
            e->face_corner[face][k] =
                find_group(w, scene->position[vertex], scene->normal[vertex], material_side);
            if (e->face_corner[face][k] == UINT32_MAX) return RSV_ERROR_MEMORY;
        }
    }
    return RSV_OK;
}

static rsv_status weld_edges(rsv_elements *e)
{
    static const int ends[3][2] = { { 0, 1 }, { 0, 2 }, { 1, 2 } };
    rsv_index_map edges;
    rsv_status status = rsv_index_map_create(e->context, 2 * e->face_count, &edges);
    for (size_t face = 0; face < e->face_count && status == RSV_OK; face++) {
        for (int k = 0; k < 3; k++) {
            uint32_t a = e->face_corner[face][ends[k][0]], b = e->face_corner[face][ends[k][1]];
            uint64_t key = a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
            e->face_edge[face][k] = rsv_index_map_insert(&edges, key, (uint32_t)edges.count);
            if (e->face_edge[face][k] == UINT32_MAX) status = RSV_ERROR_MEMORY;
        }
    }
    rsv_index_map_destroy(&edges);
    return status;
}

rsv_status rsv_weld_faces(rsv_elements *elements)
{
    rsv_status status;
    welder w = { .context = elements->context };
    RSV_TRY(rsv_index_map_create(elements->context, elements->face_count, &w.heads));
    RSV_TRY(weld_corners(elements, &w));
    RSV_TRY(weld_edges(elements));
cleanup:
    rsv_index_map_destroy(&w.heads);
    rsv_free(elements->context, w.group);
    return status;
}
