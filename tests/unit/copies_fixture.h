/// A room whose walls were written twice, in all ways that programs have of it.
#ifndef RSV_TEST_COPIES_FIXTURE_H
#define RSV_TEST_COPIES_FIXTURE_H

#include "light_fixture.h"

/// How the walls of a room are copied. Default: as single-sided faces that look outwards.
typedef enum copies {
    SINGLE, ///< not at all
    AFTER,
    BEFORE,    ///< in the scene
    MIXED,     ///< of one wall before, of the next after it
    COLORED,   ///< of another material
    OUTSIDE,   ///< a millionth of the room off the walls
    INSIDE,    ///< another copy, in front of them
    THREEFOLD, ///< copy, wall, copy
    DIAGONAL,  ///< divided along the other diagonal
    FINE,      ///< of 7 x 7 squares
    FINER,     ///< of 24 x 24
    SHARED,    ///< of the same vertices, in one mesh
    SAME_WAY,  ///< looking inwards
    TWO_SIDED, ///< double-sided, as is the wall
    KINDS
} copies;

static inline const char *name_of_copies(copies kind)
{
    static const char *const name[KINDS] = { "single", "after", "before", "mixed", "colored",
        "outside", "inside", "threefold", "diagonal", "fine", "finer", "shared", "same way",
        "two-sided" };
    return name[kind];
}

/// A wall from `corner`, along two edges, which turn counter-clockwise about its front.
typedef struct plain_wall {
    rsv_vec3 corner, edge[2];
} plain_wall;

enum { SIDE_X = 4, SIDE_Y = 3, SIDE_Z = 5, WALLS = 6, MOST_SQUARES = 24 };

static const plain_wall room_wall[WALLS] = {
    { { 0, 0, SIDE_Z }, { { SIDE_X, 0, 0 }, { 0, 0, -SIDE_Z } } },
    { { 0, SIDE_Y, 0 }, { { SIDE_X, 0, 0 }, { 0, 0, SIDE_Z } } },
    { { 0, 0, SIDE_Z }, { { 0, 0, -SIDE_Z }, { 0, SIDE_Y, 0 } } },
    { { SIDE_X, 0, 0 }, { { 0, 0, SIDE_Z }, { 0, SIDE_Y, 0 } } },
    { { 0, 0, 0 }, { { SIDE_X, 0, 0 }, { 0, SIDE_Y, 0 } } },
    { { SIDE_X, 0, SIDE_Z }, { { -SIDE_X, 0, 0 }, { 0, SIDE_Y, 0 } } },
};

/// The triangles of a wall.
typedef struct wall_mesh {
    rsv_vec3 position[(MOST_SQUARES + 1) * (MOST_SQUARES + 1)];
    uint32_t index[2 * 6 * MOST_SQUARES * MOST_SQUARES];
    size_t vertex_count, triangle_count;
} wall_mesh;

/// @param lift metres off the wall, towards its front
static inline void make_sheet(const plain_wall *w, uint32_t squares, float lift, wall_mesh *s)
{
    rsv_vec3 normal = v3_normalize(v3_cross(w->edge[0], w->edge[1]));
    *s = (wall_mesh){ 0 };
    for (uint32_t j = 0; j <= squares; j++)
        for (uint32_t i = 0; i <= squares; i++) {
            rsv_vec3 p = v3_mad(w->corner, (float)i / (float)squares, w->edge[0]);
            p = v3_mad(p, (float)j / (float)squares, w->edge[1]);
            s->position[s->vertex_count++] = v3_mad(p, lift, normal);
        }
    for (uint32_t j = 0; j < squares; j++)
        for (uint32_t i = 0; i < squares; i++) {
            uint32_t a = j * (squares + 1) + i, c = a + squares + 2;
            const uint32_t corner[6] = { a, a + 1, c, a, c, c - 1 };
            memcpy(&s->index[3 * s->triangle_count], corner, sizeof corner);
            s->triangle_count += 2;
        }
}

static inline void turn_over(wall_mesh *s)
{
    for (size_t t = 0; t < s->triangle_count; t++) {
        uint32_t second = s->index[3 * t + 1];
        s->index[3 * t + 1] = s->index[3 * t + 2];
        s->index[3 * t + 2] = second;
    }
}

static inline void add_sheet(world *w, uint32_t material, const wall_mesh *s)
{
    world_triangles(w, material, s->position, s->vertex_count, s->index, s->triangle_count);
}

static inline void make_copy(copies kind, const plain_wall *of, wall_mesh *s)
{
    static const uint32_t other_diagonal[6] = { 0, 1, 2, 1, 3, 2 };
    float lift = kind == INSIDE ? 1e-6f * SIDE_Z : kind == OUTSIDE ? -1e-6f * SIDE_Z : 0;
    make_sheet(of, kind == FINER ? MOST_SQUARES : kind == FINE ? 7 : 1, lift, s);
    if (kind == DIAGONAL) memcpy(s->index, other_diagonal, sizeof other_diagonal);
    if (kind != SAME_WAY) turn_over(s);
}

/// Puts both windings into one mesh.
static inline void add_shared(world *w, uint32_t material, wall_mesh *s)
{
    wall_mesh back = *s;
    turn_over(&back);
    memcpy(
        &s->index[3 * s->triangle_count], back.index, 3 * s->triangle_count * sizeof *back.index);
    s->triangle_count *= 2;
    add_sheet(w, material, s);
}

static inline void add_wall(world *w, copies kind, int index, uint32_t paint, uint32_t other)
{
    const plain_wall *of = &room_wall[index];
    wall_mesh own, copy;
    make_sheet(of, 1, 0, &own);
    make_copy(kind, of, &copy);
    bool before = kind == BEFORE || kind == THREEFOLD || (kind == MIXED && index % 2);
    if (kind == SHARED) {
        add_shared(w, paint, &own);
        return;
    }
    if (before) add_sheet(w, paint, &copy);
    add_sheet(w, paint, &own);
    if (kind == SINGLE || (before && kind != THREEFOLD)) return;
    add_sheet(w, kind == COLORED ? other : paint, &copy);
}

/// A room of 4 x 3 x 5 m, with a lamp below its ceiling, a crate on the floor and a mirror on the rear wall.
static inline world *create_copied_room(struct rsv_device *device, copies kind)
{
    world *w = world_begin_on(2, device);
    rsv_material gray = lambert_material(0.7f, 0), red = gray, blue = gray;
    red.base_color = rgb(0.63f, 0.06f, 0.05f);
    blue.base_color = rgb(0.05f, 0.06f, 0.8f);
    gray.double_sided = red.double_sided = kind == TWO_SIDED;
    uint32_t paint[2] = { world_material(w, gray), world_material(w, red) };
    uint32_t other = world_material(w, blue);
    for (int k = 0; k < WALLS; k++)
        add_wall(w, kind, k, paint[k == 2], other);
    world_box(w, world_lambert(w, 0.5f, 0), v3(0.5f, 0, 1), v3(1.3f, 0.8f, 1.8f));
    world_quad(w, world_material(w, mirror_material(0.9f)), v3(2.2f, 0.5f, 0.01f),
        v3(3.6f, 0.5f, 0.01f), v3(3.6f, 2, 0.01f), v3(2.2f, 2, 0.01f));
    world_quad(w, world_lambert(w, 0, 10), v3(1.5f, 2.8f, 2), v3(2.5f, 2.8f, 2), v3(2.5f, 2.8f, 3),
        v3(1.5f, 2.8f, 3));
    rsv_camera camera =
        rsv_camera_look_at("inside", v3(2.1f, 1.6f, 4.7f), v3(1.9f, 1.2f, 0), 1.2f, 1.4f);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    world_commit(w);
    return w;
}

#endif
