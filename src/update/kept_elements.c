#include "kept_elements.h"

#include "../core/parallel.h"
#include "../elements/open_corners.h"
#include "element_keys.h"

typedef struct split_job {
    const rsv_history *history;
    const rsv_elements *elements;
    uint8_t *split;
} split_job;

static void mark_splits(void *data, rsv_span span)
{
    const split_job *job = data;
    const rsv_elements *e = job->elements;
    for (uint32_t c = (uint32_t)span.begin; c < span.end; c++)
        job->split[c] = rsv_history_was_split(job->history, RSV_HISTORY_COARSE, e, c) &&
                        !rsv_history_is_near(job->history, e, c);
}

/// Cells that were split before the scene was edited, away from the edit.
static void choose_as_before(void *user, const rsv_elements *e, uint8_t *split)
{
    split_job job = { user, e, split };
    rsv_parallel_for(e->context, e->cell_count, 256, mark_splits, &job);
}

rsv_status rsv_kept_splits(const rsv_history *history, const rsv_transport_scene *scene,
    rsv_elements **elements, uint64_t *rays)
{
    rsv_elements *finer = NULL;
    rsv_status status =
        rsv_elements_refine_where(*elements, choose_as_before, (void *)(uintptr_t)history, &finer);
    if (status != RSV_OK) return status;
    for (uint32_t face = 0; face < finer->face_count; face++) {
        uint8_t halvings, level;
        if (!rsv_history_is_face_near(history, finer, face) &&
            rsv_history_find_face(history, finer, face, &halvings, &level))
            finer->face_halvings[face] = halvings;
    }
    status = rsv_elements_find_open_corners(scene, *elements, finer, rays);
    rsv_elements_destroy(*elements);
    *elements = finer;
    return status;
}

/// Gives new nodes numbers that no reused node has, because the same points twice would have the same errors.
static rsv_status draw_fresh_apart(rsv_elements *e, const uint8_t *known)
{
    uint32_t next = (uint32_t)e->node_count;
    uint8_t *taken = rsv_alloc(e->context, e->node_count, 1);
    if (!taken) return RSV_ERROR_MEMORY;
    for (uint32_t n = 0; n < e->node_count; n++) {
        if (!known[n]) continue;
        uint32_t draw = e->node_draw[n];
        if (draw < e->node_count)
            taken[draw] = 1;
        else if (draw >= next)
            next = draw + 1;
    }
    for (uint32_t n = 0; n < e->node_count; n++)
        if (!known[n] && taken[n]) e->node_draw[n] = next++;
    rsv_free(e->context, taken);
    return RSV_OK;
}

typedef struct point_job {
    const rsv_history *history;
    rsv_elements *elements;
    const uint64_t *key;
    uint16_t *valid_points;
    uint8_t *known;
} point_job;

static void take_points(void *data, rsv_span span)
{
    const point_job *job = data;
    rsv_elements *e = job->elements;
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++) {
        e->node_draw[n] = n;
        if (e->node_hanging[n] != RSV_NONE) continue;
        const rsv_history_node *then = rsv_history_find_node(job->history, e, n, job->key[n]);
        if (!then) continue;
        job->known[n] = 1;
        e->node_draw[n] = then->draw;
        job->valid_points[n] = (uint16_t)then->light.valid;
    }
}

rsv_status rsv_kept_points(
    const rsv_history *history, rsv_elements *e, uint16_t *valid_points, uint8_t *known)
{
    uint64_t *key = NULL;
    rsv_status status;
    e->node_draw = rsv_alloc(e->context, e->node_count, sizeof *e->node_draw);
    RSV_TRY(e->node_draw ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_node_keys_create(e, &key));
    point_job job = { history, e, key, valid_points, known };
    rsv_parallel_for(e->context, e->node_count, 256, take_points, &job);
    RSV_TRY(draw_fresh_apart(e, known));
cleanup:
    rsv_free(e->context, key);
    return status;
}
