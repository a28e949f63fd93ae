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

/// What numbers stand for that a file gives as strengths of lights.
typedef enum rsv_light_units {
    RSV_LIGHT_UNITS_AUTO, ///< by the program that wrote the file; watts where that is not known to mean anything else
    RSV_LIGHT_UNITS_WATT, ///< W/sr, W/m2 and W/(m2 sr)
    /// Candela, lux and candela per m2, as the specification of glTF says: divided by 683 lm/W
    RSV_LIGHT_UNITS_PHOTOMETRIC
} rsv_light_units;

/// Where a scene's files come from, in place of the file system: an archive, a database, memory. Paths are what the caller
/// gives as the scene's, and for the buffers, textures and libraries of materials that it names the folder of that and their
/// own. Called from the thread that loads; may call the library.
typedef struct rsv_file_source {
    /// Bytes of a file; -1 = there is none.
    int64_t (*size)(void *user, const char *path);
    /// Reads up to `count` bytes of it, from byte `offset` on, never beyond its end.
    /// @return how many were read; fewer are asked for again, 0 = it cannot be read
    size_t (*read)(void *user, const char *path, uint64_t offset, void *bytes, size_t count);
    void *user;
} rsv_file_source;

/// How to understand what a file leaves open. Start from rsv_default_load_desc().
/// A measured luminaire for lights of a scene.
typedef struct rsv_load_luminaire {
    const char *name; ///< of lights, nodes or objects, as in rsv_scene_place_luminaire
    const char *path; ///< file of IES LM-63 or EULUMDAT
} rsv_load_luminaire;

typedef struct rsv_load_desc {
    size_t size; ///< sizeof this structure; rsv_default_load_desc() sets it
    /// Metres per unit of .obj, .ply and .stl, which name none (default 1). The other formats say
    /// theirs.
    float metres_per_unit;
    /// The axis of .obj, .ply and .stl that points up (default y); z keeps x, as modelling tools do.
    rsv_axis up;
    /// Radians. Meshes without normals, glTF's apart (flat by its specification), are shaded smooth
    /// across edges whose triangles meet at less than this angle (default 45 degrees).
    float crease_angle;
    /// The file will become part of another scene: it needs no lights or cameras.
    bool is_part;
    /// Keep a glTF file, and the buffers and pictures beside it, in memory as they are: bakes write them back with light
    /// added (bake.h), operator files hold them (opfile.h). Default true; rsv_scene_drop_document() frees them.
    bool keep_document;
    rsv_light_units light_units; ///< default auto
    /// Shows materials that do not shine from both sides, where a file has them single-sided (default false). What
    /// lies behind a front stays hidden by it.
    bool two_sided;
    /// Which of the materials that a glTF file offers for the same parts (KHR_materials_variants): a name; NULL = those shown
    /// by default. The document is not kept then: it shows others.
    const char *variant;
    /// [luminaire_count] that are put in place of lights, or hung from nodes and objects; borrowed. Of glTF, nodes without a
    /// mesh count too, along their -y.
    const rsv_load_luminaire *luminaire;
    size_t luminaire_count;
    const rsv_file_source
        *files;     ///< borrowed while the file is read; NULL (default) = the file system
    bool emit_both; ///< Lets materials that shine do so from both sides (default false)
} rsv_load_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_load_desc().
RSV_API void rsv_load_desc_init(rsv_load_desc *desc, size_t size);
static inline rsv_load_desc rsv_default_load_desc(void)
{
    rsv_load_desc desc;
    rsv_load_desc_init(&desc, sizeof desc);
    return desc;
}

/// Reads a scene and commits it: glTF 2.0 (.gltf, .glb), Wavefront (.obj with .mtl), Stanford (.ply),
/// .fbx, COLLADA (.dae), .stl; by extension, and by content where that says nothing. docs/formats.md
/// tells what becomes of each format's materials. Messages name file, node, mesh, material and
/// accessor. Files are treated as hostile: every size and index is checked.
RSV_API rsv_status rsv_scene_load(rsv_context *context, const char *path, rsv_scene **scene);

/// The same with choices. @param desc NULL = defaults
RSV_API rsv_status rsv_scene_load_with(
    rsv_context *context, const char *path, const rsv_load_desc *desc, rsv_scene **scene);

/// The same of a file in memory that needs no others beside it: .glb, .gltf with data within, .ply, .stl, .obj, .fbx, .dae.
/// @param name stands for the path: its extension says what it is, messages and operator files name it
/// @param bytes [count]; copied where it is kept
RSV_API rsv_status rsv_scene_load_memory(rsv_context *context, const char *name, const void *bytes,
    size_t count, const rsv_load_desc *desc, rsv_scene **scene);

/// Writes a committed scene as binary glTF; what rsv_scene_load reads back is the same scene. The file
/// appears complete or not at all.
RSV_API rsv_status rsv_scene_save(const rsv_scene *scene, const char *path);

/// Reads a latitude-longitude picture (.hdr, .exr and whatever rsv_image_read reads) and surrounds the scene
/// with it. @param intensity, rotation as in rsv_environment
RSV_API rsv_status rsv_scene_load_environment(
    rsv_scene *scene, const char *path, float intensity, float rotation);

/// Reads luminaires and puts each in place of what its name means, as loading does with rsv_load_desc.luminaire.
RSV_API rsv_status rsv_scene_load_luminaires(
    rsv_scene *scene, const rsv_load_luminaire *luminaire, size_t count);

#ifdef __cplusplus
}
#endif

#endif
