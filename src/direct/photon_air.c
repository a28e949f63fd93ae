#include "photon_air.h"

#include "../core/core.h"

static void tell(const rsv_transport_scene *scene, const rsv_specular_path *path, bool leaves,
    const rsv_fog_witness *air)
{
    if (!air) return;
    rsv_ray ray = rsv_specular_segment(scene, path, leaves);
    air->cross(air->user, &ray, path->weight);
}

static void ignore(void *user, const rsv_ray *ray, rsv_rgb weight)
{
    (void)user, (void)ray, (void)weight;
}

static bool meets_surface(const rsv_transport_scene *scene, rsv_specular_path *path, bool leaves,
    rsv_random *random, const rsv_fog_witness *air)
{
    static const rsv_fog_witness nobody = { NULL, ignore };
    rsv_fog_crossing crossing = { .witness = air ? air : &nobody };
    return rsv_specular_cross_fog(scene, path, leaves, random, &crossing) == RSV_FOG_MEETS;
}

bool rsv_photon_cross_fog(const rsv_transport_scene *scene, rsv_specular_path *path,
    rsv_specular_move move, rsv_random *random, const rsv_fog_witness *air)
{
    bool leaves = move == RSV_SPECULAR_LEFT_SCENE;
    if (move == RSV_SPECULAR_LOST) return false;
    if (path->medium.depth || !(leaves || path->length > 0)) return !leaves;
    if (scene->view->fog->anisotropy != 0) return meets_surface(scene, path, leaves, random, air);
    tell(scene, path, leaves, air);
    if (!leaves) rsv_specular_dim(scene, path);
    return !leaves;
}

typedef struct air_beam {
    const rsv_photon_map *map;
    const rsv_fog *fog;
    rsv_fog_run run;
    rsv_rgb flux; ///< W, where the ray begins
    float mean;   ///< extinction by which voxels have an area, 1/m
} air_beam;

/// Metres of undimmed light that a channel of extinction sigma amounts to, times `mean`.
static double optical_length(const air_beam *b, int c, double begin, double end)
{
    double sigma = (double)(&b->fog->extinction.r)[c];
    double near = rsv_fog_column(&b->run, begin), far = rsv_fog_column(&b->run, end);
    double length =
        sigma > 0 ? exp(-sigma * near) * -expm1(-sigma * (far - near)) / sigma : far - near;
    return length * (double)b->mean;
}

static void light_voxel(void *user, uint32_t voxel, double begin, double end)
{
    const air_beam *b = user;
    size_t node = rsv_elements_surface_nodes(b->map->elements) + voxel;
    for (int c = 0; c < 3; c++)
        rsv_add_fixed(&b->map->flux[node][c],
            (double)(&b->flux.r)[c] * optical_length(b, c, begin, end) / b->map->unit);
}

void rsv_photon_map_light_air(
    const rsv_photon_map *map, const rsv_tracer *tracer, const rsv_ray *ray, rsv_rgb flux)
{
    const rsv_elements *e = map->elements;
    const rsv_fog *fog = e->scene->fog;
    air_beam beam = { map, fog, rsv_fog_run_of(fog, ray->origin, ray->direction, ray->t_max), flux,
        (fog->extinction.r + fog->extinction.g + fog->extinction.b) / 3 };
    const double range[2] = { beam.run.begin, beam.run.end };
    if (beam.run.column > 0) rsv_voxels_walk(e->voxels, tracer, ray, range, light_voxel, &beam);
}
