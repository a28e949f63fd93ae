/// @file scene.h
/// Scenes: meshes, materials, lights, cameras.
///
/// Create a scene, add to it, commit it. It is then constant, and every query is thread-safe.
/// Commit flattens instances into arrays of world-space triangles (rsv_scene_view); the rest of the
/// library reads only these.
#ifndef RESOLVENT_SCENE_H
#define RESOLVENT_SCENE_H

#include "resolvent/core.h"
#include "resolvent/luminaire.h"

#ifdef __cplusplus
extern "C" {
#endif

#define RSV_NONE UINT32_MAX ///< "no such index"

typedef struct rsv_scene rsv_scene;

/// What happens outside the unit square of texture coordinates.
typedef enum rsv_wrap { RSV_WRAP_REPEAT, RSV_WRAP_MIRROR, RSV_WRAP_CLAMP } rsv_wrap;

#define RSV_TEXTURE_MAX_SIDE 16384

/// A picture to be laid on surfaces. Texture coordinate (0, 0) is its upper left corner, v runs down.
typedef struct rsv_texture_desc {
    size_t size;            ///< of this structure; rsv_default_texture_desc() sets it
    const char *name;       ///< for messages; copied; NULL = "unnamed"
    uint32_t width, height; ///< 1..RSV_TEXTURE_MAX_SIDE
    uint32_t channel_count; ///< 1 = grey, 2 = grey and alpha, 3 = RGB, 4 = RGB and alpha
    /// [height * width * channel_count], row 0 on top; exactly one of the two; copied
    const uint8_t *codes; ///< 0..255 stand for 0..1
    const float *values;  ///< linear
    bool srgb;            ///< colour codes (not alpha) follow the sRGB curve
    rsv_wrap wrap_u, wrap_v;
    bool nearest; ///< seen from near, texels are squares; else they are blended
} rsv_texture_desc;

/// Defaults, for a descriptor of `size` bytes: what rsv_default_texture_desc() is made of.
RSV_API void rsv_texture_desc_init(rsv_texture_desc *desc, size_t size);
static inline rsv_texture_desc rsv_default_texture_desc(void)
{
    rsv_texture_desc desc;
    rsv_texture_desc_init(&desc, sizeof desc);
    return desc;
}

/// What of a material a texture multiplies, and by which of its channels (as in glTF).
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
    RSV_TEXTURE_ANISOTROPY, ///< rg: direction in tangent space, 0..1 for -1..1, turned by anisotropy_rotation; b: strength
    RSV_TEXTURE_CLEARCOAT_NORMAL, ///< rgb, like RSV_TEXTURE_NORMAL: of the clear coat, which has interpolated normals without it
    RSV_TEXTURE_ROLE_COUNT
} rsv_texture_role;

/// One texture of a material.
typedef struct rsv_texture_ref {
    rsv_texture_role role;
    uint32_t texture;      ///< from rsv_scene_add_texture
    uint32_t uv_set;       ///< 0 or 1
    float transform[2][3]; ///< texture coordinate = transform * (u, v, 1)
    float scale;           ///< of normal maps' x and y; others ignore it
} rsv_texture_ref;

/// A reference to `texture` by uv set 0 as it stands.
RSV_API rsv_texture_ref rsv_default_texture_ref(rsv_texture_role role, uint32_t texture);

/// Surface description, in the terms of glTF's metallic-roughness model and its extensions.
typedef struct rsv_material {
    const char *name;   ///< copied; NULL = "unnamed"
    rsv_rgb base_color; ///< apparent diffuse albedo, metal F0 and tint of transmission, 0..1
    float metallic;     ///< 0 dielectric .. 1 conductor
    float roughness;    ///< perceptual; alpha = roughness^2
    float ior;          ///< of the dielectric interface, >= 1; default 1.5
    float specular;     ///< scale of the dielectric's Fresnel reflectance, 0..1; 0 = pure Lambert
    rsv_rgb specular_color; ///< tint of that reflectance
    float transmission; ///< share of the light that enters and is transmitted rather than diffused
    float thickness;    ///< 0 = thin sheet (no refraction); > 0 = boundary of a solid body
    rsv_rgb attenuation_color;  ///< colour that white light becomes after attenuation_distance
    float attenuation_distance; ///< metres; INFINITY = clear
    rsv_rgb emission;           ///< emitted radiance from the front, W/(sr m2)
    /// Share of the emission that cameras see on straight lines, 0..1; default 1. Light and reflections have all of it.
    float camera_emission;
    bool double_sided; ///< both sides scatter and emit alike
    bool unlit;        ///< shows base_color as radiance to the camera; black in light transport

    float clearcoat;           ///< share of a dielectric layer (ior 1.5) over everything else
    float clearcoat_roughness; ///< perceptual
    rsv_rgb sheen_color;       ///< reflectance of upright fibres at grazing angles; black = none
    float sheen_roughness;     ///< perceptual
    /// Share of the diffuse lobe that leaves on the other side of a thin sheet, and its tint.
    float diffuse_transmission;
    rsv_rgb diffuse_transmission_color;
    /// Mean free path of light that enters and scatters below the surface, metres per channel, after
    /// which it leaves with `base_color` as its total reflectance; black = leaves where it entered.
    rsv_rgb scatter_distance;
    /// Share of the surface under a thin film, directly on the interface; its index, >= 1, and its thickness in nanometres:
    /// iridescence_thickness_max, or between the two where a texture tells.
    float iridescence, iridescence_ior;
    float iridescence_thickness_min, iridescence_thickness_max;
    /// Of smooth solid bodies: 20 / Abbe's number V; 0 = none. Red refracts with the ior less (ior - 1) / 2 V, blue with as much
    /// more, green with `ior`.
    float dispersion;
    /// 0..1: stretches the highlights of metal along the tangent (of texture coordinates, or the mesh's own), turned by
    /// `anisotropy_rotation` radians towards the bitangent: alpha is roughness^2 across, and along it
    /// roughness^2 + (1 - roughness^2) anisotropy^2. Of dielectrics it widens the highlight alike in all directions.
    float anisotropy, anisotropy_rotation;
    float opacity; ///< coverage: light passes unchanged through the rest
    /// Above 0: the surface is cut out where its opacity is below this, and opaque everywhere else.
    float alpha_cutoff;

    /// [texture_count] what varies over the surface: a texture multiplies the value above. Copied.
    const rsv_texture_ref *textures;
    size_t texture_count;
} rsv_material;

RSV_API rsv_material rsv_default_material(void);

/// A translucent material by name ("marble", "skin1", "wholemilk", ...), from coefficients that Jensen et al.
/// measured (2001): base_color is the dipole's total reflectance, scatter_distance one reduced mean free path
/// (marble: half a millimetre). Everything else is as in rsv_default_material. False if there is none of that name.
RSV_API bool rsv_material_preset(const char *name, rsv_material *material);

/// Names of the presets, NULL-terminated.
RSV_API const char *const *rsv_material_preset_names(void);

/// Triangles in object space.
typedef struct rsv_mesh_desc {
    size_t size;               ///< of this structure; rsv_default_mesh_desc() sets it
    const char *name;          ///< for messages; copied
    const rsv_vec3 *positions; ///< [vertex_count]; copied
    const rsv_vec3 *normals;   ///< [vertex_count] or NULL = flat shading
    size_t vertex_count;
    const uint32_t *indices; ///< [3 * triangle_count], or NULL = 0, 1, 2, ...
    size_t triangle_count;
    uint32_t material;        ///< from rsv_scene_add_material
    const float (*uvs[2])[2]; ///< [vertex_count] texture coordinates by set, or NULL
    /// [vertex_count] direction of increasing u, and the sign of the bitangent (n x t) * w; NULL = from the
    /// texture coordinates, where a normal map asks for them
    const float (*tangents)[4];
    const float (
        *colors)[4]; ///< [vertex_count] linear RGB and opacity, multiply the material's; or NULL
    /// true = other versions of the scene have this mesh in other shapes. A light can then follow it (rsv_light_follow): no
    /// two triangles share a vertex, in any pose.
    bool deforms;
} rsv_mesh_desc;

/// Defaults, for a descriptor of `size` bytes: what rsv_default_mesh_desc() is made of.
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
    RSV_PUNCTUAL_LUMINAIRE, ///< measured intensities (luminaire.h); its cone is all that it lights
    RSV_PUNCTUAL_KINDS      ///< how many there are
} rsv_punctual_light_kind;

/// What distinguishes a kind of punctual lights.
typedef struct rsv_punctual_facts {
    const char *name;   ///< "point", "spot", "directional", as in KHR_lights_punctual; "luminaire"
    bool has_place;     ///< else it is infinitely far away, and its intensity is an irradiance
    bool has_direction; ///< else it shines alike to all sides
    bool has_cone;      ///< shines into a cone around its direction alone
} rsv_punctual_facts;

/// Of any kind below RSV_PUNCTUAL_KINDS; beyond, the name is NULL.
RSV_API rsv_punctual_facts rsv_punctual_facts_of(rsv_punctual_light_kind kind);

/// A punctual light (area lights are emissive materials).
typedef struct rsv_punctual_light {
    const char *name; ///< copied
    rsv_punctual_light_kind kind;
    rsv_vec3 position;
    rsv_vec3
        direction; ///< unit, the way the light travels (spot axis, directional, -z of a luminaire)
    rsv_rgb
        intensity; ///< W/sr, of a luminaire at its peak; directional: irradiance at normal incidence, W/m2
    float inner_cone_angle; ///< radians, half angle; full intensity inside (spot)
    float
        outer_cone_angle; ///< radians, half angle; none outside (spot: up to pi/2, luminaire: up to pi)
    float exponent;       ///< spot intensity is also multiplied by cos^exponent; default 0
    /// Between the cones, with t the ramp in the cosine: false = t^2 (KHR_lights_punctual), true = t^2 (3 - 2 t) (Blender).
    bool smooth_cone;
    // of luminaires alone; start from rsv_luminaire_light()
    uint32_t luminaire; ///< from rsv_scene_add_luminaire
    /// Unit, at right angles to `direction`: where C = 0 points. Of other lights, about that of a luminaire that takes their
    /// place; 0 = along x.
    rsv_vec3 side;
    /// Light leaves alike from all over an opening around `position`; as rsv_luminaire_opening has it. All 0 = a point.
    rsv_vec3 opening;
} rsv_punctual_light;

typedef struct rsv_camera {
    const char *name; ///< copied
    rsv_vec3 position;
    rsv_vec3 right, up, forward; ///< orthonormal; forward is the viewing direction
    float vertical_fov;          ///< radians; 0 = orthographic
    float vertical_extent;       ///< metres, half height of an orthographic view
    float aspect;                ///< width / height for which it was made; 0 = unspecified
} rsv_camera;

/// What a picture shows of the directions around a camera.
typedef enum rsv_projection {
    RSV_PROJECTION_CAMERA, ///< what the camera is: perspective or orthographic
    RSV_PROJECTION_EQUIRECTANGULAR, ///< all: longitude along rows, ahead in the middle; latitude along columns
    RSV_PROJECTION_FISHEYE ///< the half space ahead, equidistant: 90 degrees off the axis at the nearer edge; black beyond
} rsv_projection;

/// How the film of a camera takes a picture. All zero: as a pinhole camera does.
typedef struct rsv_film_desc {
    rsv_projection projection;
    /// Focal length divided by the diameter of the aperture, on film of 24 mm height; 0 = all is sharp. Perspective alone.
    float f_number;
    float
        focus_distance; ///< metres along the axis to what is sharp; 0 = to what is in the middle of the picture
    float shift
        [2]; ///< of the film to the right and upwards, in widths and heights of the picture; not for all directions
} rsv_film_desc;

/// Light from infinitely far away, as a latitude-longitude picture. Direction (x, y, z) looks up column
/// 1/2 + atan2(z, x) / 2 pi of the width and row acos(y) / pi of the height, from the top; in between,
/// pixels are interpolated.
typedef struct rsv_environment {
    const char *name;      ///< for messages; copied
    const rsv_rgb *pixels; ///< [height * width] radiance, W/(sr m2), row-major from the top; copied
    uint32_t width, height;
    float intensity; ///< multiplies the pixels; 1 = as they are
    float
        rotation; ///< degrees by which the surroundings turn about +y, counter-clockwise from above
} rsv_environment;

/// A participating medium in the air between surfaces: it absorbs, scatters and emits. Solid bodies displace it. Start from
/// rsv_default_fog().
typedef struct rsv_fog {
    rsv_rgb extinction; ///< sigma_t, 1/m per channel, at and below `base_height`; 0..1e6
    rsv_rgb albedo;     ///< of single scattering, sigma_s / sigma_t, 0..1; default 1
    float
        anisotropy; ///< g of Henyey and Greenstein's phase function: mean cosine, -1 < g < 1; default 0
    rsv_rgb
        emission; ///< W/(sr m3): radiance emitted per metre of path, where there is extinction; default 0
    /// Metres over which extinction and emission fall to 1/e above `base_height`; INFINITY (default) = nowhere.
    float scale_height;
    float base_height; ///< y in metres; default 0
    /// The box that it fills; sides may be infinitely far. Where the minimum is not below the maximum (default): with a
    /// finite scale height all of space, else the box around the scene's surfaces, cameras, and lights that have a place.
    rsv_vec3 bounds_min, bounds_max;
} rsv_fog;

#define RSV_ENVIRONMENT_MAX_PIXELS ((size_t)1 << 27) ///< 16384 x 8192

/// The committed scene as flat arrays in world space, less `origin`; valid until the scene is destroyed.
typedef struct rsv_scene_view {
    size_t vertex_count, triangle_count, material_count, light_count, camera_count, object_count;
    size_t texture_count, luminaire_count;
    const rsv_vec3 *position;          ///< [vertex_count]
    const rsv_vec3 *normal;            ///< [vertex_count], unit shading normals
    const float (*uv[2])[2];           ///< [vertex_count] texture coordinates; NULL = none has any
    const float (*tangent)[4];         ///< [vertex_count] unit, 0 = none; NULL = none has any
    const float (*color)[4];           ///< [vertex_count] RGB and opacity; NULL = all white
    const uint32_t (*triangle)[3];     ///< [triangle_count]; counter-clockwise seen from the front
    const uint32_t *triangle_material; ///< [triangle_count]
    const uint32_t *triangle_object;   ///< [triangle_count]; one object per instanced mesh
    const rsv_material *material;      ///< [material_count]
    const struct rsv_texture *texture; ///< [texture_count]; private to the library
    const uint8_t *material_varies;  ///< [material_count] 0 = the same all over; else private flags
    const struct rsv_twins *twins;   ///< private; NULL = no two faces lie in the same place
    const rsv_punctual_light *light; ///< [light_count]
    const rsv_luminaire *luminaire;  ///< [luminaire_count] with 1 as the highest intensity
    const rsv_camera *camera;        ///< [camera_count]
    const char *const *object_name;  ///< [object_count]
    const rsv_environment *environment; ///< pixels with the intensity in them; NULL = black
    const rsv_fog *fog; ///< with its box found, less `origin` as all coordinates; NULL = clear air
    rsv_vec3 bounds_min, bounds_max;
    /// Metres that were taken out of all coordinates above, because the scene lies far from the origin of its file:
    /// position + origin is what the file says (docs/conventions.md). All 0 in most scenes.
    double origin[3];
    const char *const *light_node;  ///< [light_count] the node that placed it; NULL = none
    const char *const *camera_node; ///< [camera_count] likewise
} rsv_scene_view;

RSV_API rsv_status rsv_scene_create(rsv_context *context, rsv_scene **scene);
RSV_API void rsv_scene_destroy(rsv_scene *scene);

/// What is known of a texture.
typedef struct rsv_texture_info {
    const char *name; ///< borrowed
    uint32_t width, height, channel_count;
} rsv_texture_info;

/// @param texture of a committed scene's materials; all zero if there is none
RSV_API rsv_texture_info rsv_scene_texture_info(const rsv_scene *scene, uint32_t texture);

/// Copies a texture and builds its pyramid of coarser versions, each the exact mean of the finer one in linear
/// light. Non-finite values become 0 with a warning. RSV_ERROR_FORMAT for sizes outside the limits.
RSV_API rsv_status rsv_scene_add_texture(
    rsv_scene *scene, const rsv_texture_desc *texture, uint32_t *texture_id);

/// Values outside their range are clamped with a warning that names the material. An albedo of 1 is
/// kept here; whether a bounded answer exists is the solver's question.
RSV_API rsv_status rsv_scene_add_material(
    rsv_scene *scene, const rsv_material *material, uint32_t *material_id);

/// Refuses (RSV_ERROR_FORMAT) indices past the end and non-finite positions; skips degenerate
/// triangles with a warning; replaces unusable normals by geometric ones.
RSV_API rsv_status rsv_scene_add_mesh(
    rsv_scene *scene, const rsv_mesh_desc *mesh, uint32_t *mesh_id);

/// Places a mesh.
/// @param transform column-major 4x4, object to world; NULL = identity
/// @param name for messages and selection; NULL = the mesh's name
RSV_API rsv_status rsv_scene_add_instance(
    rsv_scene *scene, uint32_t mesh_id, const float transform[16], const char *name);

/// Copies measured intensities for lights of kind RSV_PUNCTUAL_LUMINAIRE, before or after commit. @param id out; may be NULL
RSV_API rsv_status rsv_scene_add_luminaire(
    rsv_scene *scene, const rsv_luminaire *luminaire, uint32_t *id);

/// A luminaire that hangs at the origin and points down, C = 0 along x, as bright as measured (683 lm/W), with its opening.
/// @param id from rsv_scene_add_luminaire
RSV_API rsv_punctual_light rsv_luminaire_light(const rsv_luminaire *luminaire, uint32_t id);

/// Luminous flux of a light of the scene, lm; of distant ones 0.
RSV_API double rsv_punctual_lumens(const rsv_scene_view *scene, const rsv_punctual_light *light);

/// Puts a luminaire in place of the punctual lights that NAME means: their own names; if none has it, names of nodes that placed
/// lights; if there is none either, before commit, names of objects (these stay as they are, and the luminaire is at the
/// origin of the object and points along its -y). A luminaire keeps the direction of a spot or directional light; in place of
/// other lights it points down. `*` in NAME stands for any text, `?` for any character.
/// RSV_ERROR_ARGUMENT where nothing is called so.
RSV_API rsv_status rsv_scene_place_luminaire(
    rsv_scene *scene, const char *name, const rsv_luminaire *luminaire);

RSV_API rsv_status rsv_scene_add_light(rsv_scene *scene, const rsv_punctual_light *light);
RSV_API rsv_status rsv_scene_add_camera(rsv_scene *scene, const rsv_camera *camera);

/// Surrounds the scene with `environment` (NULL = with nothing), before or after commit; solutions and pictures
/// made earlier keep what they were made with. Pixels that are negative, infinite or not a number are
/// repaired with a warning. RSV_ERROR_ARGUMENT for an empty picture or an unusable intensity or rotation,
/// RSV_ERROR_UNSUPPORTED beyond RSV_ENVIRONMENT_MAX_PIXELS.
RSV_API rsv_status rsv_scene_set_environment(rsv_scene *scene, const rsv_environment *environment);

/// Surrounds the scene without a picture's file: "white" is a radiance of 1 from everywhere; "sky" a clear day with the sun
/// 45 degrees high, under which a white floor shows a radiance of about 1.
/// @param intensity, rotation as in rsv_environment
RSV_API rsv_status rsv_scene_set_builtin_environment(
    rsv_scene *scene, const char *name, float intensity, float rotation);

/// Whether `name` is one of those, and all of them, NULL-terminated.
RSV_API bool rsv_environment_is_builtin(const char *name);
RSV_API const char *const *rsv_environment_builtin_names(void);

/// Clear air: no extinction.
RSV_API rsv_fog rsv_default_fog(void);

/// Fills a committed scene with fog (NULL, or one without extinction: with clear air). Heights and the box are in the
/// coordinates of the scene's file. RSV_ERROR_ARGUMENT for values outside their ranges. Modes reference follow light through any
/// fog; rsv_light_create through fog in a finite box, and rsv_render, rsv_probe_irradiance and rsv_certify with its solution.
/// All else refuses the scene with RSV_ERROR_UNSUPPORTED (docs/media.md).
RSV_API rsv_status rsv_scene_set_fog(rsv_scene *scene, const rsv_fog *fog);

/// Flattens and checks. RSV_ERROR_SCENE if nothing remains to be drawn. A scene without a camera gets
/// one named "framing" that shows all of it.
RSV_API rsv_status rsv_scene_commit(rsv_scene *scene);

/// Where an object of a committed scene is to be.
typedef struct rsv_motion {
    uint32_t object;  ///< index into rsv_scene_view.object_name
    float matrix[16]; ///< column-major: takes its coordinates in the scene to those that are wanted
} rsv_motion;

/// The same scene with some objects moved, turned or scaled. It shares all else with `scene`, which must outlive it.
/// RSV_ERROR_ARGUMENT for an object that does not exist, and for matrices that are not finite, mirror, or scale to nothing.
/// @param motion [count] each object at most once: further motions of it are left out
RSV_API rsv_status rsv_scene_move(
    const rsv_scene *scene, const rsv_motion *motion, size_t count, rsv_scene **moved);

RSV_API const rsv_scene_view *rsv_scene_get_view(const rsv_scene *scene);
RSV_API rsv_context *rsv_scene_get_context(const rsv_scene *scene);

/// Index of the first object (an instanced mesh) of that name; RSV_NONE if there is none.
RSV_API uint32_t rsv_scene_find_object(const rsv_scene *scene, const char *name);

/// The triangles of an object in rsv_scene_view: a run of them. Their elements are those whose rsv_element.triangle is one.
/// @param first out @return how many; 0 if there is no such object
RSV_API size_t rsv_scene_object_triangles(const rsv_scene *scene, uint32_t object, uint32_t *first);

/// Frees what a scene keeps of the file that it came from (rsv_load_desc.keep_document). Bakes of it write a file of their own
/// from then on, and operator files hold none.
RSV_API void rsv_scene_drop_document(rsv_scene *scene);

/// A camera at `position` looking at `target`, y up.
RSV_API rsv_camera rsv_camera_look_at(
    const char *name, rsv_vec3 position, rsv_vec3 target, float vertical_fov, float aspect);

/// Index of the camera called `name`, or placed by a node of that name; NULL = the first. RSV_NONE if there is none.
RSV_API uint32_t rsv_scene_find_camera(const rsv_scene *scene, const char *name);

/// Choices of a built-in scene. Start from rsv_default_builtin_desc().
typedef struct rsv_builtin_desc {
    size_t size; ///< of this structure; rsv_default_builtin_desc() sets it
    /// A committed scene whose triangles become the body of cornell-glass, cornell-marble (a dragon, say),
    /// cornell-plaster, cornell-showcase or character (a head, face towards +z), y up: scaled and shifted to stand where it belongs, and turned
    /// inside out if it faces inwards. Its materials, lights and cameras are left behind. Borrowed until the
    /// call returns; NULL = a body of our own making.
    const rsv_scene *body;
    size_t
        body_triangles; ///< about as many in that body of our own; 100..20,000,000, default 60,000
} rsv_builtin_desc;

/// Defaults, for a descriptor of `size` bytes: what rsv_default_builtin_desc() is made of.
RSV_API void rsv_builtin_desc_init(rsv_builtin_desc *desc, size_t size);
static inline rsv_builtin_desc rsv_default_builtin_desc(void)
{
    rsv_builtin_desc desc;
    rsv_builtin_desc_init(&desc, sizeof desc);
    return desc;
}

/// Builds a scene of section "Built-in scenes" of the documentation: cornell-blocks, cornell-spheres,
/// cornell-glass, cornell-marble, cornell-plaster, cornell-showcase, character, furnace, two-rooms, gallery, terraces. Committed on return.
/// @param name the last two take a size behind a colon: "gallery:20" has 20 rooms (default 6), "terraces:1e6" about a
/// million triangles (default 1e5)
RSV_API rsv_status rsv_scene_builtin(rsv_context *context, const char *name, rsv_scene **scene);

/// The same with choices. @param desc NULL = defaults
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
