/// Finds what is not read of a glTF file: unknown extensions, properties and attributes, and invalid values. Each is
/// named once per file, with the kind of object that has it. The tables below list what is read or reported elsewhere.
#include "gltf_json.hpp"

#include <cctype>
#include <cstring>
#include <map>
#include <set>

namespace
{

using namespace rsv_gltf;

/// A hostile file could have a million different ones.
constexpr size_t most_findings = 64;

struct schema;

/// Types: b flag, i integer, n number, s text; I, N, S arrays of those; o object; l array of objects; a attributes;
/// A array of attributes; x anything.
struct property {
    const char *name;
    char type;
    const schema *child = nullptr;
};

struct properties {
    const property *first = nullptr;
    size_t count = 0;

    constexpr properties() = default;
    template <size_t n> constexpr properties(const property (&all)[n]) : first(all), count(n) {}

    const property *find(const std::string &name) const
    {
        for (size_t k = 0; k < count; k++)
            if (name == first[k].name) return &first[k];
        return nullptr;
    }
};

struct schema {
    const char *one, *many;
    bool named; ///< has a name or number of its own; otherwise messages say "of" and its parent
    properties members, extensions;
};

// ---- textures and materials -----------------------------------------------------------------------

constexpr property transform_members[] = { { "offset", 'N' }, { "rotation", 'n' }, { "scale", 'N' },
    { "texCoord", 'i' } };
constexpr schema transform = { "texture transform", "texture transforms", false, transform_members,
    {} };

constexpr property texture_use_members[] = { { "index", 'i' }, { "texCoord", 'i' },
    { "scale", 'n' }, { "strength", 'n' } };
constexpr property texture_use_extensions[] = { { "KHR_texture_transform", 'o', &transform } };
constexpr schema texture_use = { "texture reference", "texture references", false,
    texture_use_members, texture_use_extensions };

constexpr property pbr_members[] = { { "baseColorFactor", 'N' },
    { "baseColorTexture", 'o', &texture_use }, { "metallicFactor", 'n' },
    { "roughnessFactor", 'n' }, { "metallicRoughnessTexture", 'o', &texture_use } };
constexpr schema pbr = { "pbrMetallicRoughness", "pbrMetallicRoughness", false, pbr_members, {} };

constexpr property anisotropy_members[] = { { "anisotropyStrength", 'n' },
    { "anisotropyRotation", 'n' }, { "anisotropyTexture", 'o', &texture_use } };
constexpr schema anisotropy = { "anisotropy", "anisotropies", false, anisotropy_members, {} };

constexpr property clearcoat_members[] = { { "clearcoatFactor", 'n' },
    { "clearcoatTexture", 'o', &texture_use }, { "clearcoatRoughnessFactor", 'n' },
    { "clearcoatRoughnessTexture", 'o', &texture_use },
    { "clearcoatNormalTexture", 'o', &texture_use } };
constexpr schema clearcoat = { "clear coat", "clear coats", false, clearcoat_members, {} };

constexpr property diffuse_members[] = { { "diffuseTransmissionFactor", 'n' },
    { "diffuseTransmissionTexture", 'o', &texture_use }, { "diffuseTransmissionColorFactor", 'N' },
    { "diffuseTransmissionColorTexture", 'o', &texture_use } };
constexpr schema diffuse = { "diffuse transmission", "diffuse transmissions", false,
    diffuse_members, {} };

constexpr property dispersion_members[] = { { "dispersion", 'n' } };
constexpr schema dispersion = { "dispersion", "dispersions", false, dispersion_members, {} };

constexpr property strength_members[] = { { "emissiveStrength", 'n' } };
constexpr schema strength = { "emissive strength", "emissive strengths", false, strength_members,
    {} };

constexpr property iridescence_members[] = { { "iridescenceFactor", 'n' },
    { "iridescenceTexture", 'o', &texture_use }, { "iridescenceIor", 'n' },
    { "iridescenceThicknessMinimum", 'n' }, { "iridescenceThicknessMaximum", 'n' },
    { "iridescenceThicknessTexture", 'o', &texture_use } };
constexpr schema iridescence = { "iridescence", "iridescences", false, iridescence_members, {} };

constexpr property ior_members[] = { { "ior", 'n' } };
constexpr schema ior = { "index of refraction", "indices of refraction", false, ior_members, {} };

constexpr property glossiness_members[] = { { "diffuseFactor", 'N' },
    { "diffuseTexture", 'o', &texture_use }, { "specularFactor", 'N' }, { "glossinessFactor", 'n' },
    { "specularGlossinessTexture", 'o', &texture_use } };
constexpr schema glossiness = { "glossiness", "glossinesses", false, glossiness_members, {} };

constexpr property scatter_members[] = { { "multiscatterColorFactor", 'N' } };
constexpr schema scatter = { "scattering medium", "scattering media", false, scatter_members, {} };

constexpr property former_scatter_members[] = { { "multiscatterColor", 'N' } };
constexpr schema former_scatter = { "scattering medium", "scattering media", false,
    former_scatter_members, {} };

constexpr property sheen_members[] = { { "sheenColorFactor", 'N' },
    { "sheenColorTexture", 'o', &texture_use }, { "sheenRoughnessFactor", 'n' },
    { "sheenRoughnessTexture", 'o', &texture_use } };
constexpr schema sheen = { "sheen", "sheens", false, sheen_members, {} };

constexpr property specular_members[] = { { "specularFactor", 'n' },
    { "specularTexture", 'o', &texture_use }, { "specularColorFactor", 'N' },
    { "specularColorTexture", 'o', &texture_use } };
constexpr schema specular = { "specular", "speculars", false, specular_members, {} };

constexpr property transmission_members[] = { { "transmissionFactor", 'n' },
    { "transmissionTexture", 'o', &texture_use } };
constexpr schema transmission = { "transmission", "transmissions", false, transmission_members,
    {} };

constexpr schema unlit = { "unlit", "unlit", false, {}, {} };

constexpr property volume_members[] = { { "thicknessFactor", 'n' },
    { "thicknessTexture", 'o', &texture_use }, { "attenuationDistance", 'n' },
    { "attenuationColor", 'N' } };
constexpr schema volume = { "volume", "volumes", false, volume_members, {} };

constexpr property material_members[] = { { "name", 's' }, { "pbrMetallicRoughness", 'o', &pbr },
    { "normalTexture", 'o', &texture_use }, { "occlusionTexture", 'o', &texture_use },
    { "emissiveTexture", 'o', &texture_use }, { "emissiveFactor", 'N' }, { "alphaMode", 's' },
    { "alphaCutoff", 'n' }, { "doubleSided", 'b' } };
constexpr property material_extensions[] = { { "KHR_materials_anisotropy", 'o', &anisotropy },
    { "KHR_materials_clearcoat", 'o', &clearcoat },
    { "KHR_materials_diffuse_transmission", 'o', &diffuse },
    { "KHR_materials_dispersion", 'o', &dispersion },
    { "KHR_materials_emissive_strength", 'o', &strength }, { "KHR_materials_ior", 'o', &ior },
    { "KHR_materials_iridescence", 'o', &iridescence },
    { "KHR_materials_pbrSpecularGlossiness", 'o', &glossiness },
    { "KHR_materials_scatter", 'o', &scatter },
    { "KHR_materials_volume_scatter", 'o', &former_scatter },
    { "KHR_materials_sheen", 'o', &sheen }, { "KHR_materials_specular", 'o', &specular },
    { "KHR_materials_transmission", 'o', &transmission }, { "KHR_materials_unlit", 'o', &unlit },
    { "KHR_materials_volume", 'o', &volume } };
constexpr schema material = { "material", "materials", true, material_members,
    material_extensions };

constexpr property texture_members[] = { { "name", 's' }, { "sampler", 'i' }, { "source", 'i' } };
constexpr property webp_members[] = { { "source", 'i' } };
constexpr schema webp = { "WebP texture", "WebP textures", false, webp_members, {} };

constexpr schema basisu = { "KTX2 texture", "KTX2 textures", false, webp_members, {} };

constexpr property texture_extensions[] = { { "EXT_texture_webp", 'o', &webp },
    { "KHR_texture_basisu", 'o', &basisu } };
constexpr schema texture = { "texture", "textures", true, texture_members, texture_extensions };

constexpr property image_members[] = { { "name", 's' }, { "uri", 's' }, { "mimeType", 's' },
    { "bufferView", 'i' } };
constexpr schema image = { "image", "images", true, image_members, {} };

constexpr property sampler_members[] = { { "name", 's' }, { "magFilter", 'i' },
    { "minFilter", 'i' }, { "wrapS", 'i' }, { "wrapT", 'i' } };
constexpr schema sampler = { "sampler", "samplers", true, sampler_members, {} };

// ---- geometry -------------------------------------------------------------------------------------

constexpr property packed_members[] = { { "bufferView", 'i' }, { "attributes", 'x' } };
constexpr schema packed = { "packed mesh", "packed meshes", false, packed_members, {} };

constexpr property mapping_members[] = { { "name", 's' }, { "material", 'i' },
    { "variants", 'I' } };
constexpr schema mapping = { "mapping", "mappings", false, mapping_members, {} };

constexpr property mappings_members[] = { { "mappings", 'l', &mapping } };
constexpr schema mappings = { "set of variants", "sets of variants", false, mappings_members, {} };

constexpr property primitive_members[] = { { "attributes", 'a' }, { "indices", 'i' },
    { "material", 'i' }, { "mode", 'i' }, { "targets", 'A' } };
constexpr property primitive_extensions[] = { { "KHR_draco_mesh_compression", 'o', &packed },
    { "KHR_materials_variants", 'o', &mappings } };
constexpr schema primitive = { "primitive", "primitives", false, primitive_members,
    primitive_extensions };

constexpr property mesh_members[] = { { "name", 's' }, { "primitives", 'l', &primitive },
    { "weights", 'N' } };
constexpr schema mesh = { "mesh", "meshes", true, mesh_members, {} };

constexpr property sparse_span_members[] = { { "bufferView", 'i' }, { "byteOffset", 'i' },
    { "componentType", 'i' } };
constexpr schema sparse_span = { "sparse part", "sparse parts", false, sparse_span_members, {} };

constexpr property sparse_members[] = { { "count", 'i' }, { "indices", 'o', &sparse_span },
    { "values", 'o', &sparse_span } };
constexpr schema sparse = { "sparse part", "sparse parts", false, sparse_members, {} };

constexpr property accessor_members[] = { { "name", 's' }, { "bufferView", 'i' },
    { "byteOffset", 'i' }, { "componentType", 'i' }, { "normalized", 'b' }, { "count", 'i' },
    { "type", 's' }, { "max", 'x' }, { "min", 'x' }, { "sparse", 'o', &sparse } };
constexpr schema accessor = { "accessor", "accessors", true, accessor_members, {} };

constexpr property view_members[] = { { "name", 's' }, { "buffer", 'i' }, { "byteOffset", 'i' },
    { "byteLength", 'i' }, { "byteStride", 'i' }, { "target", 'i' } };
constexpr property meshopt_members[] = { { "buffer", 'i' }, { "byteOffset", 'i' },
    { "byteLength", 'i' }, { "byteStride", 'i' }, { "count", 'i' }, { "mode", 's' },
    { "filter", 's' } };
constexpr schema meshopt = { "packed buffer view", "packed buffer views", false, meshopt_members,
    {} };

constexpr property view_extensions[] = { { "EXT_meshopt_compression", 'o', &meshopt } };
constexpr schema view = { "buffer view", "buffer views", true, view_members, view_extensions };

constexpr property buffer_members[] = { { "name", 's' }, { "uri", 's' }, { "byteLength", 'i' } };
constexpr property fallback_members[] = { { "fallback", 'b' } };
constexpr schema fallback = { "fallback", "fallbacks", false, fallback_members, {} };

constexpr property buffer_extensions[] = { { "EXT_meshopt_compression", 'o', &fallback } };
constexpr schema buffer = { "buffer", "buffers", true, buffer_members, buffer_extensions };

// ---- nodes ----------------------------------------------------------------------------------------

constexpr property node_light_members[] = { { "light", 'i' } };
constexpr schema node_light = { "light reference", "light references", false, node_light_members,
    {} };

constexpr property node_luminaire_members[] = { { "light", 'i' }, { "multiplier", 'n' },
    { "color", 'N' } };
constexpr schema node_luminaire = { "luminaire reference", "luminaire references", false,
    node_luminaire_members, {} };

constexpr property visibility_members[] = { { "visible", 'b' } };
constexpr schema visibility = { "visibility", "visibilities", false, visibility_members, {} };

constexpr property instancing_members[] = { { "attributes", 'a' } };
constexpr schema instancing = { "set of instances", "sets of instances", false, instancing_members,
    {} };

constexpr property node_members[] = { { "name", 's' }, { "camera", 'i' }, { "children", 'I' },
    { "skin", 'i' }, { "matrix", 'N' }, { "mesh", 'i' }, { "rotation", 'N' }, { "scale", 'N' },
    { "translation", 'N' }, { "weights", 'N' } };
constexpr property node_extensions[] = { { "KHR_lights_punctual", 'o', &node_light },
    { "EXT_lights_ies", 'o', &node_luminaire }, { "KHR_node_visibility", 'o', &visibility },
    { "EXT_mesh_gpu_instancing", 'o', &instancing } };
constexpr schema node = { "node", "nodes", true, node_members, node_extensions };

constexpr property scene_members[] = { { "name", 's' }, { "nodes", 'I' } };
constexpr schema scene = { "scene", "scenes", true, scene_members, {} };

constexpr property skin_members[] = { { "name", 's' }, { "inverseBindMatrices", 'i' },
    { "joints", 'I' }, { "skeleton", 'i' } };
constexpr schema skin = { "skin", "skins", true, skin_members, {} };

constexpr property perspective_members[] = { { "aspectRatio", 'n' }, { "yfov", 'n' },
    { "zfar", 'n' }, { "znear", 'n' } };
constexpr schema perspective = { "lens", "lenses", false, perspective_members, {} };

constexpr property orthographic_members[] = { { "xmag", 'n' }, { "ymag", 'n' }, { "zfar", 'n' },
    { "znear", 'n' } };
constexpr schema orthographic = { "lens", "lenses", false, orthographic_members, {} };

constexpr property camera_members[] = { { "name", 's' }, { "type", 's' },
    { "perspective", 'o', &perspective }, { "orthographic", 'o', &orthographic } };
constexpr schema camera = { "camera", "cameras", true, camera_members, {} };

constexpr property spot_members[] = { { "innerConeAngle", 'n' }, { "outerConeAngle", 'n' } };
constexpr schema spot = { "cone", "cones", false, spot_members, {} };

constexpr property light_members[] = { { "name", 's' }, { "color", 'N' }, { "intensity", 'n' },
    { "spot", 'o', &spot }, { "type", 's' }, { "range", 'n' } };
constexpr schema light = { "light", "lights", true, light_members, {} };

constexpr property animation_target_members[] = { { "node", 'i' }, { "path", 's' } };
constexpr schema animation_target = { "target", "targets", false, animation_target_members, {} };

constexpr property channel_members[] = { { "sampler", 'i' }, { "target", 'o', &animation_target } };
constexpr schema channel = { "channel", "channels", false, channel_members, {} };

constexpr property track_members[] = { { "input", 'i' }, { "interpolation", 's' },
    { "output", 'i' } };
constexpr schema track = { "sampler", "samplers of animations", false, track_members, {} };

constexpr property animation_members[] = { { "name", 's' }, { "channels", 'l', &channel },
    { "samplers", 'l', &track } };
constexpr schema animation = { "animation", "animations", true, animation_members, {} };

// ---- the file -------------------------------------------------------------------------------------

constexpr property asset_members[] = { { "version", 'x' }, { "minVersion", 'x' },
    { "generator", 's' }, { "copyright", 's' } };
constexpr schema asset = { "asset", "assets", false, asset_members, {} };

constexpr property lights_members[] = { { "lights", 'l', &light } };
constexpr schema lights = { "list of lights", "lists of lights", false, lights_members, {} };

constexpr property luminaire_members[] = { { "name", 's' }, { "uri", 's' }, { "bufferView", 'i' },
    { "mimeType", 's' } };
constexpr schema luminaire = { "luminaire", "luminaires", true, luminaire_members, {} };

constexpr property luminaires_members[] = { { "lights", 'l', &luminaire } };
constexpr schema luminaires = { "list of luminaires", "lists of luminaires", false,
    luminaires_members, {} };

constexpr property file_members[] = { { "asset", 'o', &asset }, { "scene", 'i' },
    { "scenes", 'l', &scene }, { "nodes", 'l', &node }, { "meshes", 'l', &mesh },
    { "accessors", 'l', &accessor }, { "bufferViews", 'l', &view }, { "buffers", 'l', &buffer },
    { "materials", 'l', &material }, { "textures", 'l', &texture }, { "images", 'l', &image },
    { "samplers", 'l', &sampler }, { "cameras", 'l', &camera }, { "skins", 'l', &skin },
    { "animations", 'l', &animation }, { "extensionsUsed", 'S' }, { "extensionsRequired", 'S' } };
constexpr property variant_members[] = { { "name", 's' } };
constexpr schema variant = { "variant", "variants", true, variant_members, {} };

constexpr property variants_members[] = { { "variants", 'l', &variant } };
constexpr schema variants = { "list of variants", "lists of variants", false, variants_members,
    {} };

constexpr property file_extensions[] = { { "KHR_materials_variants", 'o', &variants },
    { "KHR_lights_punctual", 'o', &lights }, { "EXT_lights_ies", 'o', &luminaires } };
constexpr schema file = { "file", "files", false, file_members, file_extensions };

// ---- finding --------------------------------------------------------------------------------------

/// An object of the file and its parent.
struct place {
    const json *value;
    const schema *kind;
    size_t index;
    const place *parent;
};

std::string describe(const place &at)
{
    if (at.kind->named) return label(*at.value, at.kind->one, at.index);
    if (!at.parent || !at.parent->parent)
        return "the " + std::string(at.kind->one) + (at.parent ? "" : " itself");
    const place *owner = at.parent;
    while (!owner->kind->named && owner->parent->parent)
        owner = owner->parent;
    const std::string one = at.kind->one, article = std::strchr("aeiou", one[0]) ? "an " : "a ";
    return article + one + " of " + describe(*owner);
}

enum class sort { extension, property, attribute, value };

/// Something that is not read, and the kinds of objects that have it.
struct finding {
    struct use {
        const schema *kind;
        size_t count;
        std::string first;
    };

    sort what;
    std::string name;
    std::vector<use> uses;
};

class finder
{
public:
    void walk(const place &at);
    void check_list(const json &root);
    void tell(owned_document &document) const;

private:
    void record(sort what, const std::string &name, const place &at);
    void walk_member(const property &known, const json &value, const place &at);
    void walk_attributes(const json &attributes, const place &at);
    void walk_extensions(const json &extensions, const place &at);

    std::map<std::pair<sort, std::string>, size_t> index_;
    std::vector<finding> findings_;
    std::set<std::string> unused_;
    size_t left_out_ = 0;
};

void finder::record(sort what, const std::string &name, const place &at)
{
    const auto key = std::make_pair(what, name);
    auto found = index_.find(key);
    if (found == index_.end()) {
        if (findings_.size() >= most_findings) {
            left_out_++;
            return;
        }
        found = index_.emplace(key, findings_.size()).first;
        findings_.push_back({ what, name, {} });
    }
    std::vector<finding::use> &uses = findings_[found->second].uses;
    for (finding::use &use : uses)
        if (use.kind == at.kind) {
            use.count++;
            return;
        }
    uses.push_back({ at.kind, 1, describe(at) });
}

template <class check> bool all_are(const json &array, check is)
{
    if (!array.is_array()) return false;
    for (const json &value : array)
        if (!is(value)) return false;
    return true;
}

bool has_type(const json &value, char type)
{
    const auto is_number = [](const json &v) { return v.is_number(); };
    const auto is_text = [](const json &v) { return v.is_string(); };
    switch (type) {
    case 'b':
        return value.is_boolean();
    case 'i':
        return is_whole(value) && value.get<double>() >= 0;
    case 'n':
        return value.is_number();
    case 's':
        return value.is_string();
    case 'I':
        return all_are(value, is_whole);
    case 'N':
        return all_are(value, is_number);
    case 'S':
        return all_are(value, is_text);
    case 'o':
    case 'a':
        return value.is_object();
    case 'l':
    case 'A':
        return value.is_array();
    default:
        return true;
    }
}

void finder::walk_member(const property &known, const json &value, const place &at)
{
    if (!has_type(value, known.type)) {
        record(sort::value, known.name, at);
    } else if (known.type == 'o') {
        walk({ &value, known.child, 0, &at });
    } else if (known.type == 'a') {
        walk_attributes(value, at);
    } else if (known.type == 'A') {
        for (const json &element : value)
            walk_attributes(element, at);
    } else if (known.type == 'l') {
        for (size_t k = 0; k < value.size(); k++)
            if (value[k].is_object())
                walk({ &value[k], known.child, k, &at });
            else
                record(sort::value, known.name, at);
    }
}

/// POSITION, JOINTS_1, ...: whether the attribute is read.
bool is_read(const std::string &attribute)
{
    static const char *const known[] = { "POSITION", "NORMAL", "TANGENT", "TEXCOORD_0",
        "TEXCOORD_1", "COLOR_0", "TRANSLATION", "ROTATION", "SCALE" };
    for (const char *name : known)
        if (attribute == name) return true;
    return attribute.compare(0, 7, "JOINTS_") == 0 || attribute.compare(0, 8, "WEIGHTS_") == 0;
}

void finder::walk_attributes(const json &attributes, const place &at)
{
    if (!attributes.is_object()) {
        record(sort::value, "targets", at);
        return;
    }
    for (const auto &entry : attributes.items())
        if (!is_read(entry.key()))
            record(sort::attribute, entry.key(), at);
        else if (!is_whole(entry.value()))
            record(sort::value, entry.key(), at);
}

void finder::walk_extensions(const json &extensions, const place &at)
{
    if (!extensions.is_object()) {
        record(sort::value, "extensions", at);
        return;
    }
    for (const auto &entry : extensions.items()) {
        const property *known = at.kind->extensions.find(entry.key());
        if (known)
            walk_member(*known, entry.value(), at);
        else
            record(sort::extension, entry.key(), at);
    }
}

void finder::walk(const place &at)
{
    for (const auto &entry : at.value->items()) {
        if (entry.key() == "extras" || entry.value().is_null()) continue; // null is absent
        if (entry.key() == "extensions") {
            walk_extensions(entry.value(), at);
            continue;
        }
        const property *known = at.kind->members.find(entry.key());
        if (known)
            walk_member(*known, entry.value(), at);
        else
            record(sort::property, entry.key(), at);
    }
}

/// Extensions that are listed, but that no object has.
void finder::check_list(const json &root)
{
    static const char *const without_objects[] = { "KHR_mesh_quantization" };
    std::set<std::string> known(std::begin(without_objects), std::end(without_objects));
    for (const schema *kind :
        { &texture_use, &texture, &material, &view, &primitive, &node, &file })
        for (size_t k = 0; k < kind->extensions.count; k++)
            known.insert(kind->extensions.first[k].name);
    for (const json &entry : list(root, "extensionsUsed"))
        if (entry.is_string()) unused_.insert(entry.get<std::string>());
    for (const std::string &name : known)
        unused_.erase(name);
    for (const finding &found : findings_)
        if (found.what == sort::extension) unused_.erase(found.name);
}

// ---- telling --------------------------------------------------------------------------------------

/// Whether an extension has no effect on the picture.
bool is_harmless(const finding &found)
{
    if (found.what == sort::attribute) return true;
    return found.what == sort::extension &&
           (found.name == "KHR_xmp" || found.name == "KHR_xmp_json_ld");
}

std::string describe(const finding &found)
{
    std::string text;
    const std::string name = "'" + shown(found.name) + "'";
    switch (found.what) {
    case sort::extension:
        text = "extension " + name + " is ignored: ";
        break;
    case sort::property:
        text = "property " + name + " is ignored: ";
        break;
    case sort::attribute:
        text = "attribute " + name + " is ignored: ";
        break;
    case sort::value:
        text = "property " + name + " has a value that is not in the format, and is ignored: ";
        break;
    }
    for (const finding::use &use : found.uses) {
        if (&use != &found.uses.front()) text += ", ";
        text += use.count == 1 ? use.first
                               : std::to_string(use.count) + " " + use.kind->many +
                                     " (first: " + use.first + ")";
    }
    return text;
}

void finder::tell(owned_document &document) const
{
    for (const finding &found : findings_)
        document.owned_notes.push_back(
            { is_harmless(found) ? RSV_LOG_INFO : RSV_LOG_WARNING, describe(found) });
    if (left_out_)
        document.owned_notes.push_back({ RSV_LOG_WARNING,
            std::to_string(left_out_) + " more uses of extensions and properties "
                                        "that are not known are ignored" });
    size_t told = 0;
    for (const std::string &name : unused_)
        if (told++ < most_findings)
            document.owned_notes.push_back({ RSV_LOG_INFO,
                "extension '" + shown(name) + "' is listed as used, but nothing uses it" });
}

} // namespace

void rsv_gltf::find_unread(owned_document &document)
{
    finder found;
    found.walk({ &document.tree, &file, 0, nullptr });
    found.check_list(document.tree);
    found.tell(document);
}
