/// From a view's state to pixels: keeps the light up to date and the pictures of the mode on show.
#ifndef CLI_VIEW_FRAMES_H
#define CLI_VIEW_FRAMES_H

#include "view_canvas.h"
#include "view_state.h"

/// Milliseconds of one frame by stage, and its quality.
typedef struct cli_view_timing {
    double light_ms;   ///< sources changed, orders added, the object placed
    double refresh_ms; ///< update of the light fields that frames use
    double camera_ms, path_ms, gloss_ms, display_ms;
    double still_ms; ///< pictures of modes other than operator
    double total_ms; ///< of the whole frame, without the overlay
    uint64_t path_rays;
    uint32_t samples; ///< accumulated so far
    uint32_t eyes;
    double residual; ///< of the light; 0 = exact
    uint32_t
        coarseness; ///< pixels of the window along each side of one of the frame; 0 = it has no frame
} cli_view_timing;

typedef struct cli_view_frames cli_view_frames;

/// @param body an object that moves, seen in mode operator; NULL = none; borrowed
/// @param budget_ms of a frame for orders of light; 0 = one order per frame, so that the same frames come out every
/// time
rsv_status cli_view_frames_create(
    rsv_light *solution, const rsv_scene *body, double budget_ms, cli_view_frames **frames);
void cli_view_frames_destroy(cli_view_frames *frames);

/// Makes in advance what the first frame of that size needs.
rsv_status cli_view_frames_prepare(cli_view_frames *frames, uint32_t width, uint32_t height);

/// Lets slow frames have fewer pixels while the camera moves; has no effect on frames made by a device.
void cli_view_frames_keep_pace(cli_view_frames *frames);

/// From now on the light follows the state. @param relighter of the frames' light; borrowed
rsv_status cli_view_frames_attach(cli_view_frames *frames, rsv_relighter *relighter);

/// From now on the light no longer follows the state.
void cli_view_frames_detach(cli_view_frames *frames);
/// Sets pictures and object up again, for a light whose surfaces have moved.
rsv_status cli_view_frames_begin_again(cli_view_frames *frames);

/// Makes the next frame. Nothing is allocated while size and mode stay the same, except in modes final and error at
/// rest, and when a moved light has come to rest and gets finer elements.
/// @param canvas of the size that the frame should have @param state its aspect is set
rsv_status cli_view_frames_next(
    cli_view_frames *frames, cli_view_state *state, cli_canvas *canvas, cli_view_timing *timing);

/// Frames that have added up.
uint32_t cli_view_frames_samples(const cli_view_frames *frames);

/// Whether a further frame would look the same.
bool cli_view_frames_at_rest(const cli_view_frames *frames);

/// Writes the picture of the last frame: .png as shown, others as radiance.
rsv_status cli_view_save_picture(
    const cli_view_frames *frames, const cli_canvas *canvas, const char *path);

/// Writes an equirectangular picture of the camera's surroundings, with the viewing direction in the middle.
rsv_status cli_view_save_panorama(
    const rsv_light *solution, const cli_view_state *state, const char *path);

#endif
