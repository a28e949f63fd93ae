#include "scene_parts.h"

#include "../core/core.h"
#include "../scene/scene.h"
#include "file_beside.h"
#include "texture_image.h"

#include <string.h>

typedef enum part_kind { LOG, TEXTURE, MATERIAL, MESH, INSTANCE, LIGHT, CAMERA } part_kind;

/// The head of a record. Its name follows, then the data of its kind, each padded to ALIGNMENT.
typedef struct part_head {
    uint32_t kind; ///< part_kind
    uint32_t
        number; ///< level of a log, material of a mesh, mesh of an instance, flags of a material
    uint32_t name_bytes; ///< with the zero at its end; 0 = NULL
    uint32_t flags;      ///< of a mesh: which arrays it has; of a material: how many textures
    uint64_t vertex_count, triangle_count;
} part_head;

enum { ALIGNMENT = 4, DOUBLE_SIDED = 1, UNLIT = 2 };
enum { MOST_TEXTURES = 8 };           ///< of a material
enum { HAS_NORMALS = 1, HAS_UV = 2 }; ///< HAS_UV << 1 is that of the second set

// ---- sending ------------------------------------------------------------------------------------

static void send(FILE *to, const void *data, size_t count, size_t size)
{
    static const char padding[ALIGNMENT] = { 0 };
    if (count == 0) return; // and no data
    fwrite(data, size, count, to);
    fwrite(padding, 1, -(count * size) % ALIGNMENT, to);
}

static void send_head(FILE *to, part_head head, const char *name)
{
    head.name_bytes = name ? (uint32_t)strlen(name) + 1 : 0;
    send(to, &head, 1, sizeof head);
    if (name) send(to, name, head.name_bytes, 1);
}

void rsv_send_log(FILE *to, rsv_log_level level, const char *message)
{
    send_head(to, (part_head){ .kind = LOG, .number = level }, message);
}

void rsv_send_texture(FILE *to, const rsv_part_texture *texture)
{
    send_head(to,
        (part_head){ .kind = TEXTURE, .vertex_count = texture->bytes ? texture->size : 0 },
        texture->name);
    send(to, texture, 1, sizeof *texture);
    if (texture->bytes) send(to, texture->bytes, texture->size, 1);
}

void rsv_send_material(FILE *to, const rsv_material *material)
{
    uint32_t flags = (material->double_sided ? DOUBLE_SIDED : 0) | (material->unlit ? UNLIT : 0);
    const part_head head = {
        .kind = MATERIAL, .number = flags, .flags = (uint32_t)material->texture_count
    };
    send_head(to, head, material->name);
    send(to, material, 1, sizeof *material);
    send(to, material->textures, material->texture_count, sizeof *material->textures);
}

void rsv_send_mesh(FILE *to, const rsv_mesh_desc *mesh)
{
    part_head head = { .kind = MESH,
        .number = mesh->material,
        .flags = (mesh->normals ? HAS_NORMALS : 0u) | (mesh->uvs[0] ? HAS_UV : 0u) |
                 (mesh->uvs[1] ? HAS_UV << 1 : 0u),
        .vertex_count = mesh->vertex_count,
        .triangle_count = mesh->triangle_count };
    send_head(to, head, mesh->name);
    send(to, mesh->positions, mesh->vertex_count, sizeof *mesh->positions);
    if (mesh->normals) send(to, mesh->normals, mesh->vertex_count, sizeof *mesh->normals);
    for (int k = 0; k < 2; k++)
        if (mesh->uvs[k]) send(to, mesh->uvs[k], mesh->vertex_count, sizeof *mesh->uvs[k]);
    send(to, mesh->indices, mesh->triangle_count, 3 * sizeof *mesh->indices);
}

void rsv_send_instance(FILE *to, uint32_t mesh, const double transform[16], const char *name)
{
    send_head(to, (part_head){ .kind = INSTANCE, .number = mesh }, name);
    send(to, transform, 16, sizeof *transform);
}

void rsv_send_light(FILE *to, const rsv_punctual_light *light)
{
    send_head(to, (part_head){ .kind = LIGHT }, light->name);
    send(to, light, 1, sizeof *light);
}

void rsv_send_camera(FILE *to, const rsv_camera *camera)
{
    send_head(to, (part_head){ .kind = CAMERA }, camera->name);
    send(to, camera, 1, sizeof *camera);
}

// ---- receiving ----------------------------------------------------------------------------------

/// A texture that arrived.
typedef struct arrived_texture {
    uint32_t id;       ///< in the scene; RSV_NONE = it cannot be read
    const char *name;  ///< borrowed from the bytes
    char problem[256]; ///< why not
} arrived_texture;

typedef struct parcel {
    const uint8_t *bytes;
    size_t left;
    const rsv_file_source *files;
    const char *path;
    rsv_scene *scene;
    arrived_texture *texture; ///< [texture_count]
    size_t texture_count, texture_capacity;
} parcel;

static rsv_status fail_astray(void)
{
    return rsv_fail(RSV_ERROR_FORMAT,
        "cannot be read: it makes the importer fail; repair it, or convert it to glTF");
}

/// The next bytes. @return NULL if there are fewer
static const void *take(parcel *p, uint64_t count, size_t size)
{
    if (count > p->left / size) return NULL;
    const void *taken = p->bytes;
    size_t bytes = (size_t)count * size, padded = bytes + -bytes % ALIGNMENT;
    if (padded > p->left) return NULL;
    p->bytes += padded;
    p->left -= padded;
    return taken;
}

/// Pointers in the copy mean nothing here. @param value out: [bytes]
static rsv_status take_value(parcel *p, void *value, size_t bytes)
{
    const void *taken = take(p, 1, bytes);
    if (!taken) return fail_astray();
    memcpy(value, taken, bytes);
    return RSV_OK;
}

static rsv_status take_name(parcel *p, const part_head *head, const char **name)
{
    *name = NULL;
    if (head->name_bytes == 0) return RSV_OK;
    *name = take(p, head->name_bytes, 1);
    return *name && (*name)[head->name_bytes - 1] == 0 ? RSV_OK : fail_astray();
}

/// Fails where memory runs out only.
static rsv_status load_texture(parcel *p, const rsv_part_texture *part, arrived_texture *arrived)
{
    char path[RSV_PART_PATH_BYTES + 256];
    rsv_context *context = rsv_scene_get_context(p->scene);
    rsv_status status = RSV_OK;
    rsv_texture_source source = { .file = { part->name, part->bytes, part->size },
        .srgb = part->srgb,
        .shines = part->shines,
        .use = part->use,
        .shininess = part->shininess,
        .wrap_u = part->wrap_u,
        .wrap_v = part->wrap_v };
    bool is_beside = !part->bytes;
    *arrived = (arrived_texture){ .id = RSV_NONE, .name = part->name };
    if (is_beside && !rsv_find_beside(p->files, p->path, part->name, path, sizeof path))
        status =
            rsv_fail(RSV_ERROR_IO, "there is no such file, and none of its name in the scene's "
                                   "folder");
    else if (is_beside)
        status = rsv_image_file_read(context, p->files, path, &source.file);
    source.file.path = part->name;
    if (status == RSV_OK) status = rsv_texture_load(p->scene, &source, &arrived->id);
    if (is_beside) rsv_free(context, (void *)(uintptr_t)source.file.bytes);
    if (status == RSV_OK || status == RSV_ERROR_MEMORY) return status;
    arrived->id = RSV_NONE;
    snprintf(arrived->problem, sizeof arrived->problem, "%s", rsv_last_error());
    return RSV_OK;
}

static bool is_wrap(rsv_wrap wrap) { return (unsigned)wrap <= RSV_WRAP_CLAMP; }

static rsv_status receive_texture(parcel *p, const part_head *head, const char *name)
{
    rsv_part_texture part;
    rsv_status status;
    RSV_TRY(take_value(p, &part, sizeof part));
    part.size = (size_t)head->vertex_count;
    part.bytes = part.size ? take(p, head->vertex_count, 1) : NULL;
    if (!name || (part.size && !part.bytes) || !is_wrap(part.wrap_u) || !is_wrap(part.wrap_v) ||
        (unsigned)part.use >= RSV_TEXTURE_USES)
        return fail_astray();
    RSV_TRY(rsv_grow(rsv_scene_get_context(p->scene), (void **)&p->texture, &p->texture_capacity,
        p->texture_count + 1, sizeof *p->texture));
    part.name = name;
    RSV_TRY(load_texture(p, &part, &p->texture[p->texture_count]));
    p->texture_count++;
cleanup:
    return status;
}

/// Leaves out those that cannot be read, with a warning. @param material its textures are numbers of those sent; ids in
/// the scene afterwards @param ref they again
static rsv_status find_textures(const parcel *p, rsv_material *material, rsv_texture_ref *ref)
{
    size_t kept = 0;
    for (size_t k = 0; k < material->texture_count; k++) {
        if (ref[k].texture >= p->texture_count || ref[k].uv_set > 1 ||
            (unsigned)ref[k].role >= RSV_TEXTURE_ROLE_COUNT)
            return fail_astray();
        const arrived_texture *texture = &p->texture[ref[k].texture];
        if (texture->id == RSV_NONE)
            rsv_log(rsv_scene_get_context(p->scene), RSV_LOG_WARNING,
                "material '%s': its texture '%.300s' is left out: %s",
                material->name ? material->name : "unnamed", texture->name, texture->problem);
        else
            ref[kept] = ref[k], ref[kept++].texture = texture->id;
    }
    material->texture_count = kept;
    return RSV_OK;
}

static rsv_status receive_material(parcel *p, const part_head *head, const char *name)
{
    rsv_material material;
    rsv_texture_ref ref[MOST_TEXTURES];
    rsv_status status = take_value(p, &material, sizeof material);
    if (status != RSV_OK) return status;
    material.name = name;
    material.double_sided = head->number & DOUBLE_SIDED;
    material.unlit = head->number & UNLIT;
    material.textures = ref;
    material.texture_count = head->flags;
    if (head->flags > MOST_TEXTURES) return fail_astray();
    if (head->flags) {
        const void *taken = take(p, head->flags, sizeof *ref);
        if (!taken) return fail_astray();
        memcpy(ref, taken, head->flags * sizeof *ref);
    }
    status = find_textures(p, &material, ref);
    return status == RSV_OK ? rsv_scene_add_material(p->scene, &material, NULL) : status;
}

static rsv_status receive_mesh(parcel *p, const part_head *head, const char *name)
{
    rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = name,
        .vertex_count = (size_t)head->vertex_count,
        .triangle_count = (size_t)head->triangle_count,
        .material = head->number };
    mesh.positions = take(p, head->vertex_count, sizeof *mesh.positions);
    bool lacks = !mesh.positions;
    if (head->flags & HAS_NORMALS) {
        mesh.normals = take(p, head->vertex_count, sizeof *mesh.normals);
        lacks |= !mesh.normals;
    }
    for (int k = 0; k < 2; k++) {
        if (!(head->flags & HAS_UV << k)) continue;
        mesh.uvs[k] = take(p, head->vertex_count, sizeof *mesh.uvs[k]);
        lacks |= !mesh.uvs[k];
    }
    mesh.indices = take(p, head->triangle_count, 3 * sizeof *mesh.indices);
    if (lacks || !mesh.indices) return fail_astray();
    return rsv_scene_add_mesh(p->scene, &mesh, NULL);
}

static rsv_status receive_instance(parcel *p, const part_head *head, const char *name)
{
    double transform[16]; // records are aligned to less than doubles are
    rsv_status status = take_value(p, transform, sizeof transform);
    if (status != RSV_OK) return status;
    return rsv_scene_place_instance(p->scene, head->number, transform, name);
}

static rsv_status receive_light(parcel *p, const char *name)
{
    rsv_punctual_light light;
    rsv_status status = take_value(p, &light, sizeof light);
    if (status != RSV_OK) return status;
    light.name = name;
    return rsv_scene_add_light(p->scene, &light);
}

static rsv_status receive_camera(parcel *p, const char *name)
{
    rsv_camera camera;
    rsv_status status = take_value(p, &camera, sizeof camera);
    if (status != RSV_OK) return status;
    camera.name = name;
    return rsv_scene_add_camera(p->scene, &camera);
}

static rsv_status receive_part(parcel *p)
{
    part_head head;
    const char *name = NULL;
    rsv_status status = take_value(p, &head, sizeof head);
    if (status == RSV_OK) status = take_name(p, &head, &name);
    if (status != RSV_OK) return status;
    switch (head.kind) {
    case LOG:
        rsv_log(rsv_scene_get_context(p->scene),
            head.number == RSV_LOG_WARNING ? RSV_LOG_WARNING : RSV_LOG_INFO, "%s",
            name ? name : "");
        return RSV_OK;
    case TEXTURE:
        return receive_texture(p, &head, name);
    case MATERIAL:
        return receive_material(p, &head, name);
    case MESH:
        return receive_mesh(p, &head, name);
    case INSTANCE:
        return receive_instance(p, &head, name);
    case LIGHT:
        return receive_light(p, name);
    case CAMERA:
        return receive_camera(p, name);
    default:
        return fail_astray();
    }
}

rsv_status rsv_receive_parts(const uint8_t *bytes, size_t count, const rsv_file_source *files,
    const char *path, rsv_scene *scene)
{
    parcel p = { .bytes = bytes, .left = count, .files = files, .path = path, .scene = scene };
    rsv_status status = RSV_OK;
    while (status == RSV_OK && p.left > 0)
        status = receive_part(&p);
    rsv_free(rsv_scene_get_context(scene), p.texture);
    return status;
}
