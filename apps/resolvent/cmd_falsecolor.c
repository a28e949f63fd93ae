#include "color_scale.h"
#include "command.h"
#include "options.h"
#include "photometry.h"
#include "session.h"
#include "subject.h"
#include "view/view_canvas.h"

#include "resolvent/image.h"
#include "resolvent/render.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const char help[] =
    "usage: resolvent falsecolor IN.{exr,hdr,safetensors} -o OUT.png [options]\n"
    "\n"
    "Shows the luminance of a picture in colours, with a scale in cd/m2 and a line of equal luminance for\n"
    "each value on it. Luminance is 683 lm/W times CIE 1931 Y of the radiance. For a file from `resolvent\n"
    "solve` or `relight`, shows the illuminance of the surfaces in lux, with isolux lines, as a camera\n"
    "sees them.\n"
    "\n"
    "  -o FILE            the picture\n"
    "  --max CD           top of the scale (default: the brightest 0.1 % are above it)\n"
    "  --min CD           bottom of the scale (default: 0; with --log, a thousandth of the top)\n"
    "  --log              logarithmic scale\n"
    "  --lines N          values on the scale, and lines for them (default 8; 0 = no lines)\n"
    "  --camera NAME      camera of an operator file (default: the first)\n"
    "  --size WxH         size, for an operator file (default: 512 on the longer side, with the camera's\n"
    "                     aspect ratio)\n"
    "  --efficacy LM/W    use this instead of 683, such as 179 for pictures from Radiance\n"
    "\n"
    "examples:\n"
    "  resolvent render office.glb -o office.exr\n"
    "  resolvent falsecolor office.exr -o office-luminance.png --max 5000 --log\n"
    "  resolvent falsecolor office.safetensors --camera plan --max 1000 --lines 10 -o isolux.png\n";

enum { scale_width = 96, bar_left = 12, bar_width = 18, least_height = 64, most_lines = 32 };

typedef struct settings {
    const char *input, *output, *camera;
    cli_size size;
    float least, most, efficacy; ///< NAN = not given
    uint32_t lines;
    bool logarithmic;
} settings;

/// Luminances between the foot and the top of the scale.
typedef struct luminance_scale {
    double least, most;
    bool logarithmic;
    const char *unit;
} luminance_scale;

/// Place on the scale, from 0 to 1 and beyond.
static double place_of(const luminance_scale *s, double value)
{
    if (!s->logarithmic) return (value - s->least) / (s->most - s->least);
    return value > 0 ? log(value / s->least) / log(s->most / s->least) : -1;
}

static double value_at(const luminance_scale *s, double place)
{
    if (!s->logarithmic) return s->least + place * (s->most - s->least);
    return s->least * pow(s->most / s->least, place);
}

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/// The 99.9th percentile of the pixels; 1 for a black picture. Reorders a copy.
static bool find_top(const float *luminance, size_t count, double *top)
{
    float *sorted = malloc(count * sizeof *sorted);
    if (!sorted) return false;
    for (size_t k = 0; k < count; k++)
        sorted[k] = luminance[k];
    qsort(sorted, count, sizeof *sorted, compare_floats);
    *top = (double)sorted[count - 1 - count / 1000];
    if (!(*top > 0)) *top = (double)sorted[count - 1];
    if (!(*top > 0)) *top = 1;
    free(sorted);
    return true;
}

/// Chooses the scale that was asked for; prints an error if it is invalid.
static bool choose_scale(
    const settings *s, const float *luminance, size_t count, luminance_scale *scale)
{
    double top = 0;
    if (!find_top(luminance, count, &top)) {
        cli_error("out of memory for %zu pixels", count);
        return false;
    }
    scale->logarithmic = s->logarithmic;
    scale->most = isnan(s->most) ? top : (double)s->most;
    scale->least = !isnan(s->least) ? (double)s->least : s->logarithmic ? scale->most / 1000 : 0;
    if (scale->least < scale->most && (!s->logarithmic || scale->least > 0)) return true;
    cli_error("--min %g is not below the top of the scale, %g%s", scale->least, scale->most,
        s->logarithmic ? ", or not above 0 as --log needs" : "");
    return false;
}

static void paint(uint8_t pixel[4], double place)
{
    double srgb[3];
    cli_scale_color(place, srgb);
    for (int c = 0; c < 3; c++)
        pixel[c] = (uint8_t)lround(srgb[c]);
    pixel[3] = 255;
}

/// The band between two lines that a place lies in.
static int band_of(double place, uint32_t lines)
{
    return (int)floor(fmin(fmax(place, -1), 2) * lines);
}

/// Whether a line runs between a pixel and its neighbour to the right or below.
static bool is_on_line(
    const float *place, uint32_t width, uint32_t height, uint32_t at, uint32_t lines)
{
    uint32_t x = at % width, y = at / width;
    int band = band_of((double)place[at], lines);
    return (x + 1 < width && band_of((double)place[at + 1], lines) != band) ||
           (y + 1 < height && band_of((double)place[at + width], lines) != band);
}

/// @param place [height * width] of each pixel on the scale
static void draw_picture(
    cli_canvas *canvas, const float *place, uint32_t width, uint32_t height, uint32_t lines)
{
    for (uint32_t at = 0; at < width * height; at++) {
        uint8_t *pixel = canvas->pixel[(size_t)(at / width) * canvas->width + at % width];
        paint(pixel, (double)place[at]);
        bool line = lines && is_on_line(place, width, height, at, lines);
        for (int c = 0; line && c < 3; c++)
            pixel[c] = (uint8_t)(place[at] > 0.7f ? pixel[c] / 3 : 128 + pixel[c] / 2);
    }
}

static void draw_scale(
    cli_canvas *canvas, uint32_t left, const luminance_scale *scale, uint32_t lines)
{
    const cli_ink white = { 255, 255, 255, 1 }, black = { 0, 0, 0, 1 };
    float x = (float)left, tall = (float)canvas->height, size = 7;
    uint32_t values = lines ? lines : 4;
    cli_draw_box(canvas, x, 0, scale_width, tall, white);
    float foot = tall - 16, head = 28;
    for (uint32_t y = (uint32_t)head; y < (uint32_t)foot; y++)
        for (uint32_t k = 0; k < bar_width; k++)
            paint(canvas->pixel[(size_t)y * canvas->width + left + bar_left + k],
                ((double)foot - y) / (double)(foot - head));
    cli_draw_text(canvas, x + bar_left, 16, size, scale->unit, black);
    uint32_t step = 1 + (uint32_t)((float)values * 14 / (foot - head));
    for (uint32_t k = 0; k <= values; k += step) {
        char text[32];
        float y = foot - (foot - head) * (float)k / (float)values;
        snprintf(text, sizeof text, "%.4g", value_at(scale, (double)k / values));
        cli_draw_box(canvas, x + bar_left + bar_width, y - 0.5f, 4, 1, black);
        cli_draw_text(canvas, x + bar_left + bar_width + 8, y + 3.5f, size, text, black);
    }
}

/// From codes to the linear colours that pictures hold.
static rsv_status to_image(rsv_context *context, const cli_canvas *canvas, rsv_image **image)
{
    rsv_status status = rsv_image_create(context, canvas->width, canvas->height, 1, image);
    for (size_t k = 0; status == RSV_OK && k < (size_t)canvas->width * canvas->height; k++) {
        float linear[3];
        for (int c = 0; c < 3; c++) {
            float v = (float)canvas->pixel[k][c] / 255;
            linear[c] = v <= 0.04045f ? v / 12.92f : powf((v + 0.055f) / 1.055f, 2.4f);
        }
        rsv_image_pixels(*image, 0)[k] = (rsv_rgb){ linear[0], linear[1], linear[2] };
    }
    return status;
}

/// The quantity to be shown.
typedef struct field {
    uint32_t width, height;
    float *value; ///< [height * width]
    const char *unit;
} field;

/// Turns values into places, and draws.
static rsv_status draw(cli_session *session, const settings *s, const field *in)
{
    uint32_t width = in->width, height = in->height;
    float *luminance = in->value;
    luminance_scale scale = { .unit = in->unit };
    if (!choose_scale(s, luminance, (size_t)width * height, &scale)) return RSV_ERROR_CANCELLED;
    rsv_image *out = NULL;
    cli_canvas canvas = { width + scale_width, height > least_height ? height : least_height,
        NULL };
    canvas.pixel = calloc((size_t)canvas.width * canvas.height, sizeof *canvas.pixel);
    rsv_status status = canvas.pixel ? RSV_OK : RSV_ERROR_MEMORY;
    if (status == RSV_OK) {
        for (size_t k = 0; k < (size_t)width * height; k++)
            luminance[k] = (float)place_of(&scale, (double)luminance[k]);
        draw_picture(&canvas, luminance, width, height, s->lines);
        draw_scale(&canvas, width, &scale, s->lines);
        status = to_image(session->context, &canvas, &out);
    }
    if (status == RSV_OK) status = rsv_image_write(out, s->output, 0);
    rsv_image_destroy(out);
    free(canvas.pixel);
    return status;
}

static bool make_room(field *f)
{
    f->value = calloc((size_t)f->width * f->height, sizeof *f->value);
    if (!f->value) cli_error("out of memory for %u x %u pixels", f->width, f->height);
    return f->value != NULL;
}

/// Luminances of a picture.
static bool read_picture(cli_session *session, const settings *s, field *f)
{
    rsv_image *image = NULL;
    rsv_status status = rsv_image_read(session->context, s->input, &image);
    if (status != RSV_OK) cli_report_failure(session, status);
    if (status != RSV_OK) return false;
    *f = (field){ rsv_image_width(image), rsv_image_height(image), NULL, "cd/m2" };
    const rsv_rgb *pixel = rsv_image_const_pixels(image, 0);
    double scale = (double)s->efficacy / CLI_LUMINOUS_EFFICACY;
    bool good = make_room(f);
    for (size_t k = 0; good && k < (size_t)f->width * f->height; k++) {
        double value = scale * cli_luminous(pixel[k]);
        f->value[k] = isfinite(value) && value > 0 ? (float)fmin(value, 1e30) : 0;
    }
    rsv_image_destroy(image);
    return good;
}

/// Illuminance on the surfaces that a camera sees.
static void read_surfaces(
    const settings *s, const rsv_light *light, const rsv_camera *camera, field *f)
{
    double scale = (double)s->efficacy / CLI_LUMINOUS_EFFICACY;
    for (uint32_t y = 0; y < f->height; y++)
        for (uint32_t x = 0; x < f->width; x++) {
            rsv_rgb irradiance;
            const float place[2] = { ((float)x + 0.5f) / (float)f->width,
                ((float)y + 0.5f) / (float)f->height };
            rsv_read_picture_point(light, camera, f->width, f->height, place, &irradiance);
            f->value[(size_t)y * f->width + x] = (float)(scale * cli_luminous(irradiance));
        }
}

static bool read_operator(cli_session *session, const settings *s, field *f)
{
    cli_subject subject = { 0 };
    if (!cli_open_subject(session, s->input, NULL, &subject)) return false;
    uint32_t index = rsv_scene_find_camera(subject.scene, s->camera);
    bool good = index != RSV_NONE;
    if (!good)
        cli_error("--camera: %s has no camera '%s'; `resolvent info %s` lists them", s->input,
            s->camera ? s->camera : "", s->input);
    if (good) {
        const rsv_camera *camera = &rsv_scene_get_view(subject.scene)->camera[index];
        cli_size size = s->size.width ? s->size : cli_default_size(camera);
        *f = (field){ size.width, size.height, NULL, "lux" };
        good = make_room(f);
        if (good) read_surfaces(s, subject.solution, camera, f);
    }
    cli_close_subject(&subject);
    return good;
}

static int run(cli_session *session, const settings *s)
{
    field f = { 0 };
    bool good = rsv_is_operator_file(s->input) ? read_operator(session, s, &f)
                                               : read_picture(session, s, &f);
    rsv_status status = good ? draw(session, s, &f) : RSV_ERROR_CANCELLED;
    if (status != RSV_OK && status != RSV_ERROR_CANCELLED) cli_report_failure(session, status);
    free(f.value);
    return status == RSV_OK ? CLI_SUCCESS : CLI_FAILURE;
}

int cli_falsecolor(int argc, char **argv)
{
    settings s = {
        .least = NAN, .most = NAN, .efficacy = (float)CLI_LUMINOUS_EFFICACY, .lines = 8
    };
    const cli_option options[] = {
        { .name = "-o", .kind = CLI_TEXT, .value = &s.output },
        { .name = "--max", .kind = CLI_REAL, .value = &s.most, .min = 1e-9, .max = 1e12 },
        { .name = "--min", .kind = CLI_REAL, .value = &s.least, .min = 0, .max = 1e12 },
        { .name = "--log", .kind = CLI_FLAG, .value = &s.logarithmic },
        { .name = "--lines", .kind = CLI_COUNT, .value = &s.lines, .max = most_lines },
        { .name = "--camera", .kind = CLI_TEXT, .value = &s.camera },
        { .name = "--size", .kind = CLI_SIZE, .value = &s.size, .min = 1, .max = 16384 },
        { .name = "--efficacy", .kind = CLI_REAL, .value = &s.efficacy, .min = 1e-3, .max = 1e6 },
        { .name = NULL },
    };
    const cli_usage usage = { "falsecolor", help, options, "IN", 1, 1, NULL };
    int exit_status;
    if (!cli_parse(&usage, argc, argv, &s.input, &exit_status)) return exit_status;
    if (!s.output) return cli_usage_error("falsecolor", "-o OUT.png is missing");
    if (rsv_image_check_output(s.output) != RSV_OK) {
        cli_error("%s", rsv_last_error());
        return CLI_FAILURE;
    }
    cli_session session;
    if (!cli_session_begin(&session, 0)) return CLI_FAILURE;
    exit_status = run(&session, &s);
    cli_session_end(&session);
    return exit_status;
}
