/// Unpacks compressed meshes (KHR_draco_mesh_compression, EXT_meshopt_compression), because lightmaps need other
/// vertices.
#ifndef RSV_BAKE_UNPACK_H
#define RSV_BAKE_UNPACK_H

#include "bake_document.h"

/// Takes the parser's buffer views behind those of the file into its JSON, each still naming its own buffer; accessors
/// name them, and the extension goes. Nothing happens where nothing was packed.
void rsv_bake_unpack(rsv_bake_document *document);

#endif
