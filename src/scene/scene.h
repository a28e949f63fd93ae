/// The contents of a scene before and after commit.
#ifndef RSV_SCENE_H
#define RSV_SCENE_H

#include "../core/core.h"
#include "document.h"
#include "resolvent/scene.h"
#include "texture.h"

#include <math.h>

typedef struct rsv_mesh {
    char *name;
    rsv_vec3 *position;
    rsv_vec3 *normal; ///< unit; zero = use the geometric normal; NULL = use it everywhere
    float (*uv[2])[2], (*tangent)[4], (*color)[4]; ///< [vertex_count] each, or NULL
    uint32_t *index;                               ///< [3 * triangle_count]
    size_t vertex_count, triangle_count;
    uint32_t material;
    bool deforms;            ///< has other shapes in other versions of the scene
    size_t degenerate_count; ///< world-space triangles that flattening dropped
} rsv_mesh;

typedef struct rsv_instance {
    char *name;
    uint32_t mesh;
    double transform[16]; ///< column-major, object to world
} rsv_instance;

/// Data of a light or camera that users of the library do not see.
typedef struct rsv_fixture {
    double position[3]; ///< in the world, before an origin is taken out
    char *node;         ///< name of the node that placed it; NULL = only its own name
} rsv_fixture;

struct rsv_scene {
    rsv_context *context;
    bool commit_tried, committed;
    bool is_part;                 ///< of another scene: no camera is missed
    const struct rsv_scene *base; ///< that this one varies (variant.h); NULL = it stands by itself
    const struct rsv_scene *rest; ///< whose textures these are (moment.h); NULL = it has its own
    bool owns_positions, owns_normals, owns_environment; ///< of a variant

    rsv_material *material;
    rsv_punctual_light *light;
    rsv_camera *camera;
    size_t material_count, light_count, camera_count;
    size_t material_capacity, light_capacity, camera_capacity;
    rsv_fixture *light_fixture, *camera_fixture; ///< [light_count], [camera_count]
    size_t light_fixture_capacity, camera_fixture_capacity;
    const char **light_node, **camera_node; ///< the view's, from rsv_scene_list_nodes()
    bool in_double;                         ///< instances came in double (rsv_scene_place_instance)
    double origin[3];                       ///< taken out of all coordinates (origin.c)
    double
        grain; ///< metres between numbers of single precision in the file (rsv_scene_note_single)
    rsv_texture *texture;
    size_t texture_count, texture_capacity;
    rsv_luminaire *luminaire; ///< of a variant, its base's
    size_t luminaire_count, luminaire_capacity;
    uint8_t *material_varies; ///< [material_count]; filled by commit

    // object space; released by commit
    rsv_mesh *mesh;
    rsv_instance *instance;
    size_t mesh_count, instance_count, mesh_capacity, instance_capacity;

    // world space; filled by commit
    rsv_vec3 *position, *normal;
    float (*uv[2])[2], (*tangent)[4], (*color)[4]; ///< NULL = no mesh has any
    uint32_t (*triangle)[3];
    uint32_t *triangle_material, *triangle_object;
    uint32_t *
        triangle_source; ///< triangle within its mesh; NULL = not known (scenes restored without a document)
    uint32_t *object_instance; ///< which call of rsv_scene_add_instance placed it
    char **object_name;
    size_t vertex_count, triangle_count, object_count;
    size_t position_capacity, normal_capacity;
    size_t uv_capacity[2], tangent_capacity, color_capacity;

    rsv_environment environment; ///< name and pixels owned; pixels NULL = none
    rsv_fog fog;                 ///< its box found; the view points here where there is any
    struct rsv_volume
        *volume; ///< of that fog, and those it had before; of a variant, its own alone
    rsv_scene_document document; ///< of a variant, its base's counts

    struct rsv_twins_owner *twins; ///< NULL = no two faces lie in the same place

    rsv_scene_view view;
};

/// As rsv_scene_add_instance, in double: far from the origin floats have few digits.
rsv_status rsv_scene_place_instance(
    rsv_scene *scene, uint32_t mesh_id, const double transform[16], const char *name);

/// As rsv_scene_add_light and rsv_scene_add_camera, at a place in double, which counts in place of that in `light` and
/// `camera`. @param node name of the node that placed it, by which it can be chosen too; NULL = none
rsv_status rsv_scene_place_light(
    rsv_scene *scene, const rsv_punctual_light *light, const double position[3], const char *node);
rsv_status rsv_scene_place_camera(
    rsv_scene *scene, const rsv_camera *camera, const double position[3], const char *node);

/// Lists the names of the nodes that placed lights and cameras, for the view.
rsv_status rsv_scene_list_nodes(rsv_scene *scene);

/// Subtracts a common origin from instances, lights and cameras, if a scene that was placed in double precision is far
/// from 0. Otherwise nothing changes, not even a bit: a scene placed in single precision would gain nothing. Call it
/// before flattening.
rsv_status rsv_scene_take_origin(rsv_scene *scene);

/// Records that the file has positions up to this many metres from 0 in single precision, for a warning where that is
/// too coarse. (The extent of meshes is known.)
void rsv_scene_note_single(rsv_scene *scene, double farthest);

/// Whether an origin was taken out.
static inline bool rsv_scene_is_far(const rsv_scene *scene)
{
    return scene->origin[0] != 0 || scene->origin[1] != 0 || scene->origin[2] != 0;
}

/// Whether a fog, NULL = none, fills a finite box that is not flat.
bool rsv_fog_has_volume(const rsv_fog *fog);

/// RSV_ERROR_UNSUPPORTED if the scene has unbounded fog. @param what cannot be done: "a solution"
rsv_status rsv_scene_refuse_endless_fog(const rsv_scene *scene, const char *what);

/// RSV_ERROR_ARGUMENT if the scene is not committed. All public functions that read a scene's view call it first.
rsv_status rsv_scene_require_committed(const rsv_scene *scene);

/// RSV_ERROR_UNSUPPORTED if the scene has fog. @param what cannot be done: "a solution"
rsv_status rsv_scene_refuse_fog(const rsv_scene *scene, const char *what);

/// Brings every value into its range, with one warning that names the material.
void rsv_material_clamp(const rsv_context *context, rsv_material *material);

/// Frees the environment's picture and name.
void rsv_scene_release_environment(rsv_scene *scene);

/// Metres along an axis. Beyond, products of lengths leave the range of float, and ray tracers refuse to look (Embree
/// at 1.8e18).
#define RSV_FARTHEST 1e12f

static inline bool rsv_within_reach(rsv_vec3 p)
{
    return fabsf(p.x) <= RSV_FARTHEST && fabsf(p.y) <= RSV_FARTHEST && fabsf(p.z) <= RSV_FARTHEST;
}

/// Gives a smooth mesh under a normal map tangents, if it comes without.
rsv_status rsv_mesh_create_tangents(
    rsv_context *context, const rsv_material *material, rsv_mesh *mesh);

/// Whether a committed scene has any light: emission, also of fog, lamps or an environment.
bool rsv_scene_shines(const rsv_scene_view *view);

/// Fills the world-space arrays from meshes and instances.
rsv_status rsv_scene_flatten(rsv_scene *scene);

/// Unit geometric normal of a triangle; false if it is degenerate.
bool rsv_triangle_normal(rsv_vec3 a, rsv_vec3 b, rsv_vec3 c, rsv_vec3 *normal);

/// Checks the flattened scene and commits it.
rsv_status rsv_scene_finish(rsv_scene *scene);

/// Adds a punctual light to a committed scene; the view's array of lights may move.
rsv_status rsv_scene_append_light(rsv_scene *scene, const rsv_punctual_light *light);

/// Finds faces of a committed scene that are in the same place (twins.h), and adds them to the view. Warns where it is
/// a guess which of them is visible. Also warns of lamps enclosed by something opaque, because both searches use the
/// same tree.
rsv_status rsv_scene_find_twins(rsv_scene *scene);
/// The same after vertices of a variant have moved, without searching for enclosed lamps.
rsv_status rsv_scene_move_twins(rsv_scene *scene);
/// Takes known ones to where they are now, without looking for others.
void rsv_scene_fit_twins(rsv_scene *scene);
/// Gives a variant boxes of its own around faces that lie in the same place, for vertices of its own.
rsv_status rsv_scene_copy_twins(rsv_scene *variant);
void rsv_scene_release_twins(rsv_scene *scene);

/// Finds the bounds of a committed scene again, after vertices were moved, and faces in the same place.
rsv_status rsv_scene_update_bounds(rsv_scene *scene);
/// The same, but faces that are newly in the same place are left to a later rsv_scene_update_bounds.
rsv_status rsv_scene_update_bounds_only(rsv_scene *scene);

/// A camera that shows the whole sphere from the front and a little above.
rsv_camera rsv_camera_frame_sphere(const char *name, rsv_vec3 centre, float radius);

/// Releases meshes and instances.
void rsv_scene_release_sources(rsv_scene *scene);

#endif
