#include "view_hud.h"

#include "view_keys.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/// Frames that a message stays for.
#define MESSAGE_FRAMES 180
/// Share of a new frame in the running mean.
#define FRESH 0.1

static const cli_ink white = { 236, 240, 244, 1 }, gray = { 150, 160, 170, 1 },
                     panel = { 14, 17, 22, 0.72f }, accent = { 255, 190, 92, 1 },
                     trough = { 255, 255, 255, 0.08f };

/// Stages of a frame in the order of their bars.
static const struct stage {
    const char *name;
    cli_ink ink;
} stages[] = {
    { "light", { 255, 190, 92, 1 } },
    { "refresh", { 232, 122, 96, 1 } },
    { "camera", { 96, 170, 245, 1 } },
    { "paths", { 158, 130, 240, 1 } },
    { "gloss", { 240, 214, 110, 1 } },
    { "display", { 102, 204, 160, 1 } },
    { "picture", { 220, 110, 190, 1 } },
};
enum { stage_count = sizeof stages / sizeof stages[0] };

static void stage_times(const cli_view_timing *t, double ms[stage_count])
{
    ms[0] = t->light_ms, ms[1] = t->refresh_ms, ms[2] = t->camera_ms;
    ms[3] = t->path_ms, ms[4] = t->gloss_ms, ms[5] = t->display_ms, ms[6] = t->still_ms;
}

static void approach(double *mean, double value) { *mean += FRESH * (value - *mean); }

void cli_view_hud_note(cli_view_hud *hud, const cli_view_timing *timing)
{
    cli_view_timing mean = hud->frame ? hud->mean : *timing;
    hud->history[hud->frame++ % CLI_VIEW_HISTORY] = timing->total_ms;
    approach(&mean.light_ms, timing->light_ms);
    approach(&mean.refresh_ms, timing->refresh_ms);
    approach(&mean.camera_ms, timing->camera_ms);
    approach(&mean.path_ms, timing->path_ms);
    approach(&mean.gloss_ms, timing->gloss_ms);
    approach(&mean.display_ms, timing->display_ms);
    approach(&mean.still_ms, timing->still_ms);
    approach(&mean.total_ms, timing->total_ms);
    mean.path_rays = timing->path_rays;
    mean.samples = timing->samples;
    mean.coarseness = timing->coarseness;
    mean.eyes = timing->eyes;
    mean.residual = timing->residual;
    hud->mean = mean;
    hud->message_frames = hud->message[0] ? hud->message_frames + 1 : 0;
    if (hud->message_frames > MESSAGE_FRAMES) hud->message[0] = '\0';
}

// ---- a column of text ---------------------------------------------------------------------------------

/// Where the next line goes.
typedef struct text_column {
    cli_canvas *canvas;
    float x, y, width, size; ///< size of a capital
} text_column;

static float line_height(float size) { return roundf(2.1f * size); }

static float text_size(const cli_canvas *canvas)
{
    return fminf(fmaxf(roundf((float)canvas->height / 75), 7), 16);
}

/// Draws a panel for that many lines. @return its text column, inside the margins
static text_column open_panel(cli_canvas *canvas, float x, float y, float width, float lines)
{
    float size = text_size(canvas), margin = 1.4f * size;
    cli_draw_box(canvas, x, y, width, 2 * margin + lines * line_height(size) - size, panel);
    return (text_column){ canvas, x + margin, y + margin + size, width - 2 * margin, size };
}

static void write_pair(text_column *c, const char *left, const char *right, cli_ink ink)
{
    cli_draw_text(c->canvas, c->x, c->y, c->size, left, gray);
    cli_draw_text(
        c->canvas, c->x + c->width - cli_text_width(c->size, right), c->y, c->size, right, ink);
    c->y += line_height(c->size);
}

// ---- numbers --------------------------------------------------------------------------------------------

/// Frames per second in large letters, and the mode in small ones.
static void write_title(text_column *c, const cli_view_hud *hud, const cli_view_state *state)
{
    char text[CLI_VIEW_TEXT_LENGTH];
    double rate = hud->mean.total_ms > 0 ? 1e3 / hud->mean.total_ms : 0;
    float large = 1.9f * c->size;
    snprintf(text, sizeof text, "%.0f", rate);
    float end = cli_draw_text(c->canvas, c->x, c->y + 0.9f * c->size, large, text, white);
    cli_draw_text(c->canvas, end + 2, c->y + 0.9f * c->size, c->size, "frames/s", gray);
    snprintf(text, sizeof text, "%.1f ms", hud->mean.total_ms);
    cli_draw_text(c->canvas, c->x + c->width - cli_text_width(c->size, text), c->y + 0.9f * c->size,
        c->size, text, white);
    c->y += line_height(c->size) + 1.4f * c->size;
    snprintf(text, sizeof text, "%s", cli_view_mode_names[state->mode]);
    write_pair(c, hud->scene, text, accent);
}

static void draw_stage_bar(text_column *c, const double ms[stage_count], double total)
{
    float x = c->x, height = 0.8f * c->size, scale = c->width / fmaxf((float)total, 0.01f);
    cli_draw_box(c->canvas, c->x, c->y - height, c->width, height, trough);
    for (int k = 0; k < stage_count; k++) {
        float width = (float)ms[k] * scale;
        if (x + width > c->x + c->width) width = c->x + c->width - x;
        cli_draw_box(c->canvas, x, c->y - height, width, height, stages[k].ink);
        x += width;
    }
    c->y += line_height(c->size);
}

static void write_stages(text_column *c, const cli_view_timing *mean)
{
    double ms[stage_count];
    char text[CLI_VIEW_TEXT_LENGTH];
    stage_times(mean, ms);
    draw_stage_bar(c, ms, mean->total_ms);
    for (int k = 0; k < stage_count; k++) {
        cli_draw_box(
            c->canvas, c->x, c->y - 0.8f * c->size, 0.7f * c->size, 0.7f * c->size, stages[k].ink);
        cli_draw_text(c->canvas, c->x + 1.6f * c->size, c->y, c->size, stages[k].name, gray);
        snprintf(text, sizeof text, "%.2f", ms[k]);
        write_pair(c, "", text, white);
    }
}

static void draw_graph(text_column *c, const cli_view_hud *hud)
{
    float height = 4 * line_height(c->size) - c->size, bottom = c->y - c->size + height;
    float step = c->width / CLI_VIEW_HISTORY;
    float most = fmaxf(20, 2 * (float)hud->mean.total_ms); // longer bars are cut off
    uint32_t count = hud->frame < CLI_VIEW_HISTORY ? hud->frame : CLI_VIEW_HISTORY;
    cli_draw_box(c->canvas, c->x, c->y - c->size, c->width, height, trough);
    for (uint32_t k = 0; k < count; k++) {
        uint32_t at = (hud->frame - count + k) % CLI_VIEW_HISTORY;
        float ms = (float)hud->history[at], bar = height * fminf(ms / most, 1);
        cli_ink ink = ms <= 17 ? stages[4].ink : ms <= 34 ? accent : stages[1].ink;
        cli_draw_box(c->canvas, c->x + (float)k * step, bottom - bar, fmaxf(step - 1, 1), bar, ink);
    }
    const float lines[] = { 16.7f, 33.3f };
    for (int k = 0; k < 2; k++)
        if (lines[k] < most)
            cli_draw_box(c->canvas, c->x, bottom - height * lines[k] / most, c->width, 1,
                (cli_ink){ 255, 255, 255, 0.35f });
    c->y += height + 0.6f * c->size;
}

static void layer_text(const cli_view_state *state, char *text)
{
    uint32_t layer = state->layer;
    const char *name = layer == RSV_NONE ? "all light"
                       : layer == 0      ? "emission"
                       : layer == 1      ? "direct"
                                         : NULL;
    if (name)
        snprintf(text, CLI_VIEW_TEXT_LENGTH, "%s", name);
    else
        snprintf(text, CLI_VIEW_TEXT_LENGTH, "bounce %u%s", layer - 1,
            layer + 1 == state->layer_count ? " and on" : "");
}

/// Where the animation is, what is edited, and how far the light is behind it.
static void write_moment(text_column *c, const cli_view_hud *hud, const cli_view_state *state)
{
    char text[CLI_VIEW_TEXT_LENGTH];
    if (!(state->length > 0) && !hud->object[0]) return;
    snprintf(text, sizeof text, "%.2f of %.2f s", state->time, state->length);
    if (state->length > 0) write_pair(c, state->plays ? "playing" : "paused", text, white);
    if (hud->object[0]) write_pair(c, "object", hud->object, accent);
    double lag = hud->lag_ms > 0 ? hud->lag_ms + hud->mean.total_ms : 0;
    snprintf(text, sizeof text, lag > 0 ? "%.0f ms behind" : "at rest", lag);
    write_pair(c, "moving light", text, lag > 0 ? accent : white);
}

static void write_facts(text_column *c, const cli_view_hud *hud, const cli_view_state *state)
{
    char text[CLI_VIEW_TEXT_LENGTH];
    layer_text(state, text);
    write_pair(c, "layer", text, white);
    snprintf(
        text, sizeof text, "%+.2f, %s", (double)state->exposure, state->soft ? "soft" : "clip");
    write_pair(c, "exposure", text, white);
    snprintf(text, sizeof text, "%u", hud->mean.samples);
    write_pair(c, "samples", text, white);
    bool coarse = hud->mean.coarseness > 1;
    snprintf(text, sizeof text, coarse ? "1/%u while moving" : "full", hud->mean.coarseness);
    write_pair(c, "resolution", text, coarse ? accent : white);
    if (hud->mean.residual > 0)
        snprintf(text, sizeof text, "%.1e left", hud->mean.residual);
    else
        snprintf(text, sizeof text, "exact");
    write_pair(c, "light", text, hud->mean.residual > 0 ? accent : white);
    write_moment(c, hud, state);
    write_pair(c, "quality", hud->quality ? hud->quality : "", hud->making[0] ? accent : white);
    cli_draw_text(c->canvas, c->x, c->y, c->size, hud->making, accent);
    c->y += line_height(c->size);
    snprintf(text, sizeof text, "%.2f ms", hud->mean.total_ms / fmax(hud->mean.eyes, 1));
    if (hud->mean.eyes > 1) write_pair(c, "each eye", text, white);
}

static void draw_numbers(const cli_view_hud *hud, const cli_view_state *state, cli_canvas *canvas)
{
    float size = text_size(canvas), width = 27 * size;
    float lines =
        20.6f + (hud->mean.eyes > 1) + (hud->reading[0] != 0) + (state->length > 0 ? 2 : 0);
    text_column c = open_panel(canvas, size, size, width, lines);
    write_title(&c, hud, state);
    write_stages(&c, &hud->mean);
    draw_graph(&c, hud);
    write_facts(&c, hud, state);
    if (hud->reading[0]) write_pair(&c, "under the mouse", hud->reading, white);
}

// ---- things that can be changed ---------------------------------------------------------------------------

static cli_ink ink_of(rsv_rgb color)
{
    return (cli_ink){ (uint8_t)(255 * sqrtf(fminf(color.r, 1)) + 0.5f),
        (uint8_t)(255 * sqrtf(fminf(color.g, 1)) + 0.5f),
        (uint8_t)(255 * sqrtf(fminf(color.b, 1)) + 0.5f), 1 };
}

/// Its own color, under the factors that it was given.
static rsv_rgb shown_color(const cli_view_item *item)
{
    rsv_rgb c = item->color, g = item->glow;
    return item->kind == CLI_VIEW_MATERIAL ? c : (rsv_rgb){ c.r * g.r, c.g * g.g, c.b * g.b };
}

static void value_text(const cli_view_state *state, const cli_view_item *item, char *text)
{
    const rsv_rgb *c = &item->color;
    if (item->kind == CLI_VIEW_MATERIAL)
        snprintf(
            text, CLI_VIEW_TEXT_LENGTH, "%.2f %.2f %.2f", (double)c->r, (double)c->g, (double)c->b);
    else if (item->kind == CLI_VIEW_ENVIRONMENT)
        snprintf(text, CLI_VIEW_TEXT_LENGTH, "x %.2f, %.0f deg", (double)item->scale,
            (double)state->env_rotation);
    else if (item->kind == CLI_VIEW_OBJECT)
        snprintf(text, CLI_VIEW_TEXT_LENGTH, "%.2f %.2f %.2f m", (double)item->offset.x,
            (double)item->offset.y, (double)item->offset.z);
    else
        snprintf(text, CLI_VIEW_TEXT_LENGTH, "x %.2f", (double)item->scale);
}

static void write_item(text_column *c, const cli_view_state *state, size_t index)
{
    char name[CLI_VIEW_TEXT_LENGTH], value[CLI_VIEW_TEXT_LENGTH];
    const cli_view_item *item = &state->item[index];
    bool selected = index == state->selected;
    float size = c->size, line = line_height(size);
    cli_view_item_name(item, name);
    if (strlen(name) > 22) memcpy(name + 20, "..", 3);
    value_text(state, item, value);
    if (selected)
        cli_draw_box(c->canvas, c->x - 0.7f * size, c->y - 1.5f * size, c->width + 1.4f * size,
            line, (cli_ink){ 255, 190, 92, 0.22f });
    cli_draw_box(c->canvas, c->x, c->y - size, size, size, ink_of(shown_color(item)));
    cli_draw_text(c->canvas, c->x + 1.8f * size, c->y, size, name, selected ? white : gray);
    write_pair(c, "", value, selected ? accent : white);
}

/// The items around the one selected, as many as there is room for.
static void draw_items(const cli_view_state *state, cli_canvas *canvas)
{
    float size = text_size(canvas), width = 31 * size;
    size_t most = (size_t)fmaxf(((float)canvas->height / line_height(size) - 4) / 2, 1);
    size_t count = state->item_count < most ? state->item_count : most, first = 0;
    if (count == 0) return;
    if (state->selected < state->item_count && state->selected >= count)
        first = state->selected - count + 1;
    text_column c =
        open_panel(canvas, (float)canvas->width - width - size, size, width, (float)count);
    for (size_t k = first; k < first + count; k++)
        write_item(&c, state, k);
}

static void draw_markers(const cli_view_state *state, cli_canvas *canvas)
{
    float size = text_size(canvas);
    for (size_t k = 0; k < state->item_count; k++) {
        const cli_view_item *item = &state->item[k];
        float place[2];
        if (!(cli_view_place(state, item, place) > 0)) continue;
        float x = place[0] * (float)canvas->width, y = place[1] * (float)canvas->height;
        bool selected = k == state->selected;
        cli_draw_ring(canvas, x, y, size, 1.6f, (cli_ink){ 0, 0, 0, 0.5f });
        cli_draw_ring(canvas, x, y, size, 0.8f, selected ? accent : white);
        cli_draw_ring(canvas, x, y, 0.25f * size, 0.25f * size, ink_of(shown_color(item)));
        if (selected)
            cli_draw_text(canvas, x + 1.6f * size, y + 0.5f * size, size, item->name, accent);
    }
}

// ---- help ---------------------------------------------------------------------------------------------------

static void draw_help(cli_canvas *canvas)
{
    size_t lines = 0;
    for (size_t k = 0; k < cli_view_key_count; k++)
        lines += cli_view_keys[k].help != NULL;
    float size = text_size(canvas), width = fminf(52 * size, (float)canvas->width);
    float height = ((float)lines + 2) * line_height(size);
    float x = 0.5f * ((float)canvas->width - width), y = 0.5f * ((float)canvas->height - height);
    cli_draw_box(
        canvas, 0, 0, (float)canvas->width, (float)canvas->height, (cli_ink){ 0, 0, 0, 0.35f });
    text_column c = open_panel(canvas, x, fmaxf(y, 0), width, (float)lines + 1.4f);
    cli_draw_text(canvas, c.x, c.y, 1.2f * size, "Keys and mouse", accent);
    c.y += 1.4f * line_height(size);
    for (size_t k = 0; k < cli_view_key_count; k++) {
        if (!cli_view_keys[k].help) continue;
        cli_draw_text(canvas, c.x, c.y, size, cli_view_keys[k].key, white);
        cli_draw_text(canvas, c.x + 14 * size, c.y, size, cli_view_keys[k].help, gray);
        c.y += line_height(size);
    }
}

static void draw_footer(const cli_view_hud *hud, cli_canvas *canvas)
{
    float size = text_size(canvas), margin = 1.4f * size, height = line_height(size) + size;
    const char *text = hud->message[0] ? hud->message : "F1 help";
    float width = cli_text_width(size, text) + 2 * margin,
          y = (float)canvas->height - height - size;
    cli_draw_box(canvas, size, y, width, height, panel);
    cli_draw_text(canvas, size + margin, y + 0.5f * (height + size), size, text,
        hud->message[0] ? accent : gray);
}

void cli_view_hud_draw(const cli_view_hud *hud, const cli_view_state *state, cli_canvas *canvas)
{
    if (state->markers && hud->mean.eyes == 1) draw_markers(state, canvas);
    if (state->hud) {
        draw_numbers(hud, state, canvas);
        draw_items(state, canvas);
        draw_footer(hud, canvas);
    }
    if (state->help) draw_help(canvas);
}
