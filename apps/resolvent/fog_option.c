#include "fog_option.h"

#include "session.h"

#include <stdlib.h>

/// The number that `*text` begins with; moves on past it.
static bool take_number(const char **text, float *value)
{
    char *end;
    *value = strtof(*text, &end);
    bool found = end != *text;
    *text = end;
    return found;
}

/// One number for all channels, or three: "0.1:0.2:0.3".
static bool take_color(const char **text, rsv_rgb *color)
{
    if (!take_number(text, &color->r)) return false;
    color->g = color->b = color->r;
    if (**text != ':') return true;
    ++*text;
    if (!take_number(text, &color->g) || **text != ':') return false;
    ++*text;
    return take_number(text, &color->b);
}

/// Whether another value follows; moves on to it.
static bool next_value(const char **text)
{
    bool follows = **text == ',';
    *text += follows;
    return follows;
}

static bool read_medium(const char *text, rsv_fog *fog)
{
    if (!take_color(&text, &fog->extinction)) return false;
    if (next_value(&text) && !take_color(&text, &fog->albedo)) return false;
    if (next_value(&text) && !take_number(&text, &fog->anisotropy)) return false;
    return *text == '\0';
}

static bool read_height(const char *text, rsv_fog *fog)
{
    if (!take_number(&text, &fog->scale_height)) return false;
    if (next_value(&text) && !take_number(&text, &fog->base_height)) return false;
    return *text == '\0';
}

bool cli_read_fog(const cli_fog *given, rsv_fog *fog)
{
    if (given->medium && !read_medium(given->medium, fog)) {
        cli_error("--fog: '%s' is not EXTINCTION[,ALBEDO[,G]], such as 0.05,0.9,0.3 or "
                  "0.1:0.12:0.15,0.99",
            given->medium);
        return false;
    }
    if (given->height && !read_height(given->height, fog)) {
        cli_error(
            "--fog-height: '%s' is not SCALE[,BASE] in metres, such as 10 or 10,-2", given->height);
        return false;
    }
    return true;
}
