/// Lights and cameras as Assimp read them, in metres and W/sr.
#ifndef RSV_ASSIMP_LIGHT_H
#define RSV_ASSIMP_LIGHT_H

#include "assimp_file.h"
#include "collada_scan.h"

/// What the conversion of a file's lights and cameras depends on.
typedef struct rsv_assimp_facts {
    rsv_file_kind kind;
    double metres_per_unit;
    bool watts;          ///< written by Blender 2.80 or later: strengths are watts
    bool photometric;    ///< strengths are in lumens where they would otherwise be in watts
    bool has_decay;      ///< .fbx: some light says how it falls off
    bool has_fov;        ///< .fbx: some camera says its field of view
    rsv_collada collada; ///< .dae: what a scan of its text found
} rsv_assimp_facts;

/// What the conversion of a file depends on besides its contents.
typedef struct rsv_assimp_reading {
    const rsv_file_source *files;
    const char *path;
    rsv_file_kind kind;
    rsv_light_units light_units;
    double metres_per_unit; ///< of its coordinates
} rsv_assimp_reading;

/// Whether the file was written by a Blender whose lights have watts, and whose materials are those of the Principled
/// BSDF.
bool rsv_assimp_by_blender(const struct aiScene *file);

/// Collects the facts. A note tells the user how the strengths of lights are interpreted.
rsv_status rsv_assimp_learn(rsv_context *context, const rsv_assimp_reading *reading,
    const struct aiScene *file, rsv_assimp_facts *facts);
void rsv_assimp_forget(rsv_context *context, rsv_assimp_facts *facts);

/// A light, or false, after a warning, where there is no such kind.
/// @param order how many lights its node has had before @param name [RSV_NAME_BYTES] storage for light->name
bool rsv_assimp_light(const rsv_context *context, const rsv_assimp_facts *facts,
    const struct aiLight *source, size_t order, const double world[16], rsv_punctual_light *light);

/// @param order, name as above
rsv_status rsv_assimp_camera(const rsv_context *context, const rsv_assimp_facts *facts,
    const struct aiCamera *source, size_t order, const double world[16], rsv_camera *camera);

#endif
