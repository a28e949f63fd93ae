/// From the JSON of a glTF file to plain arrays. No exception leaves this file.
#include "gltf_json.hpp"

extern "C" {
#include "../core/core.h"
#include "matrix.h"
}

#include <algorithm>
#include <exception>
#include <initializer_list>
#include <memory>
#include <new>

namespace
{

using namespace rsv_gltf;

const char *keep(owned_document &document, const std::string &text)
{
    document.names.push_back(text);
    return document.names.back().c_str();
}

const char *keep_label(owned_document &document, const json &object, const char *kind, size_t index)
{
    const std::string name = text(object, "name");
    return keep(document, name.empty() ? std::string(kind) + " " + std::to_string(index) : name);
}

void note(owned_document &document, rsv_log_level level, const std::string &text)
{
    document.owned_notes.push_back({ level, text });
}

// ---- buffers and accessors ----------------------------------------------------------------------

void convert_buffers(owned_document &document)
{
    const json &views = list(document.tree, "bufferViews");
    for (size_t k = 0; k < views.size(); k++) {
        const std::string owner = label(views[k], "buffer view", k);
        document.buffer_views.push_back(
            { reference(views[k], "buffer"), size_of(views[k], "byteOffset", owner),
                size_of(views[k], "byteLength", owner), size_of(views[k], "byteStride", owner) });
    }
}

int component_count(const std::string &type)
{
    static const struct {
        const char *name;
        int count;
    } known[] = { { "SCALAR", 1 }, { "VEC2", 2 }, { "VEC3", 3 }, { "VEC4", 4 }, { "MAT2", 4 },
        { "MAT3", 9 }, { "MAT4", 16 } };
    for (const auto &candidate : known)
        if (type == candidate.name) return candidate.count;
    return 0;
}

rsv_gltf_span span_of(const json &object, int component_type, const std::string &owner)
{
    return { reference(object, "bufferView"), size_of(object, "byteOffset", owner),
        component_type };
}

void convert_accessors(owned_document &document)
{
    const json &accessors = list(document.tree, "accessors");
    for (size_t k = 0; k < accessors.size(); k++) {
        const json &source = accessors[k], &sparse = member(source, "sparse");
        const std::string owner = label(source, "accessor", k);
        const int type = reference(source, "componentType");
        rsv_gltf_accessor accessor{};
        accessor.span = span_of(source, type, owner);
        accessor.count = size_of(source, "count", owner);
        accessor.component_count = component_count(text(source, "type"));
        accessor.normalized = flag(source, "normalized");
        if (sparse.is_object()) {
            const json &indices = member(sparse, "indices");
            accessor.sparse_count = size_of(sparse, "count", owner);
            accessor.sparse_indices = span_of(indices, reference(indices, "componentType"), owner);
            accessor.sparse_values = span_of(member(sparse, "values"), type, owner);
        }
        document.accessors.push_back(accessor);
    }
}

/// After unpacking, which adds to them.
/// Of data a few letters: they are in the JSON.
const char *keep_uri(owned_document &document, const json &owner)
{
    const std::string uri = text(owner, "uri");
    if (uri.empty()) return nullptr;
    return keep(document, uri.compare(0, 5, "data:") == 0 ? "data:" : uri);
}

void publish_buffers(owned_document &document)
{
    const json &sources = list(document.tree, "buffers");
    for (const bytes &buffer : document.buffer_bytes) {
        const size_t k = document.buffers.size();
        document.buffers.push_back({ buffer.empty() ? nullptr : buffer.data(), buffer.size(),
            k < sources.size() ? keep_uri(document, sources[k]) : nullptr });
    }
}

// ---- meshes -------------------------------------------------------------------------------------

rsv_gltf_target convert_target(const json &source)
{
    return { reference(source, "POSITION"), reference(source, "NORMAL"),
        reference(source, "TANGENT"),
        { reference(source, "TEXCOORD_0"), reference(source, "TEXCOORD_1") },
        reference(source, "COLOR_0") };
}

/// Each variant that a primitive has a material for, the first one if it names several.
void convert_variants(owned_document &document, const json &source, rsv_gltf_primitive &primitive)
{
    const json &mappings = list(extension(source, "KHR_materials_variants"), "mappings");
    if (mappings.empty()) return;
    document.variants.emplace_back();
    std::vector<rsv_gltf_variant> &variants = document.variants.back();
    for (const json &mapping : mappings)
        for (const json &variant : list(mapping, "variants"))
            if (is_whole(variant) && std::fabs(variant.get<double>()) <= INT32_MAX)
                variants.push_back(
                    { static_cast<int>(variant.get<double>()), reference(mapping, "material") });
    primitive.variant = variants.data();
    primitive.variant_count = variants.size();
}

rsv_gltf_primitive convert_primitive(owned_document &document, const json &source)
{
    const json &attributes = member(source, "attributes");
    document.targets.emplace_back();
    document.influences.emplace_back();
    std::vector<rsv_gltf_target> &targets = document.targets.back();
    std::vector<rsv_gltf_influence> &influences = document.influences.back();
    for (const json &target : list(source, "targets"))
        targets.push_back(convert_target(target));
    for (size_t set = 0;; set++) {
        const std::string number = std::to_string(set);
        const rsv_gltf_influence influence = {
            reference(attributes, ("JOINTS_" + number).c_str()),
            reference(attributes, ("WEIGHTS_" + number).c_str()),
        };
        if (influence.joints < 0 || influence.weights < 0) break;
        influences.push_back(influence);
    }
    rsv_gltf_primitive primitive{};
    primitive.position = reference(attributes, "POSITION");
    primitive.normal = reference(attributes, "NORMAL");
    primitive.indices = reference(source, "indices");
    primitive.uv[0] = reference(attributes, "TEXCOORD_0");
    primitive.uv[1] = reference(attributes, "TEXCOORD_1");
    primitive.tangent = reference(attributes, "TANGENT");
    primitive.color = reference(attributes, "COLOR_0");
    primitive.material = reference(source, "material");
    primitive.mode = reference(source, "mode", RSV_GLTF_TRIANGLES);
    primitive.target = targets.data();
    primitive.target_count = targets.size();
    primitive.influence = influences.data();
    primitive.influence_count = influences.size();
    convert_variants(document, source, primitive);
    return primitive;
}

/// The numbers of an array; those of another type are 0. NULL if there is no array.
template <class number, class reader>
const number *keep_numbers(
    std::deque<std::vector<number>> &kept, const json &array, size_t *count, reader read)
{
    *count = 0;
    if (!array.is_array()) return nullptr;
    kept.emplace_back();
    for (const json &value : array)
        kept.back().push_back(read(value));
    *count = kept.back().size();
    return kept.back().data();
}

const float *keep_weights(owned_document &document, const json &owner, size_t *count)
{
    static const float none = 0;
    const float *weights = keep_numbers(document.weights, member(owner, "weights"), count,
        [](const json &value) { return value.is_number() ? value.get<float>() : 0; });
    return weights || !member(owner, "weights").is_array() ? weights : &none;
}

/// Elements that are no index become -2, which refers to nothing.
const int *keep_references(owned_document &document, const json &array, size_t *count)
{
    return keep_numbers(document.indices, array, count, [](const json &value) {
        const double number = is_whole(value) ? value.get<double>() : -2;
        return std::fabs(number) <= INT32_MAX ? static_cast<int>(number) : -2;
    });
}

void convert_meshes(owned_document &document)
{
    for (const json &source : list(document.tree, "meshes")) {
        std::vector<rsv_gltf_primitive> primitives;
        for (const json &primitive : list(source, "primitives"))
            primitives.push_back(convert_primitive(document, primitive));
        document.primitives.push_back(std::move(primitives));
        rsv_gltf_mesh mesh{};
        mesh.name = keep_label(document, source, "mesh", document.meshes.size());
        mesh.primitive = document.primitives.back().data();
        mesh.primitive_count = document.primitives.back().size();
        mesh.weight = keep_weights(document, source, &mesh.weight_count);
        document.meshes.push_back(mesh);
    }
}

void convert_skins(owned_document &document)
{
    for (const json &source : list(document.tree, "skins")) {
        rsv_gltf_skin skin{};
        skin.name = keep_label(document, source, "skin", document.skins.size());
        skin.joint = keep_references(document, member(source, "joints"), &skin.joint_count);
        skin.inverse_bind_matrices = reference(source, "inverseBindMatrices");
        document.skins.push_back(skin);
    }
}

// ---- nodes --------------------------------------------------------------------------------------

/// T * R * S, or the matrix.
void local_transform(const json &source, rsv_gltf_node &node)
{
    const double identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    const std::string name = "node '" + std::string(node.name) + "'";
    std::copy(identity, identity + 16, node.local);
    node.rotation[3] = node.scale[0] = node.scale[1] = node.scale[2] = 1;
    node.has_matrix = member(source, "matrix").is_array();
    if (node.has_matrix) {
        exact_numbers(source, "matrix", 16, node.local, name);
        return;
    }
    exact_numbers(source, "translation", 3, node.translation, name);
    exact_numbers(source, "rotation", 4, node.rotation, name);
    exact_numbers(source, "scale", 3, node.scale, name);
    if (!rsv_matrix_place(node.translation, node.rotation, node.scale, node.local))
        refuse(RSV_ERROR_FORMAT, "the rotation of " + name + " is zero");
}

void convert_node_luminaire(const json &source, rsv_gltf_node &node)
{
    const std::string name = "node '" + std::string(node.name) + "'";
    const double multiplier = number(source, "multiplier", 1);
    double color[3] = { 1, 1, 1 }, opening[3] = {};
    node.luminaire = reference(source, "light");
    exact_numbers(source, "color", 3, color, name);
    exact_numbers(member(source, "extras"), "opening", 3, opening, name);
    node.luminaire_scale = { static_cast<float>(color[0] * multiplier),
        static_cast<float>(color[1] * multiplier), static_cast<float>(color[2] * multiplier) };
    node.opening = { static_cast<float>(opening[0]), static_cast<float>(opening[1]),
        static_cast<float>(opening[2]) };
}

void convert_node_extensions(const json &source, rsv_gltf_node &node)
{
    const json &instancing = extension(source, "EXT_mesh_gpu_instancing");
    const json &attributes = member(instancing, "attributes");
    node.light = reference(extension(source, "KHR_lights_punctual"), "light");
    convert_node_luminaire(extension(source, "EXT_lights_ies"), node);
    node.hidden = !flag(extension(source, "KHR_node_visibility"), "visible", true);
    node.instancing = { reference(attributes, "TRANSLATION"), reference(attributes, "ROTATION"),
        reference(attributes, "SCALE") };
    node.instanced = node.instancing.translation >= 0 || node.instancing.rotation >= 0 ||
                     node.instancing.scale >= 0;
}

/// Objects of one kind with the same problem: reported in one line.
struct group {
    size_t count = 0;
    std::string first;

    void add(const std::string &name)
    {
        if (!count++) first = name;
    }

    void tell(owned_document &document, const std::string &many, const std::string &what) const
    {
        if (count == 1) note(document, RSV_LOG_WARNING, first + ": " + what);
        if (count > 1)
            note(document, RSV_LOG_WARNING,
                std::to_string(count) + " " + many + " (first: " + first + "): " + what);
    }
};

bool has_more_than_matrix(const json &node)
{
    return member(node, "matrix").is_array() &&
           (member(node, "translation").is_array() || member(node, "rotation").is_array() ||
               member(node, "scale").is_array());
}

/// Makes the last row of a matrix that of an affine transform. @return whether it was already, apart from rounding
bool make_affine(double m[16])
{
    const double off = std::fabs(m[3]) + std::fabs(m[7]) + std::fabs(m[11]) + std::fabs(m[15] - 1);
    m[3] = m[7] = m[11] = 0;
    m[15] = 1;
    return off <= 1e-6;
}

void convert_nodes(owned_document &document)
{
    group both, skewed;
    for (const json &source : list(document.tree, "nodes")) {
        rsv_gltf_node node{};
        node.name = keep_label(document, source, "node", document.nodes.size());
        node.mesh = reference(source, "mesh");
        node.camera = reference(source, "camera");
        node.skin = reference(source, "skin");
        node.child = keep_references(document, member(source, "children"), &node.child_count);
        node.weight = keep_weights(document, source, &node.weight_count);
        convert_node_extensions(source, node);
        local_transform(source, node);
        if (has_more_than_matrix(source)) both.add(label(source, "node", document.nodes.size()));
        if (!make_affine(node.local)) skewed.add(label(source, "node", document.nodes.size()));
        document.nodes.push_back(node);
    }
    both.tell(document, "nodes", "translation, rotation and scale are ignored next to a matrix");
    skewed.tell(document, "nodes", "the last row of the matrix is not 0, 0, 0, 1, and is ignored");
}

/// The default scene, else the first, else every node without a parent.
void convert_roots(owned_document &document)
{
    const json &scenes = list(document.tree, "scenes");
    if (!scenes.empty()) {
        const int chosen = reference(document.tree, "scene", 0);
        const size_t index = chosen == -1 ? 0 : static_cast<size_t>(chosen);
        if (index >= scenes.size())
            refuse(RSV_ERROR_FORMAT,
                "its default scene " + std::to_string(chosen) + " does not exist");
        size_t count;
        const int *nodes = keep_references(document, member(scenes[index], "nodes"), &count);
        document.roots.assign(nodes, nodes + count);
        if (scenes.size() > 1)
            note(document, RSV_LOG_INFO,
                "it holds " + std::to_string(scenes.size()) +
                    " scenes: " + label(scenes[index], "scene", index) + " is shown");
        return;
    }
    std::vector<bool> is_child(document.nodes.size());
    for (const rsv_gltf_node &node : document.nodes)
        for (size_t k = 0; k < node.child_count; k++)
            if (static_cast<size_t>(node.child[k]) < is_child.size())
                is_child[static_cast<size_t>(node.child[k])] = true;
    for (size_t i = 0; i < is_child.size(); i++)
        if (!is_child[i]) document.roots.push_back(static_cast<int>(i));
}

// ---- materials and textures -----------------------------------------------------------------------

void convert_materials(owned_document &document)
{
    for (const json &source : list(document.tree, "materials")) {
        document.owned_materials.emplace_back();
        owned_material &owned = document.owned_materials.back();
        owned.name = text(source, "name");
        if (owned.name.empty())
            owned.name = "material " + std::to_string(document.materials.size());
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
    const int clamp_to_edge = 33071, mirrored_repeat = 33648;
    if (mode == clamp_to_edge) return RSV_WRAP_CLAMP;
    if (mode == mirrored_repeat) return RSV_WRAP_MIRROR;
    return RSV_WRAP_REPEAT;
}

/// A file beside the document, in its binary chunk or in its JSON.
rsv_gltf_image convert_file(
    owned_document &document, const json &source, const char *kind, size_t index, const bytes &data)
{
    const std::string uri = text(source, "uri");
    const bool is_data = uri.compare(0, 5, "data:") == 0;
    return { uri.empty() || is_data ? keep_label(document, source, kind, index)
                                    : keep(document, shown(uri)),
        data.empty() ? nullptr : data.data(), data.size(), reference(source, "bufferView"),
        keep_uri(document, source) };
}

void convert_textures(owned_document &document)
{
    const int nearest = 9728;
    const json &samplers = list(document.tree, "samplers");
    for (const json &source : list(document.tree, "textures")) {
        // a PNG or JPEG beside it is a fallback for readers without WebP
        const int plain = reference(source, "source");
        rsv_gltf_texture texture{ reference(extension(source, "EXT_texture_webp"), "source", plain),
            reference(extension(source, "KHR_texture_basisu"), "source"), RSV_WRAP_REPEAT,
            RSV_WRAP_REPEAT, false };
        const size_t index = static_cast<size_t>(reference(source, "sampler"));
        if (index < samplers.size()) {
            texture.wrap_u = wrap_mode(reference(samplers[index], "wrapS"));
            texture.wrap_v = wrap_mode(reference(samplers[index], "wrapT"));
            texture.nearest = reference(samplers[index], "magFilter") == nearest;
        }
        document.textures.push_back(texture);
    }
    const json &images = list(document.tree, "images");
    for (size_t k = 0; k < images.size(); k++)
        document.images.push_back(
            convert_file(document, images[k], "image", k, document.image_bytes[k]));
}

// ---- cameras and lights -------------------------------------------------------------------------

void convert_cameras(owned_document &document)
{
    for (const json &source : list(document.tree, "cameras")) {
        rsv_camera camera{};
        camera.name = keep(document, text(source, "name"));
        if (text(source, "type") == "orthographic") {
            const json &lens = member(source, "orthographic");
            const double width = number(lens, "xmag", 0), height = number(lens, "ymag", 0);
            camera.vertical_extent = static_cast<float>(std::fabs(height));
            camera.aspect = static_cast<float>(std::fabs(width / height));
        } else {
            const json &lens = member(source, "perspective");
            camera.vertical_fov = static_cast<float>(number(lens, "yfov", 0));
            camera.aspect = static_cast<float>(number(lens, "aspectRatio", 0));
        }
        document.cameras.push_back(camera);
    }
}

bool light_kind(const std::string &type, rsv_punctual_light_kind &kind)
{
    int k = 0;
    while (k < RSV_PUNCTUAL_LUMINAIRE && // which that extension does not have
           type != rsv_punctual_facts_of(static_cast<rsv_punctual_light_kind>(k)).name)
        k++;
    if (k < RSV_PUNCTUAL_LUMINAIRE) kind = static_cast<rsv_punctual_light_kind>(k);
    return k < RSV_PUNCTUAL_LUMINAIRE;
}

/// Clamps the angles of a cone to their valid range. @return whether that changed them
bool convert_cone(const json &source, rsv_punctual_light &light)
{
    const double quarter_pi = 0.78539816339744831, half_pi = 2 * quarter_pi;
    const json &spot = member(source, "spot");
    const double inner = number(spot, "innerConeAngle", 0);
    const double outer = number(spot, "outerConeAngle", quarter_pi);
    const double widest = std::min(std::max(outer, 0.0), half_pi);
    const double narrow = std::min(std::max(inner, 0.0), widest);
    light.inner_cone_angle = static_cast<float>(narrow);
    light.outer_cone_angle = static_cast<float>(widest);
    const json &extras = member(source, "extras");
    light.exponent = static_cast<float>(number(extras, "cosExponent", 0));
    light.smooth_cone = flag(member(extras, "resolvent"), "smooth_cone");
    return inner > outer || narrow < inner - 1e-6 || widest < outer - 1e-6 || inner < 0 ||
           outer < 0;
}

void convert_light(owned_document &document, const json &source)
{
    double factor[3] = { 1, 1, 1 };
    rsv_gltf_light light{};
    const double intensity = number(source, "intensity", 1);
    const std::string type = text(source, "type");
    const std::string owner = label(source, "light", document.lights.size());
    light.value.name = keep(document, text(source, "name"));
    light.strength = intensity;
    light.known = light_kind(type, light.value.kind);
    if (!light.known)
        note(document, RSV_LOG_WARNING,
            owner + ": its type '" + shown(type) + "' is not in the format; it is left out");
    exact_numbers(source, "color", 3, factor, owner);
    if (light.known && std::min(std::min(factor[0], factor[1]), factor[2]) * intensity < 0) {
        note(document, RSV_LOG_WARNING, owner + ": its intensity is negative; it is left out");
        light.known = false;
    }
    light.value.intensity = { static_cast<float>(factor[0] * intensity),
        static_cast<float>(factor[1] * intensity), static_cast<float>(factor[2] * intensity) };
    if (rsv_punctual_facts_of(light.value.kind).has_cone && convert_cone(source, light.value))
        note(document, RSV_LOG_WARNING,
            owner + ": its cone is outside the format's range (0 <= inner <= outer <= pi/2), and "
                    "is clamped to it");
    document.lights.push_back(light);
}

/// Light falls off by the square of the distance, for ever.
void note_ranges(owned_document &document, const json &lights)
{
    group ranged;
    for (size_t k = 0; k < lights.size(); k++)
        if (member(lights[k], "range").is_number()) ranged.add(label(lights[k], "light", k));
    ranged.tell(document, "lights", "the range is ignored: light reaches any distance");
}

void convert_luminaires(owned_document &document)
{
    const json &lights = list(extension(document.tree, "EXT_lights_ies"), "lights");
    for (size_t k = 0; k < lights.size(); k++)
        document.luminaires.push_back(
            convert_file(document, lights[k], "luminaire", k, document.luminaire_bytes[k]));
}

void convert_lights(owned_document &document)
{
    const json &lights = list(extension(document.tree, "KHR_lights_punctual"), "lights");
    for (const json &source : lights)
        convert_light(document, source);
    note_ranges(document, lights);
}

void convert_variant_names(owned_document &document)
{
    for (const json &source : list(extension(document.tree, "KHR_materials_variants"), "variants"))
        document.variant_names.push_back(keep(document, shown(text(source, "name"))));
}

// ---- animations -----------------------------------------------------------------------------------

/// The number of a name in a list; the list's length if it is not there.
int find_name(const std::string &name, std::initializer_list<const char *> names)
{
    int k = 0;
    for (const char *candidate : names) {
        if (name == candidate) break;
        k++;
    }
    return k;
}

rsv_gltf_channel convert_channel(const json &source)
{
    const json &target = member(source, "target");
    const int path =
        find_name(text(target, "path"), { "translation", "rotation", "scale", "weights" });
    return { reference(source, "sampler"), reference(target, "node"),
        static_cast<rsv_gltf_path>(path) };
}

rsv_gltf_sampler convert_sampler(const json &source)
{
    const std::string name = text(source, "interpolation");
    const int kind = name.empty() ? 0 : find_name(name, { "LINEAR", "STEP", "CUBICSPLINE" });
    return { reference(source, "input"), reference(source, "output"),
        static_cast<rsv_gltf_interpolation>(kind) };
}

void convert_animations(owned_document &document)
{
    for (const json &source : list(document.tree, "animations")) {
        document.channels.emplace_back();
        document.samplers.emplace_back();
        for (const json &channel : list(source, "channels"))
            document.channels.back().push_back(convert_channel(channel));
        for (const json &sampler : list(source, "samplers"))
            document.samplers.back().push_back(convert_sampler(sampler));
        document.animations.push_back(
            { keep_label(document, source, "animation", document.animations.size()),
                document.channels.back().data(), document.samplers.back().data(),
                document.channels.back().size(), document.samplers.back().size() });
    }
}

// ---- the whole document ---------------------------------------------------------------------------

template <class element>
void publish_array(const std::vector<element> &from, const element *&to, size_t &count)
{
    to = from.data();
    count = from.size();
}

void publish(owned_document &document)
{
    for (const owned_note &note : document.owned_notes)
        document.notes.push_back({ note.level, note.text.c_str() });
    publish_array(document.buffers, document.buffer, document.buffer_count);
    publish_array(document.buffer_views, document.buffer_view, document.buffer_view_count);
    publish_array(document.accessors, document.accessor, document.accessor_count);
    publish_array(document.meshes, document.mesh, document.mesh_count);
    publish_array(document.skins, document.skin, document.skin_count);
    publish_array(document.nodes, document.node, document.node_count);
    publish_array(document.animations, document.animation, document.animation_count);
    publish_array(document.materials, document.material, document.material_count);
    publish_array(document.textures, document.texture, document.texture_count);
    publish_array(document.images, document.image, document.image_count);
    publish_array(document.luminaires, document.luminaire, document.luminaire_count);
    publish_array(document.cameras, document.camera, document.camera_count);
    publish_array(document.lights, document.light, document.light_count);
    publish_array(document.roots, document.root, document.root_count);
    publish_array(document.notes, document.note, document.note_count);
    publish_array(document.variant_names, document.variant, document.variant_count);
}

void convert(owned_document &document)
{
    convert_buffers(document);
    unpack_meshopt(document);
    convert_accessors(document);
    convert_meshes(document);
    convert_skins(document);
    unpack_draco(document);
    publish_buffers(document);
    convert_nodes(document);
    convert_roots(document);
    convert_materials(document);
    convert_textures(document);
    convert_cameras(document);
    convert_lights(document);
    convert_luminaires(document);
    convert_variant_names(document);
    convert_animations(document);
    find_unread(document);
    publish(document);
    document.generator = keep(document, text(member(document.tree, "asset"), "generator"));
    document.tree = nullptr;
    document.text = document.json_text.data();
    document.text_bytes = document.json_text.size();
}

} // namespace

namespace rsv_gltf
{

void exact_numbers(
    const json &object, const char *key, size_t count, double *value, const std::string &owner)
{
    const json &array = member(object, key);
    if (!array.is_array()) return;
    if (array.size() != count)
        refuse(RSV_ERROR_FORMAT, "the " + std::string(key) + " of " + owner + " must have " +
                                     std::to_string(count) + " numbers, not " +
                                     std::to_string(array.size()));
    numbers(object, key, count, value);
}

std::string label(const json &object, const char *kind, size_t index)
{
    const std::string name = text(object, "name");
    return std::string(kind) + " " +
           (name.empty() ? std::to_string(index) : "'" + shown(name) + "'");
}

} // namespace rsv_gltf

namespace
{

/// @param read fills the owned document, which is then converted
template <class reader> rsv_status open_document(const rsv_gltf_document **document, reader read)
{
    try {
        std::unique_ptr<owned_document> owned(new owned_document());
        read(*owned);
        convert(*owned);
        *document = owned.release();
        return RSV_OK;
    } catch (const refusal &r) {
        return rsv_fail(r.status, "%s", r.message.c_str());
    } catch (const std::bad_alloc &) {
        return rsv_fail(RSV_ERROR_MEMORY, "out of memory reading glTF");
    } catch (const std::exception &) {
        return rsv_fail(RSV_ERROR_FORMAT, "is not valid glTF");
    }
}

} // namespace

rsv_status rsv_gltf_open(
    const rsv_file_source *files, const char *path, const rsv_gltf_document **document)
{
    return open_document(
        document, [files, path](owned_document &owned) { read_file(files, path, owned); });
}

rsv_status rsv_gltf_open_archive(
    const uint8_t *archive, size_t count, const rsv_gltf_document **document)
{
    return open_document(
        document, [archive, count](owned_document &owned) { read_archive(archive, count, owned); });
}

void rsv_gltf_close(const rsv_gltf_document *document)
{
    delete static_cast<const owned_document *>(document);
}
