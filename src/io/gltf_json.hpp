/// Members of a glTF file's extensions and extras, each with a value to fall back on.
#ifndef RSV_GLTF_JSON_HPP
#define RSV_GLTF_JSON_HPP

#include "gltf_document.h"

#include <tiny_gltf.h>

#include <string>

namespace rsv_gltf
{

/// Ends reading; rsv_gltf_open turns it into an error.
struct refusal {
    rsv_status status;
    std::string message;
};

[[noreturn]] inline void refuse(rsv_status status, const std::string &message)
{
    throw refusal{ status, message };
}

/// A member of an extension or of extras; NULL if absent.
inline const tinygltf::Value *find(const tinygltf::Value &object, const char *key)
{
    if (!object.IsObject() || !object.Has(key)) return nullptr;
    return &object.Get(key);
}

inline double number(const tinygltf::Value &object, const char *key, double fallback)
{
    const tinygltf::Value *value = find(object, key);
    return value && value->IsNumber() ? value->GetNumberAsDouble() : fallback;
}

/// An array of at least `count` numbers; else `value` stays as it is.
inline void numbers(const tinygltf::Value &object, const char *key, size_t count, double *value)
{
    const tinygltf::Value *array = find(object, key);
    if (!array || !array->IsArray() || array->ArrayLen() < count) return;
    for (size_t i = 0; i < count; i++)
        if (!array->Get(i).IsNumber()) return;
    for (size_t i = 0; i < count; i++)
        value[i] = array->Get(i).GetNumberAsDouble();
}

inline rsv_rgb to_rgb(const double *value)
{
    return { static_cast<float>(value[0]), static_cast<float>(value[1]),
        static_cast<float>(value[2]) };
}

inline rsv_rgb color(const tinygltf::Value &object, const char *key, rsv_rgb fallback)
{
    double value[3] = { fallback.r, fallback.g, fallback.b };
    numbers(object, key, 3, value);
    return to_rgb(value);
}

inline const tinygltf::Value &extension(const tinygltf::ExtensionMap &extensions, const char *name)
{
    static const tinygltf::Value none;
    auto found = extensions.find(name);
    return found == extensions.end() ? none : found->second;
}

/// Copies a core property of known length; absent ones keep the default in `to`.
void copy_numbers(
    const std::vector<double> &from, double *to, size_t count, const std::string &what);

/// A material and what its pointers lead to.
struct owned_material {
    rsv_gltf_material material{};
    std::vector<rsv_gltf_texture_ref> textures;
    std::string name, note, remark;
};

/// Debian's tinygltf is built without Draco and refuses indices without a buffer view, as packed ones are. This is the same
/// JSON with a view for each of them; empty if nothing is packed.
std::string name_packed_indices(const unsigned char *text, size_t length);
/// Makes plain buffers of meshes packed by KHR_draco_mesh_compression.
void unpack_draco(tinygltf::Model &model);

void convert_material(const tinygltf::Material &source, owned_material &result);

} // namespace rsv_gltf

#endif
