/// Pictures of the modes that are not made at frame rate: they add up while the view rests, or stay as they are.
#ifndef CLI_VIEW_STILL_H
#define CLI_VIEW_STILL_H

#include "view_canvas.h"
#include "view_state.h"

#include "resolvent/render.h"

typedef struct cli_still {
    const rsv_light *solution;
    uint32_t width, height; ///< of one eye's picture
    rsv_rgb *radiance;      ///< [height * width] the mean so far
    uint32_t samples;       ///< in it
    rsv_rgb *known;         ///< [height * width] by frames; mode final begins with it
    rsv_occlusion *occlusion;
    cli_view_mode occlusion_mode; ///< that it was made for
    rsv_image *picture;           ///< of occlusion
} cli_still;

/// Sets the size; the picture starts over.
rsv_status cli_still_resize(
    const rsv_light *solution, uint32_t width, uint32_t height, cli_still *still);
void cli_still_free(cli_still *still);

/// Adds a sample to the picture of the mode, not CLI_VIEW_OPERATOR, or makes it.
rsv_status cli_still_add(cli_still *still, cli_view_mode mode, const rsv_camera *camera);

/// Whether another sample would change it.
bool cli_still_is_done(const cli_still *still, cli_view_mode mode);

/// Codes of radiance x 2^exposure, as frames show it, at (left, 0) of a canvas.
/// @param mode that the picture is of
void cli_still_show(const cli_still *still, cli_view_mode mode, float exposure, bool soft,
    uint32_t left, cli_canvas *canvas);

/// The sRGB code of radiance x scale.
uint8_t cli_tone_code(float radiance, float scale, bool soft);

#endif
