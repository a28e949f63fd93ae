/// The overlay on the picture: numbers, a graph of frame times, the selection, rings around lights, help.
#ifndef CLI_VIEW_HUD_H
#define CLI_VIEW_HUD_H

#include "view_frames.h"

enum { CLI_VIEW_HISTORY = 120 };

typedef struct cli_view_hud {
    const char *scene;                  ///< name, borrowed
    double history[CLI_VIEW_HISTORY];   ///< milliseconds of the last frames, a ring
    uint32_t frame;                     ///< frames so far
    cli_view_timing mean;               ///< running mean, so that digits can be read
    char message[CLI_VIEW_TEXT_LENGTH]; ///< "" = none
    uint32_t message_frames;            ///< that it has been shown for
    double lag_ms;                      ///< that the light is behind the animation
    char object[CLI_VIEW_TEXT_LENGTH];  ///< selected for editing; "" = none
    const char *quality;                ///< of the light on show
    char reading[32];                   ///< under the mouse; "" = none
    char making[CLI_VIEW_TEXT_LENGTH];  ///< the light being computed; "" = none
} cli_view_hud;

/// Records the figures of a frame.
void cli_view_hud_note(cli_view_hud *hud, const cli_view_timing *timing);

void cli_view_hud_draw(const cli_view_hud *hud, const cli_view_state *state, cli_canvas *canvas);

#endif
