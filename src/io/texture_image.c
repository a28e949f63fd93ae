#include "texture_image.h"

#include "../core/srgb.h"
#include "image_ktx.h"
#include "phong.h"

#include <math.h>
#include <string.h>

static rsv_texture_desc describe(
    const rsv_texture_source *source, uint32_t width, uint32_t height, uint32_t channels)
{
    return (rsv_texture_desc){ .size = sizeof(rsv_texture_desc),
        .name = source->file.path,
        .width = width,
        .height = height,
        .channel_count = channels,
        .srgb = source->srgb,
        .wrap_u = source->wrap_u,
        .wrap_v = source->wrap_v,
        .nearest = source->nearest };
}

// ---- grey pictures ----------------------------------------------------------------------------------

static bool has_alpha(uint32_t channels) { return channels % 2 == 0; }

/// Number of channels of the texture made of a picture with `channels`.
static uint32_t wanted_channels(const rsv_texture_source *source, uint32_t channels)
{
    if (source->use == RSV_TEXTURE_GREY_IS_ALPHA) return has_alpha(channels) ? channels : 2;
    bool alone =
        source->use == RSV_TEXTURE_GREY_IS_GREEN || source->use == RSV_TEXTURE_GREY_IS_BLUE;
    return alone ? 3 : channels;
}

/// Whether the texels are others than the picture's.
static bool is_rearranged(const rsv_texture_source *source, uint32_t channels)
{
    return wanted_channels(source, channels) == 2 ? !has_alpha(channels)
                                                  : source->use == RSV_TEXTURE_GREY_IS_GREEN ||
                                                        source->use == RSV_TEXTURE_GREY_IS_BLUE;
}

/// Which channel the grey goes to; all others are 1.
static uint32_t channel_of_grey(const rsv_texture_source *source)
{
    return source->use == RSV_TEXTURE_GREY_IS_BLUE ? 2 : 1;
}

/// The value in the texture for that grey of the picture, 0..1.
static float value_of_grey(const rsv_texture_source *source, float grey)
{
    return source->shininess > 0 ? rsv_roughness_of_shininess(grey * source->shininess) : grey;
}

/// Normal maps are mostly blue, as normals point outwards and lean to all sides equally. @param sum of red, green and
/// blue
static rsv_status check_normals(
    const rsv_texture_source *source, const double sum[3], uint32_t channels)
{
    if (source->use != RSV_TEXTURE_ARE_NORMALS) return RSV_OK;
    if (channels >= 3 && sum[2] > 1.1 * sum[0] && sum[2] > 1.1 * sum[1]) return RSV_OK;
    return rsv_fail(RSV_ERROR_UNSUPPORTED, "it holds heights, not normals, and bump maps are not "
                                           "supported; convert it to a normal map");
}

/// Copies the texels of a picture, rearranged for the texture. @param codes [height * width * channels] @param made
/// out: to be freed
static rsv_status rearrange(rsv_context *context, const rsv_texture_source *source,
    const rsv_image_codes *codes, uint8_t **made)
{
    size_t count = (size_t)codes->width * codes->height, width = codes->channel_count;
    size_t colors = width - has_alpha(codes->channel_count);
    uint32_t wanted = wanted_channels(source, codes->channel_count);
    uint8_t *texel = rsv_alloc(context, count, wanted);
    if (!texel) return RSV_ERROR_MEMORY;
    memset(texel, 255, count * wanted);
    for (size_t i = 0; i < count; i++) {
        unsigned sum = 0;
        for (size_t c = 0; c < colors; c++)
            sum += codes->code[width * i + c];
        float grey = (float)sum / (255.0f * (float)colors);
        texel[wanted * i + channel_of_grey(source)] =
            (uint8_t)(255 * value_of_grey(source, grey) + 0.5f);
    }
    *made = texel;
    return RSV_OK;
}

static rsv_status check_codes(const rsv_texture_source *source, const rsv_image_codes *codes)
{
    double sum[3] = { 0 };
    size_t count = (size_t)codes->width * codes->height, width = codes->channel_count;
    if (source->use != RSV_TEXTURE_ARE_NORMALS) return RSV_OK;
    for (size_t i = 0; i < count && width >= 3; i++)
        for (size_t c = 0; c < 3; c++)
            sum[c] += codes->code[width * i + c];
    return check_normals(source, sum, codes->channel_count);
}

// ---- codes of 8 bits --------------------------------------------------------------------------------

static rsv_status load_codes(rsv_scene *scene, const rsv_texture_source *source, uint32_t *id)
{
    rsv_status status;
    rsv_image_codes codes = { 0 };
    uint8_t *made = NULL;
    bool is_webp = rsv_image_is_webp(&source->file);
    RSV_TRY((is_webp ? rsv_image_decode_webp : rsv_image_decode_codes)(&source->file, &codes));
    rsv_texture_desc desc = describe(source, codes.width, codes.height, codes.channel_count);
    desc.codes = codes.code;
    RSV_TRY(check_codes(source, &codes));
    if (is_rearranged(source, codes.channel_count)) {
        RSV_TRY(rearrange(rsv_scene_get_context(scene), source, &codes, &made));
        desc.codes = made;
        desc.channel_count = wanted_channels(source, codes.channel_count);
    }
    RSV_TRY(rsv_scene_add_texture(scene, &desc, id));
cleanup:
    rsv_free(rsv_scene_get_context(scene), made);
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

/// Converts 16-bit texels to linear light. @param value out: [height * width * wanted channels]
static void take_codes16(const rsv_texture_source *source, const rsv_image_codes *size,
    const uint16_t *code, float *value)
{
    uint32_t width = size->channel_count, wanted = wanted_channels(source, width);
    uint32_t colors = width - has_alpha(width);
    for (size_t i = 0; i < (size_t)size->width * size->height; i++) {
        float sum = 0;
        for (uint32_t c = 0; c < colors; c++)
            sum += (float)code[width * i + c] / 65535.0f;
        for (uint32_t c = 0; c < wanted; c++) {
            bool is_color = source->srgb && c < colors;
            value[wanted * i + c] =
                is_rearranged(source, width) ? 1 : linear_of(code[width * i + c], is_color);
        }
        if (is_rearranged(source, width))
            value[wanted * i + channel_of_grey(source)] =
                value_of_grey(source, sum / (float)colors);
    }
}

static rsv_status check_codes16(
    const rsv_texture_source *source, const rsv_image_codes *size, const uint16_t *code)
{
    double sum[3] = { 0 };
    for (size_t i = 0; i < (size_t)size->width * size->height && size->channel_count >= 3; i++)
        for (size_t c = 0; c < 3; c++)
            sum[c] += code[size->channel_count * i + c];
    return check_normals(source, sum, size->channel_count);
}

static rsv_status load_codes16(rsv_scene *scene, const rsv_texture_source *source, uint32_t *id)
{
    rsv_status status;
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_image_codes size = { 0 };
    uint16_t *code = NULL;
    float *value = NULL;
    RSV_TRY(rsv_image_decode_codes16(&source->file, &code, &size));
    RSV_TRY(check_codes16(source, &size, code));
    uint32_t wanted = wanted_channels(source, size.channel_count);
    value = rsv_alloc(context, (size_t)size.width * size.height, wanted * sizeof *value);
    if (!value) RSV_TRY(RSV_ERROR_MEMORY);
    take_codes16(source, &size, code, value);
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
    uint32_t wanted = wanted_channels(source, 3);
    if (width > RSV_TEXTURE_MAX_SIDE || height > RSV_TEXTURE_MAX_SIDE)
        RSV_TRY(
            rsv_fail(RSV_ERROR_FORMAT, "cannot read '%s': %u x %u pixels are not in 1 .. %u a side",
                source->file.path, width, height, RSV_TEXTURE_MAX_SIDE));
    float *value = (float *)pixel; // in place: pairs take less room than triples
    for (size_t i = 0; i < (size_t)width * height; i++) {
        rsv_rgb c = { cut_off(pixel[i].r, source->shines), cut_off(pixel[i].g, source->shines),
            cut_off(pixel[i].b, source->shines) };
        float grey = value_of_grey(source, (c.r + c.g + c.b) / 3);
        float *texel = &value[wanted * i];
        if (is_rearranged(source, 3)) {
            for (uint32_t k = 0; k < wanted; k++)
                texel[k] = k == channel_of_grey(source) ? grey : 1;
        } else {
            pixel[i] = c;
        }
    }
    rsv_texture_desc desc = describe(source, width, height, wanted);
    desc.values = value;
    desc.srgb = false;
    RSV_TRY(rsv_scene_add_texture(scene, &desc, id));
cleanup:
    rsv_image_destroy(image);
    return status;
}

// ---- KTX2 -------------------------------------------------------------------------------------------

/// Converts a texture's values to linear light, in place.
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
    if (is_rearranged(source, p.channel_count))
        RSV_TRY(rsv_fail(RSV_ERROR_UNSUPPORTED,
            "cannot read '%s': KTX2 pictures are not rearranged; save it as PNG",
            source->file.path));
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

static void warn_of_frames(rsv_scene *scene, const rsv_image_file *file)
{
    bool frames;
    rsv_image_png_unused(file, &frames);
    if (frames || rsv_image_gif_moves(file))
        rsv_log(rsv_scene_get_context(scene), RSV_LOG_WARNING,
            "texture '%s': only the first of its frames is used", file->path);
}

rsv_status rsv_texture_load(rsv_scene *scene, const rsv_texture_source *source, uint32_t *id)
{
    const rsv_image_file *file = &source->file;
    if (file->size == 0)
        return rsv_fail(RSV_ERROR_FORMAT, "cannot read '%s': the file is empty", file->path);
    if (rsv_image_is_ktx(file)) return load_ktx(scene, source, id);
    if (is_exr(file) || is_hdr(file)) return load_radiance(scene, source, id);
    warn_of_frames(scene, file);
    if (rsv_image_is_16_bit(file)) return load_codes16(scene, source, id);
    return load_codes(scene, source, id);
}
