#include "view_command.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// Arguments: t = a word, n = a number.
typedef struct word {
    const char *name;
    cli_view_verb verb;
    const char *arguments;
} word;

static const word words[] = {
    { "add", CLI_VIEW_ADD, "tnnn" },
    { "albedo", CLI_VIEW_ALBEDO, "tnnn" },
    { "brighten", CLI_VIEW_BRIGHTEN, "n" },
    { "camera", CLI_VIEW_CAMERA, "t" },
    { "color", CLI_VIEW_COLOR, "nnn" },
    { "delete", CLI_VIEW_DELETE, "" },
    { "dolly", CLI_VIEW_DOLLY, "n" },
    { "drag", CLI_VIEW_DRAG, "nn" },
    { "duplicate", CLI_VIEW_DUPLICATE, "" },
    { "env-rotate", CLI_VIEW_ENV_ROTATE, "n" },
    { "expose", CLI_VIEW_EXPOSE, "n" },
    { "exposure", CLI_VIEW_EXPOSURE, "n" },
    { "fly", CLI_VIEW_FLY, "nnn" },
    { "grasp", CLI_VIEW_GRASP, "nn" },
    { "haul", CLI_VIEW_HAUL, "nn" },
    { "hide", CLI_VIEW_HIDE, "" },
    { "intensity", CLI_VIEW_INTENSITY, "n" },
    { "layer", CLI_VIEW_LAYER, "t" },
    { "look", CLI_VIEW_LOOK, "nn" },
    { "mode", CLI_VIEW_MODE, "t" },
    { "move", CLI_VIEW_MOVE, "nnn" },
    { "nudge", CLI_VIEW_NUDGE, "nnn" },
    { "object", CLI_VIEW_CHOOSE, "t" },
    { "orbit", CLI_VIEW_ORBIT, "nn" },
    { "paint", CLI_VIEW_PAINT, "nnn" },
    { "panorama", CLI_VIEW_PANORAMA, "t" },
    { "pause", CLI_VIEW_PAUSE, "" },
    { "pick", CLI_VIEW_PICK, "nn" },
    { "place", CLI_VIEW_PLACE, "nnnn" },
    { "play", CLI_VIEW_PLAY, "" },
    { "point", CLI_VIEW_POINT, "nn" },
    { "quit", CLI_VIEW_QUIT, "" },
    { "release", CLI_VIEW_RELEASE, "" },
    { "reset", CLI_VIEW_RESET, "" },
    { "resize", CLI_VIEW_RESIZE, "n" },
    { "save", CLI_VIEW_SAVE, "t" },
    { "screenshot", CLI_VIEW_SCREENSHOT, "t" },
    { "scrub", CLI_VIEW_SCRUB, "n" },
    { "select", CLI_VIEW_SELECT, "t" },
    { "separation", CLI_VIEW_SEPARATION, "n" },
    { "shift", CLI_VIEW_SHIFT, "nnn" },
    { "show", CLI_VIEW_SHOW, "t" },
    { "speed", CLI_VIEW_SPEED, "n" },
    { "spin", CLI_VIEW_SPIN, "n" },
    { "step", CLI_VIEW_STEP, "n" },
    { "surface", CLI_VIEW_SURFACE, "nn" },
    { "tint", CLI_VIEW_TINT, "nnn" },
    { "tone", CLI_VIEW_TONE, "t" },
    { "turn", CLI_VIEW_TURN, "n" },
    { "undo", CLI_VIEW_UNDO, "" },
};

static const word *find_word(const char *name)
{
    for (size_t k = 0; k < sizeof words / sizeof words[0]; k++)
        if (strcmp(words[k].name, name) == 0) return &words[k];
    return NULL;
}

/// Copies the next word, or the text between double quotes, to `token`; false at the end.
static bool cut(const char **rest, char *token)
{
    const char *start = *rest + strspn(*rest, " \t\r\n");
    if (!*start || *start == '#') return false;
    bool quoted = *start == '"';
    start += quoted;
    size_t length = strcspn(start, quoted ? "\"" : " \t\r\n");
    *rest = start + length + (quoted && start[length] == '"');
    if (length >= CLI_VIEW_TEXT_LENGTH) length = CLI_VIEW_TEXT_LENGTH - 1;
    memcpy(token, start, length);
    token[length] = '\0';
    return true;
}

/// @param most of its size
static bool read_number(const char *token, double most, double *number)
{
    char *end;
    *number = strtod(token, &end);
    return end != token && !*end && fabs(*number) <= most;
}

static bool complain(char *problem, const char *format, const char *a, const char *b)
{
    snprintf(problem, CLI_VIEW_TEXT_LENGTH, format, a, b);
    return false;
}

static bool read_arguments(
    const word *known, const char *rest, cli_view_command *command, char *problem)
{
    char token[CLI_VIEW_TEXT_LENGTH];
    size_t numbers = 0;
    const double most = known->verb == CLI_VIEW_ADD ? 1e9 : 1e6; // places may lie on a map
    for (const char *kind = known->arguments; *kind; kind++) {
        if (!cut(&rest, token))
            return complain(
                problem, "'%s' needs %s more", known->name, *kind == 'n' ? "a number" : "a word");
        if (*kind == 't')
            memcpy(command->text, token, sizeof token);
        else if (!read_number(token, most, &command->exact[numbers]))
            return complain(problem,
                most > 1e6 ? "'%s': '%.60s' is not a number from -1e9 to 1e9"
                           : "'%s': '%.60s' is not a number from -1e6 to 1e6",
                known->name, token);
        else
            numbers++;
    }
    for (size_t k = 0; k < numbers; k++)
        command->number[k] = (float)command->exact[k];
    return !cut(&rest, token) ||
           complain(problem, "'%s': '%.60s' is one word too many", known->name, token);
}

bool cli_read_view_command(const char *line, cli_view_command *command, char *problem)
{
    char name[CLI_VIEW_TEXT_LENGTH];
    *command = (cli_view_command){ .number = { 0 } };
    if (!cut(&line, name)) return complain(problem, "a command is missing%s%s", "", "");
    const word *known = find_word(name);
    if (!known)
        return complain(problem,
            "'%.60s' is not a command; `resolvent view --help all` lists them%s", name, "");
    command->verb = known->verb;
    return read_arguments(known, line, command, problem);
}

bool cli_view_edits(cli_view_verb verb)
{
    switch (verb) {
    case CLI_VIEW_DELETE:
    case CLI_VIEW_DUPLICATE:
    case CLI_VIEW_GRASP:
    case CLI_VIEW_HAUL:
    case CLI_VIEW_HIDE:
    case CLI_VIEW_CHOOSE:
    case CLI_VIEW_PAINT:
    case CLI_VIEW_RESIZE:
    case CLI_VIEW_SAVE:
    case CLI_VIEW_SHIFT:
    case CLI_VIEW_SPIN:
    case CLI_VIEW_SURFACE:
    case CLI_VIEW_UNDO:
        return true;
    default:
        return false;
    }
}

bool cli_view_needs_light(cli_view_verb verb)
{
    if (cli_view_edits(verb)) return true;
    switch (verb) {
    case CLI_VIEW_ADD:
    case CLI_VIEW_ALBEDO:
    case CLI_VIEW_BRIGHTEN:
    case CLI_VIEW_COLOR:
    case CLI_VIEW_ENV_ROTATE:
    case CLI_VIEW_INTENSITY:
    case CLI_VIEW_LAYER:
    case CLI_VIEW_MODE:
    case CLI_VIEW_MOVE:
    case CLI_VIEW_NUDGE:
    case CLI_VIEW_PANORAMA:
    case CLI_VIEW_PAUSE:
    case CLI_VIEW_PLAY:
    case CLI_VIEW_SCREENSHOT:
    case CLI_VIEW_SCRUB:
    case CLI_VIEW_SELECT:
    case CLI_VIEW_STEP:
    case CLI_VIEW_TINT:
    case CLI_VIEW_TURN:
        return true;
    default:
        return false;
    }
}
