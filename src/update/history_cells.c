/// The earlier cells, and the known results of each: grids and splits as in elements.h.
#include "history_internal.h"

#include "../core/index_map.h"
#include "../core/parallel.h"
#include "../elements/open_corners.h"
#include "element_keys.h"

static size_t cells_in_grid(const rsv_history_face *face) { return (size_t)1 << (2 * face->level); }

/// Marks slots as taken. @return false if they do not exist, or are taken already
static bool take(const rsv_history_cells *c, size_t first, size_t count, uint8_t *taken)
{
    if (first > c->slot_count || count > c->slot_count - first) return false;
    for (size_t slot = first; slot < first + count; slot++)
        if (taken[slot]++) return false;
    return true;
}

bool rsv_history_cells_are_sound(const rsv_history_cells *c, uint8_t *taken)
{
    for (size_t k = 0; k < c->face_count; k++)
        if (c->face[k].level > RSV_MAX_LEVEL || c->face[k].halvings > RSV_MAX_LEVEL ||
            !take(c, c->face[k].slot, cells_in_grid(&c->face[k]), taken))
            return false;
    for (size_t slot = 0; slot < c->slot_count; slot++)
        if (c->slot[slot] & RSV_SLOT_SPLIT && !take(c, c->slot[slot] & ~RSV_SLOT_SPLIT, 4, taken))
            return false;
    return true;
}

/// Faces of an earlier version by their keys. Triangles that lie upon each other have one key, and are found in turn.
typedef struct face_finder {
    rsv_index_map first; ///< of each key
    uint32_t *next;      ///< [face_count] of the same key; RSV_NONE = there are no more
    uint32_t *turn;      ///< [face_count] by first: whose turn it is
} face_finder;

static rsv_status create_finder(rsv_context *context, const rsv_history_cells *c, face_finder *f)
{
    *f = (face_finder){ .next = rsv_alloc(context, c->face_count, sizeof *f->next),
        .turn = rsv_alloc(context, c->face_count, sizeof *f->turn) };
    if (!f->next || !f->turn) return RSV_ERROR_MEMORY;
    rsv_status status = rsv_index_map_create(context, c->face_count, &f->first);
    for (uint32_t k = 0; k < c->face_count && status == RSV_OK; k++) {
        uint32_t first = rsv_index_map_insert(&f->first, c->face[k].key, k);
        if (first == UINT32_MAX) return RSV_ERROR_MEMORY;
        f->next[k] = RSV_NONE;
        if (first != k) f->next[f->turn[first]] = k; // behind the last one so far
        f->turn[first] = k;
    }
    for (uint32_t k = 0; k < c->face_count && status == RSV_OK; k++)
        f->turn[k] = k;
    return status;
}

static void destroy_finder(rsv_context *context, face_finder *f)
{
    rsv_free(context, f->next);
    rsv_free(context, f->turn);
    rsv_index_map_destroy(&f->first);
}

/// @return the last of a key again where there are more now than there were; RSV_NONE = there was none
static uint32_t take_face(face_finder *f, uint64_t key)
{
    uint32_t first = rsv_index_map_find(&f->first, key);
    if (first == UINT32_MAX) return RSV_NONE;
    uint32_t face = f->turn[first];
    if (f->next[face] != RSV_NONE) f->turn[first] = f->next[face];
    return face;
}

rsv_status rsv_history_find_faces(rsv_history *p, const rsv_scene_view *scene)
{
    rsv_status status;
    face_finder finder = { 0 };
    RSV_TRY(create_finder(p->context, &p->layout.cells[RSV_HISTORY_COARSE], &finder));
    for (int back = 0; back < 2; back++) {
        p->face_before[back] =
            rsv_alloc(p->context, scene->triangle_count, sizeof *p->face_before[back]);
        RSV_TRY(p->face_before[back] ? RSV_OK : RSV_ERROR_MEMORY);
        for (uint32_t t = 0; t < scene->triangle_count; t++)
            p->face_before[back][t] = take_face(&finder, rsv_face_key_of(scene, t, (uint8_t)back));
    }
cleanup:
    destroy_finder(p->context, &finder);
    return status;
}

static const rsv_history_face *find_face(
    const rsv_history *p, rsv_history_level level, const rsv_elements *e, uint32_t face)
{
    uint32_t then = p->face_before[e->face_back[face]][e->face_triangle[face]];
    const rsv_history_cells *c = &p->layout.cells[level];
    return then < c->face_count ? &c->face[then] : NULL; // RSV_NONE is none of them
}

/// Turns a cell into the one that it is a child of. @return which child
static uint32_t climb(rsv_cell *c)
{
    static const uint8_t child[2][4] = { { 0, 1, 2, 3 }, { 3, 2, 1, 0 } }; // see rsv_child_cell
    uint32_t i = c->i & 1, j = c->j & 1, which = child[c->flipped & 1][i + 2 * j];
    c->flipped = (uint8_t)(c->flipped ? i | j : i & j);
    c->i >>= 1;
    c->j >>= 1;
    c->level--;
    return which;
}

/// The slot of a cell; RSV_NONE if there was none.
static uint32_t find_slot(
    const rsv_history *p, rsv_history_level level, const rsv_elements *e, uint32_t cell)
{
    rsv_cell at = e->cell[cell];
    const uint32_t *slots = p->layout.cells[level].slot;
    const rsv_history_face *face = find_face(p, level, e, at.face);
    uint32_t way[RSV_MAX_LEVEL + 1], steps = 0;
    if (!face || at.level < face->level || at.level > RSV_MAX_LEVEL) return RSV_NONE;
    while (at.level > face->level)
        way[steps++] = climb(&at);
    uint32_t side = 1u << at.level;
    uint32_t slot = face->slot + at.j * (2 * side - at.j) + 2u * at.i + at.flipped;
    while (steps > 0) {
        if (!(slots[slot] & RSV_SLOT_SPLIT)) return RSV_NONE;
        slot = (slots[slot] & ~RSV_SLOT_SPLIT) + way[--steps];
    }
    return slot;
}

bool rsv_history_was_split(
    const rsv_history *p, rsv_history_level level, const rsv_elements *e, uint32_t cell)
{
    if (e->cell[cell].level >= RSV_MAX_LEVEL) return false;
    uint32_t slot = find_slot(p, level, e, cell);
    return slot != RSV_NONE && p->layout.cells[level].slot[slot] & RSV_SLOT_SPLIT;
}

bool rsv_history_find_face(
    const rsv_history *p, const rsv_elements *e, uint32_t face, uint8_t *halvings, uint8_t *level)
{
    const rsv_history_face *then = find_face(p, RSV_HISTORY_COARSE, e, face);
    if (!then) return false;
    *halvings = then->halvings;
    *level = then->level;
    return true;
}

bool rsv_history_openness(
    const rsv_history *p, const rsv_elements *e, uint32_t cell, uint8_t *openness)
{
    for (int level = RSV_HISTORY_LEVELS; level-- > 0;) {
        const rsv_history_cells *c = &p->layout.cells[level];
        uint32_t slot = find_slot(p, (rsv_history_level)level, e, cell);
        if (slot == RSV_NONE || !(c->openness[slot] & RSV_OPENNESS_KNOWN)) continue;
        if (rsv_history_is_beside(p, e, cell)) return false;
        *openness = c->openness[slot] & (uint8_t)~RSV_OPENNESS_KNOWN;
        return true;
    }
    return false;
}

static bool grid_level(const void *history, const rsv_elements *e, uint32_t face, uint8_t *level)
{
    uint8_t halvings;
    return rsv_history_find_face(history, e, face, &halvings, level);
}

static bool is_split(const void *history, const rsv_elements *e, uint32_t cell, bool *split)
{
    if (rsv_history_is_near(history, e, cell)) return false;
    *split = rsv_history_was_split(history, RSV_HISTORY_COARSE, e, cell);
    return true;
}

static bool openness(const void *history, const rsv_elements *e, uint32_t cell, uint8_t *known)
{
    return rsv_history_openness(history, e, cell, known);
}

typedef struct undivided_job {
    const rsv_history *history;
    const rsv_elements *elements;
    const uint64_t *key;
    uint8_t *undivided;
} undivided_job;

static void find_known(void *data, rsv_span span)
{
    const undivided_job *job = data;
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++)
        job->undivided[n] = rsv_history_knows_around(job->history, job->elements, n, job->key[n]);
}

/// Nodes that no wall divided then, and none does now.
static rsv_status find_undivided(const void *history, const rsv_elements *e, uint8_t *undivided)
{
    uint64_t *key = NULL;
    rsv_status status = rsv_node_keys_create(e, &key);
    undivided_job job = { history, e, key, undivided };
    if (status == RSV_OK) rsv_parallel_for(e->context, e->node_count, 256, find_known, &job);
    rsv_free(e->context, key);
    return status;
}

rsv_known_cells rsv_history_answers(const rsv_history *history)
{
    return (rsv_known_cells){ history, grid_level, is_split, openness, find_undivided };
}
