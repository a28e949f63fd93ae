#include "elements_constants.h"
#include "voxels.h"

static bool grid_is_sound(const rsv_voxels *v)
{
    size_t cells = 1;
    for (int axis = 0; axis < 3; axis++) {
        float low = (&v->low.x)[axis], size = (&v->size.x)[axis];
        if (v->side[axis] < 1 || v->side[axis] > MOST_VOXELS || !isfinite(low)) return false;
        if (!(size > 0 && size * (float)v->side[axis] < INFINITY)) return false;
        cells *= v->side[axis];
    }
    return cells == v->cell_count && v->begin[0] == 0 && v->begin[v->cell_count] == v->count;
}

/// Each point of a cell lies in one of its voxels.
static bool cell_is_sound(const rsv_voxels *v, size_t cell)
{
    uint32_t seen = 0;
    if (v->begin[cell + 1] <= v->begin[cell] || v->begin[cell + 1] > v->count) return false;
    for (uint32_t k = v->begin[cell]; k < v->begin[cell + 1]; k++) {
        if (!v->points[k] || (seen & v->points[k])) return false;
        seen |= v->points[k];
    }
    return seen == (1u << RSV_VOXEL_POINTS) - 1;
}

static bool places_are_sound(const rsv_voxels *v)
{
    if (v->place_begin[0] != 0 || v->place_begin[v->count] != v->place_count) return false;
    for (size_t n = 0; n < v->count; n++)
        if (v->place_begin[n + 1] < v->place_begin[n] ||
            v->place_begin[n + 1] - v->place_begin[n] > CUT_PLACES)
            return false;
    for (size_t k = 0; k < v->place_count; k++)
        if (!isfinite(v->place[k].x + v->place[k].y + v->place[k].z)) return false;
    return true;
}

static bool is_sound(const rsv_voxels *v)
{
    if (!grid_is_sound(v)) return false;
    for (size_t cell = 0; cell < v->cell_count; cell++)
        if (!cell_is_sound(v, cell)) return false;
    return places_are_sound(v);
}

rsv_status rsv_voxels_restore(rsv_voxels *v)
{
    if (!is_sound(v)) return rsv_fail(RSV_ERROR_FORMAT, "voxels: cells and parts do not fit");
    v->cell = rsv_alloc(v->context, v->count, sizeof *v->cell);
    if (!v->cell) return RSV_ERROR_MEMORY;
    for (size_t cell = 0; cell < v->cell_count; cell++)
        for (uint32_t k = v->begin[cell]; k < v->begin[cell + 1]; k++)
            v->cell[k] = (uint32_t)cell;
    return RSV_OK;
}
