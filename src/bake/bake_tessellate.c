#include "bake_tessellate.h"

#include "../core/index_map.h"
#include "../core/vec.h"
#include "bake_cells.h"
#include "bake_constants.h"

#include <string.h>

/// A corner of a cell within one triangle of the file.
typedef struct corner {
    float w1, w2;       ///< weights of the triangle's corners 1 and 2
    uint32_t place;     ///< equal where positions are
    uint32_t attribute; ///< index into the mesh's `parent`
    uint32_t on;        ///< bit k = on the triangle's edge that is opposite to its corner k
} corner;

/// Where an edge is cut.
typedef struct edge_cut {
    uint32_t place;
    float share; ///< of the end with the larger place
} edge_cut;

struct rsv_bake_tessellator {
    rsv_bake_cells cells; ///< of the triangle at hand
    rsv_bake_lattices lattices;
    rsv_bake_tessellation desc;
    rsv_bake_mesh *mesh;
    const rsv_bake_borders *borders;
    rsv_index_map foreign; ///< of two places: into `cut`
    edge_cut *cut;         ///< at points of other edges
    size_t cut_count, cut_capacity;
    uint32_t *vertex_place; ///< [vertex_count of the part]
    uint32_t place_count;
    rsv_index_map middle_place; ///< of two places
    rsv_index_map middle;       ///< of two attributes
    uint32_t *first_vertex;     ///< [attribute_count] of the mesh's vertices
    size_t first_capacity;
};

typedef rsv_bake_tessellator tessellator;

static uint64_t pair_key(uint32_t a, uint32_t b)
{
    return a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
}

// ---- dividing -------------------------------------------------------------------------------------

/// The place in the middle of two. @return RSV_NONE if that edge is not divided
static uint32_t middle_place(const tessellator *q, uint32_t a, uint32_t b)
{
    return rsv_index_map_find(&q->middle_place, pair_key(a, b));
}

/// The same, made if need be. @return RSV_NONE when out of memory
static uint32_t make_middle_place(tessellator *q, uint32_t a, uint32_t b)
{
    uint32_t place = rsv_index_map_insert(&q->middle_place, pair_key(a, b), q->place_count);
    q->place_count += place == q->place_count;
    return place;
}

/// Gives the edges of divided cells their middles.
static rsv_status mark(tessellator *q, size_t node, int depth, const uint32_t place[3])
{
    rsv_status status = RSV_OK;
    if (depth == q->cells.depth || !q->cells.split[node]) return RSV_OK;
    uint32_t m[3];
    for (int k = 0; k < 3; k++) {
        m[k] = make_middle_place(q, place[k], place[(k + 1) % 3]);
        if (m[k] == RSV_NONE) return RSV_ERROR_MEMORY;
    }
    const uint32_t child[4][3] = { { place[0], m[0], m[2] }, { m[0], place[1], m[1] },
        { m[2], m[1], place[2] }, { m[1], m[2], m[0] } };
    for (size_t k = 0; k < 4 && status == RSV_OK; k++)
        status = mark(q, 4 * node + 1 + k, depth + 1, child[k]);
    return status;
}

static rsv_status divide(tessellator *q)
{
    uint32_t place[3];
    rsv_bake_cells_decide(&q->cells);
    for (int k = 0; k < 3; k++)
        place[k] = q->vertex_place[q->cells.part->corner[q->cells.t][k]];
    rsv_status status = mark(q, 0, 0, place);
    return rsv_cancelled(q->cells.s->context) ? RSV_ERROR_CANCELLED : status;
}

/// Numbers the vertices of the file by where they are.
static rsv_status number_places(tessellator *q)
{
    rsv_status status;
    rsv_index_map map = { 0 };
    const rsv_bake_part *part = q->cells.part;
    q->vertex_place = rsv_alloc(q->cells.s->context, part->vertex_count, sizeof *q->vertex_place);
    RSV_TRY(q->vertex_place ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_index_map_create(q->cells.s->context, part->vertex_count, &map));
    for (size_t n = 0; n < part->vertex_count; n++) {
        uint32_t bits[3];
        memcpy(bits, &part->position[n], sizeof bits);
        // different positions with the same key are not distinguished: 64 bits of 96 must suffice
        uint64_t key =
            ((uint64_t)bits[0] << 32 | bits[1]) ^ (uint64_t)bits[2] * 0x9e3779b97f4a7c15u;
        q->vertex_place[n] = rsv_index_map_insert(&map, key, q->place_count);
        RSV_TRY(q->vertex_place[n] == RSV_NONE ? RSV_ERROR_MEMORY : RSV_OK);
        q->place_count += q->vertex_place[n] == q->place_count;
    }
cleanup:
    rsv_index_map_destroy(&map);
    return status;
}

// ---- writing --------------------------------------------------------------------------------------

/// @param share of b
static rsv_status add_attribute(tessellator *q, uint32_t a, uint32_t b, float share)
{
    rsv_status status;
    rsv_bake_mesh *mesh = q->mesh;
    size_t count = mesh->attribute_count;
    RSV_TRY(rsv_grow(mesh->context, (void **)&mesh->parent, &mesh->attribute_capacity, count + 1,
        sizeof *mesh->parent));
    RSV_TRY(rsv_grow(mesh->context, (void **)&mesh->share, &mesh->share_capacity, count + 1,
        sizeof *mesh->share));
    RSV_TRY(rsv_grow(mesh->context, (void **)&q->first_vertex, &q->first_capacity, count + 1,
        sizeof *q->first_vertex));
    mesh->parent[count][0] = a;
    mesh->parent[count][1] = b;
    mesh->share[count] = share;
    q->first_vertex[count] = RSV_NONE;
    mesh->attribute_count++;
cleanup:
    return status;
}

static rsv_vec3 position_at(const tessellator *q, uint32_t t, float w1, float w2)
{
    const rsv_bake_part *part = q->cells.part;
    const rsv_scene_view *view = q->cells.s->scene.view;
    const uint32_t *v = view->triangle[part->triangle[t]];
    float u1, u2;
    rsv_bake_place(part, w1, w2, &u1, &u2);
    return v3_barycentric(view->position[v[0]], view->position[v[1]], view->position[v[2]], u1, u2);
}

/// Cuts an edge where a point of another edge lies on it. @param found out: index into q->cut; RSV_NONE = there is none
static rsv_status find_foreign(tessellator *q, const corner *a, const corner *b, uint32_t *found)
{
    rsv_status status = RSV_OK;
    float share;
    uint64_t key = pair_key(a->place, b->place);
    *found = rsv_index_map_find(&q->foreign, key);
    if (*found != RSV_NONE || !(a->on & b->on) || !q->desc.divide) return RSV_OK;
    if (a->place > b->place) {
        const corner *turned = a;
        a = b, b = turned;
    }
    uint32_t t = q->cells.t;
    if (!rsv_bake_borders_find(
            q->borders, position_at(q, t, a->w1, a->w2), position_at(q, t, b->w1, b->w2), &share))
        return RSV_OK;
    RSV_TRY(rsv_grow(
        q->mesh->context, (void **)&q->cut, &q->cut_capacity, q->cut_count + 1, sizeof *q->cut));
    q->cut[q->cut_count] = (edge_cut){ q->place_count++, share };
    *found = rsv_index_map_insert(&q->foreign, key, (uint32_t)q->cut_count++);
    status = *found == RSV_NONE ? RSV_ERROR_MEMORY : RSV_OK;
cleanup:
    return status;
}

/// Where to cut an edge. @param share out: weight of b; 0 = not at all
static rsv_status find_cut(
    tessellator *q, const corner *a, const corner *b, uint32_t *place, float *share)
{
    uint32_t foreign;
    *place = middle_place(q, a->place, b->place);
    *share = 0.5f;
    if (*place != RSV_NONE) return RSV_OK;
    rsv_status status = find_foreign(q, a, b, &foreign);
    *share = 0;
    if (status != RSV_OK || foreign == RSV_NONE) return status;
    *place = q->cut[foreign].place;
    *share = a->place < b->place ? q->cut[foreign].share : 1 - q->cut[foreign].share;
    return RSV_OK;
}

/// The corner where an edge is cut. @param is_cut out: whether it is
static rsv_status cut_edge(
    tessellator *q, const corner *a, const corner *b, corner *middle, bool *is_cut)
{
    uint32_t fresh = (uint32_t)q->mesh->attribute_count, place;
    float share;
    rsv_status status = find_cut(q, a, b, &place, &share);
    *is_cut = status == RSV_OK && share > 0;
    if (!*is_cut) return status;
    *middle = (corner){ .w1 = (1 - share) * a->w1 + share * b->w1,
        .w2 = (1 - share) * a->w2 + share * b->w2,
        .place = place,
        .attribute = rsv_index_map_insert(&q->middle, pair_key(a->attribute, b->attribute), fresh),
        .on = a->on & b->on };
    if (middle->attribute == RSV_NONE) return RSV_ERROR_MEMORY;
    if (middle->attribute != fresh) return RSV_OK;
    return add_attribute(q, a->attribute, b->attribute, share);
}

static rsv_status add_vertex(tessellator *q, const corner *c, rsv_rgb light, uint32_t *vertex)
{
    rsv_status status;
    rsv_bake_mesh *mesh = q->mesh;
    size_t count = mesh->vertex_count;
    void **const arrays[] = { (void **)&mesh->attribute, (void **)&mesh->receiver,
        (void **)&mesh->light, (void **)&mesh->next };
    const size_t sizes[] = { sizeof *mesh->attribute, sizeof *mesh->receiver, sizeof *mesh->light,
        sizeof *mesh->next };
    for (int k = 0; k < 4; k++)
        RSV_TRY(rsv_grow(mesh->context, arrays[k], &mesh->vertex_capacity[k], count + 1, sizes[k]));
    mesh->attribute[count] = c->attribute;
    mesh->receiver[count] = rsv_bake_cells_receiver(&q->cells, c->w1, c->w2);
    mesh->light[count] = light;
    mesh->next[count] = q->first_vertex[c->attribute];
    mesh->changed |= mesh->next[count] != RSV_NONE;
    q->first_vertex[c->attribute] = *vertex = (uint32_t)count;
    mesh->vertex_count++;
cleanup:
    return status;
}

/// The vertex of a corner: one that is there already, if the same light falls on it.
static rsv_status find_vertex(
    tessellator *q, const corner *c, const float centre[2], uint32_t *vertex)
{
    rsv_rgb light = rsv_bake_cells_light(&q->cells, c->w1, c->w2);
    *vertex = q->first_vertex[c->attribute];
    while (*vertex != RSV_NONE &&
           !rsv_bake_cells_agree(&q->cells, q->mesh->light[*vertex], light, JUMP))
        *vertex = q->mesh->next[*vertex];
    if (*vertex != RSV_NONE) return RSV_OK;
    rsv_status status = add_vertex(q, c, light, vertex);
    if (status == RSV_OK) // once more where it will be read: a little inside
        q->mesh->receiver[*vertex] =
            rsv_bake_cells_pulled(&q->cells, c->w1, c->w2, centre[0], centre[1]);
    return status;
}

static rsv_status add_triangle(tessellator *q, const corner *a, const corner *b, const corner *c)
{
    rsv_status status;
    rsv_bake_mesh *mesh = q->mesh;
    const float centre[2] = { (a->w1 + b->w1 + c->w1) / 3, (a->w2 + b->w2 + c->w2) / 3 };
    const corner *at[3] = { a, b, c };
    RSV_TRY(rsv_grow(mesh->context, (void **)&mesh->corner, &mesh->triangle_capacity,
        mesh->triangle_count + 1, sizeof *mesh->corner));
    for (int k = 0; k < 3; k++)
        RSV_TRY(find_vertex(q, at[k], centre, &mesh->corner[mesh->triangle_count][k]));
    mesh->triangle_count++;
cleanup:
    return status;
}

/// Cuts a cell along the points that its edges have, on whichever side they are needed.
static rsv_status emit(tessellator *q, const corner c[3])
{
    rsv_status status = RSV_OK;
    corner m[3];
    bool cut[3];
    int cuts = 0, k = 0;
    for (int e = 0; e < 3; e++) {
        RSV_TRY(cut_edge(q, &c[e], &c[(e + 1) % 3], &m[e], &cut[e]));
        cuts += cut[e];
    }
    if (cuts == 0) return add_triangle(q, &c[0], &c[1], &c[2]);
    if (cuts == 3) {
        RSV_TRY(emit(q, (corner[]){ c[0], m[0], m[2] }));
        RSV_TRY(emit(q, (corner[]){ m[0], c[1], m[1] }));
        RSV_TRY(emit(q, (corner[]){ m[2], m[1], c[2] }));
        return emit(q, (corner[]){ m[1], m[2], m[0] });
    }
    // from the first cut edge that does not follow another one
    while (!(cut[k] && !cut[(k + 2) % 3]))
        k++;
    const corner *a = &c[k], *b = &c[(k + 1) % 3], *d = &c[(k + 2) % 3];
    RSV_TRY(emit(q, (corner[]){ *a, m[k], *d }));
    if (cuts == 1) return emit(q, (corner[]){ m[k], *b, *d });
    const corner *n = &m[(k + 1) % 3];
    RSV_TRY(emit(q, (corner[]){ m[k], *b, *n }));
    RSV_TRY(emit(q, (corner[]){ m[k], *n, *d }));
cleanup:
    return status;
}

static rsv_status write_triangle(tessellator *q)
{
    corner c[3];
    for (int k = 0; k < 3; k++) {
        uint32_t vertex = q->cells.part->corner[q->cells.t][k];
        c[k] = (corner){ .w1 = k == 1,
            .w2 = k == 2,
            .place = q->vertex_place[vertex],
            .attribute = vertex,
            .on = 7u & ~(1u << k) };
    }
    return emit(q, c);
}

/// Decides where triangles are divided.
static rsv_status divide_all(tessellator *q)
{
    rsv_status status = RSV_OK;
    const rsv_bake_part *part = q->cells.part;
    rsv_context *context = q->cells.s->context;
    q->cells.split = rsv_alloc(context, RSV_BAKE_CELLS, 1);
    RSV_TRY(q->cells.split ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(number_places(q));
    RSV_TRY(rsv_index_map_create(context, part->vertex_count, &q->middle_place));
    RSV_TRY(rsv_index_map_create(context, part->vertex_count, &q->middle));
    RSV_TRY(rsv_index_map_create(context, 0, &q->foreign));
    uint32_t *t = &q->cells.t;
    for (*t = 0; q->desc.divide && *t < part->triangle_count; ++*t)
        if (part->triangle[*t] != RSV_NONE) RSV_TRY(divide(q));
cleanup:
    rsv_free(context, q->cells.split);
    q->cells.split = NULL;
    return status;
}

rsv_status rsv_bake_tessellator_create(const rsv_light_view *s, const rsv_bake_part *part,
    const rsv_bake_tessellation *desc, rsv_bake_mesh *mesh, rsv_bake_tessellator **result)
{
    rsv_status status;
    *mesh = (rsv_bake_mesh){ .context = s->context };
    tessellator *q = *result = rsv_alloc(s->context, 1, sizeof *q);
    if (!q) return RSV_ERROR_MEMORY;
    q->desc = *desc;
    q->mesh = mesh;
    q->cells = (rsv_bake_cells){ .s = s, .part = part, .lattices = &q->lattices, .desc = &q->desc };
    RSV_TRY(rsv_bake_lattices_create(s, part, desc->finest, desc->divide, &q->lattices));
    RSV_TRY(rsv_bake_lattices_light(&q->lattices, &desc->accuracy));
    RSV_TRY(divide_all(q));
cleanup:
    return status;
}

/// An edge of triangle `t` of the file, or a piece of it.
typedef struct border_piece {
    uint32_t t, place[2];
    float w[2][2];
} border_piece;

/// Adds the points between the ends of a piece.
static rsv_status add_between(
    const tessellator *q, const border_piece *p, rsv_bake_borders *borders)
{
    uint32_t middle = middle_place(q, p->place[0], p->place[1]);
    if (middle == RSV_NONE) return RSV_OK;
    border_piece half[2] = { *p, *p };
    half[0].place[1] = half[1].place[0] = middle;
    for (int c = 0; c < 2; c++)
        half[0].w[1][c] = half[1].w[0][c] = 0.5f * (p->w[0][c] + p->w[1][c]);
    rsv_status status =
        rsv_bake_borders_add(borders, position_at(q, p->t, half[1].w[0][0], half[1].w[0][1]));
    if (status == RSV_OK) status = add_between(q, &half[0], borders);
    return status == RSV_OK ? add_between(q, &half[1], borders) : status;
}

rsv_status rsv_bake_tessellator_border(const tessellator *q, rsv_bake_borders *borders)
{
    rsv_status status = RSV_OK;
    const rsv_bake_part *part = q->cells.part;
    static const float weight[3][2] = { { 0, 0 }, { 1, 0 }, { 0, 1 } };
    for (uint32_t t = 0; t < part->triangle_count; t++) {
        if (part->triangle[t] == RSV_NONE) continue;
        for (int e = 0; e < 3; e++) {
            int f = (e + 1) % 3;
            const border_piece piece = { t,
                { q->vertex_place[part->corner[t][e]], q->vertex_place[part->corner[t][f]] },
                { { weight[e][0], weight[e][1] }, { weight[f][0], weight[f][1] } } };
            RSV_TRY(rsv_bake_borders_add(borders, position_at(q, t, weight[e][0], weight[e][1])));
            RSV_TRY(add_between(q, &piece, borders));
        }
    }
cleanup:
    return status;
}

rsv_status rsv_bake_tessellator_write(tessellator *q, const rsv_bake_borders *borders)
{
    rsv_status status = RSV_OK;
    const rsv_bake_part *part = q->cells.part;
    uint32_t *t = &q->cells.t;
    q->borders = borders;
    for (uint32_t n = 0; n < part->vertex_count; n++)
        RSV_TRY(add_attribute(q, n, n, 0));
    for (*t = 0; *t < part->triangle_count; ++*t)
        if (part->triangle[*t] != RSV_NONE) RSV_TRY(write_triangle(q));
    q->mesh->changed |= q->mesh->attribute_count > part->vertex_count;
cleanup:
    return status;
}

void rsv_bake_tessellator_destroy(tessellator *q)
{
    if (!q) return;
    rsv_context *context = q->mesh->context;
    rsv_bake_lattices_destroy(&q->lattices);
    rsv_free(context, q->vertex_place);
    rsv_free(context, q->first_vertex);
    rsv_free(context, q->cut);
    rsv_index_map_destroy(&q->middle_place);
    rsv_index_map_destroy(&q->middle);
    rsv_index_map_destroy(&q->foreign);
    rsv_free(context, q);
}

void rsv_bake_mesh_destroy(rsv_bake_mesh *mesh)
{
    rsv_free(mesh->context, mesh->parent);
    rsv_free(mesh->context, mesh->share);
    rsv_free(mesh->context, mesh->attribute);
    rsv_free(mesh->context, mesh->receiver);
    rsv_free(mesh->context, mesh->light);
    rsv_free(mesh->context, mesh->next);
    rsv_free(mesh->context, mesh->corner);
    *mesh = (rsv_bake_mesh){ .context = mesh->context };
}
