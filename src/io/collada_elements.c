#include "collada_elements.h"

#include <string.h>

static bool is_among(const char *const *names, const char *name, size_t length)
{
    for (; *names; names++)
        if (strlen(*names) == length && memcmp(*names, name, length) == 0) return true;
    return false;
}

static const char *const structure[] = { "COLLADA", "asset", "unit", "up_axis", "contributor",
    "author", "author_email", "author_website", "authoring_tool", "comments", "copyright",
    "source_data", "created", "modified", "keywords", "revision", "subject", "title", "coverage",
    "geographic_location", "longitude", "latitude", "altitude", "extra", "technique",
    "technique_common", "scene", "instance_visual_scene", "library_visual_scenes", "visual_scene",
    "evaluate_scene", "render", "layer", "library_nodes", "node", "instance_node", "matrix",
    "translate", "rotate", "scale", "lookat", "skew", NULL };

static const char *const geometry[] = { "library_geometries", "geometry", "mesh", "source",
    "float_array", "int_array", "bool_array", "Name_array", "IDREF_array", "accessor", "param",
    "vertices", "input", "triangles", "polylist", "polygons", "trifans", "tristrips", "lines",
    "linestrips", "p", "vcount", "instance_geometry", "library_controllers", "controller", "skin",
    "morph", "bind_shape_matrix", "joints", "vertex_weights", "v", "targets", "skeleton",
    "instance_controller", "library_animations", "library_animation_clips", "animation",
    "animation_clip", "instance_animation", "sampler", "channel", NULL };

static const char *const look[] = { "library_materials", "material", "instance_material",
    "bind_material", "bind", "bind_vertex_input", "library_effects", "effect", "instance_effect",
    "technique_hint", "profile_COMMON", "setparam", "newparam", "annotate", "semantic", "modifier",
    "float", "float2", "float3", "float4", "string", "surface", "sampler2D", "instance_image",
    "minfilter", "magfilter", "mipfilter", "wrap_s", "wrap_t", "wrap_p", "border_color",
    "mipmap_maxlevel", "mip_max_level", "mip_min_level", "mipmap_bias", "mip_bias",
    "max_anisotropy", "format", "format_hint", "channels", "range", "precision", "option", "size",
    "size_exact", "size_ratio", "viewport_ratio", "mip_levels", "mipmap_generate", "phong",
    "lambert", "blinn", "constant", "emission", "ambient", "diffuse", "specular", "shininess",
    "reflective", "reflectivity", "transparent", "transparency", "index_of_refraction", "color",
    "texture", "library_images", "image", "init_from", "create_2d", "ref", "hex", "data",
    "renderable", NULL };

static const char *const lights_and_cameras[] = { "library_lights", "light", "instance_light",
    "directional", "point", "spot", "constant_attenuation", "linear_attenuation",
    "quadratic_attenuation", "falloff_angle", "falloff_exponent", "library_cameras", "camera",
    "instance_camera", "optics", "perspective", "orthographic", "xfov", "yfov", "xmag", "ymag",
    "aspect_ratio", "znear", "zfar", "imager", NULL };

bool rsv_collada_knows_element(const char *name, size_t length)
{
    return is_among(geometry, name, length) || is_among(structure, name, length) ||
           is_among(look, name, length) || is_among(lights_and_cameras, name, length);
}

bool rsv_collada_passes_over(const char *name, size_t length)
{
    static const char *const passed[] = { "spline", "convex_mesh", "brep", "ph", "profile_CG",
        "profile_GLSL", "profile_GLES", "profile_GLES2", "profile_BRIDGE", "library_physics_models",
        "library_physics_scenes", "library_physics_materials", "library_force_fields",
        "library_articulated_systems", "library_joints", "library_kinematics_models",
        "library_kinematics_scenes", "library_formulas", "instance_physics_scene",
        "instance_kinematics_scene", NULL };
    return is_among(passed, name, length);
}
