/// Access to the JSON of a glTF file, with a default for each member, and the document made of it.
///
/// A member of the wrong type counts as absent: rsv_gltf::find_unread() reports it.
#ifndef RSV_GLTF_JSON_HPP
#define RSV_GLTF_JSON_HPP

#include "gltf_document.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <deque>
#include <string>
#include <vector>

namespace rsv_gltf
{

typedef nlohmann::json json;
typedef std::vector<unsigned char> bytes;

/// Ends reading; rsv_gltf_open turns it into an error.
struct refusal {
    rsv_status status;
    std::string message;
};

[[noreturn]] inline void refuse(rsv_status status, const std::string &message)
{
    throw refusal{ status, message };
}

/// A member of an object; null if absent, or if this is no object.
inline const json &member(const json &object, const char *key)
{
    static const json none;
    if (!object.is_object()) return none;
    auto found = object.find(key);
    return found == object.end() ? none : *found;
}

/// An array of objects; empty if absent.
inline const json &list(const json &object, const char *key)
{
    static const json none = json::array();
    const json &found = member(object, key);
    return found.is_array() ? found : none;
}

inline const json &extension(const json &object, const char *name)
{
    return member(member(object, "extensions"), name);
}

inline double number(const json &object, const char *key, double fallback)
{
    const json &value = member(object, key);
    return value.is_number() ? value.get<double>() : fallback;
}

/// Whether JSON's number has no fraction: some exporters write 5126.0.
inline bool is_whole(const json &value)
{
    if (value.is_number_integer()) return true; // unsigned ones, too
    if (!value.is_number()) return false;
    const double number = value.get<double>();
    return std::floor(number) == number && std::fabs(number) < 9007199254740992.0;
}

/// An index; `fallback` if absent, and -2, which refers to nothing, for numbers beyond int.
inline int reference(const json &object, const char *key, int fallback = -1)
{
    const json &value = member(object, key);
    if (!is_whole(value)) return fallback;
    const double number = value.get<double>();
    return std::fabs(number) <= INT32_MAX ? static_cast<int>(number) : -2;
}

/// A size or an offset in bytes or elements.
inline size_t size_of(const json &object, const char *key, const std::string &owner)
{
    const json &value = member(object, key);
    if (!is_whole(value)) return 0;
    if (value.is_number_unsigned()) return value.get<size_t>();
    const double number = value.get<double>();
    if (number < 0) refuse(RSV_ERROR_FORMAT, owner + ": its " + std::string(key) + " is negative");
    return static_cast<size_t>(number);
}

inline bool flag(const json &object, const char *key, bool fallback = false)
{
    const json &value = member(object, key);
    return value.is_boolean() ? value.get<bool>() : fallback;
}

inline std::string text(const json &object, const char *key)
{
    const json &value = member(object, key);
    return value.is_string() ? value.get<std::string>() : std::string();
}

/// An array of at least `count` numbers; else `value` stays as it is.
inline void numbers(const json &object, const char *key, size_t count, double *value)
{
    const json &array = member(object, key);
    if (!array.is_array() || array.size() < count) return;
    for (size_t i = 0; i < count; i++)
        if (!array[i].is_number()) return;
    for (size_t i = 0; i < count; i++)
        value[i] = array[i].get<double>();
}

/// Reads an array of exactly `count` numbers, from the core format; if it is absent, `value` is kept.
void exact_numbers(
    const json &object, const char *key, size_t count, double *value, const std::string &owner);

inline rsv_rgb to_rgb(const double *value)
{
    return { static_cast<float>(value[0]), static_cast<float>(value[1]),
        static_cast<float>(value[2]) };
}

inline rsv_rgb color(const json &object, const char *key, rsv_rgb fallback)
{
    double value[3] = { fallback.r, fallback.g, fallback.b };
    numbers(object, key, 3, value);
    return to_rgb(value);
}

/// The name, or "node 3".
std::string label(const json &object, const char *kind, size_t index);

/// A text from the file, cut short for a message.
std::string shown(const std::string &text);

/// A material and the storage that its pointers refer to.
struct owned_material {
    rsv_gltf_material material{};
    std::vector<rsv_gltf_texture_ref> textures;
    std::string name, note, remark;
};

/// A message about the file as a whole.
struct owned_note {
    rsv_log_level level;
    std::string text;
};

/// The document and the storage that its pointers refer to.
struct owned_document : rsv_gltf_document {
    json tree; ///< the whole file; empty once it is converted
    std::string json_text;
    std::deque<bytes> buffer_bytes, image_bytes, luminaire_bytes;
    std::vector<rsv_gltf_buffer> buffers;
    std::vector<rsv_gltf_buffer_view> buffer_views;
    std::vector<rsv_gltf_accessor> accessors;
    std::deque<std::vector<rsv_gltf_primitive>> primitives;
    std::deque<std::vector<rsv_gltf_target>> targets;
    std::deque<std::vector<int>> indices;
    std::deque<std::vector<rsv_gltf_variant>> variants;
    std::vector<const char *> variant_names;
    std::deque<std::vector<float>> weights;
    std::deque<std::vector<rsv_gltf_influence>> influences;
    std::vector<rsv_gltf_mesh> meshes;
    std::vector<rsv_gltf_skin> skins;
    std::deque<std::vector<rsv_gltf_channel>> channels;
    std::deque<std::vector<rsv_gltf_sampler>> samplers;
    std::vector<rsv_gltf_animation> animations;
    std::vector<rsv_gltf_node> nodes;
    std::vector<rsv_gltf_material> materials;
    std::deque<owned_material> owned_materials;
    std::vector<rsv_gltf_texture> textures;
    std::vector<rsv_gltf_image> images, luminaires;
    std::vector<rsv_camera> cameras;
    std::vector<rsv_gltf_light> lights;
    std::vector<int> roots;
    std::deque<std::string> names; // a deque: c_str() stays valid while it grows
    std::deque<owned_note> owned_notes;
    std::vector<rsv_gltf_note> notes;
};

/// Parses the file and loads its buffers and images. Fails if it is not glTF 2.0 or requires an unsupported extension.
void read_file(const rsv_file_source *files, const char *path, owned_document &document);

/// The same from an archive (gltf_archive.h).
void read_archive(const uint8_t *archive, size_t count, owned_document &document);

/// Reports what is not read: unknown extensions and properties, and values of a wrong type.
void find_unread(owned_document &document);

/// Makes plain buffers of meshes packed by KHR_draco_mesh_compression.
void unpack_draco(owned_document &document);

/// Makes plain buffers of buffer views packed by EXT_meshopt_compression.
void unpack_meshopt(owned_document &document);

void convert_material(const json &source, owned_material &result);

} // namespace rsv_gltf

#endif
