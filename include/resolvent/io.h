/// @file io.h
/// Scenes from and to files.
#ifndef RESOLVENT_IO_H
#define RESOLVENT_IO_H

#include "resolvent/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/// An axis of a file's own coordinates.
typedef enum rsv_axis { RSV_AXIS_X, RSV_AXIS_Y, RSV_AXIS_Z } rsv_axis;

/// Units of the strengths of lights in a file.
typedef enum rsv_light_units {
    RSV_LIGHT_UNITS_AUTO, ///< by the program that wrote the file; watts, unless other units are known
    RSV_LIGHT_UNITS_WATT, ///< W/sr, W/m2 and W/(m2 sr)
    /// Candela, lux and candela per m2, as in the specification of glTF: divided by 683 lm/W
    RSV_LIGHT_UNITS_PHOTOMETRIC
} rsv_light_units;

/// Reads files from somewhere other than the file system: an archive, a database, memory. Paths are the scene's path as
/// given by the caller, and, for buffers, textures and material libraries, its folder followed by their own path.
/// Called from the thread that loads; may call the library.
typedef struct rsv_file_source {
    /// Size of a file in bytes; -1 = there is no such file.
    int64_t (*size)(void *user, const char *path);
    /// Reads up to `count` bytes from byte `offset`, never beyond the end of the file.
    /// @return number of bytes read; the rest is requested again. 0 = the file cannot be read
    size_t (*read)(void *user, const char *path, uint64_t offset, void *bytes, size_t count);
    void *user;
} rsv_file_source;

/// A measured luminaire for lights of a scene.
typedef struct rsv_load_luminaire {
    const char *name; ///< of lights, nodes or objects, as in rsv_scene_place_luminaire
    const char *path; ///< file of IES LM-63 or EULUMDAT
} rsv_load_luminaire;

/// Options for reading a scene. Start from rsv_default_load_desc().
typedef struct rsv_load_desc {
    size_t size; ///< sizeof this structure; rsv_default_load_desc() sets it
    /// Metres per unit of .obj, .ply and .stl, which do not state one (default 1). Other formats state theirs.
    float metres_per_unit;
    /// The axis of .obj, .ply and .stl that points up (default y). With z, x stays the same, as in modelling tools.
    rsv_axis up;
    /// Radians, default 45 degrees. Meshes without normals are shaded smoothly across edges at which triangles meet at
    /// a smaller angle. Not for glTF, whose specification requires flat shading.
    float crease_angle;
    /// The file will become part of another scene, and needs no lights or cameras.
    bool is_part;
    /// Keep a glTF file, with its buffers and images, in memory, so that bakes can add light to it (bake.h) and
    /// operator files can contain it (opfile.h). Default true; rsv_scene_drop_document() frees it.
    bool keep_document;
    rsv_light_units light_units; ///< default auto
    /// Show both sides of single-sided materials that do not emit (default false). Surfaces behind a front are still
    /// hidden by it.
    bool two_sided;
    /// Name of the variant of a glTF file's materials to use (KHR_materials_variants); NULL = the default materials.
    /// With a variant the document is not kept, because it shows other materials.
    const char *variant;
    /// [luminaire_count] luminaires that replace lights, or are placed at nodes and objects; borrowed. In glTF this
    /// includes nodes without a mesh; the luminaire points along their -y.
    const rsv_load_luminaire *luminaire;
    size_t luminaire_count;
    const rsv_file_source
        *files;     ///< borrowed while the file is read; NULL (default) = the file system
    bool emit_both; ///< Emissive materials emit from both sides (default false)
} rsv_load_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_load_desc().
RSV_API void rsv_load_desc_init(rsv_load_desc *desc, size_t size);
static inline rsv_load_desc rsv_default_load_desc(void)
{
    rsv_load_desc desc;
    rsv_load_desc_init(&desc, sizeof desc);
    return desc;
}

/// Reads and commits a scene: glTF 2.0 (.gltf, .glb), Wavefront (.obj with .mtl), Stanford (.ply), .fbx, COLLADA (.dae)
/// or .stl. The format follows from the extension, or else from the content. docs/formats.md describes how materials of
/// each format are converted. Messages name file, node, mesh, material and accessor. Files are treated as hostile:
/// every size and index is checked.
RSV_API rsv_status rsv_scene_load(rsv_context *context, const char *path, rsv_scene **scene);

/// The same with options. @param desc NULL = defaults
RSV_API rsv_status rsv_scene_load_with(
    rsv_context *context, const char *path, const rsv_load_desc *desc, rsv_scene **scene);

/// Reads a file in memory that needs no other files: .glb, .gltf with embedded data, .ply, .stl, .obj, .fbx, .dae.
/// @param name used like a path: its extension gives the format; messages and operator files show it
/// @param bytes [count]; copied if it is kept
RSV_API rsv_status rsv_scene_load_memory(rsv_context *context, const char *name, const void *bytes,
    size_t count, const rsv_load_desc *desc, rsv_scene **scene);

/// Writes a committed scene as binary glTF. rsv_scene_load reads the same scene back. The file appears complete or not
/// at all.
RSV_API rsv_status rsv_scene_save(const rsv_scene *scene, const char *path);

/// Reads a latitude-longitude image (.hdr, .exr or another format of rsv_image_read) and sets it as the scene's
/// environment.
/// @param intensity, rotation as in rsv_environment
RSV_API rsv_status rsv_scene_load_environment(
    rsv_scene *scene, const char *path, float intensity, float rotation);

/// Reads luminaires and places them by name, as loading does with rsv_load_desc.luminaire.
RSV_API rsv_status rsv_scene_load_luminaires(
    rsv_scene *scene, const rsv_load_luminaire *luminaire, size_t count);

/// Fills the scene's air with the fog of an OpenVDB file: rsv_scene_set_volume with its grid "density", or else its first
/// grid of single numbers that is no level set. RSV_ERROR_IO and RSV_ERROR_FORMAT for files that cannot be read,
/// RSV_ERROR_UNSUPPORTED for files without such a grid, grids turned against the axes or too large, and builds without
/// OpenVDB.
/// @param fog extinction and emission where the density is 1, albedo and anisotropy
RSV_API rsv_status rsv_scene_load_volume(rsv_scene *scene, const rsv_fog *fog, const char *path);

#ifdef __cplusplus
}
#endif

#endif
