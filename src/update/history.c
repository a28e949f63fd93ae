#include "history_internal.h"

#include "../core/index_map.h"
#include "element_keys.h"
#include "material_keys.h"
#include "update_constants.h"

/// More than tables and scenes can have.
#define TOO_MANY ((uint64_t)1 << 36)

static bool is_table_size(uint64_t slots)
{
    return slots > 0 && slots < TOO_MANY && (slots & (slots - 1)) == 0;
}

static bool is_finite(rsv_rgb c) { return isfinite(c.r) && isfinite(c.g) && isfinite(c.b); }

static bool is_box(rsv_vec3 low, rsv_vec3 high)
{
    return low.x <= high.x && low.y <= high.y && low.z <= high.z;
}

static bool is_light(const rsv_history_light *l)
{
    return is_finite(l->direct) && l->deviation >= 0;
}

/// Whether all numbers are ones that scenes and their light have.
static bool has_sound_numbers(const rsv_history_header *h)
{
    rsv_history_layout l = rsv_history_layout_of(h);
    const rsv_history_node *node =
        (const rsv_history_node *)(const void *)l.nodes[RSV_HISTORY_COARSE].value;
    const rsv_history_light *light =
        (const rsv_history_light *)(const void *)l.nodes[RSV_HISTORY_FINE].value;
    for (size_t t = 0; t < h->triangle_count; t++)
        if (!is_box(l.triangle[t].low, l.triangle[t].high)) return false;
    for (size_t k = 0; k < l.nodes[RSV_HISTORY_COARSE].slots; k++)
        if (!is_light(&node[k].light) || !is_finite(node[k].source) || !is_finite(node[k].indirect))
            return false;
    for (size_t k = 0; k < l.nodes[RSV_HISTORY_FINE].slots; k++)
        if (!is_light(&light[k])) return false;
    return true;
}

static bool is_sound(const rsv_history_header *h, size_t bytes, uint64_t settings)
{
    if (bytes < sizeof *h || h->magic != RSV_HISTORY_MAGIC || h->settings != settings ||
        h->triangle_count >= TOO_MANY || !(h->spacing[0] > 0) || isinf(h->spacing[0]) ||
        !(h->spacing[1] >= 0))
        return false;
    for (int k = 0; k < RSV_HISTORY_LEVELS; k++)
        if (h->faces[k] >= RSV_NONE || h->slots[k] >= RSV_SLOT_SPLIT || !is_table_size(h->nodes[k]))
            return false;
    return rsv_history_layout_of(h).bytes == bytes &&
           rsv_history_checksum(h, bytes) == h->checksum && has_sound_numbers(h);
}

static rsv_status check_cells(const rsv_history *p, bool *sound)
{
    *sound = true;
    for (int k = 0; k < RSV_HISTORY_LEVELS && *sound; k++) {
        const rsv_history_cells *c = &p->layout.cells[k];
        uint8_t *taken = rsv_alloc(p->context, c->slot_count, 1);
        if (!taken) return RSV_ERROR_MEMORY;
        *sound = rsv_history_cells_are_sound(c, taken);
        rsv_free(p->context, taken);
    }
    return RSV_OK;
}

/// Boxes around triangles of one version that the other does not have, one for each run of them.
static rsv_status find_change(rsv_history *p, const rsv_transport_scene *scene)
{
    rsv_index_map then = { 0 };
    rsv_status status;
    size_t count = p->header->triangle_count;
    uint32_t object = RSV_NONE; // of the new triangle just before
    bool gone = false;          // whether the triangle just before was removed
    rsv_material_key *keys = NULL;
    uint8_t *stays = rsv_alloc(p->context, count, 1);
    RSV_TRY(stays ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_material_keys_create(p->context, scene, &keys));
    RSV_TRY(rsv_index_map_create(p->context, count, &then));
    for (uint32_t k = 0; k < count; k++)
        if (rsv_index_map_insert(&then, p->layout.triangle[k].key, k) == UINT32_MAX)
            RSV_TRY(RSV_ERROR_MEMORY);
    for (uint32_t t = 0; t < scene->view->triangle_count; t++) {
        uint64_t key = rsv_surface_key(scene->view, keys, t);
        uint32_t same = key ? rsv_index_map_find(&then, key) : UINT32_MAX;
        uint32_t new_object = same == UINT32_MAX ? scene->view->triangle_object[t] : RSV_NONE;
        if (same != UINT32_MAX) stays[same] = 1;
        rsv_box b;
        rsv_history_triangle_box(scene->view, t, &b.low, &b.high);
        if (same == UINT32_MAX)
            rsv_scene_change_add(&p->added, b.low, b.high, object == new_object);
        object = new_object;
    }
    p->change = p->added;
    for (size_t k = 0; k < count; k++) {
        const rsv_history_triangle *t = &p->layout.triangle[k];
        bool twice = rsv_index_map_find(&then, t->key) != k;
        if (!stays[k] && !twice) rsv_scene_change_add(&p->change, t->low, t->high, gone);
        gone = !stays[k] && !twice;
    }
    rsv_scene_change_add_margins(&p->added);
    rsv_scene_change_add_margins(&p->change);
    p->change.has_gone = true;
cleanup:
    rsv_index_map_destroy(&then);
    rsv_free(p->context, stays);
    rsv_free(p->context, keys);
    return status;
}

/// Opens the blob, and finds what the edit changed. @param sound out: whether it can be used
static rsv_status open_blob(rsv_history *p, const rsv_transport_scene *scene,
    const rsv_lights *lights, uint64_t settings, bool *sound)
{
    rsv_status status = RSV_OK;
    p->header = (const rsv_history_header *)(const void *)p->blob.byte;
    *sound = is_sound(p->header, p->blob.count, settings);
    if (!*sound) return RSV_OK;
    p->layout = rsv_history_layout_of(p->header);
    p->shafts.all_light_changed = p->header->lights == RSV_HISTORY_NO_LIGHTS ||
                                  scene->media.bodies ||
                                  p->header->lights != rsv_history_lights_key(lights);
    RSV_TRY(check_cells(p, sound));
    if (!*sound) goto cleanup;
    RSV_TRY(rsv_history_find_faces(p, scene->view));
    RSV_TRY(find_change(p, scene));
    p->shafts.change = &p->change;
    rsv_light_shafts_find_sources(&p->shafts, lights);
    p->known_cells = rsv_history_answers(p);
cleanup:
    return status;
}

rsv_status rsv_history_open(const rsv_transport_scene *scene, const rsv_lights *lights,
    rsv_store *store, uint64_t settings, rsv_history **history)
{
    rsv_status status;
    bool sound = false;
    char name[RSV_STORE_NAME_BYTES];
    *history = NULL;
    rsv_history *p = rsv_alloc(lights->context, 1, sizeof *p);
    if (!p) return RSV_ERROR_MEMORY;
    p->context = lights->context;
    p->store = store;
    rsv_history_name(settings, name);
    status = store->table->read(store, name, 0, &p->blob);
    if (status == RSV_OK) status = open_blob(p, scene, lights, settings, &sound);
    if (status == RSV_ERROR_IO) status = RSV_OK; // solved as a whole
    if (status == RSV_OK && sound) {
        *history = p;
        p = NULL;
    }
    rsv_history_close(p);
    return status;
}

void rsv_history_close(rsv_history *p)
{
    if (!p) return;
    p->store->table->release(p->store, &p->blob);
    rsv_free(p->context, p->face_before[0]);
    rsv_free(p->context, p->face_before[1]);
    rsv_free(p->context, p);
}

rsv_spacing rsv_history_spacing(const rsv_history *p, rsv_spacing now)
{
    float metres = p->header->spacing[0], reach = p->header->spacing[1];
    bool is_open = reach < INFINITY;
    if (is_open != (now.reach < INFINITY) || fabsf(now.metres - metres) > LIKE_SPACING * metres)
        return now;
    now.metres = metres;
    now.reach = reach;
    return now;
}

const rsv_known_cells *rsv_history_known_cells(const rsv_history *p) { return &p->known_cells; }

const rsv_scene_change *rsv_history_added(const rsv_history *p) { return &p->added; }

const rsv_scene_change *rsv_history_change(const rsv_history *p) { return &p->change; }

uint64_t rsv_history_identity(const rsv_history *p) { return p->header->checksum | 1; }

bool rsv_history_sources_changed(const rsv_history *p) { return p->shafts.all_light_changed; }

bool rsv_history_is_beside(const rsv_history *p, const rsv_elements *e, uint32_t cell)
{
    return rsv_cell_is_beside(e, cell, &p->change);
}

const rsv_history_light *rsv_history_find_light(const rsv_history *p, rsv_history_level level,
    const rsv_elements *e, uint32_t node, uint64_t node_key)
{
    const uint8_t *value = rsv_history_find(&p->layout.nodes[level], node_key);
    if (!value || rsv_node_is_beside(e, node, &p->change)) return NULL;
    return (const rsv_history_light *)(const void *)value;
}

const rsv_history_node *rsv_history_find_node(
    const rsv_history *p, const rsv_elements *e, uint32_t node, uint64_t node_key)
{
    return (const rsv_history_node *)rsv_history_find_light(
        p, RSV_HISTORY_COARSE, e, node, node_key);
}

bool rsv_history_knows_around(
    const rsv_history *p, const rsv_elements *e, uint32_t node, uint64_t node_key)
{
    return rsv_history_find_light(p, RSV_HISTORY_FINE, e, node, node_key) ||
           rsv_history_find_light(p, RSV_HISTORY_COARSE, e, node, node_key);
}

static bool is_box_near(const rsv_history *p, const rsv_box *b)
{
    for (uint32_t k = 0; k < p->change.count; k++) {
        rsv_vec3 low = p->change.low[k], high = p->change.high[k];
        rsv_box wide = rsv_box_grow((rsv_box){ low, high }, v3_length(v3_sub(high, low)));
        if (b->low.x <= wide.high.x && b->low.y <= wide.high.y && b->low.z <= wide.high.z &&
            b->high.x >= wide.low.x && b->high.y >= wide.low.y && b->high.z >= wide.low.z)
            return true;
    }
    return false;
}

bool rsv_history_is_face_near(const rsv_history *p, const rsv_elements *e, uint32_t face)
{
    rsv_box b;
    rsv_history_triangle_box(e->scene, e->face_triangle[face], &b.low, &b.high);
    return is_box_near(p, &b);
}

bool rsv_history_is_near(const rsv_history *p, const rsv_elements *e, uint32_t cell)
{
    rsv_box b = rsv_box_of_cell(e, cell);
    return is_box_near(p, &b);
}

bool rsv_history_is_node_near(const rsv_history *p, const rsv_elements *e, uint32_t node)
{
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++)
        if (rsv_history_is_near(p, e, e->support[s] / 4)) return true;
    return false;
}

bool rsv_history_is_light_changed(const rsv_history *p, const rsv_elements *e, uint32_t cell)
{
    return rsv_light_shafts_meet(&p->shafts, e, cell);
}

rsv_status rsv_history_find_light_changed(
    const rsv_history *p, const rsv_elements *e, uint8_t **light_changed)
{
    return rsv_light_shafts_find_changed(&p->shafts, e, light_changed);
}
