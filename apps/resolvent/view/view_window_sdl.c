/// The only file that uses SDL2.
#include "view_window.h"

#include "../progress.h"
#include "../session.h"
#include "view_keys.h"

#define SDL_MAIN_HANDLED
#include <SDL.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COMMAND_LENGTH = 128 };

struct cli_window {
    SDL_Window *window;
    SDL_Renderer *renderer;
    SDL_Texture *texture;
    uint32_t width, height; ///< of the texture
    double listened;        ///< seconds, when it last was
};

/// Where events go.
typedef struct listener {
    cli_window *window;
    void (*command)(void *user, const char *text);
    void *user;
} listener;

static cli_window *give_up(cli_window *w)
{
    cli_error("view: no window can be opened (%s); --record DIR writes the frames without one",
        SDL_GetError());
    cli_window_close(w);
    return NULL;
}

/// Without a display SDL would draw to nothing.
static bool has_display(void)
{
#if defined(__unix__) && !defined(__APPLE__)
    return getenv("DISPLAY") || getenv("WAYLAND_DISPLAY") || getenv("SDL_VIDEODRIVER");
#else
    return true;
#endif
}

cli_window *cli_window_open(const char *title, uint32_t width, uint32_t height)
{
    if (!has_display()) {
        cli_error("view: there is no display to open a window on; --record DIR writes the frames "
                  "without one");
        return NULL;
    }
    cli_window *w = calloc(1, sizeof *w);
    if (!w) return NULL;
    SDL_SetMainReady();
    SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1"); // Ctrl-C stays the program's
    if (SDL_Init(SDL_INIT_VIDEO) != 0) return give_up(w);
    w->window = SDL_CreateWindow(title, SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED, (int)width,
        (int)height, SDL_WINDOW_RESIZABLE);
    if (!w->window) return give_up(w);
    w->renderer = SDL_CreateRenderer(w->window, -1, SDL_RENDERER_PRESENTVSYNC);
    if (!w->renderer) w->renderer = SDL_CreateRenderer(w->window, -1, SDL_RENDERER_SOFTWARE);
    if (!w->renderer) return give_up(w);
    w->listened = cli_seconds();
    return w;
}

void cli_window_close(cli_window *w)
{
    if (!w) return;
    if (w->texture) SDL_DestroyTexture(w->texture);
    if (w->renderer) SDL_DestroyRenderer(w->renderer);
    if (w->window) SDL_DestroyWindow(w->window);
    SDL_Quit();
    free(w);
}

void cli_window_size(const cli_window *w, uint32_t *width, uint32_t *height)
{
    int x = 0, y = 0;
    if (!(SDL_GetWindowFlags(w->window) & SDL_WINDOW_MINIMIZED))
        SDL_GetRendererOutputSize(w->renderer, &x, &y);
    *width = x > 0 && y > 0 ? (uint32_t)x : 0;
    *height = x > 0 && y > 0 ? (uint32_t)y : 0;
}

static bool fit_texture(cli_window *w, const cli_canvas *canvas)
{
    if (w->texture && w->width == canvas->width && w->height == canvas->height) return true;
    if (w->texture) SDL_DestroyTexture(w->texture);
    w->width = canvas->width;
    w->height = canvas->height;
    w->texture = SDL_CreateTexture(w->renderer, SDL_PIXELFORMAT_RGBA32, SDL_TEXTUREACCESS_STREAMING,
        (int)w->width, (int)w->height);
    return w->texture != NULL;
}

bool cli_window_show(cli_window *w, const cli_canvas *canvas)
{
    bool good = fit_texture(w, canvas) &&
                SDL_UpdateTexture(w->texture, NULL, canvas->pixel,
                    (int)(canvas->width * sizeof *canvas->pixel)) == 0 &&
                SDL_RenderCopy(w->renderer, w->texture, NULL, NULL) == 0;
    if (good)
        SDL_RenderPresent(w->renderer);
    else
        cli_error("view: the window cannot be drawn: %s", SDL_GetError());
    return good;
}

// ---- events -------------------------------------------------------------------------------------------

static void say(const listener *l, const char *word, float x, float y)
{
    char text[COMMAND_LENGTH];
    snprintf(text, sizeof text, "%s %.6g %.6g", word, (double)x, (double)y);
    l->command(l->user, text);
}

static void press_key(const listener *l, const SDL_Keysym *key)
{
    char name[COMMAND_LENGTH];
    snprintf(name, sizeof name, "%s%s%s", key->mod & KMOD_CTRL ? "Ctrl+" : "",
        key->mod & KMOD_SHIFT ? "Shift+" : "", SDL_GetKeyName(key->sym));
    for (size_t k = 0; k < cli_view_key_count; k++)
        if (cli_view_keys[k].command && strcmp(cli_view_keys[k].key, name) == 0)
            l->command(l->user, cli_view_keys[k].command);
}

static void press_button(const listener *l, const SDL_MouseButtonEvent *button)
{
    int width, height;
    SDL_GetWindowSize(l->window->window, &width, &height);
    if (button->button == SDL_BUTTON_LEFT && width > 0 && height > 0)
        say(l, SDL_GetModState() & KMOD_CTRL ? "grasp" : "pick", (float)button->x / (float)width,
            (float)button->y / (float)height);
}

static void move_mouse(const listener *l, const SDL_MouseMotionEvent *motion)
{
    int width, height;
    SDL_GetWindowSize(l->window->window, &width, &height);
    if (width <= 0 || height <= 0) return;
    float x = (float)motion->xrel / (float)width, y = (float)motion->yrel / (float)height;
    if (motion->state & SDL_BUTTON_LMASK)
        say(l, SDL_GetModState() & KMOD_CTRL ? "haul" : "drag", x, y);
    say(l, "point", (float)motion->x / (float)width, (float)motion->y / (float)height);
    if (motion->state & SDL_BUTTON_RMASK) say(l, "look", -60 * x, -40 * y);
}

static void roll_wheel(const listener *l, int steps)
{
    char text[COMMAND_LENGTH];
    snprintf(text, sizeof text, "dolly %.6g", (double)SDL_powf(0.92f, (float)steps));
    l->command(l->user, text);
}

static void hear(const listener *l, const SDL_Event *event)
{
    if (event->type == SDL_QUIT) l->command(l->user, "quit");
    if (event->type == SDL_KEYDOWN) press_key(l, &event->key.keysym);
    if (event->type == SDL_MOUSEBUTTONDOWN) press_button(l, &event->button);
    if (event->type == SDL_MOUSEBUTTONUP) l->command(l->user, "release");
    if (event->type == SDL_MOUSEMOTION) move_mouse(l, &event->motion);
    if (event->type == SDL_MOUSEWHEEL) roll_wheel(l, event->wheel.y);
}

/// Keys that are held down move on as long as they are.
static void fly(const listener *l, float distance)
{
    const Uint8 *held = SDL_GetKeyboardState(NULL);
    char text[COMMAND_LENGTH];
    if (SDL_GetModState() & KMOD_CTRL) return;
    if (SDL_GetModState() & KMOD_SHIFT) distance *= 4;
    int right = held[SDL_SCANCODE_D] - held[SDL_SCANCODE_A];
    int up = held[SDL_SCANCODE_E] - held[SDL_SCANCODE_Q];
    int ahead = held[SDL_SCANCODE_W] - held[SDL_SCANCODE_S];
    if (!right && !up && !ahead) return;
    snprintf(text, sizeof text, "fly %.6g %.6g %.6g", (double)((float)right * distance),
        (double)((float)up * distance), (double)((float)ahead * distance));
    l->command(l->user, text);
}

void cli_window_listen(cli_window *w, float speed, int wait_ms,
    void (*command)(void *user, const char *text), void *user)
{
    SDL_Event event;
    listener l = { w, command, user };
    if (wait_ms > 0 && SDL_WaitEventTimeout(&event, wait_ms)) hear(&l, &event);
    while (SDL_PollEvent(&event))
        hear(&l, &event);
    double now = cli_seconds(), passed = now - w->listened;
    w->listened = now;
    fly(&l, speed * (float)(passed < 0.1 ? passed : 0.1));
}
