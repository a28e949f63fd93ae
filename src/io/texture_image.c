#include "texture_image.h"

#include "../core/srgb.h"
#include "image_ktx.h"

#include <math.h>
#include <string.h>

static rsv_texture_desc describe(
    const rsv_texture_source *source, uint32_t width, uint32_t height, uint32_t channels)
{
    return (rsv_texture_desc){ .name = source->file.path,
        .width = width,
        .height = height,
        .channel_count = channels,
        .srgb = source->srgb,
        .wrap_u = source->wrap_u,
        .wrap_v = source->wrap_v,
        .nearest = source->nearest };
}

// ---- opacity from grey ------------------------------------------------------------------------------

/// Whether a picture of so many channels is to get an alpha channel of its colours.
static bool needs_alpha(const rsv_texture_source *source, uint32_t channels)
{
    return source->grey_is_alpha && channels != 2 && channels != 4;
}

/// Grey and alpha of pictures without alpha. @param codes are replaced
static rsv_status add_alpha(rsv_context *context, rsv_image_codes *codes, uint8_t **pairs)
{
    size_t count = (size_t)codes->width * codes->height, width = codes->channel_count;
    uint8_t *pair = rsv_alloc(context, count, 2);
    if (!pair) return RSV_ERROR_MEMORY;
    for (size_t i = 0; i < count; i++) {
        unsigned sum = 0;
        for (size_t c = 0; c < width; c++)
            sum += codes->code[width * i + c];
        pair[2 * i] = 255;
        pair[2 * i + 1] = (uint8_t)(sum / width);
    }
    *pairs = pair;
    return RSV_OK;
}

// ---- codes of 8 bits --------------------------------------------------------------------------------

static rsv_status load_codes(rsv_scene *scene, const rsv_texture_source *source, uint32_t *id)
{
    rsv_status status;
    rsv_image_codes codes = { 0 };
    uint8_t *pairs = NULL;
    bool is_webp = rsv_image_is_webp(&source->file);
    RSV_TRY((is_webp ? rsv_image_decode_webp : rsv_image_decode_codes)(&source->file, &codes));
    rsv_texture_desc desc = describe(source, codes.width, codes.height, codes.channel_count);
    desc.codes = codes.code;
    if (needs_alpha(source, codes.channel_count)) {
        RSV_TRY(add_alpha(rsv_scene_get_context(scene), &codes, &pairs));
        desc.codes = pairs;
        desc.channel_count = 2;
    }
    RSV_TRY(rsv_scene_add_texture(scene, &desc, id));
cleanup:
    rsv_free(rsv_scene_get_context(scene), pairs);
    rsv_image_free_codes(&codes);
    return status;
}

// ---- codes of 16 bits -------------------------------------------------------------------------------

/// Alpha does not follow the curve of colours.
static float linear_of(uint16_t code, bool is_color)
{
    double value = code / 65535.0;
    return (float)(is_color ? rsv_srgb_decode(value) : value);
}

static rsv_status load_codes16(rsv_scene *scene, const rsv_texture_source *source, uint32_t *id)
{
    rsv_status status;
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_image_codes size = { 0 };
    uint16_t *code = NULL;
    float *value = NULL;
    RSV_TRY(rsv_image_decode_codes16(&source->file, &code, &size));
    uint32_t width = size.channel_count, wanted = needs_alpha(source, width) ? 2 : width;
    size_t count = (size_t)size.width * size.height;
    if (!(value = rsv_alloc(context, count * wanted, sizeof *value))) RSV_TRY(RSV_ERROR_MEMORY);
    for (size_t i = 0; i < count; i++) {
        float sum = 0;
        for (uint32_t c = 0; c < width; c++) {
            bool is_alpha = c + 1 == width && width % 2 == 0;
            float v = linear_of(code[width * i + c], source->srgb && !is_alpha);
            if (wanted == width) value[width * i + c] = v;
            sum += (float)code[width * i + c] / 65535.0f;
        }
        if (wanted == width) continue;
        value[2 * i] = 1;
        value[2 * i + 1] = sum / (float)width;
    }
    rsv_texture_desc desc = describe(source, size.width, size.height, wanted);
    desc.values = value;
    desc.srgb = false;
    RSV_TRY(rsv_scene_add_texture(scene, &desc, id));
cleanup:
    rsv_free(context, value);
    rsv_image_free_codes16(code);
    return status;
}

// ---- radiance ---------------------------------------------------------------------------------------

static bool is_exr(const rsv_image_file *file)
{
    return file->size >= 4 && memcmp(file->bytes, "\x76\x2f\x31\x01", 4) == 0;
}

static bool is_hdr(const rsv_image_file *file)
{
    return file->size >= 2 && memcmp(file->bytes, "#?", 2) == 0;
}

static float cut_off(float value, bool shines)
{
    return isfinite(value) ? fmaxf(shines ? value : fminf(value, 1), 0) : 0;
}

static rsv_status load_radiance(rsv_scene *scene, const rsv_texture_source *source, uint32_t *id)
{
    rsv_status status;
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_image *image = NULL;
    RSV_TRY((is_exr(&source->file) ? rsv_image_decode_exr : rsv_image_decode_hdr)(
        context, &source->file, &image));
    uint32_t width = rsv_image_width(image), height = rsv_image_height(image);
    rsv_rgb *pixel = rsv_image_pixels(image, 0);
    bool makes_alpha = source->grey_is_alpha;
    if (width > RSV_TEXTURE_MAX_SIDE || height > RSV_TEXTURE_MAX_SIDE)
        RSV_TRY(
            rsv_fail(RSV_ERROR_FORMAT, "cannot read '%s': %u x %u pixels are not in 1 .. %u a side",
                source->file.path, width, height, RSV_TEXTURE_MAX_SIDE));
    float *value = (float *)pixel; // in place: pairs take less room than triples
    for (size_t i = 0; i < (size_t)width * height; i++) {
        rsv_rgb c = { cut_off(pixel[i].r, source->shines), cut_off(pixel[i].g, source->shines),
            cut_off(pixel[i].b, source->shines) };
        float alpha = (c.r + c.g + c.b) / 3;
        if (makes_alpha)
            value[2 * i] = 1, value[2 * i + 1] = alpha;
        else
            pixel[i] = c;
    }
    rsv_texture_desc desc = describe(source, width, height, makes_alpha ? 2 : 3);
    desc.values = value;
    desc.srgb = false;
    RSV_TRY(rsv_scene_add_texture(scene, &desc, id));
cleanup:
    rsv_image_destroy(image);
    return status;
}

// ---- KTX2 -------------------------------------------------------------------------------------------

/// What a texture's values are in linear light, in place.
static void make_linear(const rsv_texture_source *source, rsv_ktx_picture *p)
{
    size_t count = (size_t)p->width * p->height * p->channel_count;
    for (size_t i = 0; i < count; i++) {
        bool is_alpha = p->channel_count == 4 && i % 4 == 3;
        float value = cut_off(p->values[i], source->shines && !is_alpha);
        bool curved = p->are_codes && source->srgb && !is_alpha;
        p->values[i] = curved ? (float)rsv_srgb_decode((double)value) : value;
    }
}

static rsv_status load_ktx(rsv_scene *scene, const rsv_texture_source *source, uint32_t *id)
{
    rsv_status status;
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_ktx_picture p;
    RSV_TRY(rsv_ktx_decode(context, &source->file, &p));
    if (needs_alpha(source, p.channel_count))
        RSV_TRY(rsv_fail(RSV_ERROR_UNSUPPORTED,
            "cannot read '%s': opacity needs a KTX2 picture with alpha", source->file.path));
    rsv_texture_desc desc = describe(source, p.width, p.height, p.channel_count);
    if (p.values) make_linear(source, &p);
    desc.codes = p.codes;
    desc.values = p.values;
    desc.srgb = source->srgb && p.codes;
    RSV_TRY(rsv_scene_add_texture(scene, &desc, id));
cleanup:
    rsv_ktx_free(context, &p);
    return status;
}

rsv_status rsv_texture_load(rsv_scene *scene, const rsv_texture_source *source, uint32_t *id)
{
    const rsv_image_file *file = &source->file;
    if (file->size == 0)
        return rsv_fail(RSV_ERROR_FORMAT, "cannot read '%s': the file is empty", file->path);
    if (rsv_image_is_ktx(file)) return load_ktx(scene, source, id);
    if (is_exr(file) || is_hdr(file)) return load_radiance(scene, source, id);
    if (rsv_image_is_16_bit(file)) return load_codes16(scene, source, id);
    return load_codes(scene, source, id);
}
