/// A picture of 8-bit codes to draw on: boxes, lines and letters, blended over its contents.
#ifndef CLI_VIEW_CANVAS_H
#define CLI_VIEW_CANVAS_H

#include <stdbool.h>
#include <stdint.h>

typedef struct cli_canvas {
    uint32_t width, height;
    uint8_t (*pixel)[4]; ///< [height * width] red, green, blue, 255; row 0 on top
} cli_canvas;

typedef struct cli_ink {
    uint8_t r, g, b;
    float opacity; ///< 0..1
} cli_ink;

/// Drawing is clipped to the canvas. Coordinates are in pixels, y down.
void cli_draw_box(cli_canvas *canvas, float x, float y, float width, float height, cli_ink ink);

void cli_draw_ring(
    cli_canvas *canvas, float x, float y, float radius, float half_width, cli_ink ink);

/// Letters drawn with a pen: printable ASCII, others as '?'.
/// @param x, y where the baseline begins @param size height of a capital @return where the text ends
float cli_draw_text(
    cli_canvas *canvas, float x, float y, float size, const char *text, cli_ink ink);

/// Its width.
float cli_text_width(float size, const char *text);

#endif
