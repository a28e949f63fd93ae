/// A build for web pages goes without Draco: meshes that it has packed are refused.
#include "gltf_json.hpp"

void rsv_gltf::unpack_draco(owned_document &document)
{
    for (const json &mesh : list(document.tree, "meshes"))
        for (const json &primitive : list(mesh, "primitives"))
            if (extension(primitive, "KHR_draco_mesh_compression").is_object())
                refuse(RSV_ERROR_UNSUPPORTED,
                    "its meshes are packed by Draco, which is not supported in web pages; export it without compression");
}
