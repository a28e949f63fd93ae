#include "linear_map.h"

static void apply_other(void *data, size_t columns, const float *field, float *image)
{
    const rsv_linear_map *map = data;
    map->table->apply_transpose(map->data, columns, field, image);
}

static void apply_same(void *data, size_t columns, const float *field, float *image)
{
    const rsv_linear_map *map = data;
    map->table->apply(map->data, columns, field, image);
}

rsv_linear_map rsv_linear_map_transposed(const rsv_linear_map *map)
{
    static const rsv_linear_map_table table = { .apply = apply_other,
        .apply_transpose = apply_same };
    RSV_ASSERT(map->table->apply_transpose);
    return (rsv_linear_map){
        .context = map->context, .table = &table, .data = (void *)map, .count = map->count
    };
}
