#include "image_internal.h"

#include <stdio.h>
#include <string.h>

struct rsv_image {
    rsv_context *context;
    uint32_t width, height, layer_count;
    rsv_rgb *pixels;                     // [layer_count][height][width]
    char (*names)[RSV_LAYER_NAME_BYTES]; // [layer_count], all different
};

static size_t pixel_count(const rsv_image *image) { return (size_t)image->width * image->height; }

static bool size_is_valid(int64_t width, int64_t height)
{
    return width > 0 && height > 0 && width <= RSV_IMAGE_MAX_SIDE && height <= RSV_IMAGE_MAX_SIDE &&
           width * height <= RSV_IMAGE_MAX_PIXELS;
}

rsv_status rsv_image_check_size(const char *path, int64_t width, int64_t height)
{
    if (size_is_valid(width, height)) return RSV_OK;
    return rsv_fail(RSV_ERROR_FORMAT,
        "cannot read '%s': its size %lld x %lld is not within 1..%d a side and %lld pixels", path,
        (long long)width, (long long)height, RSV_IMAGE_MAX_SIDE, (long long)RSV_IMAGE_MAX_PIXELS);
}

rsv_status rsv_image_create(
    rsv_context *context, uint32_t width, uint32_t height, uint32_t layer_count, rsv_image **image)
{
    if (!size_is_valid(width, height))
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "image size %u x %u is not within 1..%d a side and %lld pixels", width, height,
            RSV_IMAGE_MAX_SIDE, (long long)RSV_IMAGE_MAX_PIXELS);
    if (layer_count == 0) return rsv_fail(RSV_ERROR_ARGUMENT, "an image needs at least one layer");

    rsv_image *created = rsv_alloc(context, 1, sizeof *created);
    if (!created) return RSV_ERROR_MEMORY;
    created->context = context;
    created->width = width;
    created->height = height;
    created->layer_count = layer_count;
    created->names = rsv_alloc(context, layer_count, sizeof *created->names);
    created->pixels = rsv_alloc(context, layer_count, pixel_count(created) * sizeof(rsv_rgb));
    if (!created->names || !created->pixels) {
        rsv_image_destroy(created);
        return RSV_ERROR_MEMORY;
    }
    for (uint32_t i = 1; i < layer_count; i++)
        snprintf(created->names[i], sizeof created->names[i], "layer%u", i);
    *image = created;
    return RSV_OK;
}

void rsv_image_destroy(rsv_image *image)
{
    if (!image) return;
    rsv_free(image->context, image->names);
    rsv_free(image->context, image->pixels);
    rsv_free(image->context, image);
}

rsv_context *rsv_image_context(const rsv_image *image) { return image->context; }

uint32_t rsv_image_width(const rsv_image *image) { return image->width; }

uint32_t rsv_image_height(const rsv_image *image) { return image->height; }

uint32_t rsv_image_layer_count(const rsv_image *image) { return image->layer_count; }

rsv_rgb *rsv_image_pixels(rsv_image *image, uint32_t layer)
{
    RSV_ASSERT(layer < image->layer_count);
    return image->pixels + layer * pixel_count(image);
}

const rsv_rgb *rsv_image_const_pixels(const rsv_image *image, uint32_t layer)
{
    RSV_ASSERT(layer < image->layer_count);
    return image->pixels + layer * pixel_count(image);
}

const char *rsv_image_layer_name(const rsv_image *image, uint32_t layer)
{
    RSV_ASSERT(layer < image->layer_count);
    return image->names[layer];
}

uint32_t rsv_image_find_layer(const rsv_image *image, const char *name)
{
    for (uint32_t i = 0; i < image->layer_count; i++)
        if (strcmp(image->names[i], name) == 0) return i;
    return UINT32_MAX;
}

rsv_status rsv_image_set_layer_name(rsv_image *image, uint32_t layer, const char *name)
{
    if (layer >= image->layer_count)
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "image has %u layers, no layer %u", image->layer_count, layer);
    if (strlen(name) >= RSV_LAYER_NAME_BYTES)
        return rsv_fail(RSV_ERROR_ARGUMENT, "layer name '%s' is longer than %d bytes", name,
            RSV_LAYER_NAME_BYTES - 1);
    uint32_t owner = rsv_image_find_layer(image, name);
    if (owner != UINT32_MAX && owner != layer)
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "layer %u cannot be named '%s': layer %u is", layer, name, owner);
    strcpy(image->names[layer], name);
    return RSV_OK;
}
