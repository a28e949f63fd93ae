/// Scenes of tests/validation/cases.json: from JSON to a description, from that to a committed rsv_scene.
#ifndef CASE_SCENE_H
#define CASE_SCENE_H

#include "case_sky.h"

enum { CASE_MAX_SURFACES = 16, CASE_MAX_LIGHTS = 4, CASE_MAX_ZONES = 4, CASE_MAX_CAMERAS = 8 };

typedef enum case_shape { CASE_QUAD, CASE_DISK, CASE_SPHERE } case_shape;

/// Material of a part of a surface. Spheres have one part per zone of the polar angle, other surfaces
/// just one.
typedef struct case_zone {
    double cos_min, cos_max;
    double rho;      ///< albedo
    double exitance; ///< M, W/m2
} case_zone;

typedef struct case_surface {
    const char *name; ///< borrowed from the JSON
    case_shape shape;
    rsv_vec3 corner[4];      ///< quad: a parallelogram, counter-clockwise from the active side
    rsv_vec3 center, normal; ///< disk, sphere
    double radius;
    bool inside;        ///< sphere: the inside is the active side
    double mesh_radius; ///< sphere: of the vertices of its mesh
    int refinement;     ///< sphere: factor by which its facets are smaller
    enum { CASE_DIFFUSE, CASE_MIRROR, CASE_DIELECTRIC } bsdf;
    double ior;
    bool two_sided;
    case_zone zone[CASE_MAX_ZONES];
    int zone_count;
} case_surface;

/// Which of the listed sources and albedos a reading wants.
typedef struct case_variant {
    bool black;        ///< albedos 0: only direct light
    uint32_t emitters; ///< bit per surface that emits M = 1, nothing else does; 0 = as listed
    bool sky;          ///< the alternative sky in place of the lights
} case_variant;

typedef struct case_scene {
    case_surface surface[CASE_MAX_SURFACES];
    int surface_count;
    rsv_punctual_light light[CASE_MAX_LIGHTS];
    int light_count;
    rsv_camera camera[CASE_MAX_CAMERAS]; ///< one per radiance probe
    int camera_count;
    case_sky sky;
    bool sky_is_alternative; ///< present only in the variant that asks for it
    case_surface receiver;   ///< black, not under the alternative sky; no name = none
} case_scene;

/// NULL if understood, else why not.
const char *case_scene_read(const cJSON *json, case_scene *scene);

rsv_status case_scene_build(
    rsv_context *context, const case_scene *scene, case_variant variant, rsv_scene **built);

/// Index of the surface of that name, or -1.
int case_scene_find(const case_scene *scene, const char *name);

double case_surface_area(const case_surface *surface);
const case_zone *case_surface_zone(const case_surface *surface, rsv_vec3 point);

/// Whether `point` lies on the surface, up to rounding.
bool case_surface_contains(const case_surface *surface, rsv_vec3 point);

/// A probe on the active side at `point` of the surface; where a sphere's mesh would bury it, it is
/// moved along the radius to the mesh.
rsv_probe case_surface_probe(const case_surface *surface, rsv_vec3 point);

/// A probe at a uniformly distributed point, from two numbers in [0, 1).
rsv_probe case_surface_sample(const case_surface *surface, float x, float y);

/// Three numbers; zero if absent.
rsv_vec3 case_vector(const cJSON *json);

/// Whether any surface has an albedo.
bool case_scene_reflects(const case_scene *scene);

#endif
