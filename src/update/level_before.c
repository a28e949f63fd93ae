#include "level_before.h"

#include "../core/parallel.h"
#include "../elements/open_corners.h"
#include "moved_elements.h"

static bool openness(const void *user, const rsv_elements *e, uint32_t cell, uint8_t *known)
{
    const rsv_level_before *b = user;
    const rsv_elements *then = b->elements;
    uint32_t slot = rsv_elements_find_slot(then, &e->cell[cell]);
    if (slot == RSV_NONE || rsv_cell_is_beside(e, cell, b->shafts->change)) return false;
    if (!(then->slot[slot] & RSV_SLOT_SPLIT)) {
        if (!then->cell_openness) return false;
        *known = then->cell_openness[then->slot[slot]];
        return true;
    }
    if (!then->slot_openness || !(then->slot_openness[slot] & RSV_OPENNESS_KNOWN)) return false;
    *known = then->slot_openness[slot] & (uint8_t)~RSV_OPENNESS_KNOWN;
    return true;
}

static bool grid_level(const void *user, const rsv_elements *e, uint32_t face, uint8_t *level)
{
    (void)user, (void)e, (void)face, (void)level;
    return false; // coarse elements have grids, and they are the same
}

static bool is_split(const void *user, const rsv_elements *e, uint32_t cell, bool *split)
{
    (void)user, (void)e, (void)cell, (void)split;
    return false; // the same for their splits
}

typedef struct undivided_job {
    const rsv_level_before *before;
    const rsv_elements *elements;
    uint8_t *undivided;
} undivided_job;

static void find_twins(void *data, rsv_span span)
{
    const undivided_job *job = data;
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++)
        job->undivided[n] = rsv_level_before_find(job->before, job->elements, n) != RSV_NONE;
}

static rsv_status find_undivided(const void *user, const rsv_elements *e, uint8_t *undivided)
{
    undivided_job job = { user, e, undivided };
    rsv_parallel_for(e->context, e->node_count, 256, find_twins, &job);
    return RSV_OK;
}

rsv_known_cells rsv_level_before_answers(const rsv_level_before *before)
{
    return (rsv_known_cells){ before, grid_level, is_split, openness, find_undivided };
}

bool rsv_level_before_was_split(const rsv_level_before *b, const rsv_elements *e, uint32_t cell)
{
    uint32_t slot = e->cell[cell].level < RSV_MAX_LEVEL
                        ? rsv_elements_find_slot(b->elements, &e->cell[cell])
                        : RSV_NONE;
    return slot != RSV_NONE && b->elements->slot[slot] & RSV_SLOT_SPLIT;
}

uint32_t rsv_level_before_find(const rsv_level_before *b, const rsv_elements *e, uint32_t node)
{
    if (e->support_begin[node] == e->support_begin[node + 1]) return RSV_NONE;
    uint8_t moved = b->moved[e->face_triangle[e->node_face[node]]];
    if (moved == RSV_MOVE_TURN) return RSV_NONE;
    uint32_t twin = rsv_elements_find_twin(e, node, b->elements);
    if (twin == RSV_NONE || b->elements->node_hanging[twin] != RSV_NONE) return RSV_NONE;
    if (moved == RSV_MOVE_WAITS) return twin;
    return rsv_node_is_beside(e, node, b->shafts->change) ? RSV_NONE : twin;
}
