#include "view_still.h"

#include "resolvent/certify.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/// Samples per pixel at which mode final stops.
#define FINAL_SAMPLES 256
/// The previous frames count for this many samples at first.
#define KNOWN_SAMPLES 16
/// The heat map has this many times fewer pixels along each side, and this many gather rays per pixel.
#define ERROR_COARSENESS 3
#define ERROR_GATHER_RAYS 24

rsv_status cli_still_resize(
    const rsv_light *solution, uint32_t width, uint32_t height, cli_still *s)
{
    rsv_context *context = rsv_scene_get_context(rsv_light_scene(solution));
    cli_still_free(s);
    *s = (cli_still){ .solution = solution, .width = width, .height = height };
    s->radiance = calloc((size_t)width * height, sizeof *s->radiance);
    s->known = calloc((size_t)width * height, sizeof *s->known);
    if (!s->radiance || !s->known) return RSV_ERROR_MEMORY;
    return rsv_image_create(context, width, height, 1, &s->picture);
}

void cli_still_free(cli_still *s)
{
    rsv_occlusion_destroy(s->occlusion);
    rsv_image_destroy(s->picture);
    free(s->radiance);
    free(s->known);
    *s = (cli_still){ 0 };
}

/// Brings the mean up to date by one more picture of the same size.
static void add_picture(cli_still *s, const rsv_image *image)
{
    const rsv_rgb *added = rsv_image_const_pixels(image, 0);
    float share = 1 / (float)(s->samples + 1);
    for (size_t k = 0; k < (size_t)s->width * s->height; k++) {
        rsv_rgb *mean = &s->radiance[k];
        mean->r += share * (added[k].r - mean->r);
        mean->g += share * (added[k].g - mean->g);
        mean->b += share * (added[k].b - mean->b);
    }
    s->samples++;
}

static rsv_status add_final(cli_still *s, const rsv_camera *camera)
{
    rsv_image *image = NULL;
    rsv_render_desc desc = rsv_default_render_desc();
    desc.mode = RSV_RENDER_FINAL;
    desc.width = s->width;
    desc.height = s->height;
    desc.samples = 1;
    desc.viewpoint = camera;
    desc.seed = s->samples;
    rsv_status status = rsv_render(s->solution, &desc, &image);
    if (status == RSV_OK) add_picture(s, image);
    rsv_image_destroy(image);
    return status;
}

static rsv_status add_occlusion(cli_still *s, cli_view_mode mode, const rsv_camera *camera)
{
    rsv_status status = RSV_OK;
    if (!s->occlusion || s->occlusion_mode != mode) {
        rsv_render_desc desc = rsv_default_render_desc();
        desc.mode = mode == CLI_VIEW_OCCLUSION ? RSV_RENDER_OCCLUSION : RSV_RENDER_OCCLUSION_SCREEN;
        desc.width = s->width;
        desc.height = s->height;
        desc.samples = 1;
        rsv_occlusion_destroy(s->occlusion);
        s->occlusion = NULL;
        s->occlusion_mode = mode;
        status = rsv_occlusion_create(rsv_light_scene(s->solution), &desc, &s->occlusion);
    }
    if (status == RSV_OK) status = rsv_occlusion_render(s->occlusion, camera, s->picture);
    if (status == RSV_OK) add_picture(s, s->picture);
    return status;
}

/// Nearest pixels of a smaller picture.
static void enlarge(cli_still *s, const rsv_image *image)
{
    const rsv_rgb *from = rsv_image_const_pixels(image, 0);
    uint32_t width = rsv_image_width(image), height = rsv_image_height(image);
    for (uint32_t y = 0; y < s->height; y++)
        for (uint32_t x = 0; x < s->width; x++)
            s->radiance[(size_t)y * s->width + x] =
                from[(size_t)(y * (uint64_t)height / s->height) * width +
                     x * (uint64_t)width / s->width];
    s->samples = 1;
}

static rsv_status make_error(cli_still *s, const rsv_camera *camera)
{
    rsv_image *image = NULL;
    rsv_certificate certificate;
    rsv_certify_desc sampling = rsv_brief_certify_desc();
    rsv_heat_map_desc desc = rsv_default_heat_map_desc();
    desc.width = s->width / ERROR_COARSENESS < 16 ? 16 : s->width / ERROR_COARSENESS;
    desc.height = s->height / ERROR_COARSENESS < 32 ? 32 : s->height / ERROR_COARSENESS;
    desc.viewpoint = camera;
    desc.gather_rays = ERROR_GATHER_RAYS;
    rsv_status status = rsv_certify_picture(s->solution, &sampling, &desc, &certificate, &image);
    if (status == RSV_OK) enlarge(s, image);
    rsv_image_destroy(image);
    return status;
}

bool cli_still_is_done(const cli_still *s, cli_view_mode mode)
{
    return s->samples >= (mode == CLI_VIEW_FINAL ? FINAL_SAMPLES : 1);
}

rsv_status cli_still_add(cli_still *s, cli_view_mode mode, const rsv_camera *camera)
{
    if (cli_still_is_done(s, mode)) return RSV_OK;
    if (mode == CLI_VIEW_FINAL) return add_final(s, camera);
    if (mode == CLI_VIEW_ERROR) return make_error(s, camera);
    return add_occlusion(s, mode, camera);
}

uint8_t cli_tone_code(float radiance, float scale, bool soft)
{
    float x = fmaxf(radiance * scale, 0);
    if (soft) x = x * (1 + x / 16) / (1 + x);
    x = fminf(x, 1);
    float code = x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - 0.055f;
    return (uint8_t)(255 * code + 0.5f);
}

/// Weight of the previous frames: it falls with every sample, and finally to 0.
static float share_known(const cli_still *s, cli_view_mode mode)
{
    float samples = (float)s->samples;
    if (mode != CLI_VIEW_FINAL || s->samples >= FINAL_SAMPLES) return 0;
    return KNOWN_SAMPLES * (1 - samples / FINAL_SAMPLES) / (KNOWN_SAMPLES + samples);
}

static float mixed(float a, float b, float share) { return a + share * (b - a); }

void cli_still_show(const cli_still *s, cli_view_mode mode, float exposure, bool soft,
    uint32_t left, cli_canvas *canvas)
{
    float scale = exp2f(exposure), share = share_known(s, mode);
    for (uint32_t y = 0; y < s->height; y++)
        for (uint32_t x = 0; x < s->width; x++) {
            rsv_rgb c = s->radiance[(size_t)y * s->width + x];
            const rsv_rgb *k = &s->known[(size_t)y * s->width + x];
            c = (rsv_rgb){ mixed(c.r, k->r, share), mixed(c.g, k->g, share),
                mixed(c.b, k->b, share) };
            uint8_t *pixel = canvas->pixel[(size_t)y * canvas->width + left + x];
            pixel[0] = cli_tone_code(c.r, scale, soft);
            pixel[1] = cli_tone_code(c.g, scale, soft);
            pixel[2] = cli_tone_code(c.b, scale, soft);
            pixel[3] = 255;
        }
}
