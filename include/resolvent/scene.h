/// @file scene.h
/// Scenes: meshes, materials, lights, cameras.
///
/// Create a scene, add to it, commit it. It is then constant, and all queries are thread-safe. Commit flattens
/// instances into arrays of world-space triangles (rsv_scene_view), which the rest of the library reads.
#ifndef RESOLVENT_SCENE_H
#define RESOLVENT_SCENE_H

#include "resolvent/core.h"
#include "resolvent/luminaire.h"

#ifdef __cplusplus
extern "C" {
#endif

#define RSV_NONE UINT32_MAX ///< "no such index"

typedef struct rsv_scene rsv_scene;

/// How texture coordinates outside the unit square are treated.
typedef enum rsv_wrap { RSV_WRAP_REPEAT, RSV_WRAP_MIRROR, RSV_WRAP_CLAMP } rsv_wrap;

#define RSV_TEXTURE_MAX_SIDE 16384

/// An image for surfaces. Texture coordinate (0, 0) is its upper left corner, and v points down.
typedef struct rsv_texture_desc {
    size_t size;            ///< sizeof this structure; rsv_default_texture_desc() sets it
    const char *name;       ///< for messages; copied; NULL = "unnamed"
    uint32_t width, height; ///< 1..RSV_TEXTURE_MAX_SIDE
    uint32_t channel_count; ///< 1 = grey, 2 = grey and alpha, 3 = RGB, 4 = RGB and alpha
    /// [height * width * channel_count], row 0 on top; set exactly one of the two; copied
    const uint8_t *codes; ///< 0..255 stand for 0..1
    const float *values;  ///< linear
    bool srgb;            ///< colour channels of `codes` (not alpha) are sRGB
    rsv_wrap wrap_u, wrap_v;
    bool nearest; ///< magnified texels are squares; false = they are interpolated
} rsv_texture_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_texture_desc().
RSV_API void rsv_texture_desc_init(rsv_texture_desc *desc, size_t size);
static inline rsv_texture_desc rsv_default_texture_desc(void)
{
    rsv_texture_desc desc;
    rsv_texture_desc_init(&desc, sizeof desc);
    return desc;
}

/// The property of a material that a texture multiplies, and the channels that it uses (as in glTF).
typedef enum rsv_texture_role {
    RSV_TEXTURE_BASE_COLOR,                 ///< rgb
    RSV_TEXTURE_OPACITY,                    ///< a
    RSV_TEXTURE_METALLIC_ROUGHNESS,         ///< b metallic, g roughness
    RSV_TEXTURE_NORMAL,                     ///< rgb: tangent-space normal, 0..1 for -1..1
    RSV_TEXTURE_EMISSION,                   ///< rgb
    RSV_TEXTURE_SPECULAR,                   ///< a
    RSV_TEXTURE_SPECULAR_COLOR,             ///< rgb
    RSV_TEXTURE_TRANSMISSION,               ///< r
    RSV_TEXTURE_CLEARCOAT,                  ///< r
    RSV_TEXTURE_CLEARCOAT_ROUGHNESS,        ///< g
    RSV_TEXTURE_SHEEN_COLOR,                ///< rgb
    RSV_TEXTURE_SHEEN_ROUGHNESS,            ///< a
    RSV_TEXTURE_DIFFUSE_TRANSMISSION,       ///< a
    RSV_TEXTURE_DIFFUSE_TRANSMISSION_COLOR, ///< rgb
    RSV_TEXTURE_IRIDESCENCE,                ///< r
    RSV_TEXTURE_IRIDESCENCE_THICKNESS,      ///< g: from iridescence_thickness_min to _max
    /// rg: direction in tangent space, 0..1 for -1..1, rotated by anisotropy_rotation; b: strength
    RSV_TEXTURE_ANISOTROPY,
    /// rgb: like RSV_TEXTURE_NORMAL, of the clear coat; without it, the coat has interpolated normals
    RSV_TEXTURE_CLEARCOAT_NORMAL,
    RSV_TEXTURE_ROLE_COUNT
} rsv_texture_role;

/// One texture of a material.
typedef struct rsv_texture_ref {
    rsv_texture_role role;
    uint32_t texture;      ///< from rsv_scene_add_texture
    uint32_t uv_set;       ///< 0 or 1
    float transform[2][3]; ///< texture coordinate = transform * (u, v, 1)
    float scale;           ///< of normal maps: factor of x and y; others ignore it
} rsv_texture_ref;

/// A reference to `texture` with uv set 0, an identity transform and a scale of 1.
RSV_API rsv_texture_ref rsv_default_texture_ref(rsv_texture_role role, uint32_t texture);

/// A surface, described by glTF's metallic-roughness model and its extensions.
typedef struct rsv_material {
    const char *name;   ///< copied; NULL = "unnamed"
    rsv_rgb base_color; ///< apparent diffuse albedo, metal F0 and tint of transmission, 0..1
    float metallic;     ///< 0 dielectric .. 1 conductor
    float roughness;    ///< perceptual; alpha = roughness^2
    float ior;          ///< index of refraction of the dielectric interface, >= 1; default 1.5
    float specular;     ///< scale of the dielectric's Fresnel reflectance, 0..1; 0 = pure Lambert
    rsv_rgb specular_color; ///< tint of that reflectance
    float
        transmission; ///< fraction of the light entering the surface that is transmitted instead of diffused
    float thickness;            ///< 0 = thin sheet (no refraction); > 0 = boundary of a solid body
    rsv_rgb attenuation_color;  ///< colour that white light becomes after attenuation_distance
    float attenuation_distance; ///< metres; INFINITY = clear
    rsv_rgb emission;           ///< emitted radiance from the front, W/(sr m2)
    /// Fraction of the emission that cameras see directly, 0..1; default 1. Illumination and reflections use all of it.
    float camera_emission;
    bool double_sided; ///< both sides scatter and emit
    bool unlit;        ///< shows base_color as radiance to the camera; black in light transport

    float clearcoat; ///< fraction covered by a dielectric layer (ior 1.5) above everything else
    float clearcoat_roughness; ///< perceptual
    rsv_rgb sheen_color;       ///< reflectance of upright fibres at grazing angles; black = none
    float sheen_roughness;     ///< perceptual
    /// Fraction of the diffuse lobe that leaves on the other side of a thin sheet, and its tint.
    float diffuse_transmission;
    rsv_rgb diffuse_transmission_color;
    /// Mean free path of light below the surface, metres per channel. The light leaves with `base_color` as its total
    /// reflectance. Black = it leaves where it entered.
    rsv_rgb scatter_distance;
    /// Fraction of the surface under a thin film that lies directly on the interface, and the film's index, >= 1.
    float iridescence, iridescence_ior;
    /// Thickness of the film, nanometres: the maximum, or between the two according to a texture.
    float iridescence_thickness_min, iridescence_thickness_max;
    /// For smooth solid bodies: 20 / V, where V is the Abbe number; 0 = none. The index is `ior` for green, and lower
    /// by (ior - 1) / 2 V for red and higher by as much for blue.
    float dispersion;
    /// 0..1. For metal: stretches highlights along the tangent (from texture coordinates or the mesh), rotated by
    /// `anisotropy_rotation` radians towards the bitangent. alpha is roughness^2 across the tangent, and roughness^2 +
    /// (1 - roughness^2) anisotropy^2 along it. For dielectrics: widens highlights equally in all directions.
    float anisotropy, anisotropy_rotation;
    float opacity; ///< coverage: the remaining light passes unchanged
    /// > 0: the surface is cut out where its opacity is below this value, and opaque everywhere else.
    float alpha_cutoff;

    /// [texture_count] textures, which multiply the values above. Copied.
    const rsv_texture_ref *textures;
    size_t texture_count;
} rsv_material;

RSV_API rsv_material rsv_default_material(void);

/// A translucent material by name ("marble", "skin1", "wholemilk", ...), from coefficients measured by Jensen et al.
/// (2001). base_color is the dipole's total reflectance, and scatter_distance one reduced mean free path (marble: half
/// a millimetre). Everything else is as in rsv_default_material.
/// @return false if there is no preset of that name
RSV_API bool rsv_material_preset(const char *name, rsv_material *material);

/// Names of the presets, NULL-terminated.
RSV_API const char *const *rsv_material_preset_names(void);

/// Triangles in object space.
typedef struct rsv_mesh_desc {
    size_t size;               ///< sizeof this structure; rsv_default_mesh_desc() sets it
    const char *name;          ///< for messages; copied
    const rsv_vec3 *positions; ///< [vertex_count]; copied
    const rsv_vec3 *normals;   ///< [vertex_count]; NULL = flat shading
    size_t vertex_count;
    const uint32_t *indices; ///< [3 * triangle_count]; NULL = 0, 1, 2, ...
    size_t triangle_count;
    uint32_t material;        ///< from rsv_scene_add_material
    const float (*uvs[2])[2]; ///< [vertex_count] texture coordinates of each set, or NULL
    /// [vertex_count] direction of increasing u, and the sign w of the bitangent (n x t) * w. NULL = computed from the
    /// texture coordinates where a normal map needs them
    const float (*tangents)[4];
    /// [vertex_count] linear RGB and opacity, which multiply the material's; or NULL
    const float (*colors)[4];
    /// Set it if this mesh has other shapes in other versions of the scene. A light can then follow the mesh
    /// (rsv_light_follow). No two triangles may share a vertex, in any pose.
    bool deforms;
} rsv_mesh_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_mesh_desc().
RSV_API void rsv_mesh_desc_init(rsv_mesh_desc *desc, size_t size);
static inline rsv_mesh_desc rsv_default_mesh_desc(void)
{
    rsv_mesh_desc desc;
    rsv_mesh_desc_init(&desc, sizeof desc);
    return desc;
}

typedef enum rsv_punctual_light_kind {
    RSV_PUNCTUAL_POINT,
    RSV_PUNCTUAL_SPOT,
    RSV_PUNCTUAL_DIRECTIONAL,
    RSV_PUNCTUAL_LUMINAIRE, ///< measured intensities (luminaire.h); it lights only its cone
    RSV_PUNCTUAL_KINDS      ///< number of kinds
} rsv_punctual_light_kind;

/// Properties of a kind of punctual light.
typedef struct rsv_punctual_facts {
    const char *name;   ///< "point", "spot", "directional", as in KHR_lights_punctual; "luminaire"
    bool has_place;     ///< false = infinitely far away; its intensity is an irradiance
    bool has_direction; ///< false = it shines equally in all directions
    bool has_cone;      ///< shines only into a cone around its direction
} rsv_punctual_facts;

/// The name is NULL if `kind` is not below RSV_PUNCTUAL_KINDS.
RSV_API rsv_punctual_facts rsv_punctual_facts_of(rsv_punctual_light_kind kind);

/// A punctual light (area lights are emissive materials).
typedef struct rsv_punctual_light {
    const char *name; ///< copied
    rsv_punctual_light_kind kind;
    rsv_vec3 position;
    rsv_vec3
        direction; ///< unit; direction in which light travels (spot axis, directional, -z of a luminaire)
    /// W/sr, for a luminaire at its peak; directional: irradiance at normal incidence, W/m2
    rsv_rgb intensity;
    float inner_cone_angle; ///< radians, half angle; full intensity inside (spot)
    /// Radians, half angle; no light outside (spot: up to pi/2, luminaire: up to pi)
    float outer_cone_angle;
    float exponent; ///< spot intensity is also multiplied by cos^exponent; default 0
    /// Falloff between the cones, for t linear in the cosine: false = t^2 (KHR_lights_punctual), true = t^2 (3 - 2 t)
    /// (Blender).
    bool smooth_cone;
    // only for luminaires; start from rsv_luminaire_light()
    uint32_t luminaire; ///< from rsv_scene_add_luminaire
    /// Unit, perpendicular to `direction`: the direction of C = 0. For other lights, that of a luminaire that replaces
    /// them, approximately; 0 = along x.
    rsv_vec3 side;
    /// Size of the opening around `position` that light leaves uniformly, as in rsv_luminaire_opening. All 0 = a point.
    rsv_vec3 opening;
} rsv_punctual_light;

typedef struct rsv_camera {
    const char *name; ///< copied
    rsv_vec3 position;
    rsv_vec3 right, up, forward; ///< orthonormal; forward is the viewing direction
    float vertical_fov;          ///< radians; 0 = orthographic
    float vertical_extent;       ///< metres, half height of an orthographic view
    float aspect;                ///< width / height that it was made for; 0 = unspecified
} rsv_camera;

/// The directions that a picture shows.
typedef enum rsv_projection {
    RSV_PROJECTION_CAMERA, ///< perspective or orthographic, as the camera is
    /// All directions: longitude along rows, with straight ahead in the middle, latitude along columns
    RSV_PROJECTION_EQUIRECTANGULAR,
    /// The half space ahead, equidistant: 90 degrees off the axis is at the nearer edge. Black beyond that
    RSV_PROJECTION_FISHEYE
} rsv_projection;

/// Film and lens of a camera. All zero = a pinhole camera.
typedef struct rsv_film_desc {
    rsv_projection projection;
    /// Focal length divided by the diameter of the aperture, for film of 24 mm height; 0 = everything is in focus. Only
    /// for perspective cameras.
    float f_number;
    /// Metres along the axis to the plane in focus; 0 = the distance of what the centre of the picture shows
    float focus_distance;
    /// Shift of the film to the right and upwards, in widths and heights of the picture; not for pictures of all
    /// directions
    float shift[2];
} rsv_film_desc;

/// Light from infinitely far away, as a latitude-longitude image. Direction (x, y, z) looks up column
/// width (1/2 + atan2(z, x) / 2 pi) and row height acos(y) / pi, from the top. Pixels are interpolated.
typedef struct rsv_environment {
    const char *name;      ///< for messages; copied
    const rsv_rgb *pixels; ///< [height * width] radiance, W/(sr m2), row-major from the top; copied
    uint32_t width, height;
    float intensity; ///< factor of the pixels; 1 = unchanged
    float rotation;  ///< degrees about +y, counter-clockwise from above
} rsv_environment;

/// A participating medium in the air between surfaces, which absorbs, scatters and emits. It does not fill solid
/// bodies. Start from rsv_default_fog().
typedef struct rsv_fog {
    rsv_rgb extinction; ///< sigma_t, 1/m per channel, at and below `base_height`; 0..1e6
    rsv_rgb albedo;     ///< of single scattering, sigma_s / sigma_t, 0..1; default 1
    /// g of the Henyey-Greenstein phase function, the mean cosine, -1 < g < 1; default 0
    float anisotropy;
    /// Radiance emitted per metre of path where there is extinction, W/(sr m3); default 0
    rsv_rgb emission;
    /// Metres above `base_height` over which extinction and emission fall to 1/e; INFINITY (default) = they are
    /// constant.
    float scale_height;
    float base_height; ///< y in metres; default 0
    /// The box that the fog fills; sides may be at infinity. If the minimum is not below the maximum (default): all of
    /// space with a finite scale height, otherwise the box around the scene's surfaces, cameras, and lights with a
    /// position.
    rsv_vec3 bounds_min, bounds_max;
    /// Private: the densities that rsv_scene_set_volume multiplied extinction and emission by. rsv_scene_set_fog ignores
    /// it.
    const struct rsv_volume *volume;
} rsv_fog;

#define RSV_VOLUME_MAX_POINTS ((size_t)1 << 28) ///< 1 GiB

/// Densities of a heterogeneous medium at the points of a grid. In between, the density is interpolated along each axis;
/// outside, it is 0.
typedef struct rsv_volume_grid {
    uint32_t side[3];   ///< points along x, y and z; at least 2 each, at most RSV_VOLUME_MAX_POINTS in total
    rsv_vec3 low, high; ///< first and last point, metres, in the coordinates of the scene's file
    const float *density; ///< [side[2]][side[1]][side[0]], 0 or more, without a unit
} rsv_volume_grid;

#define RSV_ENVIRONMENT_MAX_PIXELS ((size_t)1 << 27) ///< 16384 x 8192

/// The committed scene as flat arrays in world space, relative to `origin`; valid until the scene is destroyed.
typedef struct rsv_scene_view {
    size_t vertex_count, triangle_count, material_count, light_count, camera_count, object_count;
    size_t texture_count, luminaire_count;
    const rsv_vec3 *position;      ///< [vertex_count]
    const rsv_vec3 *normal;        ///< [vertex_count], unit shading normals
    const float (*uv[2])[2];       ///< [vertex_count] texture coordinates; NULL = no mesh has any
    const float (*tangent)[4];     ///< [vertex_count] unit, 0 = none; NULL = no mesh has any
    const float (*color)[4];       ///< [vertex_count] RGB and opacity; NULL = all white
    const uint32_t (*triangle)[3]; ///< [triangle_count]; counter-clockwise seen from the front
    const uint32_t *triangle_material;  ///< [triangle_count]
    const uint32_t *triangle_object;    ///< [triangle_count]; one object per instanced mesh
    const rsv_material *material;       ///< [material_count]
    const struct rsv_texture *texture;  ///< [texture_count]; private to the library
    const uint8_t *material_varies;     ///< [material_count] 0 = uniform; otherwise private flags
    const struct rsv_twins *twins;      ///< private; NULL = there are no duplicate faces
    const rsv_punctual_light *light;    ///< [light_count]
    const rsv_luminaire *luminaire;     ///< [luminaire_count], scaled to a highest intensity of 1
    const rsv_camera *camera;           ///< [camera_count]
    const char *const *object_name;     ///< [object_count]
    const rsv_environment *environment; ///< pixels multiplied by the intensity; NULL = black
    const rsv_fog *
        fog; ///< with its box filled in, relative to `origin` like all coordinates; NULL = clear air
    rsv_vec3 bounds_min, bounds_max;
    /// Metres subtracted from all coordinates above if the scene is far from the origin of its file: position + origin
    /// is the position in the file (docs/conventions.md). All 0 in most scenes.
    double origin[3];
    const char *const *light_node;  ///< [light_count] the node that placed it; NULL = none
    const char *const *camera_node; ///< [camera_count] the same for cameras
} rsv_scene_view;

RSV_API rsv_status rsv_scene_create(rsv_context *context, rsv_scene **scene);
RSV_API void rsv_scene_destroy(rsv_scene *scene);

/// Properties of a texture.
typedef struct rsv_texture_info {
    const char *name; ///< borrowed
    uint32_t width, height, channel_count;
} rsv_texture_info;

/// @param texture index into the textures of a committed scene
/// @return all zero if there is no such texture
RSV_API rsv_texture_info rsv_scene_texture_info(const rsv_scene *scene, uint32_t texture);

/// Copies a texture and builds its mip levels. Each is the exact mean of the finer one in linear light. Non-finite
/// values become 0, with a warning. RSV_ERROR_FORMAT for sizes outside the limits.
RSV_API rsv_status rsv_scene_add_texture(
    rsv_scene *scene, const rsv_texture_desc *texture, uint32_t *texture_id);

/// Clamps values outside their range, with a warning that names the material. An albedo of 1 is accepted; the solver
/// decides whether a bounded solution exists.
RSV_API rsv_status rsv_scene_add_material(
    rsv_scene *scene, const rsv_material *material, uint32_t *material_id);

/// Indices out of range and non-finite positions are errors (RSV_ERROR_FORMAT). Degenerate triangles are skipped with a
/// warning, and unusable normals are replaced by geometric ones.
RSV_API rsv_status rsv_scene_add_mesh(
    rsv_scene *scene, const rsv_mesh_desc *mesh, uint32_t *mesh_id);

/// Places a mesh.
/// @param transform column-major 4x4, object to world; NULL = identity
/// @param name for messages and selection; NULL = the mesh's name
RSV_API rsv_status rsv_scene_add_instance(
    rsv_scene *scene, uint32_t mesh_id, const float transform[16], const char *name);

/// Copies measured intensities for lights of kind RSV_PUNCTUAL_LUMINAIRE, before or after commit.
/// @param id out; may be NULL
RSV_API rsv_status rsv_scene_add_luminaire(
    rsv_scene *scene, const rsv_luminaire *luminaire, uint32_t *id);

/// A luminaire at the origin that points down, with C = 0 along x, its measured intensity (683 lm/W) and its opening.
/// @param id from rsv_scene_add_luminaire
RSV_API rsv_punctual_light rsv_luminaire_light(const rsv_luminaire *luminaire, uint32_t id);

/// Luminous flux of a light of the scene, lm; 0 for directional lights.
RSV_API double rsv_punctual_lumens(const rsv_scene_view *scene, const rsv_punctual_light *light);

/// Replaces the punctual lights called `name` by a luminaire. If no light has that name, nodes that placed lights are
/// searched, and then, before commit, objects. Objects are kept, and get a luminaire at their origin that points along
/// their -y. A luminaire keeps the direction of a spot or directional light; in place of other lights it points down.
/// @param name `*` stands for any text, `?` for any character
/// @return RSV_ERROR_ARGUMENT if nothing has that name
RSV_API rsv_status rsv_scene_place_luminaire(
    rsv_scene *scene, const char *name, const rsv_luminaire *luminaire);

RSV_API rsv_status rsv_scene_add_light(rsv_scene *scene, const rsv_punctual_light *light);
RSV_API rsv_status rsv_scene_add_camera(rsv_scene *scene, const rsv_camera *camera);

/// Sets the environment (NULL = none), before or after commit. Existing solutions and pictures keep theirs. Pixels that
/// are negative, infinite or NaN are repaired, with a warning. RSV_ERROR_ARGUMENT for an empty image or an invalid
/// intensity or rotation, RSV_ERROR_UNSUPPORTED beyond RSV_ENVIRONMENT_MAX_PIXELS.
RSV_API rsv_status rsv_scene_set_environment(rsv_scene *scene, const rsv_environment *environment);

/// Sets an environment that needs no image file.
/// @param name "white" = a radiance of 1 from all directions; "sky" = a clear day with the sun at an elevation of 45
/// degrees, under which a white floor has a radiance of about 1
/// @param intensity, rotation as in rsv_environment
RSV_API rsv_status rsv_scene_set_builtin_environment(
    rsv_scene *scene, const char *name, float intensity, float rotation);

/// Whether `name` is a built-in environment; the names of all of them, NULL-terminated.
RSV_API bool rsv_environment_is_builtin(const char *name);
RSV_API const char *const *rsv_environment_builtin_names(void);

/// Clear air: no extinction.
RSV_API rsv_fog rsv_default_fog(void);

/// Fills a committed scene with fog. NULL, or fog without extinction, removes it. Heights and the box are in the
/// coordinates of the scene's file. RSV_ERROR_ARGUMENT for values outside their ranges. Mode `reference` supports all
/// fog. rsv_light_create, and rsv_render, rsv_probe_irradiance and rsv_certify with its solution, support fog in a
/// finite box. Nothing else supports scenes with fog (RSV_ERROR_UNSUPPORTED; docs/media.md).
RSV_API rsv_status rsv_scene_set_fog(rsv_scene *scene, const rsv_fog *fog);

/// Fills the box of a grid with fog whose extinction and emission are those of `fog` times the density there. The box and
/// the heights of `fog` are ignored. The grid is copied, and its memory is kept until the scene is destroyed. Supported
/// like fog in a finite box. RSV_ERROR_ARGUMENT for grids without any density, densities that are negative, infinite or
/// NaN, more than 1e6 per metre, and a finite scale height; RSV_ERROR_UNSUPPORTED for too many points.
/// @param grid borrowed; NULL = the same as rsv_scene_set_fog
RSV_API rsv_status rsv_scene_set_volume(
    rsv_scene *scene, const rsv_fog *fog, const rsv_volume_grid *grid);

/// Points along each axis of the grid on which the fog's density varies. @return false if it does not
RSV_API bool rsv_scene_volume_size(const rsv_scene_view *scene, uint32_t side[3]);

/// Flattens and checks the scene. RSV_ERROR_SCENE if nothing is left to draw. A scene without a camera gets one named
/// "framing" that shows all of it.
RSV_API rsv_status rsv_scene_commit(rsv_scene *scene);

/// The motion of an object of a committed scene.
typedef struct rsv_motion {
    uint32_t object;  ///< index into rsv_scene_view.object_name
    float matrix[16]; ///< column-major: maps its coordinates in the scene to the new ones
} rsv_motion;

/// Creates a copy of a scene with some objects moved, rotated or scaled. It shares everything else with `scene`, which
/// must outlive it. RSV_ERROR_ARGUMENT for objects that do not exist, and for matrices that are not finite, mirror, or
/// scale to zero.
/// @param motion [count]; if an object is listed more than once, only its first motion counts
RSV_API rsv_status rsv_scene_move(
    const rsv_scene *scene, const rsv_motion *motion, size_t count, rsv_scene **moved);

RSV_API const rsv_scene_view *rsv_scene_get_view(const rsv_scene *scene);
RSV_API rsv_context *rsv_scene_get_context(const rsv_scene *scene);

/// Index of the first object (an instanced mesh) of that name; RSV_NONE if there is none.
RSV_API uint32_t rsv_scene_find_object(const rsv_scene *scene, const char *name);

/// The triangles of an object in rsv_scene_view, which are contiguous. The elements on them are found by
/// rsv_element.triangle.
/// @param first out: index of the first triangle
/// @return number of triangles; 0 if there is no such object
RSV_API size_t rsv_scene_object_triangles(const rsv_scene *scene, uint32_t object, uint32_t *first);

/// Frees the copy of the file that a scene was loaded from (rsv_load_desc.keep_document). Bakes then write a new file,
/// and operator files contain no document.
RSV_API void rsv_scene_drop_document(rsv_scene *scene);

/// Whether a scene keeps such a copy.
RSV_API bool rsv_scene_has_document(const rsv_scene *scene);

/// A camera at `position` looking at `target`, y up.
RSV_API rsv_camera rsv_camera_look_at(
    const char *name, rsv_vec3 position, rsv_vec3 target, float vertical_fov, float aspect);

/// Index of the camera called `name`, or placed by a node of that name; NULL = the first. RSV_NONE if there is none.
RSV_API uint32_t rsv_scene_find_camera(const rsv_scene *scene, const char *name);

/// Options of a built-in scene. Start from rsv_default_builtin_desc().
typedef struct rsv_builtin_desc {
    size_t size; ///< sizeof this structure; rsv_default_builtin_desc() sets it
    /// A committed scene whose triangles become the body of cornell-glass, cornell-marble (a dragon, for example),
    /// cornell-plaster, cornell-showcase or character (a head that faces +z), with y up. The body is scaled and moved
    /// into place, and turned inside out if it faces inwards. Its materials, lights and cameras are ignored. Borrowed
    /// until the call returns; NULL = a generated body.
    const rsv_scene *body;
    size_t
        body_triangles; ///< approximate size of the generated body; 100..20,000,000, default 60,000
} rsv_builtin_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_builtin_desc().
RSV_API void rsv_builtin_desc_init(rsv_builtin_desc *desc, size_t size);
static inline rsv_builtin_desc rsv_default_builtin_desc(void)
{
    rsv_builtin_desc desc;
    rsv_builtin_desc_init(&desc, sizeof desc);
    return desc;
}

/// Builds and commits a built-in scene: cornell-blocks, cornell-spheres, cornell-glass, cornell-marble,
/// cornell-plaster, cornell-showcase, character, furnace, two-rooms, gallery, terraces, fog-rooms, milk or smoke.
/// fog-rooms and smoke come with fog.
/// @param name gallery and terraces take a size after a colon: "gallery:20" has 20 rooms (default 6), "terraces:1e6"
/// about a million triangles (default 1e5)
RSV_API rsv_status rsv_scene_builtin(rsv_context *context, const char *name, rsv_scene **scene);

/// The same with options. @param desc NULL = defaults

RSV_API rsv_status rsv_scene_builtin_with(
    rsv_context *context, const char *name, const rsv_builtin_desc *desc, rsv_scene **scene);

/// Whether `name`, with or without a size, names a built-in scene.
RSV_API bool rsv_scene_is_builtin(const char *name);

/// Names of the built-in scenes, NULL-terminated.
RSV_API const char *const *rsv_scene_builtin_names(void);

#ifdef __cplusplus
}
#endif

#endif
