/// Loads the parts of a glTF file: its JSON, and the bytes of its buffers and images, wherever they are. Messages are
/// the library's own and quote no data.
#include "file_source.h"
#include "gltf_archive.h"
#include "gltf_json.hpp"

extern "C" {
#include "../core/core.h"
}

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstring>
#include <map>
#include <memory>

namespace
{

using namespace rsv_gltf;

constexpr int max_json_depth = 200; // readers of JSON, ours of baked files too, recurse
constexpr size_t glb_header = 12, chunk_header = 8;
constexpr uint32_t chunk_json = 0x4e4f534a, chunk_binary = 0x004e4942;

// ---- files --------------------------------------------------------------------------------------

/// The first `most` bytes of a file. @param problem out: what is wrong; empty = nothing
bytes read_bytes(
    const rsv_file_source *files, const std::string &path, uint64_t most, std::string &problem)
{
    const int64_t there = rsv_file_size(files, path.c_str());
    std::unique_ptr<FILE, int (*)(FILE *)> file(rsv_file_open(files, path.c_str()), std::fclose);
    bytes data;
    if (!file || there < 0) {
        problem = std::string("cannot be opened: ") + std::strerror(errno);
        return data;
    }
    const uint64_t size = std::min(static_cast<uint64_t>(there), most);
    if (size > UINT_MAX) { // the limit of the GLB container, too
        problem = "is larger than 4 GiB; split the scene";
        return data;
    }
    data.resize(static_cast<size_t>(size));
    if (std::fread(data.data(), 1, data.size(), file.get()) != data.size())
        problem = "cannot be read to its end";
    return data;
}

/// False if ".." on the way leads out of the folder that a relative path begins in, or if it is none.
bool stays_below(const std::string &path)
{
    if (path.empty() || path[0] == '/') return false;
    int depth = 0;
    for (size_t begin = 0; begin <= path.size();) {
        const size_t end = std::min(path.find('/', begin), path.size());
        const std::string part = path.substr(begin, end - begin);
        if (part == "..")
            depth--;
        else if (!part.empty() && part != ".")
            depth++;
        if (depth < 0) return false;
        begin = end + 1;
    }
    return true;
}

bool is_file(const rsv_file_source *files, const std::string &path)
{
    return path.find('\0') == std::string::npos && rsv_file_size(files, path.c_str()) >= 0;
}

// ---- URIs ---------------------------------------------------------------------------------------

int hex_digit(char c)
{
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

/// Replaces only %xx; a plus stays a plus, and a percent sign without two digits stays as it is.
std::string percent_decoded(const std::string &uri)
{
    std::string decoded;
    for (size_t i = 0; i < uri.size(); i++) {
        const bool coded = uri[i] == '%' && i + 2 < uri.size() && hex_digit(uri[i + 1]) >= 0 &&
                           hex_digit(uri[i + 2]) >= 0;
        decoded +=
            coded ? static_cast<char>(16 * hex_digit(uri[i + 1]) + hex_digit(uri[i + 2])) : uri[i];
        if (coded) i += 2;
    }
    return decoded;
}

/// The file that a URI names: as it is decoded, as it is written, or with the slashes of Windows turned.
std::string find_file(
    const rsv_file_source *files, const std::string &folder, const std::string &uri)
{
    std::string turned = percent_decoded(uri);
    std::replace(turned.begin(), turned.end(), '\\', '/');
    for (const std::string &name : { percent_decoded(uri), uri, turned })
        if (stays_below(name) && is_file(files, folder + name)) return folder + name;
    return {};
}

bool is_data_uri(const std::string &uri) { return uri.compare(0, 5, "data:") == 0; }

/// The value of each character of base64, of URLs' too; -1 = none.
std::array<int8_t, 256> base64_values()
{
    std::array<int8_t, 256> value;
    value.fill(-1);
    const char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (int8_t k = 0; k < 64; k++)
        value[static_cast<unsigned char>(letters[k])] = k;
    value['-'] = 62;
    value['_'] = 63;
    return value;
}

/// The first `most` bytes of a data URI. @return what is wrong; empty = nothing
std::string decode_data_uri(const std::string &uri, size_t most, bytes &data)
{
    const size_t comma = uri.find(',');
    if (comma == std::string::npos) return "its data URI has no comma before its data";
    const std::string head = uri.substr(0, comma);
    const bool base64 = head.size() >= 7 && head.compare(head.size() - 7, 7, ";base64") == 0;
    if (!base64) {
        const std::string plain = percent_decoded(uri.substr(comma + 1));
        data.assign(plain.begin(),
            plain.begin() + static_cast<std::ptrdiff_t>(std::min(most, plain.size())));
        return {};
    }
    static const std::array<int8_t, 256> value = base64_values();
    data.reserve(std::min(most, (uri.size() - comma) / 4 * 3 + 3));
    uint32_t word = 0;
    int bits = 0;
    const std::string coded = uri.find('%', comma) == std::string::npos
                                  ? std::string()
                                  : percent_decoded(uri.substr(comma + 1));
    const char *at = coded.empty() ? uri.data() + comma + 1 : coded.data();
    const char *end = coded.empty() ? uri.data() + uri.size() : coded.data() + coded.size();
    for (; at < end && *at != '='; at++) {
        const int digit = value[static_cast<unsigned char>(*at)];
        if (digit < 0 && std::strchr(" \t\r\n", *at) && *at) continue;
        if (digit < 0) return "its data URI is not valid base64";
        word = word << 6 | static_cast<uint32_t>(digit);
        bits += 6;
        if (bits < 8) continue;
        bits -= 8;
        if (data.size() < most) data.push_back(static_cast<unsigned char>(word >> bits & 255));
    }
    return {};
}

// ---- JSON ---------------------------------------------------------------------------------------

/// "line 3, column 7" of a byte of a text.
std::string place_in(const unsigned char *text, size_t byte)
{
    const unsigned char *end = text + byte;
    const auto line = 1 + std::count(text, end, '\n');
    const unsigned char *begin = end;
    while (begin > text && begin[-1] != '\n')
        begin--;
    return "line " + std::to_string(line) + ", column " + std::to_string(end - begin + 1);
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
            if (++depth > max_json_depth)
                refuse(RSV_ERROR_FORMAT, "its JSON is nested too deeply at " + place_in(text, i) +
                                             ": more than " + std::to_string(max_json_depth) +
                                             " levels");
        } else if (c == '}' || c == ']') {
            depth--;
        }
    }
}

json parse_json(const unsigned char *text, size_t length)
{
    while (length && (text[length - 1] == 0 || text[length - 1] == ' '))
        length--; // padding
    if (length >= 2 && (text[0] == 0xff || text[0] == 0xfe || !text[0] || !text[1]))
        refuse(RSV_ERROR_FORMAT, "its JSON is not in UTF-8, as glTF requires");
    check_json_depth(text, length);
    try {
        json root = json::parse(text, text + length);
        if (!root.is_object())
            refuse(RSV_ERROR_FORMAT, "is not valid glTF: it holds no JSON object");
        return root;
    } catch (const json::parse_error &e) {
        const size_t byte = e.byte ? std::min(e.byte - 1, length) : length;
        if (byte >= length)
            refuse(RSV_ERROR_FORMAT, length ? "its JSON ends in the middle: is the file cut short?"
                                            : "holds no JSON: it is empty");
        refuse(RSV_ERROR_FORMAT, "its JSON is broken near " + place_in(text, byte));
    } catch (const json::out_of_range &) {
        refuse(RSV_ERROR_FORMAT, "its JSON holds a number that is too large");
    }
}

// ---- the container ------------------------------------------------------------------------------

uint32_t word_at(const bytes &data, size_t at)
{
    return data[at] | static_cast<uint32_t>(data[at + 1]) << 8 |
           static_cast<uint32_t>(data[at + 2]) << 16 | static_cast<uint32_t>(data[at + 3]) << 24;
}

/// Part of a file.
struct chunk {
    size_t begin, length;
    bool found;
};

/// Finds the JSON of a .glb, and its binary chunk.
void find_chunks(const bytes &data, chunk &text, chunk &binary)
{
    if (data.size() < glb_header + chunk_header)
        refuse(RSV_ERROR_FORMAT, "is cut short: it ends within its header");
    const uint32_t version = word_at(data, 4), length = word_at(data, 8);
    if (version != 2)
        refuse(version == 1 ? RSV_ERROR_UNSUPPORTED : RSV_ERROR_FORMAT,
            "is binary glTF of version " + std::to_string(version) +
                ", which is not supported; convert it to glTF 2.0");
    if (length > data.size())
        refuse(RSV_ERROR_FORMAT, "is cut short: its header says " + std::to_string(length) +
                                     " bytes, but it has " + std::to_string(data.size()));
    for (size_t at = glb_header; at + chunk_header <= length;) {
        const size_t size = word_at(data, at), begin = at + chunk_header;
        const uint32_t type = word_at(data, at + 4);
        if (size > data.size() - begin)
            refuse(RSV_ERROR_FORMAT,
                "is cut short: a chunk of " + std::to_string(size) + " bytes does not fit in it");
        if (at == glb_header && type != chunk_json)
            refuse(RSV_ERROR_FORMAT, "is not valid glTF: its first chunk is not JSON");
        chunk &found = type == chunk_json ? text : binary;
        if ((type == chunk_json || type == chunk_binary) && !found.found)
            found = { begin, size, true };
        at = begin + size;
    }
    if (!text.found) refuse(RSV_ERROR_FORMAT, "is not valid glTF: it has no chunk of JSON");
}

// ---- checks of the document ---------------------------------------------------------------------

/// "2.1", also where it is written as a number; [0] = -1 if there is none.
std::array<int, 2> version_of(const json &asset, const char *key)
{
    const json &value = member(asset, key);
    std::array<int, 2> version = { -1, 0 };
    const std::string text = value.is_string()   ? value.get<std::string>()
                             : value.is_number() ? value.dump()
                                                 : std::string();
    if (std::sscanf(text.c_str(), "%4d.%4d", &version[0], &version[1]) < 1) version[0] = -1;
    return version;
}

void check_version(const json &root)
{
    const json &asset = member(root, "asset");
    const std::array<int, 2> version = version_of(asset, "version"),
                             least = version_of(asset, "minVersion");
    if (version[0] < 0)
        refuse(RSV_ERROR_FORMAT,
            "is not valid glTF: it has no asset.version, and may be something else");
    const bool suffices = least[0] == 2 && version[0] > 2;
    if (version[0] != 2 && !suffices)
        refuse(RSV_ERROR_UNSUPPORTED,
            "is glTF " + shown(std::to_string(version[0]) + "." + std::to_string(version[1])) +
                ", which is not supported; convert it to glTF 2.0");
    if (least[0] > 2 || (least[0] == 2 && least[1] > 0))
        refuse(RSV_ERROR_UNSUPPORTED, "needs a reader of glTF " + std::to_string(least[0]) + "." +
                                          std::to_string(least[1]) +
                                          " (asset.minVersion); only 2.0 is supported");
}

/// Extensions that are read, or whose absence changes nothing here.
void check_required_extensions(const json &root)
{
    static const char *const known[] = { "EXT_lights_ies", "EXT_mesh_gpu_instancing",
        "EXT_meshopt_compression", "EXT_texture_webp", "KHR_draco_mesh_compression",
        "KHR_lights_punctual", "KHR_materials_anisotropy", "KHR_materials_clearcoat",
        "KHR_materials_diffuse_transmission", "KHR_materials_dispersion",
        "KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_iridescence",
        "KHR_materials_pbrSpecularGlossiness", "KHR_materials_scatter", "KHR_materials_sheen",
        "KHR_materials_specular", "KHR_materials_transmission", "KHR_materials_unlit",
        "KHR_materials_variants", "KHR_materials_volume", "KHR_materials_volume_scatter",
        "KHR_mesh_quantization", "KHR_node_visibility", "KHR_texture_basisu",
        "KHR_texture_transform", "KHR_xmp_json_ld" };
    for (const json &entry : list(root, "extensionsRequired")) {
        if (!entry.is_string()) continue; // reported by find_unread()
        const std::string name = entry.get<std::string>();
        bool found = false;
        for (const char *candidate : known)
            found = found || name == candidate;
        if (!found)
            refuse(RSV_ERROR_UNSUPPORTED, "requires the extension '" + shown(name) +
                                              "', which is not supported; export without it");
    }
}

// ---- buffers and images -------------------------------------------------------------------------

/// State while a document is read: where its files come from, and what was found in the first one.
struct source {
    const rsv_file_source *files;
    std::string folder; ///< "" or with a slash at its end
    bytes file;
    chunk binary;
    bool is_archive;
    std::map<std::string, bytes> kept; ///< files of an archive, by their URIs
};

std::string more_bytes(size_t there, size_t wanted)
{
    return "needs " + std::to_string(wanted) + " bytes (byteLength), but " + std::to_string(there) +
           " are there";
}

/// A buffer of the file named `uri`: its first bytes.
bytes read_buffer_file(
    source &from, const std::string &uri, size_t wanted, const std::string &owner)
{
    if (from.is_archive) {
        bytes kept = from.kept[uri];
        kept.resize(std::min(kept.size(), wanted));
        return kept;
    }
    const std::string path = find_file(from.files, from.folder, uri);
    if (path.empty())
        refuse(RSV_ERROR_IO, owner + ": there is no file '" + shown(uri) +
                                 "'; buffers must lie in the asset's folder or below");
    std::string problem;
    bytes data = read_bytes(from.files, path, wanted, problem);
    if (!problem.empty()) refuse(RSV_ERROR_IO, owner + ": '" + shown(uri) + "' " + problem);
    return data;
}

void read_buffers(owned_document &document, source &from)
{
    const json &buffers = list(document.tree, "buffers");
    for (size_t k = 0; k < buffers.size(); k++) {
        const std::string owner = label(buffers[k], "buffer", k), uri = text(buffers[k], "uri");
        const size_t wanted = size_of(buffers[k], "byteLength", owner);
        bytes data;
        if (is_data_uri(uri)) {
            const std::string problem = decode_data_uri(uri, wanted, data);
            if (!problem.empty()) refuse(RSV_ERROR_FORMAT, owner + ": " + problem);
        } else if (!uri.empty()) {
            data = read_buffer_file(from, uri, wanted, owner);
        } else if (k == 0 && from.binary.found) {
            const size_t size = std::min(wanted, from.binary.length);
            const auto begin = from.file.begin() + static_cast<std::ptrdiff_t>(from.binary.begin);
            data.assign(begin, begin + static_cast<std::ptrdiff_t>(size));
        } else {
            document.buffer_bytes.emplace_back(); // reported where it is used
            continue;
        }
        if (data.size() < wanted)
            refuse(RSV_ERROR_FORMAT, owner + " " + more_bytes(data.size(), wanted));
        document.buffer_bytes.push_back(std::move(data));
    }
}

/// Missing and broken files are empty.
void read_files(const json &images, source &from, std::deque<bytes> &to)
{
    for (const json &image : images) {
        const std::string uri = text(image, "uri");
        std::string problem;
        bytes data;
        if (is_data_uri(uri)) {
            problem = decode_data_uri(uri, SIZE_MAX, data);
        } else if (from.is_archive) {
            data = uri.empty() ? bytes() : from.kept[uri];
        } else if (!uri.empty()) {
            const std::string path = find_file(from.files, from.folder, uri);
            if (!path.empty()) data = read_bytes(from.files, path, UINT64_MAX, problem);
        }
        if (!problem.empty()) data.clear();
        to.push_back(std::move(data));
    }
}

/// All of a document, once its text and its binary chunk are found.
void read_parts(owned_document &document, source &from, const chunk &text)
{
    const unsigned char *begin = from.file.data() + text.begin;
    document.tree = parse_json(begin, text.length);
    document.json_text.assign(begin, begin + text.length);
    check_version(document.tree);
    check_required_extensions(document.tree);
    read_buffers(document, from);
    read_files(list(document.tree, "images"), from, document.image_bytes);
    read_files(
        list(extension(document.tree, "EXT_lights_ies"), "lights"), from, document.luminaire_bytes);
}

bool is_binary(const bytes &file)
{
    return file.size() >= 4 && std::memcmp(file.data(), "glTF", 4) == 0;
}

} // namespace

namespace rsv_gltf
{

std::string shown(const std::string &text)
{
    std::string line = text.substr(0, text.find('\n'));
    return is_data_uri(line) ? "data:..." : line.size() > 200 ? line.substr(0, 200) + "..." : line;
}

void read_file(const rsv_file_source *files, const char *path, owned_document &document)
{
    source from{};
    from.files = files;
    std::string problem;
    const std::string name = path;
    from.folder = name.substr(0, name.rfind('/') + 1); // npos + 1 = 0
    from.file = read_bytes(files, name, UINT64_MAX, problem);
    if (!problem.empty())
        refuse(problem.find("4 GiB") != std::string::npos ? RSV_ERROR_UNSUPPORTED : RSV_ERROR_IO,
            problem);
    chunk text = { 0, from.file.size(), true };
    if (is_binary(from.file)) {
        text.found = false;
        find_chunks(from.file, text, from.binary);
    }
    read_parts(document, from, text);
}

void read_archive(const uint8_t *archive, size_t count, owned_document &document)
{
    source from{};
    size_t at = 0;
    chunk text{};
    rsv_gltf_chunk part;
    from.is_archive = true;
    while (rsv_gltf_archive_next(archive, count, &at, &part))
        if (part.uri) from.kept[part.uri].assign(part.data, part.data + part.size);
    if (at != count) refuse(RSV_ERROR_FORMAT, "is cut off, or is not binary glTF");
    from.file.assign(archive, archive + count);
    find_chunks(from.file, text, from.binary);
    read_parts(document, from, text);
}

} // namespace rsv_gltf
