#include "moment.h"

#include "command.h"
#include "options.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { most_frames = 1000000 };
enum { SHUTTER_MOMENTS = 8 };

/// Parses a frame number of digits only. @param end out: the text after it
static bool read_frame(const char *text, uint32_t *frame, const char **end)
{
    char *stop;
    unsigned long value = strtoul(text, &stop, 10);
    *end = stop;
    *frame = (uint32_t)value;
    return *text >= '0' && *text <= '9' && value < most_frames;
}

bool cli_read_sequence(const char *command, cli_sequence *s)
{
    const char *end;
    bool good = read_frame(s->frames, &s->first, &end);
    s->last = s->first;
    if (good && *end == '-') good = read_frame(end + 1, &s->last, &end);
    if (good && !*end && s->first <= s->last) return true;
    cli_usage_error(command,
        "--frames: '%s' is not A-B, such as 0-47: the first frame and the last, below %d",
        s->frames, most_frames);
    return false;
}

uint32_t cli_moments_of_frame(const cli_sequence *s)
{
    return s->shutter > 0 ? SHUTTER_MOMENTS : 1;
}

float cli_frame_time(const cli_sequence *s, uint32_t frame, uint32_t moment)
{
    double open = s->shutter > 0 ? (double)s->shutter * (moment + 0.5) / SHUTTER_MOMENTS : 0;
    return (float)((frame + open) / (double)s->fps);
}

/// Prints which clip is played, if there are several and none was chosen.
static void note_choice(cli_session *session)
{
    char text[256];
    const rsv_animation *a = session->animation;
    size_t count = rsv_animation_clip_count(a);
    if (count < 2) return;
    snprintf(text, sizeof text, "%zu animations: '%.100s' is played; choose another with --clip",
        count, rsv_animation_clip(a, 0)->name);
    cli_note(session, text);
}

/// @return false, after an error message, on failure
static bool find_clip(cli_session *session, const char *path, uint32_t *clip)
{
    const char *name = session->moment.clip;
    *clip = 0;
    if (!rsv_animation_clip_count(session->animation)) {
        cli_error("%s: it holds no animation: leave out --time and --frames", path);
        return false;
    }
    if (!name) note_choice(session);
    if (name) *clip = rsv_animation_find_clip(session->animation, name);
    if (*clip != RSV_NONE || strcmp(name, "all") == 0) return true;
    cli_error("--clip: %s has no animation '%s'; `resolvent info %s` lists them", path, name, path);
    return false;
}

bool cli_load_moment(cli_session *session, const char *path, rsv_scene **scene)
{
    uint32_t clip;
    rsv_status status = RSV_OK;
    const rsv_load_desc load = cli_describe_load(session);
    if (!session->animation)
        status = rsv_animation_open(session->context, path, &load, &session->animation);
    if (status == RSV_OK && !find_clip(session, path, &clip)) return false;
    if (status == RSV_OK)
        status = rsv_animation_scene(session->animation, clip, (double)session->moment.time, scene);
    if (status != RSV_OK) cli_report_failure(session, status);
    return status == RSV_OK;
}
