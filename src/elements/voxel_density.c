/// How dense heterogeneous fog is in voxels.
#include "../core/parallel.h"
#include "../media/volume.h"
#include "elements_constants.h"
#include "voxels.h"

float rsv_voxels_density(const rsv_voxels *v, rsv_vec3 place)
{
    if (!v->volume) return 1;
    const rsv_grid_line line = rsv_volume_line(v->volume, place, v3(0, 0, 0));
    return (float)rsv_volume_density(v->volume, &line, 0);
}

/// The greatest density of the grid points around a cell: no place in it is denser.
static float bound_cell(const rsv_voxels *v, size_t cell)
{
    const rsv_volume *volume = v->volume;
    rsv_vec3 low = rsv_voxel_low(v, v->begin[cell]), high = v3_add(low, v->size);
    size_t from[3], to[3];
    float most = 0;
    for (int k = 0; k < 3; k++) {
        double origin = (double)(&volume->low.x)[k], spacing = (double)(&volume->spacing.x)[k];
        double last = (double)volume->side[k] - 1;
        double a = floor(((double)(&low.x)[k] - origin) / spacing - 1e-3);
        double b = ceil(((double)(&high.x)[k] - origin) / spacing + 1e-3);
        from[k] = (size_t)fmin(fmax(a, 0.0), last);
        to[k] = (size_t)fmin(fmax(b, 0.0), last);
    }
    for (size_t z = from[2]; z <= to[2]; z++)
        for (size_t y = from[1]; y <= to[1]; y++)
            for (size_t x = from[0]; x <= to[0]; x++)
                most =
                    f_max(most, volume->density[(z * volume->side[1] + y) * volume->side[0] + x]);
    return most;
}

/// Mean over a voxel that fills its cell.
static float mean_of_whole(const rsv_voxels *v, uint32_t voxel)
{
    rsv_vec3 low = rsv_voxel_low(v, voxel);
    double sum = 0;
    for (uint32_t k = 0; k < DENSITY_SIDE * DENSITY_SIDE * DENSITY_SIDE; k++) {
        float x = ((float)(k % DENSITY_SIDE) + 0.5f) / DENSITY_SIDE;
        float y = ((float)(k / DENSITY_SIDE % DENSITY_SIDE) + 0.5f) / DENSITY_SIDE;
        float z = ((float)(k / DENSITY_SIDE / DENSITY_SIDE) + 0.5f) / DENSITY_SIDE;
        rsv_vec3 place = v3_add(low, v3(x * v->size.x, y * v->size.y, z * v->size.z));
        sum += (double)rsv_voxels_density(v, place);
    }
    return (float)(sum / (DENSITY_SIDE * DENSITY_SIDE * DENSITY_SIDE));
}

static float mean_of_part(const rsv_voxels *v, uint32_t voxel)
{
    uint32_t begin = v->place_begin[voxel], end = v->place_begin[voxel + 1];
    double sum = 0;
    if (begin == end) return rsv_voxels_density(v, rsv_voxel_centre(v, voxel));
    for (uint32_t k = begin; k < end; k++)
        sum += (double)rsv_voxels_density(v, v->place[k]);
    return (float)(sum / (end - begin));
}

static void weigh_span(void *user, rsv_span span)
{
    const rsv_voxels *v = user;
    for (size_t k = span.begin; k < span.end; k++) {
        uint32_t voxel = (uint32_t)k;
        v->densest[k] = bound_cell(v, v->cell[k]);
        v->density[k] =
            rsv_voxel_is_whole(v, voxel) ? mean_of_whole(v, voxel) : mean_of_part(v, voxel);
    }
}

rsv_status rsv_voxels_weigh(rsv_voxels *v, const struct rsv_volume *volume)
{
    v->volume = volume;
    if (!volume) return RSV_OK;
    v->density = rsv_alloc(v->context, v->count, sizeof *v->density);
    v->densest = rsv_alloc(v->context, v->count, sizeof *v->densest);
    if (!v->density || !v->densest) return RSV_ERROR_MEMORY;
    rsv_parallel_for(v->context, v->count, 64, weigh_span, v);
    return RSV_OK;
}

float rsv_voxel_mean_density(const rsv_voxels *v, uint32_t voxel)
{
    if (!v->volume) return 1;
    return f_max(v->density[voxel], LEAST_DENSITY * v->volume->densest);
}

rsv_vec3 rsv_voxel_place(const rsv_voxels *v, uint32_t voxel, const float u[3])
{
    rsv_vec3 place = rsv_voxel_even_place(v, voxel, u);
    if (!v->volume || !(v->density[voxel] > 0)) return place;
    rsv_random random = rsv_random_from(
        (uint32_t)(u[0] * 0x1p32f), (uint32_t)(u[1] * 0x1p32f), (uint32_t)(u[2] * 0x1p32f) ^ voxel);
    for (int k = 0; k < DENSITY_TRIES; k++) {
        if (rsv_random_float(&random) * v->densest[voxel] < rsv_voxels_density(v, place)) break;
        float next[3];
        for (int axis = 0; axis < 3; axis++)
            next[axis] = rsv_random_float(&random);
        place = rsv_voxel_even_place(v, voxel, next);
    }
    return place;
}
