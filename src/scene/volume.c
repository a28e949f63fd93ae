/// Heterogeneous fog: densities on a grid.
#include "volume.h"

#include "../media/volume.h"
#include "restore.h"
#include "scene.h"

#include <string.h>

static rsv_status check_grid(const rsv_volume_grid *grid)
{
    size_t points = 1;
    rsv_vec3 extent = v3_sub(grid->high, grid->low);
    for (int k = 0; k < 3; k++) {
        if (grid->side[k] < 2)
            return rsv_fail(RSV_ERROR_ARGUMENT,
                "volume: %u x %u x %u points; each side must have at least 2", grid->side[0],
                grid->side[1], grid->side[2]);
        if (grid->side[k] > RSV_VOLUME_MAX_POINTS / points)
            return rsv_fail(RSV_ERROR_UNSUPPORTED,
                "volume: %u x %u x %u points are more than 2^28; make the grid coarser",
                grid->side[0], grid->side[1], grid->side[2]);
        points *= grid->side[k];
    }
    if (!(extent.x > 0 && extent.y > 0 && extent.z > 0) ||
        !isfinite(extent.x + extent.y + extent.z))
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "volume: a box of %g x %g x %g m; each side must be positive and finite",
            (double)extent.x, (double)extent.y, (double)extent.z);
    return RSV_OK;
}

/// @param densest out
static rsv_status check_densities(const rsv_volume_grid *grid, float *densest)
{
    size_t points = (size_t)grid->side[0] * grid->side[1] * grid->side[2];
    *densest = 0;
    for (size_t k = 0; k < points; k++) {
        float d = grid->density[k];
        if (!(d >= 0 && d < INFINITY))
            return rsv_fail(RSV_ERROR_ARGUMENT,
                "volume: the density %g at point %zu, %zu, %zu; it must be 0 or more, and finite",
                (double)d, k % grid->side[0], k / grid->side[0] % grid->side[1],
                k / grid->side[0] / grid->side[1]);
        if (d > *densest) *densest = d;
    }
    if (*densest > 0) return RSV_OK;
    return rsv_fail(RSV_ERROR_ARGUMENT, "volume: all densities are 0; leave it out");
}

/// The greatest density among the points of a block's cells.
static float find_densest(const rsv_volume *v, const size_t block[3])
{
    size_t low[3], high[3];
    float densest = 0;
    for (int k = 0; k < 3; k++) {
        low[k] = block[k] * RSV_VOLUME_BLOCK;
        high[k] = low[k] + RSV_VOLUME_BLOCK;
        if (high[k] > v->side[k] - 1) high[k] = v->side[k] - 1;
    }
    for (size_t z = low[2]; z <= high[2]; z++)
        for (size_t y = low[1]; y <= high[1]; y++)
            for (size_t x = low[0]; x <= high[0]; x++) {
                float d = v->density[(z * v->side[1] + y) * v->side[0] + x];
                if (d > densest) densest = d;
            }
    return densest;
}

static void find_blocks(rsv_volume *v)
{
    const uint32_t *side = v->block_side;
    for (size_t k = 0; k < (size_t)side[0] * side[1] * side[2]; k++) {
        const size_t block[3] = { k % side[0], k / side[0] % side[1], k / side[0] / side[1] };
        v->block_densest[k] = find_densest(v, block);
    }
}

/// @param bounds the fog's box, less the scene's origin
static void place(rsv_volume *v, const rsv_fog *bounds)
{
    const float *low = &bounds->bounds_min.x, *high = &bounds->bounds_max.x;
    v->low = bounds->bounds_min;
    for (int k = 0; k < 3; k++)
        (&v->spacing.x)[k] = (float)(((double)high[k] - (double)low[k]) / (v->side[k] - 1));
}

static rsv_status copy_volume(rsv_context *context, const rsv_volume_grid *grid, rsv_volume **out)
{
    size_t points = (size_t)grid->side[0] * grid->side[1] * grid->side[2];
    rsv_volume *v = rsv_alloc(context, 1, sizeof *v);
    if (!v) return RSV_ERROR_MEMORY;
    for (int k = 0; k < 3; k++) {
        v->side[k] = grid->side[k];
        v->block_side[k] = (grid->side[k] - 2) / RSV_VOLUME_BLOCK + 1;
    }
    v->density = rsv_reserve(context, points, sizeof *v->density);
    v->block_densest = rsv_alloc(context,
        (size_t)v->block_side[0] * v->block_side[1] * v->block_side[2], sizeof *v->block_densest);
    if (!v->density || !v->block_densest) {
        rsv_volumes_destroy(context, v);
        return RSV_ERROR_MEMORY;
    }
    memcpy(v->density, grid->density, points * sizeof *v->density);
    find_blocks(v);
    *out = v;
    return RSV_OK;
}

void rsv_volumes_destroy(rsv_context *context, rsv_volume *v)
{
    while (v) {
        rsv_volume *earlier = v->earlier;
        rsv_free(context, v->density);
        rsv_free(context, v->block_densest);
        rsv_free(context, v);
        v = earlier;
    }
}

static rsv_status check_fog_of(const rsv_fog *fog, float densest)
{
    if (fog->scale_height < INFINITY)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "volume: its densities cannot fall with height, too; leave out the scale height");
    float most = densest * rgb_max(fog->extinction);
    if (most > RSV_LARGEST_EXTINCTION)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "volume: an extinction of %g per metre where it is densest; it must be at most 1e6",
            (double)most);
    return RSV_OK;
}

/// Gives the scene's fog, whose box is set, a volume, which is taken over.
static void adopt(rsv_scene *scene, rsv_volume *volume)
{
    place(volume, &scene->fog);
    volume->earlier = scene->volume;
    scene->volume = volume;
    scene->fog.volume = volume;
}

rsv_status rsv_scene_set_volume(rsv_scene *scene, const rsv_fog *fog, const rsv_volume_grid *grid)
{
    rsv_status status;
    rsv_volume *volume = NULL;
    float densest;
    rsv_fog filled = *fog;
    if (!grid) return rsv_scene_set_fog(scene, fog);
    RSV_TRY(rsv_scene_require_committed(scene));
    RSV_TRY(check_grid(grid));
    RSV_TRY(check_densities(grid, &densest));
    RSV_TRY(check_fog_of(fog, densest));
    filled.bounds_min = grid->low;
    filled.bounds_max = grid->high;
    RSV_TRY(copy_volume(scene->context, grid, &volume));
    volume->densest = densest;
    RSV_TRY(rsv_scene_set_fog(scene, &filled));
    if (!scene->view.fog) goto cleanup; // no extinction
    adopt(scene, volume);
    volume = NULL;
cleanup:
    rsv_volumes_destroy(scene->context, volume);
    return status;
}

rsv_status rsv_scene_restore_volume(rsv_scene *scene, const uint32_t side[3], const float *density)
{
    const rsv_volume_grid grid = { .side = { side[0], side[1], side[2] },
        .low = scene->fog.bounds_min,
        .high = scene->fog.bounds_max,
        .density = density };
    rsv_status status;
    rsv_volume *volume = NULL;
    float densest;
    RSV_TRY(check_grid(&grid));
    RSV_TRY(check_densities(&grid, &densest));
    RSV_TRY(check_fog_of(&scene->fog, densest));
    RSV_TRY(copy_volume(scene->context, &grid, &volume));
    volume->densest = densest;
    adopt(scene, volume);
cleanup:
    return status;
}

bool rsv_scene_volume_size(const rsv_scene_view *scene, uint32_t side[3])
{
    const rsv_volume *volume = scene->fog ? scene->fog->volume : NULL;
    if (volume) memcpy(side, volume->side, sizeof volume->side);
    return volume;
}
