/// KHR_draco_mesh_compression: the unpacked data become buffers of their own, which accessors then refer to as usual.
#include "gltf_json.hpp"

#include <draco/compression/decode.h>

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
int add_view(owned_document &document, bytes &&data, size_t stride)
{
    document.buffer_views.push_back(
        { static_cast<int>(document.buffer_bytes.size()), 0, data.size(), stride });
    document.buffer_bytes.push_back(std::move(data));
    return static_cast<int>(document.buffer_views.size()) - 1;
}

rsv_gltf_accessor &find_accessor(owned_document &document, int index, const std::string &what)
{
    if (index < 0 || static_cast<size_t>(index) >= document.accessors.size())
        refuse(RSV_ERROR_FORMAT, what + ": accessor " + std::to_string(index) + " does not exist");
    return document.accessors[static_cast<size_t>(index)];
}

void place(rsv_gltf_accessor &accessor, int view)
{
    accessor.span.buffer_view = view;
    accessor.span.offset = 0;
    accessor.sparse_count = 0;
}

std::unique_ptr<draco::Mesh> unpack(
    const owned_document &document, const json &packed, const std::string &what)
{
    const size_t index = static_cast<size_t>(reference(packed, "bufferView"));
    if (index >= document.buffer_views.size())
        refuse(RSV_ERROR_FORMAT, what + ": " + extension_name + " names no buffer view");
    const rsv_gltf_buffer_view &view = document.buffer_views[index];
    if (static_cast<size_t>(view.buffer) >= document.buffer_bytes.size())
        refuse(RSV_ERROR_FORMAT, what + ": its packed data lie in a buffer that does not exist");
    const bytes &data = document.buffer_bytes[static_cast<size_t>(view.buffer)];
    if (view.offset > data.size() || view.length > data.size() - view.offset)
        refuse(RSV_ERROR_FORMAT, what + ": its packed data reach past the end of their buffer");
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char *>(data.data()) + view.offset, view.length);
    auto mesh = draco::Decoder().DecodeMeshFromBuffer(&buffer);
    if (!mesh.ok())
        refuse(RSV_ERROR_FORMAT, what + ": its Draco data cannot be unpacked; are they damaged?");
    return std::move(mesh).value();
}

template <class integer> bytes indices_of(const draco::Mesh &mesh, const std::string &what)
{
    if (mesh.num_points() > std::numeric_limits<integer>::max())
        refuse(RSV_ERROR_FORMAT, what + ": more vertices than its type of indices can name");
    bytes data(3 * sizeof(integer) * mesh.num_faces());
    unsigned char *to = data.data();
    for (draco::FaceIndex f(0); f < mesh.num_faces(); ++f)
        for (draco::PointIndex point : mesh.face(f)) {
            const integer index = static_cast<integer>(point.value());
            std::memcpy(to, &index, sizeof index);
            to += sizeof index;
        }
    return data;
}

bytes indices_of(const draco::Mesh &mesh, int component_type, const std::string &what)
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
bytes values_of(const draco::Mesh &mesh, const draco::PointAttribute &attribute,
    const rsv_gltf_accessor &accessor, size_t *stride, const std::string &what)
{
    const int width = accessor.component_count,
              size = rsv_gltf_component_bytes(accessor.span.component_type);
    if (width < 1 || width > 4 || size < 1 || attribute.num_components() != width)
        refuse(RSV_ERROR_FORMAT, what + ": packed with other components than its accessor has");
    if (accessor.count != mesh.num_points())
        refuse(RSV_ERROR_FORMAT, what + ": " + std::to_string(mesh.num_points()) +
                                     " vertices are packed where " +
                                     std::to_string(accessor.count) + " are announced");
    *stride = (static_cast<size_t>(width * size) + word - 1) / word * word;
    bytes data(*stride * mesh.num_points());
    const auto copy = [&](auto component) {
        copy_values<decltype(component)>(
            mesh, attribute, static_cast<size_t>(width), *stride, data.data());
    };
    switch (accessor.span.component_type) {
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
    return data;
}

void unpack_primitive(owned_document &document, const json &source, rsv_gltf_primitive &primitive,
    const std::string &what)
{
    const json &packed = extension(source, extension_name);
    const std::unique_ptr<draco::Mesh> mesh = unpack(document, packed, what);
    const json &attributes = member(packed, "attributes");
    if (!attributes.is_object())
        refuse(RSV_ERROR_FORMAT, what + ": " + extension_name + " names no attributes");
    for (const auto &entry : attributes.items()) {
        const std::string label = what + ": attribute '" + shown(entry.key()) + "'";
        const int named = reference(member(source, "attributes"), entry.key().c_str());
        if (named < 0) continue; // not used by the primitive
        const int id = reference(attributes, entry.key().c_str());
        const draco::PointAttribute *attribute =
            id >= 0 ? mesh->GetAttributeByUniqueId(static_cast<uint32_t>(id)) : nullptr;
        if (!attribute) refuse(RSV_ERROR_FORMAT, label + " is not among its packed data");
        rsv_gltf_accessor &accessor = find_accessor(document, named, label);
        size_t stride;
        bytes data = values_of(*mesh, *attribute, accessor, &stride, label);
        place(accessor, add_view(document, std::move(data), stride));
    }
    if (primitive.indices < 0) return;
    rsv_gltf_accessor &accessor = find_accessor(document, primitive.indices, what);
    accessor.count = 3 * static_cast<size_t>(mesh->num_faces());
    place(accessor, add_view(document, indices_of(*mesh, accessor.span.component_type, what), 0));
    primitive.mode = RSV_GLTF_TRIANGLES; // the packed data are triangles, whatever the mode was
}

} // namespace

void rsv_gltf::unpack_draco(owned_document &document)
{
    const json &meshes = list(document.tree, "meshes");
    for (size_t k = 0; k < meshes.size(); k++) {
        const json &primitives = list(meshes[k], "primitives");
        for (size_t i = 0; i < primitives.size(); i++)
            if (extension(primitives[i], extension_name).is_object())
                unpack_primitive(document, primitives[i], document.primitives[k][i],
                    label(meshes[k], "mesh", k));
    }
}
