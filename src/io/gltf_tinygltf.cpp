/// tinygltf behind a C interface: parses, then copies what a scene needs into plain arrays. No exception
/// leaves this file.
#include "gltf_archive.h"
#include "gltf_json.hpp"

extern "C" {
#include "../core/core.h"
}

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <deque>
#include <exception>
#include <map>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include <sys/stat.h>

namespace
{

constexpr int max_json_depth = 200; // tinygltf recurses into extensions and extras

using namespace rsv_gltf;

/// The document and what its pointers lead to.
struct owned_document : rsv_gltf_document {
    tinygltf::Model model;
    std::vector<rsv_gltf_buffer> buffers;
    std::vector<rsv_gltf_buffer_view> buffer_views;
    std::vector<rsv_gltf_accessor> accessors;
    std::deque<std::vector<rsv_gltf_primitive>> primitives;
    std::vector<rsv_gltf_mesh> meshes;
    std::vector<rsv_gltf_node> nodes;
    std::vector<rsv_gltf_material> materials;
    std::deque<owned_material> owned_materials;
    std::vector<rsv_gltf_texture> textures;
    std::vector<rsv_gltf_image> images;
    std::vector<rsv_camera> cameras;
    std::vector<rsv_light> lights;
    std::vector<int> roots;
    std::deque<std::string> names; // a deque: c_str() stays valid while it grows
    std::string parser_warning, json;
};

// ---- files --------------------------------------------------------------------------------------

std::vector<unsigned char> read_file(const std::string &path)
{
    std::unique_ptr<FILE, int (*)(FILE *)> file(std::fopen(path.c_str(), "rb"), std::fclose);
    if (!file) refuse(RSV_ERROR_IO, std::string("cannot be opened: ") + std::strerror(errno));
    struct stat info;
    if (fstat(fileno(file.get()), &info) != 0 || !S_ISREG(info.st_mode))
        refuse(RSV_ERROR_IO, "is not a regular file");
    if (info.st_size > static_cast<off_t>(UINT_MAX)) // the limit of the GLB container, too
        refuse(RSV_ERROR_UNSUPPORTED, "is larger than 4 GiB; split the scene");
    std::vector<unsigned char> bytes(static_cast<size_t>(info.st_size));
    if (std::fread(bytes.data(), 1, bytes.size(), file.get()) != bytes.size())
        refuse(RSV_ERROR_IO, "cannot be read to its end");
    return bytes;
}

/// True if `path` is `root`/... and no ".." on the way leads out of it.
bool lies_below(const std::string &root, const std::string &path)
{
    if (path.compare(0, root.size() + 1, root + "/") != 0) return false;
    int depth = 0;
    size_t begin = root.size() + 1;
    while (begin <= path.size()) {
        size_t end = std::min(path.find('/', begin), path.size());
        std::string part = path.substr(begin, end - begin);
        if (part == "..")
            depth--;
        else if (!part.empty() && part != ".")
            depth++;
        if (depth < 0) return false;
        begin = end + 1;
    }
    return true;
}

/// Where a document lies: in a folder, or in an archive.
struct source {
    std::string folder;
    bool is_archive;
    std::map<std::string, rsv_gltf_chunk>
        files; ///< of the archive, by the path that tinygltf asks for

    const rsv_gltf_chunk *find(const std::string &path) const
    {
        auto found = files.find(path);
        return found == files.end() ? nullptr : &found->second;
    }
};

/// What tinygltf may open: files in the asset's folder or below. It also tries the working directory.
bool file_exists(const std::string &path, void *user)
{
    const source &from = *static_cast<const source *>(user);
    if (from.is_archive) return from.find(path) != nullptr;
    if (!lies_below(from.folder, path)) return false;
    struct stat info;
    return stat(path.c_str(), &info) == 0 && S_ISREG(info.st_mode);
}

std::string same_path(const std::string &path, void *) { return path; }

bool read_whole_file(
    std::vector<unsigned char> *bytes, std::string *error, const std::string &path, void *user)
{
    const source &from = *static_cast<const source *>(user);
    try {
        const rsv_gltf_chunk *kept = from.find(path);
        if (kept)
            bytes->assign(kept->data, kept->data + kept->size);
        else
            *bytes = read_file(path);
        return true;
    } catch (const refusal &r) {
        if (error) *error = r.message;
        return false;
    }
}

bool write_nothing(std::string *, const std::string &, const std::vector<unsigned char> &, void *)
{
    return false;
}

bool file_size(size_t *size, std::string *, const std::string &path, void *user)
{
    struct stat info;
    if (const rsv_gltf_chunk *kept = static_cast<const source *>(user)->find(path)) {
        *size = kept->size;
        return true;
    }
    if (stat(path.c_str(), &info) != 0) return false;
    *size = static_cast<size_t>(info.st_size);
    return true;
}

/// Later versions of tinygltf ask for sizes through one more callback.
template <class callbacks>
auto set_file_size(callbacks &fs, int) -> decltype(fs.GetFileSizeInBytes, void())
{
    fs.GetFileSizeInBytes = file_size;
}
template <class callbacks> void set_file_size(callbacks &, long) { (void)file_size; }

/// Keeps the encoded bytes. Those in a buffer view stay where they are: tinygltf has not checked that they lie
/// inside the buffer.
bool keep_image(tinygltf::Image *image, const int, std::string *, std::string *, int, int,
    const unsigned char *bytes, int size, void *)
{
    if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
    return true;
}

// ---- parsing ------------------------------------------------------------------------------------

std::string first_line(const std::string &text)
{
    std::string line = text.substr(0, text.find('\n'));
    return line.size() > 300 ? line.substr(0, 300) + "..." : line;
}

bool is_binary(const std::vector<unsigned char> &bytes)
{
    return bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0;
}

void check_json_depth(const unsigned char *text, size_t length)
{
    int depth = 0;
    bool in_string = false;
    for (size_t i = 0; i < length; i++) {
        unsigned char c = text[i];
        if (in_string) {
            if (c == '\\')
                i++;
            else if (c == '"')
                in_string = false;
        } else if (c == '"') {
            in_string = true;
        } else if (c == '{' || c == '[') {
            if (++depth > max_json_depth) refuse(RSV_ERROR_FORMAT, "its JSON is nested too deeply");
        } else if (c == '}' || c == ']') {
            depth--;
        }
    }
}

/// The length of a GLB file's JSON chunk as far as it lies within the file.
size_t json_chunk_length(const std::vector<unsigned char> &glb)
{
    if (glb.size() < 20) return 0;
    size_t length = glb[12] | glb[13] << 8 | glb[14] << 16 | static_cast<size_t>(glb[15]) << 24;
    return std::min(length, glb.size() - 20);
}

/// Puts another JSON text into a GLB file's bytes.
void replace_json(std::vector<unsigned char> &glb, std::string text)
{
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const size_t old = json_chunk_length(glb);
    glb.erase(glb.begin() + 20, glb.begin() + 20 + static_cast<std::ptrdiff_t>(old));
    glb.insert(glb.begin() + 20, text.begin(), text.end());
    for (size_t k = 0; k < 4; k++) {
        glb[8 + k] = static_cast<unsigned char>(glb.size() >> 8 * k);
        glb[12 + k] = static_cast<unsigned char>(text.size() >> 8 * k);
    }
}

/// Extensions that are read, or whose absence changes nothing here.
void check_required_extensions(const tinygltf::Model &model)
{
    static const char *const known[] = { "KHR_draco_mesh_compression", "KHR_lights_punctual",
        "KHR_materials_anisotropy", "KHR_materials_clearcoat", "KHR_materials_diffuse_transmission",
        "KHR_materials_dispersion", "KHR_materials_emissive_strength", "KHR_materials_ior",
        "KHR_materials_iridescence", "KHR_materials_pbrSpecularGlossiness", "KHR_materials_scatter",
        "KHR_materials_sheen", "KHR_materials_specular", "KHR_materials_transmission",
        "KHR_materials_unlit", "KHR_materials_variants", "KHR_materials_volume",
        "KHR_materials_volume_scatter", "KHR_mesh_quantization", "KHR_texture_transform" };
    for (const std::string &name : model.extensionsRequired) {
        bool found = false;
        for (const char *candidate : known)
            found = found || name == candidate;
        if (!found)
            refuse(RSV_ERROR_UNSUPPORTED,
                "requires the extension '" + name + "', which is not supported; export without it");
    }
}

/// What the parser found wrong, without the number that its exceptions have in front.
std::string parser_says(const std::string &error)
{
    std::string line = first_line(error);
    if (line.rfind("[json.exception", 0) == 0)
        line.erase(0, std::min(line.find(']'), line.size() - 1) + 1);
    line.erase(0, line.find_first_not_of(' '));
    return line.empty() ? line : ": " + line;
}

/// As tinygltf decodes URIs: a plus is a blank, too.
std::string decoded(const std::string &uri)
{
    std::string text;
    for (size_t k = 0; k < uri.size(); k++) {
        const char digits[] = { k + 2 < uri.size() ? uri[k + 1] : '\0',
            k + 2 < uri.size() ? uri[k + 2] : '\0', '\0' };
        const bool coded = uri[k] == '%' && std::isxdigit(static_cast<unsigned char>(digits[0])) &&
                           std::isxdigit(static_cast<unsigned char>(digits[1]));
        text += coded           ? static_cast<char>(std::stoi(digits, nullptr, 16))
                : uri[k] == '+' ? ' '
                                : uri[k];
        if (coded) k += 2;
    }
    return text;
}

/// The text or binary glTF of an archive, and the files beside it.
std::vector<unsigned char> read_archive(const uint8_t *archive, size_t count, source &from)
{
    size_t at = 0;
    bool binary = false;
    rsv_gltf_chunk chunk, text{};
    while (rsv_gltf_archive_next(archive, count, &at, &chunk)) {
        if (chunk.type == RSV_GLB_JSON && !text.data) text = chunk;
        if (chunk.type == RSV_GLB_BINARY) binary = true;
        if (chunk.uri) from.files.emplace("./" + decoded(chunk.uri), chunk);
    }
    if (at != count || !text.data) refuse(RSV_ERROR_FORMAT, "is cut off or no binary glTF");
    if (binary) return { archive, archive + count };
    return { text.data, text.data + text.size };
}

void parse(std::vector<unsigned char> bytes, source &from, owned_document &document)
{
    const std::string &folder = from.folder;
    tinygltf::TinyGLTF loader;
    tinygltf::FsCallbacks fs{};
    fs.FileExists = file_exists;
    fs.ExpandFilePath = same_path;
    fs.ReadWholeFile = read_whole_file;
    fs.WriteWholeFile = write_nothing;
    fs.user_data = &from;
    set_file_size(fs, 0);
    loader.SetFsCallbacks(fs);
    loader.SetImageLoader(keep_image, nullptr);

    std::string error, image_warnings;
    bool loaded;
    if (is_binary(bytes)) {
        const auto text = bytes.begin() + std::min<std::ptrdiff_t>(20, bytes.end() - bytes.begin());
        document.json.assign(text, text + static_cast<std::ptrdiff_t>(json_chunk_length(bytes)));
        check_json_depth(
            bytes.data() + std::min<size_t>(20, bytes.size()), json_chunk_length(bytes));
        const std::string named = name_packed_indices(
            bytes.data() + std::min<size_t>(20, bytes.size()), json_chunk_length(bytes));
        if (!named.empty()) replace_json(bytes, named);
        loaded = loader.LoadBinaryFromMemory(&document.model, &error, &image_warnings, bytes.data(),
            static_cast<unsigned>(bytes.size()), folder);
    } else {
        document.json.assign(bytes.begin(), bytes.end());
        check_json_depth(bytes.data(), bytes.size());
        const std::string named = name_packed_indices(bytes.data(), bytes.size());
        if (!named.empty()) bytes.assign(named.begin(), named.end());
        loaded = loader.LoadASCIIFromString(&document.model, &error, &image_warnings,
            reinterpret_cast<const char *>(bytes.data()), static_cast<unsigned>(bytes.size()),
            folder);
    }
    check_required_extensions(document.model); // first: it explains most failures of such files
    if (!loaded) {
        bool missing = error.find("File not found") != std::string::npos;
        std::string message = "is not valid glTF" + parser_says(error);
        if (missing) message += "; buffers must lie in the asset's folder or below";
        refuse(missing ? RSV_ERROR_IO : RSV_ERROR_FORMAT, message);
    }
    document.parser_warning = first_line(error);
}

// ---- conversion ---------------------------------------------------------------------------------

const char *keep_name(
    owned_document &document, const std::string &name, const std::string &fallback)
{
    document.names.push_back(name.empty() ? fallback : name);
    return document.names.back().c_str();
}

std::string numbered(const char *kind, size_t index)
{
    return std::string(kind) + " " + std::to_string(index);
}

void convert_buffers(owned_document &document)
{
    for (const tinygltf::Buffer &buffer : document.model.buffers)
        document.buffers.push_back({ buffer.data.data(), buffer.data.size(),
            buffer.uri.empty() ? nullptr : buffer.uri.c_str() });
    for (const tinygltf::BufferView &view : document.model.bufferViews)
        document.buffer_views.push_back(
            { view.buffer, view.byteOffset, view.byteLength, view.byteStride });
}

rsv_gltf_span make_span(int buffer_view, int offset, int component_type)
{
    if (offset < 0) refuse(RSV_ERROR_FORMAT, "a sparse accessor has a negative byteOffset");
    return { buffer_view, static_cast<size_t>(offset), component_type };
}

void convert_accessors(owned_document &document)
{
    for (const tinygltf::Accessor &source : document.model.accessors) {
        rsv_gltf_accessor accessor{};
        accessor.span = { source.bufferView, source.byteOffset, source.componentType };
        accessor.count = source.count;
        accessor.component_count =
            tinygltf::GetNumComponentsInType(static_cast<uint32_t>(source.type));
        accessor.normalized = source.normalized;
        if (source.sparse.isSparse) {
            if (source.sparse.count < 0)
                refuse(RSV_ERROR_FORMAT, "a sparse accessor has a negative count");
            accessor.sparse_count = static_cast<size_t>(source.sparse.count);
            accessor.sparse_indices = make_span(source.sparse.indices.bufferView,
                source.sparse.indices.byteOffset, source.sparse.indices.componentType);
            accessor.sparse_values = make_span(source.sparse.values.bufferView,
                source.sparse.values.byteOffset, source.componentType);
        }
        document.accessors.push_back(accessor);
    }
}

int attribute(const tinygltf::Primitive &primitive, const char *name)
{
    auto found = primitive.attributes.find(name);
    return found == primitive.attributes.end() ? -1 : found->second;
}

void convert_meshes(owned_document &document)
{
    for (const tinygltf::Mesh &mesh : document.model.meshes) {
        std::vector<rsv_gltf_primitive> primitives;
        for (const tinygltf::Primitive &p : mesh.primitives)
            primitives.push_back({ attribute(p, "POSITION"), attribute(p, "NORMAL"), p.indices,
                { attribute(p, "TEXCOORD_0"), attribute(p, "TEXCOORD_1") }, attribute(p, "TANGENT"),
                attribute(p, "COLOR_0"), p.material, p.mode, !p.targets.empty() });
        document.primitives.push_back(std::move(primitives));
        const char *name = keep_name(document, mesh.name, numbered("mesh", document.meshes.size()));
        document.meshes.push_back(
            { name, document.primitives.back().data(), document.primitives.back().size() });
    }
}

/// T * R * S, or the matrix.
void local_transform(const tinygltf::Node &node, const std::string &name, double m[16])
{
    const double identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    std::copy(identity, identity + 16, m);
    if (!node.matrix.empty()) {
        copy_numbers(node.matrix, m, 16, "the matrix of node '" + name + "'");
        return;
    }
    double t[3] = { 0, 0, 0 }, q[4] = { 0, 0, 0, 1 }, s[3] = { 1, 1, 1 };
    copy_numbers(node.translation, t, 3, "the translation of node '" + name + "'");
    copy_numbers(node.rotation, q, 4, "the rotation of node '" + name + "'");
    copy_numbers(node.scale, s, 3, "the scale of node '" + name + "'");
    double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length > 0)) refuse(RSV_ERROR_FORMAT, "the rotation of node '" + name + "' is zero");
    double x = q[0] / length, y = q[1] / length, z = q[2] / length, w = q[3] / length;
    const double rotation[3][3] = {
        { 1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w) },
        { 2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w) },
        { 2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y) },
    };
    for (int column = 0; column < 3; column++)
        for (int row = 0; row < 3; row++)
            m[4 * column + row] = rotation[column][row] * s[column];
    std::copy(t, t + 3, m + 12);
}

void convert_nodes(owned_document &document)
{
    for (const tinygltf::Node &source : document.model.nodes) {
        rsv_gltf_node node{};
        node.name = keep_name(document, source.name, numbered("node", document.nodes.size()));
        node.mesh = source.mesh;
        node.camera = source.camera;
        node.skin = source.skin;
        const tinygltf::Value *light =
            find(extension(source.extensions, "KHR_lights_punctual"), "light");
        node.light = light && light->IsInt() ? light->GetNumberAsInt() : -1;
        node.child = source.children.data();
        node.child_count = source.children.size();
        local_transform(source, node.name, node.local);
        document.nodes.push_back(node);
    }
}

/// The default scene, else the first, else every node that is nobody's child.
void convert_roots(owned_document &document)
{
    const tinygltf::Model &model = document.model;
    if (!model.scenes.empty()) {
        size_t index = model.defaultScene == -1 ? 0 : static_cast<size_t>(model.defaultScene);
        if (index >= model.scenes.size())
            refuse(RSV_ERROR_FORMAT,
                "its default scene " + std::to_string(model.defaultScene) + " does not exist");
        document.roots = model.scenes[index].nodes;
        return;
    }
    std::vector<bool> is_child(model.nodes.size());
    for (const tinygltf::Node &node : model.nodes)
        for (int child : node.children)
            if (static_cast<size_t>(child) < is_child.size())
                is_child[static_cast<size_t>(child)] = true;
    for (size_t i = 0; i < is_child.size(); i++)
        if (!is_child[i]) document.roots.push_back(static_cast<int>(i));
}

void convert_materials(owned_document &document)
{
    for (const tinygltf::Material &source : document.model.materials) {
        document.owned_materials.emplace_back();
        owned_material &owned = document.owned_materials.back();
        owned.name =
            source.name.empty() ? numbered("material", document.materials.size()) : source.name;
        convert_material(source, owned);
        owned.material.value.name = owned.name.c_str();
        owned.material.note = owned.note.c_str();
        owned.material.remark = owned.remark.c_str();
        owned.material.texture = owned.textures.data();
        owned.material.texture_count = owned.textures.size();
        document.materials.push_back(owned.material);
    }
}

rsv_wrap wrap_mode(int mode)
{
    if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return RSV_WRAP_CLAMP;
    if (mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return RSV_WRAP_MIRROR;
    return RSV_WRAP_REPEAT;
}

void convert_textures(owned_document &document)
{
    const tinygltf::Model &model = document.model;
    for (const tinygltf::Texture &source : model.textures) {
        rsv_gltf_texture texture{ source.source, RSV_WRAP_REPEAT, RSV_WRAP_REPEAT, false };
        if (static_cast<size_t>(source.sampler) < model.samplers.size()) {
            const tinygltf::Sampler &sampler = model.samplers[static_cast<size_t>(source.sampler)];
            texture.wrap_u = wrap_mode(sampler.wrapS);
            texture.wrap_v = wrap_mode(sampler.wrapT);
            texture.nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
        }
        document.textures.push_back(texture);
    }
    for (const tinygltf::Image &source : model.images) {
        const std::string &name = source.name.empty() ? source.uri : source.name;
        document.images.push_back({ keep_name(document, source.uri.empty() ? name : source.uri,
                                        numbered("image", document.images.size())),
            source.image.empty() ? nullptr : source.image.data(), source.image.size(),
            source.bufferView, source.uri.empty() ? nullptr : source.uri.c_str() });
    }
}

void convert_cameras(owned_document &document)
{
    for (const tinygltf::Camera &source : document.model.cameras) {
        rsv_camera camera{};
        camera.name = keep_name(document, source.name, "");
        if (source.type == "orthographic") {
            camera.vertical_extent = static_cast<float>(std::fabs(source.orthographic.ymag));
            camera.aspect =
                static_cast<float>(std::fabs(source.orthographic.xmag / source.orthographic.ymag));
        } else {
            camera.vertical_fov = static_cast<float>(source.perspective.yfov);
            camera.aspect = static_cast<float>(source.perspective.aspectRatio);
        }
        document.cameras.push_back(camera);
    }
}

rsv_light_kind light_kind(const std::string &type)
{
    if (type == "point") return RSV_LIGHT_POINT;
    if (type == "spot") return RSV_LIGHT_SPOT;
    if (type == "directional") return RSV_LIGHT_DIRECTIONAL;
    refuse(RSV_ERROR_FORMAT, "a light has the unknown type '" + first_line(type) + "'");
}

void convert_lights(owned_document &document)
{
    for (const tinygltf::Light &source : document.model.lights) {
        double factor[3] = { 1, 1, 1 };
        rsv_light light{};
        light.name = keep_name(document, source.name, "");
        light.kind = light_kind(source.type);
        copy_numbers(source.color, factor, 3, "the colour of light '" + source.name + "'");
        light.intensity = { static_cast<float>(factor[0] * source.intensity),
            static_cast<float>(factor[1] * source.intensity),
            static_cast<float>(factor[2] * source.intensity) };
        if (light.kind == RSV_LIGHT_SPOT) {
            light.inner_cone_angle = static_cast<float>(source.spot.innerConeAngle);
            light.outer_cone_angle = static_cast<float>(source.spot.outerConeAngle);
            light.exponent = static_cast<float>(number(source.extras, "cosExponent", 0));
        }
        document.lights.push_back(light);
    }
}

template <class element>
void publish_array(const std::vector<element> &from, const element *&to, size_t &count)
{
    to = from.data();
    count = from.size();
}

void publish(owned_document &document)
{
    publish_array(document.buffers, document.buffer, document.buffer_count);
    publish_array(document.buffer_views, document.buffer_view, document.buffer_view_count);
    publish_array(document.accessors, document.accessor, document.accessor_count);
    publish_array(document.meshes, document.mesh, document.mesh_count);
    publish_array(document.nodes, document.node, document.node_count);
    publish_array(document.materials, document.material, document.material_count);
    publish_array(document.textures, document.texture, document.texture_count);
    publish_array(document.images, document.image, document.image_count);
    publish_array(document.cameras, document.camera, document.camera_count);
    publish_array(document.lights, document.light, document.light_count);
    publish_array(document.roots, document.root, document.root_count);
    document.warning = document.parser_warning.c_str();
    document.text = document.json.data();
    document.text_bytes = document.json.size();
}

} // namespace

namespace rsv_gltf
{

void copy_numbers(
    const std::vector<double> &from, double *to, size_t count, const std::string &what)
{
    if (from.empty()) return;
    if (from.size() != count)
        refuse(RSV_ERROR_FORMAT, what + " must have " + std::to_string(count) + " numbers, not " +
                                     std::to_string(from.size()));
    std::copy(from.begin(), from.end(), to);
}

} // namespace rsv_gltf

namespace
{

/// @param read gives the bytes of the document, and says where those beside it lie
template <class reader> rsv_status open_document(const rsv_gltf_document **document, reader read)
{
    try {
        std::unique_ptr<owned_document> owned(new owned_document());
        source from{};
        std::vector<unsigned char> bytes = read(from);
        parse(std::move(bytes), from, *owned);
        unpack_draco(owned->model);
        convert_buffers(*owned);
        convert_accessors(*owned);
        convert_meshes(*owned);
        convert_nodes(*owned);
        convert_roots(*owned);
        convert_materials(*owned);
        convert_textures(*owned);
        convert_cameras(*owned);
        convert_lights(*owned);
        publish(*owned);
        *document = owned.release();
        return RSV_OK;
    } catch (const refusal &r) {
        return rsv_fail(r.status, "%s", r.message.c_str());
    } catch (const std::bad_alloc &) {
        return rsv_fail(RSV_ERROR_MEMORY, "out of memory reading glTF");
    } catch (const std::exception &e) {
        return rsv_fail(RSV_ERROR_FORMAT, "%s", e.what());
    } catch (...) {
        return rsv_fail(RSV_ERROR_FORMAT, "is not valid glTF");
    }
}

} // namespace

rsv_status rsv_gltf_open(const char *path, const rsv_gltf_document **document)
{
    return open_document(document, [path](source &from) {
        const std::string file = path;
        from.folder = file.substr(0, file.rfind('/') + 1) + "."; // npos + 1 = 0: "." alone
        return read_file(file);
    });
}

rsv_status rsv_gltf_open_archive(
    const uint8_t *archive, size_t count, const rsv_gltf_document **document)
{
    return open_document(document, [archive, count](source &from) {
        from.is_archive = true;
        from.folder = ".";
        return read_archive(archive, count, from);
    });
}

void rsv_gltf_close(const rsv_gltf_document *document)
{
    delete static_cast<const owned_document *>(document);
}
