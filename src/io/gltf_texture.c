#include "gltf_texture.h"

#include "texture_image.h"

/// Stands for a texture that was tried and cannot be used.
#define UNUSABLE (RSV_NONE - 1)

/// Meaning of a texture's values.
enum { LINEAR, COLOR, EMISSION, USES };

typedef struct texture_loader {
    rsv_context *context;
    const rsv_gltf_document *document;
    rsv_scene *scene;
    uint32_t (*id)[USES]; ///< [texture_count] in the scene, by use; RSV_NONE = not tried yet
} texture_loader;

const char *rsv_gltf_find_bytes(
    const rsv_gltf_document *document, const rsv_gltf_image *image, rsv_image_file *file)
{
    *file = (rsv_image_file){ image->name, image->bytes, image->size };
    if (image->bytes) return NULL;
    if (image->buffer_view < 0)
        return "it is missing (files must lie in the asset's folder or below)";
    if ((size_t)image->buffer_view >= document->buffer_view_count)
        return "its buffer view does not exist";
    const rsv_gltf_buffer_view *view = &document->buffer_view[image->buffer_view];
    if ((size_t)view->buffer >= document->buffer_count) return "its buffer does not exist";
    const rsv_gltf_buffer *buffer = &document->buffer[view->buffer];
    if (!buffer->data || view->offset > buffer->size || view->length > buffer->size - view->offset)
        return "its buffer view reaches past the end of its buffer";
    file->bytes = buffer->data + view->offset;
    file->size = view->length;
    return NULL;
}

static rsv_status add_image(
    texture_loader *loader, const rsv_gltf_texture *texture, int index, int use, uint32_t *id)
{
    const rsv_gltf_document *document = loader->document;
    if ((size_t)index >= document->image_count)
        return rsv_fail(RSV_ERROR_FORMAT, "it has no PNG or JPEG image, and no WebP or KTX2 (other "
                                          "formats need extensions that are "
                                          "not supported)");
    const rsv_gltf_image *image = &document->image[index];
    rsv_texture_source source = { .srgb = use != LINEAR,
        .shines = use == EMISSION,
        .wrap_u = texture->wrap_u,
        .wrap_v = texture->wrap_v,
        .nearest = texture->nearest };
    const char *problem = rsv_gltf_find_bytes(document, image, &source.file);
    if (problem)
        return rsv_fail(RSV_ERROR_FORMAT, "cannot read image '%s': %s", image->name, problem);
    return rsv_texture_load(loader->scene, &source, id);
}

/// Adds the KTX2 picture if it can be read, else the fallback picture.
static rsv_status add_texture(
    texture_loader *loader, const rsv_gltf_texture *texture, int use, uint32_t *id)
{
    if (texture->ktx < 0) return add_image(loader, texture, texture->image, use, id);
    rsv_status status = add_image(loader, texture, texture->ktx, use, id);
    if (status == RSV_OK || status == RSV_ERROR_MEMORY || texture->image < 0) return status;
    rsv_log(loader->context, RSV_LOG_INFO, "%s; the fallback picture is used instead",
        rsv_last_error());
    return add_image(loader, texture, texture->image, use, id);
}

/// The scene's id of a texture; UNUSABLE after a warning. Fails where memory runs out only.
static rsv_status find_texture(
    texture_loader *loader, int texture, int use, const char *material, uint32_t *id)
{
    if ((size_t)texture >= loader->document->texture_count) {
        *id = UNUSABLE;
        rsv_log(loader->context, RSV_LOG_WARNING,
            "material '%s': texture %d does not exist; the factor alone is used", material,
            texture);
        return RSV_OK;
    }
    uint32_t *known = &loader->id[texture][use];
    if (*known == RSV_NONE) {
        rsv_status status = add_texture(loader, &loader->document->texture[texture], use, known);
        if (status == RSV_ERROR_MEMORY) return status;
        if (status != RSV_OK) {
            *known = UNUSABLE;
            rsv_log(loader->context, RSV_LOG_WARNING,
                "material '%s': texture %d: %s; the factor alone is used", material, texture,
                rsv_last_error());
        }
    }
    *id = *known;
    return RSV_OK;
}

static rsv_status add_material(texture_loader *loader, const rsv_gltf_material *source)
{
    rsv_status status = RSV_OK;
    rsv_material material = source->value;
    rsv_texture_ref *ref = rsv_alloc(loader->context, source->texture_count, sizeof *ref);
    if (!ref) return RSV_ERROR_MEMORY;
    for (size_t i = 0; i < source->texture_count; i++) {
        const rsv_gltf_texture_ref *use = &source->texture[i];
        uint32_t id;
        int as = use->ref.role == RSV_TEXTURE_EMISSION ? EMISSION : use->srgb ? COLOR : LINEAR;
        RSV_TRY(find_texture(loader, use->texture, as, material.name, &id));
        if (id == UNUSABLE) continue;
        ref[material.texture_count] = use->ref;
        ref[material.texture_count++].texture = id;
    }
    material.textures = ref;
    RSV_TRY(rsv_scene_add_material(loader->scene, &material, NULL));
    if (*source->note)
        rsv_log(loader->context, RSV_LOG_WARNING, "material '%s': %s", material.name, source->note);
    if (*source->remark)
        rsv_log(loader->context, RSV_LOG_INFO, "material '%s': %s", material.name, source->remark);
cleanup:
    rsv_free(loader->context, ref);
    return status;
}

rsv_status rsv_gltf_add_materials(
    rsv_context *context, const rsv_gltf_document *document, rsv_scene *scene)
{
    rsv_status status = RSV_OK;
    texture_loader loader = { context, document, scene, NULL };
    loader.id = rsv_alloc(context, document->texture_count, sizeof *loader.id);
    if (!loader.id) return RSV_ERROR_MEMORY;
    for (size_t i = 0; i < document->texture_count; i++)
        for (int use = 0; use < USES; use++)
            loader.id[i][use] = RSV_NONE;
    for (size_t i = 0; i < document->material_count; i++)
        RSV_TRY(add_material(&loader, &document->material[i]));
cleanup:
    rsv_free(context, loader.id);
    return status;
}
