#include "pilot_near.h"

#include "../core/parallel.h"
#include "../elements/elements.h"
#include "../update/element_keys.h"
#include "pilot.h"
#include "solve_constants.h"
#include "source.h"

#include <string.h>

const rsv_history *rsv_pilot_settled(const rsv_builder *b)
{
    const rsv_history *history = rsv_history_of(&b->scene);
    return history && !rsv_history_sources_changed(history) ? history : NULL;
}

/// Nodes far from an edit of the scene keep their previous light. [node_count] each
typedef struct settled_light {
    uint8_t *far;      ///< those nodes: nothing is gathered for them
    rsv_rgb *source;   ///< of these
    rsv_rgb *indirect; ///< of all nodes that existed before
} settled_light;

static rsv_status allocate_settled(const rsv_builder *b, settled_light *then)
{
    size_t nodes = b->elements->node_count;
    then->source = rsv_alloc(b->context, nodes, sizeof *then->source);
    then->indirect = rsv_alloc(b->context, nodes, sizeof *then->indirect);
    return then->source && then->indirect ? RSV_OK : RSV_ERROR_MEMORY;
}

typedef struct sort_job {
    const rsv_builder *builder;
    const uint64_t *key; ///< [node_count]
    settled_light *light;
} sort_job;

static void sort_span(void *data, rsv_span span)
{
    const sort_job *job = data;
    const rsv_builder *b = job->builder;
    const rsv_history *history = rsv_history_of(&b->scene);
    const rsv_elements *e = b->elements;
    settled_light *light = job->light;
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++) {
        if (e->node_hanging[n] != RSV_NONE) continue;
        const rsv_history_node *then = rsv_history_find_node(history, e, n, job->key[n]);
        light->far[n] = !b->valid_points[n] || (then && !rsv_history_is_node_near(history, e, n));
        if (!then) continue;
        light->indirect[n] = then->indirect;
        if (light->far[n]) light->source[n] = then->source; // nothing is gathered without a row
    }
}

/// Sorts nodes into those that an edit of the scene is far from, whose light from before will do, and those that are
/// looked at again.
static rsv_status sort_nodes(const rsv_builder *b, settled_light *light)
{
    const rsv_elements *e = b->elements;
    uint64_t *key = NULL;
    rsv_status status = rsv_node_keys_create(e, &key);
    sort_job job = { b, key, light };
    if (status == RSV_OK) rsv_parallel_for(b->context, e->node_count, 256, sort_span, &job);
    rsv_free(b->context, key);
    return status;
}

/// Rows of nodes that are not far from an edit.
static rsv_status trace_near(rsv_builder *b, const uint8_t *far, rsv_operator **op)
{
    size_t nodes = b->elements->node_count;
    uint16_t *valid = rsv_alloc(b->context, nodes, sizeof *valid);
    if (!valid) return RSV_ERROR_MEMORY;
    for (size_t n = 0; n < nodes; n++)
        valid[n] = far[n] ? 0 : b->valid_points[n];
    const rsv_update *update = b->scene.update, no_rows = { .history = rsv_history_of(&b->scene) };
    b->scene.update = &no_rows;
    rsv_status status = rsv_builder_trace(b, valid, RSV_PILOT_RAYS, op);
    b->scene.update = update;
    rsv_free(b->context, valid);
    return status;
}

/// One more order of light for nodes near an edit, from the light of all.
static void gather_near(rsv_light *light, const settled_light *then, rsv_rgb *exitance)
{
    const rsv_elements *e = light->elements;
    rsv_rgb *indirect = light->field.indirect;
    for (size_t n = 0; n < e->node_count; n++)
        exitance[n] =
            rgb_mul(light->view.exitance_albedo[n], rgb_add(light->field.source[n], indirect[n]));
    rsv_transport_apply(light->view.transport, exitance, indirect);
    for (size_t n = 0; n < e->node_count; n++)
        if (then->far[n]) indirect[n] = then->indirect[n];
    rsv_elements_constrain(e, indirect);
}

/// Direct light of nodes near an edit, and the settled light of the others.
static rsv_status begin_near(rsv_light *light, const settled_light *then)
{
    size_t nodes = light->elements->node_count;
    light->field.indirect = rsv_alloc(light->context, nodes, sizeof *light->field.indirect);
    if (!light->field.indirect) return RSV_ERROR_MEMORY;
    memcpy(light->field.indirect, then->indirect, nodes * sizeof *then->indirect);
    memcpy(light->field.source, then->source, nodes * sizeof *then->source);
    rsv_elements_constrain(light->elements, light->field.indirect);
    rsv_status status = rsv_source_estimate(light, then->far);
    if (status == RSV_OK) rsv_source_add_gathered(light);
    return status;
}

rsv_status rsv_pilot_solve_near(rsv_builder *b, uint8_t *far, rsv_light **light)
{
    rsv_status status;
    settled_light then = { .far = far };
    rsv_operator *op = NULL;
    rsv_rgb *exitance = rsv_alloc(b->context, b->elements->node_count, sizeof *exitance);
    RSV_TRY(exitance ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(allocate_settled(b, &then));
    RSV_TRY(sort_nodes(b, &then));
    RSV_TRY(trace_near(b, far, &op));
    RSV_TRY(rsv_light_begin(op, b->sources, &b->scene, &b->desc, light));
    RSV_TRY(begin_near(*light, &then));
    for (uint32_t order = 0; order < RSV_PILOT_ORDERS; order++)
        gather_near(*light, &then, exitance);
cleanup:
    rsv_operator_release(op);
    rsv_free(b->context, then.source);
    rsv_free(b->context, then.indirect);
    rsv_free(b->context, exitance);
    return status;
}
