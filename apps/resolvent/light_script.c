#include "light_script.h"

#include "session.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// Where a line comes from, for messages.
typedef struct script_line {
    const char *path;
    size_t number;
} script_line;

static bool complain(const script_line *line, const char *problem, const char *detail)
{
    cli_error("%s:%zu: %s%s", line->path, line->number, problem, detail);
    return false;
}

size_t cli_cut_change(char *text, float number[4])
{
    size_t count = 0;
    char *next = strrchr(text, '=');
    if (!next || next == text) return 0;
    *next++ = '\0';
    for (;;) {
        char *end;
        number[count++] = strtof(next, &end);
        if (end == next || !isfinite(number[count - 1]) || (*end && *end != ',')) return 0;
        if (!*end) return count;
        if (count == 4) return 0;
        next = end + 1;
    }
}

bool cli_light_scale(const float *number, size_t count, rsv_rgb *scale)
{
    const rsv_rgb one = { number[0], number[0], number[0] };
    if (count == 1)
        *scale = one;
    else if (count == 3)
        *scale = (rsv_rgb){ number[0], number[1], number[2] };
    else if (count == 4)
        *scale = (rsv_rgb){ number[0] * number[1], number[0] * number[2], number[0] * number[3] };
    return count == 1 || count == 3 || count == 4;
}

/// The next word, or the text between double quotes; NULL at the end.
static char *cut_word(char **rest)
{
    char *word = *rest + strspn(*rest, " \t\r\n");
    if (!*word || *word == '#') return NULL;
    bool quoted = *word == '"';
    word += quoted;
    char *end = word + strcspn(word, quoted ? "\"" : " \t\r\n");
    *rest = *end ? end + 1 : end;
    *end = '\0';
    return word;
}

/// Kind and name of "light.NAME" and the like. @return its numbers' count; 0 = unknown
static size_t identify(const char *target, cli_track_kind *kind, const char **name)
{
    static const struct {
        const char *prefix;
        cli_track_kind kind;
        size_t values;
    } known[] = { { "light.", CLI_TRACK_LIGHT, 4 }, { "albedo.", CLI_TRACK_ALBEDO, 3 },
        { "move.", CLI_TRACK_MOVE, 3 }, { "aim.", CLI_TRACK_AIM, 3 },
        { "place.", CLI_TRACK_PLACE, 3 }, { "env-intensity", CLI_TRACK_INTENSITY, 1 },
        { "env-rotate", CLI_TRACK_ROTATION, 1 } };
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
        size_t length = strlen(known[k].prefix);
        bool named = known[k].values > 1;
        if (strncmp(target, known[k].prefix, length) != 0) continue;
        if (named ? !target[length] : target[length]) continue;
        if (known[k].kind == CLI_TRACK_PLACE && strcmp(target + length, "object") != 0) continue;
        *kind = known[k].kind;
        *name = target + length;
        return known[k].values;
    }
    return 0;
}

static cli_track *find_track(cli_light_script *script, cli_track_kind kind, const char *name)
{
    for (size_t k = 0; k < script->track_count; k++)
        if (script->track[k].kind == kind && strcmp(script->track[k].name, name) == 0)
            return &script->track[k];
    if (script->track_count == CLI_MAX_TRACKS) return NULL;
    cli_track *track = &script->track[script->track_count];
    *track = (cli_track){ .kind = kind, .name = strdup(name) };
    if (!track->name) return NULL;
    script->track_count++;
    return track;
}

static bool add_key(const script_line *line, cli_track *track, cli_key key)
{
    if (track->key_count > 0 && track->key[track->key_count - 1].frame >= key.frame)
        return complain(line, "frames must increase", "");
    cli_key *grown = realloc(track->key, (track->key_count + 1) * sizeof key);
    if (!grown) return complain(line, "out of memory", "");
    track->key = grown;
    track->key[track->key_count++] = key;
    return true;
}

static bool read_change(
    const script_line *line, uint32_t frame, char *word, cli_light_script *script)
{
    float number[4] = { 0 };
    const char *name;
    cli_track_kind kind;
    size_t count = cli_cut_change(word, number), wanted = identify(word, &kind, &name);
    if (wanted == 0)
        return complain(line,
            "expected light.NAME=, move.NAME=, aim.NAME=, albedo.MATERIAL=, place.object=, "
            "env-rotate= or "
            "env-intensity= instead of ",
            word);
    cli_key key = { frame, { number[0], number[1], number[2] } };
    rsv_rgb scale;
    bool fits = kind == CLI_TRACK_LIGHT ? cli_light_scale(number, count, &scale) : count == wanted;
    if (!fits) return complain(line, "wrong number or range of values in ", word);
    if (kind == CLI_TRACK_LIGHT) key = (cli_key){ frame, { scale.r, scale.g, scale.b } };
    cli_track *track = find_track(script, kind, name);
    if (!track) return complain(line, "too many lights and materials", "");
    return add_key(line, track, key);
}

static bool read_line(const script_line *line, char *text, cli_light_script *script)
{
    char *rest = text, *end, *word = cut_word(&rest);
    if (!word) return true;
    unsigned long frame = strtoul(word, &end, 10);
    if (*end || word[0] == '-' || frame > CLI_MAX_FRAME)
        return complain(line, "expected a frame number instead of ", word);
    if (script->track_count == 0) script->first = (uint32_t)frame;
    while ((word = cut_word(&rest)))
        if (!read_change(line, (uint32_t)frame, word, script)) return false;
    if (frame < script->last) return complain(line, "frames must increase", "");
    script->last = (uint32_t)frame;
    return true;
}

bool cli_read_light_script(const char *path, cli_light_script *script)
{
    *script = (cli_light_script){ .track_count = 0 };
    FILE *file = fopen(path, "r");
    if (!file) {
        cli_error("%s: cannot be read: %s", path, strerror(errno));
        return false;
    }
    script_line line = { path, 0 };
    char *text = NULL;
    size_t capacity = 0;
    bool good = true;
    while (good && getline(&text, &capacity, file) > 0) {
        line.number++;
        good = read_line(&line, text, script);
    }
    if (ferror(file)) { // a folder
        cli_error("%s: cannot be read: %s", path, strerror(errno));
        good = false;
    }
    free(text);
    fclose(file);
    return good && (script->track_count > 0 || complain(&line, "the script changes nothing", ""));
}

void cli_free_light_script(cli_light_script *script)
{
    for (size_t k = 0; k < script->track_count; k++) {
        free(script->track[k].name);
        free(script->track[k].key);
    }
    script->track_count = 0;
}

void cli_track_at(const cli_track *track, uint32_t frame, float value[3])
{
    size_t next = 0;
    while (next < track->key_count && track->key[next].frame <= frame)
        next++;
    const cli_key *to = &track->key[next < track->key_count ? next : next - 1];
    const cli_key *from = next > 0 ? &track->key[next - 1] : to;
    float way = to->frame > from->frame
                    ? (float)(frame - from->frame) / (float)(to->frame - from->frame)
                    : 0;
    for (int c = 0; c < 3; c++)
        value[c] = (1 - way) * from->value[c] + way * to->value[c];
}
