#include "row_record.h"

#include "../core/key.h"
#include "row_record_head.h"

#include <string.h>

#define MAGIC 0x35776f72u // "row5"

rsv_row_record_layout rsv_row_record_layout_of(const rsv_row_record_head *r)
{
    const size_t bytes[RSV_ROW_PARTS] = { [RSV_ROW_COLUMN] = r->count * sizeof(uint32_t),
        [RSV_ROW_TINTED_COLUMN] = r->tinted_count * sizeof(uint32_t),
        [RSV_ROW_TINTED_WEIGHT] = r->tinted_count * sizeof(rsv_rgb),
        [RSV_ROW_ESCAPE_WEIGHT] = r->tinted_escape_count * sizeof(rsv_rgb),
        [RSV_ROW_ESCAPE] = r->escape_count * sizeof(uint16_t),
        [RSV_ROW_TINTED_ESCAPE] = r->tinted_escape_count * sizeof(uint16_t),
        [RSV_ROW_KIND] = r->ray_count };
    rsv_row_record_layout l = { { sizeof *r } };
    for (int k = 0; k < RSV_ROW_PARTS; k++)
        l.begin[k + 1] = l.begin[k] + bytes[k];
    l.begin[RSV_ROW_PARTS] = (l.begin[RSV_ROW_PARTS] + 7) / 8 * 8;
    return l;
}

uint64_t rsv_row_record_checksum(const uint8_t *bytes, size_t count)
{
    rsv_row_record_head head;
    memcpy(&head, bytes, sizeof head);
    head.checksum = 0;
    uint64_t sum = rsv_key_add_bytes(MAGIC, &head, sizeof head);
    return rsv_key_add_bytes(sum, bytes + sizeof head, count - sizeof head);
}

static uint32_t count_columns(const rsv_row_scratch *s, uint32_t ray_count)
{
    uint32_t count = 0;
    for (uint32_t ray = 0; ray < ray_count; ray++)
        count += s->column[ray] != RSV_NONE;
    return count;
}

static void fill(uint8_t *bytes, const rsv_row_record_head *r, const rsv_row_scratch *s)
{
    rsv_row_record_layout l = rsv_row_record_layout_of(r);
    uint32_t *column = (uint32_t *)(bytes + l.begin[RSV_ROW_COLUMN]);
    uint8_t *kind = bytes + l.begin[RSV_ROW_KIND];
    memset(bytes + l.begin[RSV_ROW_PARTS] - 8, 0, 8); // padding after the last part
    memcpy(bytes, r, sizeof *r);
    for (uint32_t ray = 0; ray < r->ray_count; ray++) {
        bool ends = s->column[ray] != RSV_NONE;
        if (ends) *column++ = s->column[ray];
        kind[ray] = (uint8_t)(s->kind[ray] | (ends ? RSV_ROW_RAY_ENDS : 0));
    }
    const void *from[RSV_ROW_PARTS] = { [RSV_ROW_TINTED_COLUMN] = s->tinted_column,
        [RSV_ROW_TINTED_WEIGHT] = s->tinted_weight,
        [RSV_ROW_ESCAPE_WEIGHT] = s->escapes.tinted_weight,
        [RSV_ROW_ESCAPE] = s->escapes.bin,
        [RSV_ROW_TINTED_ESCAPE] = s->escapes.tinted_bin };
    for (int k = RSV_ROW_TINTED_COLUMN; k < RSV_ROW_KIND; k++)
        memcpy(bytes + l.begin[k], from[k], l.begin[k + 1] - l.begin[k]);
}

rsv_status rsv_row_record_put(rsv_context *context, uint32_t node, uint32_t ray_count,
    const rsv_row_scratch *s, uint64_t rays, rsv_row_block *b)
{
    rsv_row_record_head r = { .magic = MAGIC,
        .node = node,
        .count = count_columns(s, ray_count),
        .tinted_count = s->tinted_count,
        .escape_count = s->escapes.count,
        .tinted_escape_count = s->escapes.tinted_count,
        .emission = s->emission,
        .ray_count = ray_count,
        .index = s->index,
        .valid = s->valid,
        .rays = rays };
    size_t bytes = rsv_row_record_layout_of(&r).begin[RSV_ROW_PARTS];
    rsv_status status =
        rsv_grow(context, (void **)&b->byte, &b->capacity, b->count + bytes, sizeof *b->byte);
    if (status != RSV_OK) return status;
    uint8_t *start = b->byte + b->count;
    fill(start, &r, s);
    r.checksum = rsv_row_record_checksum(start, bytes);
    memcpy(start, &r, sizeof r);
    b->count += bytes;
    return RSV_OK;
}

/// Whether nodes and bins exist, and as many rays end at nodes as there are columns.
static bool indices_fit(const rsv_row_record_head *r, const uint8_t *bytes, size_t node_count)
{
    rsv_row_record_layout l = rsv_row_record_layout_of(r);
    const uint32_t *node = (const uint32_t *)(bytes + l.begin[RSV_ROW_COLUMN]);
    const uint16_t *bin = (const uint16_t *)(bytes + l.begin[RSV_ROW_ESCAPE]);
    uint32_t ends = 0;
    for (uint32_t k = 0; k < r->count + r->tinted_count; k++)
        if (node[k] >= node_count) return false;
    for (uint32_t k = 0; k < r->escape_count + r->tinted_escape_count; k++)
        if (bin[k] >= RSV_ESCAPE_BINS) return false;
    for (uint32_t ray = 0; ray < r->ray_count; ray++)
        ends += (bytes[l.begin[RSV_ROW_KIND] + ray] & RSV_ROW_RAY_ENDS) != 0;
    return ends == r->count;
}

size_t rsv_row_record_bytes(
    const uint8_t *bytes, size_t left, size_t node_count, uint32_t ray_count, uint32_t *node)
{
    rsv_row_record_head r;
    if (left < sizeof r) return 0;
    memcpy(&r, bytes, sizeof r);
    const uint32_t counts[] = { r.count, r.tinted_count, r.escape_count, r.tinted_escape_count };
    for (size_t k = 0; k < 4; k++)
        if (counts[k] > ray_count) return 0;
    if (r.valid == 0 || r.valid >> RSV_SUPPORT_POINTS || r.magic != MAGIC ||
        r.ray_count != ray_count || r.node >= node_count)
        return 0;
    size_t size = rsv_row_record_layout_of(&r).begin[RSV_ROW_PARTS];
    if (size > left) return 0;
    *node = r.node;
    return size;
}

bool rsv_row_record_is_sound(const uint8_t *bytes, size_t count, size_t node_count)
{
    rsv_row_record_head r;
    memcpy(&r, bytes, sizeof r);
    return r.checksum == rsv_row_record_checksum(bytes, count) &&
           indices_fit(&r, bytes, node_count);
}

void rsv_row_record_take(const uint8_t *bytes, uint32_t ray_count, rsv_row_scratch *s)
{
    rsv_row_record_head r;
    memcpy(&r, bytes, sizeof r);
    rsv_row_record_layout l = rsv_row_record_layout_of(&r);
    const uint32_t *column = (const uint32_t *)(bytes + l.begin[RSV_ROW_COLUMN]);
    for (uint32_t ray = 0; ray < ray_count; ray++) {
        uint8_t kind = bytes[l.begin[RSV_ROW_KIND] + ray];
        s->kind[ray] = kind & (uint8_t)~RSV_ROW_RAY_ENDS;
        s->column[ray] = kind & RSV_ROW_RAY_ENDS ? *column++ : RSV_NONE;
    }
    void *to[RSV_ROW_PARTS] = { [RSV_ROW_TINTED_COLUMN] = s->tinted_column,
        [RSV_ROW_TINTED_WEIGHT] = s->tinted_weight,
        [RSV_ROW_ESCAPE_WEIGHT] = s->escapes.tinted_weight,
        [RSV_ROW_ESCAPE] = s->escapes.bin,
        [RSV_ROW_TINTED_ESCAPE] = s->escapes.tinted_bin };
    for (int k = RSV_ROW_TINTED_COLUMN; k < RSV_ROW_KIND; k++)
        memcpy(to[k], bytes + l.begin[k], l.begin[k + 1] - l.begin[k]);
    s->tinted_count = r.tinted_count;
    s->escapes.count = r.escape_count;
    s->escapes.tinted_count = r.tinted_escape_count;
    s->emission = r.emission;
    s->index = r.index;
    s->valid = (uint16_t)r.valid;
    s->rays += r.rays;
}

rsv_kept_row rsv_row_record_kept(const uint8_t *bytes)
{
    rsv_row_record_head r;
    memcpy(&r, bytes, sizeof r);
    rsv_row_record_layout l = rsv_row_record_layout_of(&r);
    return (rsv_kept_row){ .index = r.index,
        .valid = (uint16_t)r.valid,
        .kind = bytes + l.begin[RSV_ROW_KIND],
        .column = (const uint32_t *)(bytes + l.begin[RSV_ROW_COLUMN]) };
}
