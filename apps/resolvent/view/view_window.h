/// A window that shows a canvas and turns keys and mouse into commands. Two builds: with SDL2, and one that has none.
#ifndef CLI_VIEW_WINDOW_H
#define CLI_VIEW_WINDOW_H

#include "view_canvas.h"

typedef struct cli_window cli_window;

/// Says on standard error why there is none: no display, or a build without windows. NULL then.
cli_window *cli_window_open(const char *title, uint32_t width, uint32_t height);
void cli_window_close(cli_window *window);

/// Pixels of its inside; 0 x 0 while it is minimized.
void cli_window_size(const cli_window *window, uint32_t *width, uint32_t *height);

bool cli_window_show(cli_window *window, const cli_canvas *canvas);

/// Passes on the keys and mouse actions since the last call, as commands.
/// @param speed of flying, metres per second @param wait_ms longest time to wait for an action
void cli_window_listen(cli_window *window, float speed, int wait_ms,
    void (*command)(void *user, const char *text), void *user);

#endif
