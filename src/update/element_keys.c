#include "element_keys.h"

#include "../core/key.h"
#include "../core/parallel.h"

uint64_t rsv_triangle_key(const rsv_scene_view *scene, uint32_t triangle)
{
    uint64_t key = 0;
    for (int k = 0; k < 3; k++)
        key = rsv_key_add_vector(key, scene->position[scene->triangle[triangle][k]]);
    return key;
}

uint64_t rsv_face_key_of(const rsv_scene_view *scene, uint32_t triangle, uint8_t back)
{
    uint64_t key = rsv_key_add(rsv_triangle_key(scene, triangle), back);
    for (int k = 0; k < 3; k++)
        key = rsv_key_add_vector(key, scene->normal[scene->triangle[triangle][k]]);
    return key;
}

uint64_t rsv_face_key(const rsv_elements *e, uint32_t face)
{
    return rsv_face_key_of(e->scene, e->face_triangle[face], e->face_back[face]);
}

uint64_t rsv_cell_key_on(uint64_t face_key, const rsv_cell *c)
{
    uint64_t place = (uint64_t)c->i << 32 | (uint64_t)c->j << 16 | (uint64_t)c->level << 8;
    return rsv_key_add(face_key, place | c->flipped);
}

typedef struct key_job {
    const rsv_elements *elements;
    const uint64_t *cell_key; ///< [cell_count], for those of nodes
    uint64_t *key;            ///< out
} key_job;

static void key_cells(void *data, rsv_span span)
{
    const key_job *job = data;
    const rsv_elements *e = job->elements;
    uint32_t face = RSV_NONE; // of the cell just before
    uint64_t face_key = 0;
    for (size_t k = span.begin; k < span.end; k++) {
        if (e->cell[k].face != face) face_key = rsv_face_key(e, face = e->cell[k].face);
        job->key[k] = rsv_cell_key_on(face_key, &e->cell[k]);
    }
}

void rsv_elements_cell_keys(const rsv_elements *e, uint64_t *key)
{
    key_job job = { e, NULL, key };
    rsv_parallel_for(e->context, e->cell_count, 0, key_cells, &job);
}

static uint64_t add_support(
    const rsv_elements *e, const uint64_t *cell_key, uint32_t node, uint64_t key)
{
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++)
        key = rsv_key_add(rsv_key_add(key, cell_key[e->support[s] / 4]), e->support[s] & 3);
    return key;
}

static uint64_t key_of_node(const rsv_elements *e, const uint64_t *cell_key, uint32_t node)
{
    uint64_t key = add_support(e, cell_key, node, 0);
    for (uint32_t k = e->led_begin ? e->led_begin[node] : 0;
         e->led_begin && k < e->led_begin[node + 1]; k++) {
        key = add_support(e, cell_key, e->led[k].follower, key);
        key = rsv_key_add_bytes(key, &e->led[k].weight, sizeof e->led[k].weight);
    }
    return key;
}

static void key_nodes(void *data, rsv_span span)
{
    const key_job *job = data;
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++)
        job->key[n] = key_of_node(job->elements, job->cell_key, n);
}

void rsv_elements_node_keys(const rsv_elements *e, const uint64_t *cell_key, uint64_t *key)
{
    key_job job = { e, cell_key, key };
    rsv_parallel_for(e->context, e->node_count, 0, key_nodes, &job);
}

rsv_status rsv_node_keys_create(const rsv_elements *e, uint64_t **key)
{
    uint64_t *cell_key = rsv_alloc(e->context, e->cell_count, sizeof *cell_key);
    *key = rsv_alloc(e->context, e->node_count, sizeof **key);
    if (cell_key && *key) {
        rsv_elements_cell_keys(e, cell_key);
        rsv_elements_node_keys(e, cell_key, *key);
    }
    rsv_status status = cell_key && *key ? RSV_OK : RSV_ERROR_MEMORY;
    rsv_free(e->context, cell_key);
    return status;
}
