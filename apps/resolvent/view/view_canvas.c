#include "view_canvas.h"

#include "view_font.h"

#include <math.h>
#include <string.h>

static void blend(uint8_t pixel[4], cli_ink ink, float coverage)
{
    const uint8_t color[3] = { ink.r, ink.g, ink.b };
    float share = ink.opacity * coverage;
    for (int c = 0; c < 3; c++)
        pixel[c] = (uint8_t)((float)pixel[c] + share * ((float)color[c] - (float)pixel[c]) + 0.5f);
}

/// Pixels of a box that lie on the canvas.
typedef struct pixel_box {
    int left, top, right, bottom; ///< the last two excluded
} pixel_box;

static int clamped(float value, uint32_t most)
{
    return value > 0 ? value < (float)most ? (int)value : (int)most : 0;
}

static pixel_box box_on(const cli_canvas *canvas, float x0, float y0, float x1, float y1)
{
    return (pixel_box){ clamped(floorf(x0), canvas->width), clamped(floorf(y0), canvas->height),
        clamped(ceilf(x1), canvas->width), clamped(ceilf(y1), canvas->height) };
}

void cli_draw_box(cli_canvas *canvas, float x, float y, float width, float height, cli_ink ink)
{
    pixel_box box =
        box_on(canvas, roundf(x), roundf(y), roundf(x) + roundf(width), roundf(y) + roundf(height));
    for (int j = box.top; j < box.bottom; j++)
        for (int i = box.left; i < box.right; i++)
            blend(canvas->pixel[(size_t)j * canvas->width + (size_t)i], ink, 1);
}

static float distance_to_line(float x, float y, float dx, float dy)
{
    float length2 = dx * dx + dy * dy;
    float along = length2 > 0 ? fminf(fmaxf((x * dx + y * dy) / length2, 0), 1) : 0;
    return hypotf(x - along * dx, y - along * dy);
}

static float coverage_at(float distance) { return fminf(fmaxf(0.5f - distance, 0), 1); }

void cli_draw_ring(
    cli_canvas *canvas, float x, float y, float radius, float half_width, cli_ink ink)
{
    float reach = radius + half_width + 1;
    if (!isfinite(x + y + radius)) return;
    pixel_box box = box_on(canvas, x - reach, y - reach, x + reach, y + reach);
    for (int j = box.top; j < box.bottom; j++)
        for (int i = box.left; i < box.right; i++) {
            float r = hypotf((float)i + 0.5f - x, (float)j + 0.5f - y);
            float coverage = coverage_at(fabsf(r - radius) - half_width);
            if (coverage > 0)
                blend(canvas->pixel[(size_t)j * canvas->width + (size_t)i], ink, coverage);
        }
}

// ---- letters ----------------------------------------------------------------------------------------

/// The strokes of one letter around a pixel: only the nearest counts, so that joints are no darker.
static float pen_distance(const char *strokes, float scale, float x, float y)
{
    float nearest = INFINITY;
    bool down = false;
    float px = 0, py = 0;
    for (const char *s = strokes; *s; s++) {
        if (*s == ' ') {
            down = false;
            continue;
        }
        float qx = cli_pen_x(s[0]) * scale, qy = cli_pen_y(s[1]) * scale;
        s++;
        if (down) nearest = fminf(nearest, distance_to_line(x - px, y - py, qx - px, qy - py));
        px = qx, py = qy;
        down = true;
    }
    return nearest;
}

static void draw_letter(cli_canvas *canvas, float x, float y, float size, char letter, cli_ink ink)
{
    const char *strokes = cli_font_strokes(letter);
    float scale = size / CLI_FONT_CAP, radius = 0.02f * size + 0.45f, reach = radius + 1;
    pixel_box box = box_on(canvas, x - reach, y - size - reach,
        x + cli_font_advance(letter) * scale + reach, y + CLI_FONT_DESCENT * scale + reach);
    for (int j = box.top; j < box.bottom; j++)
        for (int i = box.left; i < box.right; i++) {
            float distance =
                pen_distance(strokes, scale, (float)i + 0.5f - x, (float)j + 0.5f - (y - size));
            float coverage = coverage_at(distance - radius);
            if (coverage > 0)
                blend(canvas->pixel[(size_t)j * canvas->width + (size_t)i], ink, coverage);
        }
}

float cli_draw_text(cli_canvas *canvas, float x, float y, float size, const char *text, cli_ink ink)
{
    for (const char *letter = text; *letter; letter++) {
        if (*letter != ' ') draw_letter(canvas, x, y, size, *letter, ink);
        x += cli_font_advance(*letter) * size / CLI_FONT_CAP;
    }
    return x;
}

float cli_text_width(float size, const char *text)
{
    float width = 0;
    for (const char *letter = text; *letter; letter++)
        width += cli_font_advance(*letter);
    return width * size / CLI_FONT_CAP;
}
