#include "scene_parts.h"

#include "../core/core.h"
#include "../scene/scene.h"

#include <string.h>

typedef enum part_kind { LOG, MATERIAL, MESH, INSTANCE, LIGHT, CAMERA } part_kind;

/// What a record begins with. Its name follows, then what its kind needs, each padded to ALIGNMENT.
typedef struct part_head {
    uint32_t kind; ///< part_kind
    uint32_t
        number; ///< level of a log, material of a mesh, mesh of an instance, flags of a material
    uint32_t name_bytes; ///< with the zero at its end; 0 = NULL
    uint32_t has_normals;
    uint64_t vertex_count, triangle_count;
} part_head;

enum { ALIGNMENT = 4, DOUBLE_SIDED = 1, UNLIT = 2 };

// ---- sending ------------------------------------------------------------------------------------

static void send(FILE *to, const void *data, size_t count, size_t size)
{
    static const char padding[ALIGNMENT] = { 0 };
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

void rsv_send_material(FILE *to, const rsv_material *material)
{
    uint32_t flags = (material->double_sided ? DOUBLE_SIDED : 0) | (material->unlit ? UNLIT : 0);
    send_head(to, (part_head){ .kind = MATERIAL, .number = flags }, material->name);
    send(to, material, 1, sizeof *material);
}

void rsv_send_mesh(FILE *to, const rsv_mesh_desc *mesh)
{
    part_head head = { .kind = MESH,
        .number = mesh->material,
        .has_normals = mesh->normals != NULL,
        .vertex_count = mesh->vertex_count,
        .triangle_count = mesh->triangle_count };
    send_head(to, head, mesh->name);
    send(to, mesh->positions, mesh->vertex_count, sizeof *mesh->positions);
    if (mesh->normals) send(to, mesh->normals, mesh->vertex_count, sizeof *mesh->normals);
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

typedef struct parcel {
    const uint8_t *bytes;
    size_t left;
    rsv_scene *scene;
} parcel;

static rsv_status fail_astray(void)
{
    return rsv_fail(RSV_ERROR_FORMAT,
        "cannot be read: the importer goes astray on it; repair it, or convert it to glTF");
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

static rsv_status receive_material(parcel *p, const part_head *head, const char *name)
{
    rsv_material material;
    rsv_status status = take_value(p, &material, sizeof material);
    if (status != RSV_OK) return status;
    material.name = name;
    material.double_sided = head->number & DOUBLE_SIDED;
    material.unlit = head->number & UNLIT;
    material.textures = NULL;
    material.texture_count = 0;
    return rsv_scene_add_material(p->scene, &material, NULL);
}

static rsv_status receive_mesh(parcel *p, const part_head *head, const char *name)
{
    rsv_mesh_desc mesh = { .name = name,
        .vertex_count = (size_t)head->vertex_count,
        .triangle_count = (size_t)head->triangle_count,
        .material = head->number };
    mesh.positions = take(p, head->vertex_count, sizeof *mesh.positions);
    if (head->has_normals) mesh.normals = take(p, head->vertex_count, sizeof *mesh.normals);
    mesh.indices = take(p, head->triangle_count, 3 * sizeof *mesh.indices);
    if (!mesh.positions || !mesh.indices || (head->has_normals && !mesh.normals))
        return fail_astray();
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

rsv_status rsv_receive_parts(const uint8_t *bytes, size_t count, rsv_scene *scene)
{
    parcel p = { bytes, count, scene };
    rsv_status status = RSV_OK;
    while (status == RSV_OK && p.left > 0)
        status = receive_part(&p);
    return status;
}
