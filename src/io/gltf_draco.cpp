/// KHR_draco_mesh_compression: what is packed becomes buffers of its own, which accessors then name like any other.
#include "gltf_json.hpp"

#include <draco/compression/decode.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>

namespace
{

using namespace rsv_gltf;

constexpr const char *extension_name = "KHR_draco_mesh_compression";
constexpr size_t word = 4; // glTF wants vertex attributes to begin at multiples of it

/// A new buffer with one view over all of it; its index.
int add_view(tinygltf::Model &model, std::vector<unsigned char> &&bytes, size_t stride, int target)
{
    tinygltf::Buffer buffer;
    tinygltf::BufferView view;
    view.buffer = static_cast<int>(model.buffers.size());
    view.byteLength = bytes.size();
    view.byteStride = stride;
    view.target = target;
    buffer.data = std::move(bytes);
    model.buffers.push_back(std::move(buffer));
    model.bufferViews.push_back(std::move(view));
    return static_cast<int>(model.bufferViews.size()) - 1;
}

tinygltf::Accessor &find_accessor(tinygltf::Model &model, int index, const std::string &what)
{
    if (index < 0 || static_cast<size_t>(index) >= model.accessors.size())
        refuse(RSV_ERROR_FORMAT, what + ": accessor " + std::to_string(index) + " does not exist");
    return model.accessors[static_cast<size_t>(index)];
}

void place(tinygltf::Accessor &accessor, int view)
{
    accessor.bufferView = view;
    accessor.byteOffset = 0;
    accessor.sparse.isSparse = false;
}

std::unique_ptr<draco::Mesh> unpack(
    const tinygltf::Model &model, const tinygltf::Value &packed, const std::string &what)
{
    const double view_number = number(packed, "bufferView", -1);
    if (!(view_number >= 0 && view_number < static_cast<double>(model.bufferViews.size())))
        refuse(RSV_ERROR_FORMAT, what + ": " + extension_name + " names no buffer view");
    const tinygltf::BufferView &view = model.bufferViews[static_cast<size_t>(view_number)];
    if (view.buffer < 0 || static_cast<size_t>(view.buffer) >= model.buffers.size())
        refuse(RSV_ERROR_FORMAT, what + ": its packed data lie in a buffer that does not exist");
    const std::vector<unsigned char> &bytes = model.buffers[static_cast<size_t>(view.buffer)].data;
    if (view.byteOffset > bytes.size() || view.byteLength > bytes.size() - view.byteOffset)
        refuse(RSV_ERROR_FORMAT, what + ": its packed data reach past the end of their buffer");
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char *>(bytes.data()) + view.byteOffset, view.byteLength);
    auto mesh = draco::Decoder().DecodeMeshFromBuffer(&buffer);
    if (!mesh.ok())
        refuse(RSV_ERROR_FORMAT,
            what + ": its Draco data cannot be unpacked: " + mesh.status().error_msg_string());
    return std::move(mesh).value();
}

template <class integer>
std::vector<unsigned char> indices_of(const draco::Mesh &mesh, const std::string &what)
{
    if (mesh.num_points() > std::numeric_limits<integer>::max())
        refuse(RSV_ERROR_FORMAT, what + ": more vertices than its type of indices can name");
    std::vector<unsigned char> bytes(3 * sizeof(integer) * mesh.num_faces());
    unsigned char *to = bytes.data();
    for (draco::FaceIndex f(0); f < mesh.num_faces(); ++f)
        for (draco::PointIndex point : mesh.face(f)) {
            const integer index = static_cast<integer>(point.value());
            std::memcpy(to, &index, sizeof index);
            to += sizeof index;
        }
    return bytes;
}

std::vector<unsigned char> indices_of(
    const draco::Mesh &mesh, int component_type, const std::string &what)
{
    switch (component_type) {
    case RSV_GLTF_UNSIGNED_BYTE:
        return indices_of<uint8_t>(mesh, what);
    case RSV_GLTF_UNSIGNED_SHORT:
        return indices_of<uint16_t>(mesh, what);
    case RSV_GLTF_UNSIGNED_INT:
        return indices_of<uint32_t>(mesh, what);
    default:
        refuse(RSV_ERROR_FORMAT, what + ": its indices are not unsigned integers");
    }
}

/// Values of all points, `stride` bytes apart.
template <class component>
void copy_values(const draco::Mesh &mesh, const draco::PointAttribute &attribute, size_t width,
    size_t stride, unsigned char *to)
{
    component value[4] = {};
    for (draco::PointIndex point(0); point < mesh.num_points(); ++point, to += stride) {
        attribute.ConvertValue<component>(
            attribute.mapped_index(point), static_cast<int8_t>(width), value);
        std::memcpy(to, value, width * sizeof(component));
    }
}

/// One attribute in the accessor's own type. @param stride filled in
std::vector<unsigned char> values_of(const draco::Mesh &mesh,
    const draco::PointAttribute &attribute, const tinygltf::Accessor &accessor, size_t *stride,
    const std::string &what)
{
    const int width = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type));
    const int size =
        tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(accessor.componentType));
    if (width < 1 || width > 4 || size < 1 || attribute.num_components() != width)
        refuse(RSV_ERROR_FORMAT, what + ": packed with other components than its accessor has");
    if (accessor.count != mesh.num_points())
        refuse(RSV_ERROR_FORMAT, what + ": " + std::to_string(mesh.num_points()) +
                                     " vertices are packed where " +
                                     std::to_string(accessor.count) + " are announced");
    *stride = (static_cast<size_t>(width * size) + word - 1) / word * word;
    std::vector<unsigned char> bytes(*stride * mesh.num_points());
    const auto copy = [&](auto component) {
        copy_values<decltype(component)>(
            mesh, attribute, static_cast<size_t>(width), *stride, bytes.data());
    };
    switch (accessor.componentType) {
    case RSV_GLTF_BYTE:
        copy(int8_t{});
        break;
    case RSV_GLTF_UNSIGNED_BYTE:
        copy(uint8_t{});
        break;
    case RSV_GLTF_SHORT:
        copy(int16_t{});
        break;
    case RSV_GLTF_UNSIGNED_SHORT:
        copy(uint16_t{});
        break;
    case RSV_GLTF_UNSIGNED_INT:
        copy(uint32_t{});
        break;
    case RSV_GLTF_FLOAT:
        copy(float{});
        break;
    default:
        refuse(RSV_ERROR_FORMAT, what + ": of a type that glTF does not have");
    }
    return bytes;
}

void unpack_primitive(tinygltf::Model &model, tinygltf::Primitive &primitive,
    const tinygltf::Value &packed, const std::string &what)
{
    const std::unique_ptr<draco::Mesh> mesh = unpack(model, packed, what);
    const tinygltf::Value *attributes = find(packed, "attributes");
    if (!attributes || !attributes->IsObject())
        refuse(RSV_ERROR_FORMAT, what + ": " + extension_name + " names no attributes");
    for (const std::string &name : attributes->Keys()) {
        const std::string label = what + ": attribute '" + name + "'";
        auto named = primitive.attributes.find(name);
        if (named == primitive.attributes.end()) continue; // nothing asks for it
        const double id = number(*attributes, name.c_str(), -1);
        const draco::PointAttribute *attribute =
            id >= 0 && id < std::numeric_limits<uint32_t>::max()
                ? mesh->GetAttributeByUniqueId(static_cast<uint32_t>(id))
                : nullptr;
        if (!attribute) refuse(RSV_ERROR_FORMAT, label + " is not among its packed data");
        tinygltf::Accessor &accessor = find_accessor(model, named->second, label);
        size_t stride;
        std::vector<unsigned char> bytes = values_of(*mesh, *attribute, accessor, &stride, label);
        place(accessor, add_view(model, std::move(bytes), stride, TINYGLTF_TARGET_ARRAY_BUFFER));
    }
    if (primitive.indices < 0) return;
    tinygltf::Accessor &accessor = find_accessor(model, primitive.indices, what);
    accessor.count = 3 * static_cast<size_t>(mesh->num_faces());
    place(accessor, add_view(model, indices_of(*mesh, accessor.componentType, what), 0,
                        TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER));
    primitive.mode = RSV_GLTF_TRIANGLES; // whatever it was, triangles are what is packed
}

/// Member `name` of a JSON object; NULL if absent.
nlohmann::json *member(nlohmann::json *object, const char *name)
{
    if (!object || !object->is_object()) return nullptr;
    auto found = object->find(name);
    return found == object->end() ? nullptr : &*found;
}

void name_view(nlohmann::json &root, nlohmann::json &primitive)
{
    nlohmann::json *packed = member(member(&primitive, "extensions"), extension_name);
    nlohmann::json *view = member(packed, "bufferView"), *indices = member(&primitive, "indices"),
                   *accessors = member(&root, "accessors");
    if (!view || !indices || !indices->is_number_unsigned() || !accessors ||
        !accessors->is_array() || indices->get<size_t>() >= accessors->size())
        return;
    nlohmann::json &accessor = (*accessors)[indices->get<size_t>()];
    if (accessor.is_object() && !accessor.contains("bufferView")) accessor["bufferView"] = *view;
}

} // namespace

std::string rsv_gltf::name_packed_indices(const unsigned char *text, size_t length)
{
    const unsigned char *end = text + length;
    if (std::search(text, end, extension_name, extension_name + std::strlen(extension_name)) == end)
        return {};
    nlohmann::json root = nlohmann::json::parse(text, end, nullptr, false);
    nlohmann::json *meshes = member(&root, "meshes");
    if (!meshes || !meshes->is_array()) return {}; // tinygltf says what is wrong
    for (nlohmann::json &mesh : *meshes)
        if (nlohmann::json *primitives = member(&mesh, "primitives"))
            if (primitives->is_array())
                for (nlohmann::json &primitive : *primitives)
                    name_view(root, primitive);
    return root.dump();
}

void rsv_gltf::unpack_draco(tinygltf::Model &model)
{
    for (tinygltf::Mesh &mesh : model.meshes)
        for (tinygltf::Primitive &primitive : mesh.primitives) {
            auto packed = primitive.extensions.find(extension_name);
            if (packed != primitive.extensions.end())
                unpack_primitive(model, primitive, packed->second, "mesh '" + mesh.name + "'");
        }
}
