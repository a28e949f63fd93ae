/// Reads a file through Assimp's importers and turns Assimp's C structures into the library's own values.
#ifndef RSV_ASSIMP_FILE_H
#define RSV_ASSIMP_FILE_H

#include "../scene/scene.h"
#include "scene_read.h"

#include <assimp/scene.h>
#include <stdio.h>

#define RSV_NAME_BYTES 128

/// Reads and triangulates a file. Importers may crash, hang or corrupt memory: call this in a child process
/// (child_process.h). Materials and other files that it refers to must be regular files. Warnings name those that
/// cannot be read, and anything in the file that is not used. Error messages are the library's own, not Assimp's.
/// @param imported to be released by aiReleaseImport @param origin out: what was subtracted from all coordinates
rsv_status rsv_assimp_import(rsv_context *context, const rsv_file_source *files, const char *path,
    rsv_file_kind kind, const struct aiScene **imported, double origin[3]);

/// Whether a file has these bytes anywhere.
bool rsv_file_mentions(const rsv_file_source *files, const char *path, const char *word);

/// Imports a file and sends its contents as parts of a scene (scene_parts.h).
rsv_status rsv_assimp_convert(rsv_context *context, const char *path, rsv_file_kind kind,
    const rsv_load_desc *desc, FILE *to);

/// A name fit for messages: printable, cut to size, `fallback` where there is none.
/// @param name [RSV_NAME_BYTES]
void rsv_assimp_name(const struct aiString *source, const char *fallback, char *name);

/// The number that metadata holds under `key`, or `fallback`.
double rsv_assimp_number(const struct aiMetadata *metadata, const char *key, double fallback);

/// How the materials of a file are to be interpreted: depends on the format and on the program that wrote it.
typedef struct rsv_assimp_maker {
    rsv_file_kind kind;
    /// Above 0: Blender wrote the file; roughness is 1 - sqrt(shininess / this), colours and textures those of its
    /// Principled BSDF.
    float blender_shininess;
    bool
        blender_collada; ///< Blender wrote the file, in which the reflectivity is how metallic a material is
} rsv_assimp_maker;

/// @param file what was imported from `path`
rsv_assimp_maker rsv_assimp_maker_of(
    const rsv_file_source *files, const char *path, rsv_file_kind kind, const struct aiScene *file);

/// Converts a material of the file; a warning names what is lost.
/// @param name [RSV_NAME_BYTES] storage for material->name
void rsv_assimp_material(const rsv_context *context, const rsv_assimp_maker *maker,
    const struct aiMaterial *source, char *name, rsv_material *material);

#endif
