#include "row_catalogue.h"

#include "../core/key.h"
#include "element_keys.h"
#include "material_keys.h"
#include "scene_change.h"

#include <string.h>

#define MAGIC 0x32746163u // "cat2"
/// More nodes, cells or triangles than elements can have.
#define TOO_MANY ((uint64_t)1 << 34)

static size_t bytes_of(const rsv_row_catalogue_header *h)
{
    return sizeof *h + (h->node_count + h->cell_count + h->triangle_count) * sizeof(uint64_t) +
           h->cell_count * sizeof(uint32_t[3]) + h->node_count;
}

/// Allocates the arrays described by a header.
static rsv_status create_empty(
    rsv_context *context, const rsv_row_catalogue_header *header, rsv_row_catalogue **catalogue)
{
    rsv_row_catalogue *c = rsv_alloc(context, 1, sizeof *c);
    if (!c) return RSV_ERROR_MEMORY;
    *catalogue = c;
    c->context = context;
    c->header = rsv_alloc(context, bytes_of(header), 1);
    if (!c->header) return RSV_ERROR_MEMORY;
    *c->header = *header;
    c->node_key = (uint64_t *)(c->header + 1);
    c->cell_key = c->node_key + header->node_count;
    c->triangle_key = c->cell_key + header->cell_count;
    c->cell_node = (uint32_t(*)[3])(c->triangle_key + header->triangle_count);
    c->has_row = (uint8_t *)(c->cell_node + header->cell_count);
    return RSV_OK;
}

void rsv_row_catalogue_destroy(rsv_row_catalogue *c)
{
    if (!c) return;
    rsv_free(c->context, c->header);
    rsv_free(c->context, c);
}

/// Under another normal map, a node receives by other rays.
static rsv_status add_normal_maps(const rsv_elements *e, uint64_t *node_key)
{
    rsv_material_key *keys;
    rsv_status status = rsv_normal_map_keys_create(e->context, e->scene, &keys);
    for (size_t n = 0; n < e->node_count && status == RSV_OK; n++) {
        uint32_t triangle = e->face_triangle[e->node_face[n]];
        uint64_t map = keys[e->scene->triangle_material[triangle]].key;
        if (map) node_key[n] = rsv_key_add_uvs(rsv_key_add(node_key[n], map), e->scene, triangle);
    }
    rsv_free(e->context, keys);
    return status;
}

static rsv_status fill(const rsv_row_basis *t, rsv_row_catalogue *c)
{
    const rsv_elements *e = t->elements;
    rsv_elements_cell_keys(e, c->cell_key);
    rsv_elements_node_keys(e, c->cell_key, c->node_key);
    memcpy(c->cell_node, e->cell_node, e->cell_count * sizeof *e->cell_node);
    for (size_t n = 0; n < e->node_count; n++)
        c->has_row[n] = t->valid_points[n] != 0;
    for (size_t k = 0; k < e->cell_count; k++) {
        uint32_t face = e->cell[k].face;
        size_t side = 2 * (size_t)e->face_triangle[face] + e->face_back[face];
        c->cell_key[k] = rsv_key_add(c->cell_key[k], t->side_kind[side]);
        const float *cut = rsv_cell_sides(e, (uint32_t)k);
        if (cut) c->cell_key[k] = rsv_key_add_bytes(c->cell_key[k], cut, sizeof *e->cut_side);
    }
    return add_normal_maps(e, c->node_key);
}

rsv_status rsv_row_catalogue_create(const rsv_row_basis *t, rsv_row_catalogue **catalogue)
{
    rsv_context *context = t->elements->context;
    rsv_row_catalogue *c = NULL;
    uint64_t *triangles = NULL;
    size_t count = 0;
    rsv_status status = rsv_scene_change_keys(context, t->scene->view, &triangles, &count);
    if (status != RSV_OK) return status;
    const rsv_row_catalogue_header header = { .magic = MAGIC,
        .ray_count = t->ray_count,
        .seed = t->seed,
        .node_count = t->elements->node_count,
        .cell_count = t->elements->cell_count,
        .triangle_count = count };
    RSV_TRY(create_empty(context, &header, &c));
    memcpy(c->triangle_key, triangles, count * sizeof *triangles);
    RSV_TRY(fill(t, c));
    *catalogue = c;
    c = NULL;
cleanup:
    rsv_free(context, triangles);
    rsv_row_catalogue_destroy(c);
    return status;
}

static uint64_t checksum_of(const rsv_row_catalogue *c)
{
    rsv_row_catalogue_header header = *c->header;
    header.checksum = 0;
    uint64_t sum = rsv_key_add_bytes(MAGIC, &header, sizeof header);
    return rsv_key_add_bytes(sum, c->header + 1, bytes_of(&header) - sizeof header);
}

static bool nodes_exist(const rsv_row_catalogue *c)
{
    for (size_t k = 0; k < c->header->cell_count; k++)
        for (int corner = 0; corner < 3; corner++)
            if (c->cell_node[k][corner] >= c->header->node_count) return false;
    return true;
}

static bool is_sound_header(const rsv_row_catalogue_header *h, size_t bytes)
{
    return h->magic == MAGIC && h->node_count < TOO_MANY && h->cell_count < TOO_MANY &&
           h->triangle_count < TOO_MANY && h->seconds >= 0 && h->seconds < INFINITY &&
           bytes_of(h) == bytes;
}

/// A copy, as others may write over the blob. @param catalogue out: NULL if it is not sound
static rsv_status copy_sound(
    rsv_context *context, const rsv_blob *blob, rsv_row_catalogue **catalogue)
{
    rsv_row_catalogue_header header;
    rsv_row_catalogue *c = NULL;
    if (blob->count < sizeof header) return RSV_OK;
    memcpy(&header, blob->byte, sizeof header);
    if (!is_sound_header(&header, blob->count)) return RSV_OK;
    rsv_status status = create_empty(context, &header, &c);
    if (status == RSV_OK) {
        memcpy(c->header + 1, blob->byte + sizeof header, blob->count - sizeof header);
        if (header.checksum == checksum_of(c) && nodes_exist(c)) {
            *catalogue = c;
            c = NULL;
        }
    }
    rsv_row_catalogue_destroy(c);
    return status;
}

rsv_status rsv_row_catalogue_read(
    rsv_context *context, rsv_store *store, const char *name, rsv_row_catalogue **catalogue)
{
    rsv_blob blob;
    *catalogue = NULL;
    rsv_status status = store->table->read(store, name, 0, &blob);
    if (status != RSV_OK) return status;
    status = copy_sound(context, &blob, catalogue);
    store->table->release(store, &blob);
    return status;
}

void rsv_row_catalogue_write(rsv_row_catalogue *c, rsv_store *store, const char *name)
{
    c->header->checksum = checksum_of(c);
    int why = store->table->write(store, name, c->header, bytes_of(c->header));
    if (why)
        rsv_log(c->context, RSV_LOG_WARNING,
            "%s: cannot write '%s/%s': %s; after an edit of the scene all rows will be traced "
            "again",
            store->kind, store->place, name, strerror(why));
}
