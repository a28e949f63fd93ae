/// Pixels around a pixel.
#ifndef RSV_PIXEL_WINDOW_H
#define RSV_PIXEL_WINDOW_H

/// Pixels on either side over which brightness is averaged, and the square of the part of the picture's that counts as
/// the least: what errors of pixels are relative to.
#define RSV_PIXEL_SURROUNDINGS 2
#define RSV_PIXEL_FLOOR 0.01

/// A part of a picture.
typedef struct rsv_pixel_window {
    int left, right, top, bottom; ///< inclusive
} rsv_pixel_window;

/// The part around a pixel that reaches so far on either side.
static inline rsv_pixel_window rsv_pixel_window_around(
    int width, int height, int x, int y, int reach)
{
    return (rsv_pixel_window){ x < reach ? 0 : x - reach, x + reach < width ? x + reach : width - 1,
        y < reach ? 0 : y - reach, y + reach < height ? y + reach : height - 1 };
}

#endif
