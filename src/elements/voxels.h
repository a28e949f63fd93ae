/// Elements of the air, where fog scatters light: a regular grid of cells over the fog's box. Walls that cut a cell
/// divide it into *voxels*, so that light on one side of a wall is not seen on the other.
///
/// The nodes of voxels follow those of surfaces. A node stores a quarter of the mean fluence of its voxel, which is pi
/// times the mean radiance. With isotropic scattering, it then has the radiance albedo x E / pi, like a surface of that
/// irradiance and albedo, and its row has the scale of a surface's.
#ifndef RSV_VOXELS_H
#define RSV_VOXELS_H

#include "../specular/specular_path.h"
#include "elements.h"

#define RSV_VOXEL_POINTS 16

typedef struct rsv_voxels {
    rsv_context *context;
    rsv_vec3 low, size; ///< corner of the grid; edges of a cell, metres
    uint32_t side[3];   ///< cells along each axis
    size_t cell_count, count, place_count;
    uint32_t *begin;       ///< [cell_count + 1] first voxel of each cell
    uint32_t *cell;        ///< [count]
    uint16_t *points;      ///< [count] bit k = point k of the cell lies in this voxel
    uint32_t *place_begin; ///< [count + 1] into `place`
    /// Heterogeneous fog's densities; NULL = it is the same everywhere, and so are the next two.
    const struct rsv_volume *volume;
    float *density, *densest; ///< [count] mean over each voxel, and a bound
    rsv_vec3 *place;          ///< in voxels of cells that are cut, evenly distributed
} rsv_voxels;

/// A grid over the scene's fog, whose box is finite. @param target approximate number of cells @param rays out: rays
/// traced
rsv_status rsv_voxels_create(
    const rsv_transport_scene *scene, size_t target, uint64_t *rays, rsv_voxels **voxels);
void rsv_voxels_destroy(rsv_voxels *voxels); ///< NULL is allowed

/// Completes voxels of which grid, `begin`, `points`, `place_begin` and `place` were kept. RSV_ERROR_FORMAT if they do
/// not fit each other.
rsv_status rsv_voxels_restore(rsv_voxels *voxels);

/// Adds the nodes of voxels to elements without any, which take them over, even on failure.
rsv_status rsv_elements_add_voxels(rsv_elements *elements, rsv_voxels *voxels);

/// Whether no wall cuts the voxel's cell.
RSV_INLINE bool rsv_voxel_is_whole(const rsv_voxels *voxels, uint32_t voxel)
{
    return voxels->points[voxel] == (1u << RSV_VOXEL_POINTS) - 1;
}

/// Volume, m3.
float rsv_voxel_volume(const rsv_voxels *voxels, uint32_t voxel);

/// Lower corner of its cell.
rsv_vec3 rsv_voxel_low(const rsv_voxels *voxels, uint32_t voxel);

/// About its middle.
rsv_vec3 rsv_voxel_centre(const rsv_voxels *voxels, uint32_t voxel);

/// A place in the voxel, evenly distributed. @param u in [0, 1)
rsv_vec3 rsv_voxel_even_place(const rsv_voxels *voxels, uint32_t voxel, const float u[3]);

/// A place in the voxel, distributed as the fog's density. @param u in [0, 1)
rsv_vec3 rsv_voxel_place(const rsv_voxels *voxels, uint32_t voxel, const float u[3]);

/// Takes the densities of a scene's fog; NULL = it is the same everywhere.
rsv_status rsv_voxels_weigh(rsv_voxels *voxels, const struct rsv_volume *volume);

/// Density of the fog at a place. @return 1 where it is the same everywhere
float rsv_voxels_density(const rsv_voxels *voxels, rsv_vec3 place);

/// Mean density over a voxel; a little where there is none, so that it has an area.
float rsv_voxel_mean_density(const rsv_voxels *voxels, uint32_t voxel);

/// The voxel of a place that light comes to through the air.
uint32_t rsv_voxels_find(const rsv_voxels *voxels, const rsv_tracer *tracer, rsv_vec3 place);

/// A piece of a ray within one cell of the grid. @param begin, end metres along the ray
typedef void (*rsv_voxel_cell_visitor)(void *user, size_t cell, double begin, double end);

/// Visits the cells along a ray between two distances, in order. @param ray of unit direction
void rsv_voxels_walk_cells(const rsv_voxels *voxels, const rsv_ray *ray, const double range[2],
    rsv_voxel_cell_visitor visit, void *user);

/// A piece of a ray within one voxel. @param begin, end metres along the ray
typedef void (*rsv_voxel_visitor)(void *user, uint32_t voxel, double begin, double end);

/// Visits the voxels along a ray between two distances, in order. @param ray of unit direction, free of surfaces in
/// between
void rsv_voxels_walk(const rsv_voxels *voxels, const rsv_tracer *tracer, const rsv_ray *ray,
    const double range[2], rsv_voxel_visitor visit, void *user);

/// The node of that voxel; RSV_NONE without fog.
uint32_t rsv_elements_find_voxel(
    const rsv_elements *elements, const rsv_tracer *tracer, rsv_vec3 place);

#endif
