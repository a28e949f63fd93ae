/// A build without SDL2.
#include "view_window.h"

#include "../session.h"

cli_window *cli_window_open(const char *title, uint32_t width, uint32_t height)
{
    (void)title, (void)width, (void)height;
    cli_error("view: this program was built without SDL2 and has no window; --record DIR writes "
              "the frames without one");
    return NULL;
}

void cli_window_close(cli_window *window) { (void)window; }

void cli_window_size(const cli_window *window, uint32_t *width, uint32_t *height)
{
    (void)window;
    *width = *height = 0;
}

bool cli_window_show(cli_window *window, const cli_canvas *canvas)
{
    (void)window, (void)canvas;
    return false;
}

void cli_window_listen(cli_window *window, float speed, int wait_ms,
    void (*command)(void *user, const char *text), void *user)
{
    (void)window, (void)speed, (void)wait_ms, (void)command, (void)user;
}
