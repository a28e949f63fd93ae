#include "motion_boxes.h"

#include "../core/vec.h"
#include "update_constants.h"

#include <math.h>

rsv_status rsv_motion_boxes_begin(rsv_context *context, const rsv_scene_view *scene,
    const uint8_t *moved, size_t count, rsv_motion_boxes *b)
{
    *b = (rsv_motion_boxes){ .context = context, .count = count };
    b->low = rsv_reserve(context, count, sizeof *b->low);
    b->high = rsv_reserve(context, count, sizeof *b->high);
    if (!b->low || !b->high) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < count; k++) {
        b->low[k] = v3(INFINITY, INFINITY, INFINITY);
        b->high[k] = v3_neg(b->low[k]);
    }
    rsv_motion_boxes_end(b, scene, moved);
    return RSV_OK;
}

void rsv_motion_boxes_end(rsv_motion_boxes *b, const rsv_scene_view *scene, const uint8_t *moved)
{
    size_t k = 0;
    for (size_t t = 0; t < scene->triangle_count && k < b->count; t++) {
        if (!moved[t]) continue;
        for (int c = 0; c < 3; c++) {
            rsv_vec3 p = scene->position[scene->triangle[t][c]];
            b->low[k] = v3_min(b->low[k], p);
            b->high[k] = v3_max(b->high[k], p);
        }
        k++;
    }
}

void rsv_motion_boxes_free(rsv_motion_boxes *b)
{
    rsv_free(b->context, b->low);
    rsv_free(b->context, b->high);
    *b = (rsv_motion_boxes){ .context = NULL };
}

/// Half the surface of a box: how likely a line is to meet it, in proportion.
static float size_of(rsv_vec3 low, rsv_vec3 high)
{
    rsv_vec3 d = v3_sub(high, low);
    return d.x * d.y + d.y * d.z + d.z * d.x;
}

static float axis_of(rsv_vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

/// Twice the centre of a box along an axis.
static float centre_of(const rsv_motion_boxes *b, size_t k, int axis)
{
    return axis_of(b->low[k], axis) + axis_of(b->high[k], axis);
}

static void exchange(rsv_motion_boxes *b, size_t i, size_t k)
{
    rsv_vec3 low = b->low[i], high = b->high[i];
    b->low[i] = b->low[k], b->high[i] = b->high[k];
    b->low[k] = low, b->high[k] = high;
}

/// Sorts boxes into those on both sides of their mean. @return where the second half begins
static size_t divide(rsv_motion_boxes *b, size_t first, size_t end, rsv_vec3 extent)
{
    int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    double sum = 0;
    size_t second = first;
    for (size_t k = first; k < end; k++)
        sum += (double)centre_of(b, k, axis);
    float mean = (float)(sum / (double)(end - first));
    for (size_t k = first; k < end; k++)
        if (centre_of(b, k, axis) < mean) exchange(b, k, second++);
    return second;
}

/// Encloses boxes in one, or in up to 2^levels if these are smaller together. @return their size
static float enclose(
    rsv_motion_boxes *b, size_t first, size_t end, int levels, rsv_scene_change *change)
{
    rsv_vec3 low = b->low[first], high = b->high[first];
    uint32_t before = change->count;
    for (size_t k = first + 1; k < end; k++) {
        low = v3_min(low, b->low[k]);
        high = v3_max(high, b->high[k]);
    }
    float size = size_of(low, high);
    size_t second = levels > 0 ? divide(b, first, end, v3_sub(high, low)) : first;
    if (second > first && second < end) {
        float halves = enclose(b, first, second, levels - 1, change) +
                       enclose(b, second, end, levels - 1, change);
        if (halves < SPLIT_GAIN * size) return halves;
    }
    change->count = before;
    rsv_scene_change_add(change, low, high, false);
    return size;
}

void rsv_motion_boxes_enclose(rsv_motion_boxes *b, rsv_scene_change *change)
{
    if (b->count > 0) enclose(b, 0, b->count, BOX_LEVELS, change);
}
