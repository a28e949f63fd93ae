/// EXT_meshopt_compression: packed buffer views become views of buffers of their own.
#include "gltf_json.hpp"

#include <meshoptimizer.h>

namespace
{

using namespace rsv_gltf;

constexpr const char *extension_name = "EXT_meshopt_compression";
/// A block of attributes takes a byte at least for 64 of its own; a triangle or an index a byte.
constexpr size_t most_bytes_per_byte = 64;

/// The extension's description of packed data.
struct packed_view {
    const unsigned char *data;
    size_t length, count, stride;
    std::string mode, filter;
};

packed_view find_packed(const owned_document &document, const json &from, const std::string &what)
{
    packed_view view{};
    const int index = reference(from, "buffer");
    const size_t offset = size_of(from, "byteOffset", what);
    view.length = size_of(from, "byteLength", what);
    view.count = size_of(from, "count", what);
    view.stride = size_of(from, "byteStride", what);
    view.mode = text(from, "mode");
    view.filter = text(from, "filter");
    if (index < 0 || static_cast<size_t>(index) >= document.buffer_bytes.size())
        refuse(RSV_ERROR_FORMAT, what + ": its packed data lie in a buffer that does not exist");
    const bytes &data = document.buffer_bytes[static_cast<size_t>(index)];
    if (offset > data.size() || view.length > data.size() - offset)
        refuse(RSV_ERROR_FORMAT, what + ": its packed data reach past the end of their buffer");
    view.data = data.data() + offset;
    return view;
}

/// Strides that the mode has, and a count that can come out of so few bytes.
void check_packed(const packed_view &view, const std::string &what)
{
    const bool attributes = view.mode == "ATTRIBUTES", triangles = view.mode == "TRIANGLES";
    if (!attributes && !triangles && view.mode != "INDICES")
        refuse(RSV_ERROR_FORMAT,
            what + ": its mode '" + shown(view.mode) + "' is not one of " + extension_name);
    const bool fits = attributes ? view.stride % 4 == 0 && view.stride >= 4 && view.stride <= 256
                                 : view.stride == 2 || view.stride == 4;
    if (!fits || (triangles && view.count % 3))
        refuse(RSV_ERROR_FORMAT, what + ": its byteStride of " + std::to_string(view.stride) +
                                     " or its count of " + std::to_string(view.count) +
                                     " does not go with mode " + view.mode);
    const size_t most = attributes  ? view.length * most_bytes_per_byte / view.stride
                        : triangles ? 3 * view.length
                                    : view.length;
    if (view.count > most)
        refuse(RSV_ERROR_FORMAT, what + ": " + std::to_string(view.count) +
                                     " elements do not fit in " + std::to_string(view.length) +
                                     " bytes");
}

void filter(const packed_view &view, bytes &data, const std::string &what)
{
    const size_t stride = view.stride;
    const auto need = [&](bool fits) {
        if (!fits || view.mode != "ATTRIBUTES")
            refuse(RSV_ERROR_FORMAT, what + ": its filter " + shown(view.filter) +
                                         " does not go with its mode or byteStride");
    };
    if (view.filter.empty() || view.filter == "NONE") return;
    if (view.filter == "OCTAHEDRAL") {
        need(stride == 4 || stride == 8);
        meshopt_decodeFilterOct(data.data(), view.count, stride);
    } else if (view.filter == "QUATERNION") {
        need(stride == 8);
        meshopt_decodeFilterQuat(data.data(), view.count, stride);
    } else if (view.filter == "EXPONENTIAL") {
        need(true);
        meshopt_decodeFilterExp(data.data(), view.count, stride);
    } else {
        refuse(RSV_ERROR_FORMAT,
            what + ": its filter '" + shown(view.filter) + "' is not one of " + extension_name);
    }
}

bytes unpack(const packed_view &view, const std::string &what)
{
    bytes data(view.count * view.stride);
    int problem = 0;
    if (view.count == 0) return data;
    if (view.mode == "ATTRIBUTES")
        problem = meshopt_decodeVertexBuffer(
            data.data(), view.count, view.stride, view.data, view.length);
    else if (view.mode == "TRIANGLES")
        problem =
            meshopt_decodeIndexBuffer(data.data(), view.count, view.stride, view.data, view.length);
    else
        problem = meshopt_decodeIndexSequence(
            data.data(), view.count, view.stride, view.data, view.length);
    if (problem)
        refuse(RSV_ERROR_FORMAT, what + ": its packed data (" + extension_name +
                                     ") cannot be unpacked; are they damaged?");
    filter(view, data, what);
    return data;
}

} // namespace

void rsv_gltf::unpack_meshopt(owned_document &document)
{
    const json &views = list(document.tree, "bufferViews");
    for (size_t k = 0; k < views.size(); k++) {
        const json &packed = extension(views[k], extension_name);
        if (!packed.is_object()) continue;
        const std::string what = label(views[k], "buffer view", k);
        const packed_view view = find_packed(document, packed, what);
        check_packed(view, what);
        bytes data = unpack(view, what);
        document.buffer_views[k] = { static_cast<int>(document.buffer_bytes.size()), 0, data.size(),
            view.mode == "ATTRIBUTES" ? view.stride : 0 };
        document.buffer_bytes.push_back(std::move(data));
    }
}
