/// From a view's state to pixels: keeps the light up to date and the pictures of the mode on show.
#ifndef CLI_VIEW_FRAMES_H
#define CLI_VIEW_FRAMES_H

#include "view_canvas.h"
#include "view_state.h"

/// Milliseconds of one frame by stage, and what it achieved.
typedef struct cli_view_timing {
    double light_ms;   ///< sources changed, orders added, the object placed
    double refresh_ms; ///< fields brought to the frames
    double camera_ms, path_ms, gloss_ms, display_ms;
    double still_ms; ///< pictures of modes other than operator
    double total_ms; ///< all of it; what is drawn over the picture is not in it
    uint64_t path_rays;
    uint32_t samples; ///< that have added up
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

/// Makes beforehand what the first frame of such a size would have to make.
rsv_status cli_view_frames_prepare(cli_view_frames *frames, uint32_t width, uint32_t height);

/// Lets frames that take too long have fewer pixels while the camera moves; not for those of a device.
void cli_view_frames_keep_pace(cli_view_frames *frames);

/// From here on the light follows the state. @param relighter of the frames' light; borrowed
rsv_status cli_view_frames_attach(cli_view_frames *frames, rsv_relighter *relighter);

/// From here on the light stays as it is, as far as the state is concerned.
void cli_view_frames_detach(cli_view_frames *frames);
/// Has pictures and object show the light anew, whose surfaces are elsewhere.
rsv_status cli_view_frames_begin_again(cli_view_frames *frames);

/// Makes the next frame. Nothing is allocated while size and mode stay, but by modes final and error at rest, and where
/// a light that was moved has come to rest and gets finer elements.
/// @param canvas as large as the frame is to be @param state its aspect is set
rsv_status cli_view_frames_next(
    cli_view_frames *frames, cli_view_state *state, cli_canvas *canvas, cli_view_timing *timing);

/// Frames that have added up.
uint32_t cli_view_frames_samples(const cli_view_frames *frames);

/// Whether a further frame would look the same.
bool cli_view_frames_at_rest(const cli_view_frames *frames);

/// Writes the picture of the last frame: .png as shown, others as radiance.
rsv_status cli_view_save_picture(
    const cli_view_frames *frames, const cli_canvas *canvas, const char *path);

/// Writes an equirectangular picture of all that surrounds the camera; what is ahead is in its middle.
rsv_status cli_view_save_panorama(
    const rsv_light *solution, const cli_view_state *state, const char *path);

#endif
