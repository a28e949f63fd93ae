/// Writes the results of a solve.
#include "history_file.h"

#include "../core/key.h"
#include "../core/parallel.h"
#include "../elements/open_corners.h"
#include "element_keys.h"
#include "material_keys.h"

#include <errno.h>
#include <string.h>

/// Number of slots for a number of keys, with at least a third free.
static uint64_t slots_for(size_t count)
{
    uint64_t slots = 16;
    while (2 * slots < 3 * (uint64_t)count)
        slots *= 2;
    return slots;
}

/// @return its value, for the caller to fill
static uint8_t *put(rsv_history_table *table, uint64_t key)
{
    size_t at = rsv_history_slot(table, key);
    table->key[at] = key;
    return table->value + at * table->value_bytes;
}

typedef struct cell_job {
    const rsv_elements *elements;
    rsv_history_cells *cells;
} cell_job;

static void put_faces(void *data, rsv_span span)
{
    const cell_job *job = data;
    const rsv_elements *e = job->elements;
    for (uint32_t face = (uint32_t)span.begin; face < span.end; face++)
        job->cells->face[face] = (rsv_history_face){ .key = rsv_face_key(e, face),
            .slot = e->face_slot[face],
            .level = e->face_level[face],
            .halvings = e->face_halvings[face] };
}

static void put_openness(void *data, rsv_span span)
{
    const cell_job *job = data;
    const rsv_elements *e = job->elements;
    for (size_t slot = span.begin; slot < span.end; slot++) {
        bool split = e->slot[slot] & RSV_SLOT_SPLIT;
        const uint8_t *known = split ? e->slot_openness : e->cell_openness;
        size_t at = split ? slot : e->slot[slot];
        job->cells->openness[slot] = known ? known[at] | (split ? 0 : RSV_OPENNESS_KNOWN) : 0;
    }
}

static void put_cells(rsv_history_cells *cells, const rsv_elements *e)
{
    cell_job job = { e, cells };
    rsv_parallel_for(e->context, e->face_count, 0, put_faces, &job);
    memcpy(cells->slot, e->slot, e->slot_count * sizeof *e->slot);
    rsv_parallel_for(e->context, e->slot_count, 0, put_openness, &job);
}

static rsv_history_light light_of(const rsv_history_fields *f, size_t n)
{
    return (rsv_history_light){ .direct = f->direct ? f->direct[n] : rgb_gray(0),
        .deviation = f->deviation ? f->deviation[n] : 0,
        .valid = f->valid_points[n] };
}

static rsv_history_node node_of(const rsv_history_fields *f, uint32_t n)
{
    return (rsv_history_node){ .light = light_of(f, n),
        .source = f->source ? f->source[n] : rgb_gray(0),
        .indirect = f->indirect ? f->indirect[n] : rgb_gray(0),
        .draw = rsv_elements_draw_of(f->elements, n) };
}

static rsv_status put_nodes(rsv_history_table *table, const rsv_history_fields *f)
{
    const rsv_elements *e = f->elements;
    rsv_status status;
    uint64_t *node_key = NULL;
    RSV_TRY(rsv_node_keys_create(e, &node_key));
    for (uint32_t n = 0; n < e->node_count; n++) {
        if (e->node_hanging[n] != RSV_NONE) continue;
        const rsv_history_node node = node_of(f, n); // of the fine level, its beginning
        memcpy(put(table, node_key[n]), &node, table->value_bytes);
    }
cleanup:
    rsv_free(e->context, node_key);
    return status;
}

static size_t put_triangles(
    const rsv_transport_scene *scene, const rsv_material_key *keys, rsv_history_triangle *triangle)
{
    size_t count = 0;
    for (uint32_t t = 0; t < scene->view->triangle_count; t++) {
        rsv_history_triangle now = { .key = rsv_surface_key(scene->view, keys, t) };
        if (now.key == 0) continue;
        rsv_history_triangle_box(scene->view, t, &now.low, &now.high);
        if (triangle) triangle[count] = now;
        count++;
    }
    return count;
}

static rsv_history_header describe(const rsv_transport_scene *scene, const rsv_lights *lights,
    const rsv_material_key *keys, uint64_t settings, const rsv_spacing *spacing,
    const rsv_history_fields *level)
{
    rsv_history_header h = { .magic = RSV_HISTORY_MAGIC,
        .settings = settings,
        .lights = scene->media.bodies ? RSV_HISTORY_NO_LIGHTS : rsv_history_lights_key(lights),
        .triangle_count = put_triangles(scene, keys, NULL),
        .spacing = { spacing->metres, spacing->reach } };
    for (int k = 0; k < RSV_HISTORY_LEVELS; k++) {
        const rsv_elements *e = level[k].elements;
        h.faces[k] = e ? e->face_count : 0;
        h.slots[k] = e ? e->slot_count : 0;
        h.nodes[k] = slots_for(e ? e->node_count : 0);
    }
    return h;
}

static rsv_status fill(const rsv_transport_scene *scene, const rsv_material_key *keys,
    const rsv_history_fields *level, rsv_history_header *h, size_t bytes)
{
    rsv_status status = RSV_OK;
    rsv_history_layout layout = rsv_history_layout_of(h);
    put_triangles(scene, keys, layout.triangle);
    for (int k = 0; k < RSV_HISTORY_LEVELS; k++) {
        if (!level[k].elements) continue;
        put_cells(&layout.cells[k], level[k].elements);
        RSV_TRY(put_nodes(&layout.nodes[k], &level[k]));
    }
    h->checksum = rsv_history_checksum(h, bytes);
cleanup:
    return status;
}

/// @return 0 or the number of an error
static int write_all(const rsv_transport_scene *scene, const rsv_lights *lights, rsv_store *store,
    uint64_t settings, const rsv_spacing *spacing, const rsv_history_fields *level)
{
    rsv_context *context = lights->context;
    char name[RSV_STORE_NAME_BYTES];
    rsv_material_key *keys = NULL;
    rsv_history_header *h = NULL;
    int why = ENOMEM;
    if (rsv_material_keys_create(context, scene, &keys) != RSV_OK) goto cleanup;
    rsv_history_header header = describe(scene, lights, keys, settings, spacing, level);
    size_t bytes = rsv_history_layout_of(&header).bytes;
    h = rsv_alloc(context, bytes, 1);
    if (!h) goto cleanup;
    *h = header;
    if (fill(scene, keys, level, h, bytes) != RSV_OK) goto cleanup;
    rsv_history_name(settings, name);
    why = store->table->write(store, name, h, bytes);
cleanup:
    rsv_free(context, keys);
    rsv_free(context, h);
    return why;
}

void rsv_history_write(const rsv_transport_scene *scene, const rsv_lights *lights, rsv_store *store,
    uint64_t settings, const rsv_spacing *spacing,
    const rsv_history_fields level[RSV_HISTORY_LEVELS])
{
    int why = write_all(scene, lights, store, settings, spacing, level);
    if (why)
        rsv_log(lights->context, RSV_LOG_WARNING,
            "%s: cannot save the results of this solution in '%s': %s; after an edit of the scene "
            "everything will be solved again",
            store->kind, store->place, strerror(why));
}
