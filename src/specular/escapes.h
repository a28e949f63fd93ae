/// Directions in which specular paths of gather rays left the scene. They are stored with the rows of G as bins, so
/// that rotating, dimming or replacing the environment takes no new rays.
///
/// Bins are octahedral. Paths that left the receiver straight, possibly through blended surfaces, are kept apart from
/// those that met specular surfaces first, because they find different parts of the environment: the former only
/// `gathered` (the rest is sampled), the latter everything but the suns.
#ifndef RSV_ESCAPES_H
#define RSV_ESCAPES_H

#include "../sources/lights.h"

#define RSV_ESCAPE_SIDE 64 ///< bins of 3 degrees
/// Straight escapes have the first half of the indices.
#define RSV_ESCAPE_BINS (2 * RSV_ESCAPE_SIDE * RSV_ESCAPE_SIDE)

/// Escapes of one row.
typedef struct rsv_escape_row {
    uint16_t *bin;          ///< [capacity] of weight 1
    uint16_t *tinted_bin;   ///< [capacity]
    rsv_rgb *tinted_weight; ///< [capacity]
    uint32_t count, tinted_count;
} rsv_escape_row;

/// Escapes of rows one after the other, as many as there are.
typedef struct rsv_escape_list {
    uint16_t *bin, *tinted_bin;
    rsv_rgb *tinted_weight;
    size_t count, tinted_count;
    size_t bin_capacity, tinted_bin_capacity, tinted_weight_capacity;
} rsv_escape_list;

/// Escapes of all rows.
typedef struct rsv_escapes {
    size_t *begin;        ///< [row_count + 1] into bin
    size_t *tinted_begin; ///< [row_count + 1] into tinted_bin, tinted_weight
    rsv_escape_list list;
} rsv_escapes;

/// Radiance of every bin: [RSV_ESCAPE_BINS] averages of the divided environment over the bin.
/// @param light NULL = black
rsv_status rsv_escape_radiance(
    rsv_context *context, const rsv_environment_light *light, rsv_rgb *radiance);

rsv_status rsv_escape_row_create(rsv_context *context, uint32_t capacity, rsv_escape_row *row);
void rsv_escape_row_destroy(rsv_context *context, rsv_escape_row *row);
/// @param turns specular events before the escape (rsv_specular_path.turns)
void rsv_escape_row_add(rsv_escape_row *row, rsv_vec3 direction, rsv_rgb weight, uint32_t turns);

rsv_status rsv_escapes_create(rsv_context *context, size_t row_count, rsv_escapes *escapes);
void rsv_escapes_destroy(rsv_context *context, rsv_escapes *escapes);
/// Appends row `index` to a list of consecutive rows. Different lists may grow at the same time.
rsv_status rsv_escapes_store(rsv_context *context, rsv_escapes *escapes, size_t index,
    const rsv_escape_row *row, rsv_escape_list *list);
/// Moves a list of rows behind those of all lists before; it is empty then.
rsv_status rsv_escapes_append(rsv_context *context, rsv_escapes *escapes, rsv_escape_list *list);
/// Call it after all lists have been appended.
void rsv_escapes_finish(rsv_escapes *escapes, size_t row_count);
void rsv_escape_list_destroy(rsv_context *context, rsv_escape_list *list);

/// Marks the bins that rays of a row escaped to straight from the receiver. @param seen [RSV_ESCAPE_BINS / 2] 1 = so
void rsv_escapes_mark(const rsv_escapes *escapes, size_t row, uint16_t *seen);

/// Sum over a row of weight times radiance.
rsv_rgb rsv_escapes_sum(const rsv_escapes *escapes, size_t row, const rsv_rgb *radiance);
/// The same of the squared luminances.
float rsv_escapes_sum_squares(const rsv_escapes *escapes, size_t row, const rsv_rgb *radiance);

#endif
