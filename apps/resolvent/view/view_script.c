#include "view_script.h"

#include "../session.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// Parses "12" or "12-40". @return the text after it, or NULL
static const char *read_frames(const char *text, cli_view_script_line *line)
{
    char *end;
    unsigned long first = strtoul(text, &end, 10), last = first;
    if (end == text) return NULL;
    if (*end == '-') {
        const char *start = end + 1;
        last = strtoul(start, &end, 10);
        if (end == start || *start == '-') return NULL;
    }
    bool good = (*end == ' ' || *end == '\t') && first <= last && last <= CLI_VIEW_MOST_FRAMES;
    line->first = (uint32_t)first;
    line->last = (uint32_t)last;
    return good ? end : NULL;
}

static bool read_line(const char *text, cli_view_script_line *line, char *problem)
{
    const char *rest = *text == '-' ? NULL : read_frames(text, line);
    if (rest) return cli_read_view_command(rest, &line->command, problem);
    snprintf(problem, CLI_VIEW_TEXT_LENGTH, "expected FRAME or FIRST-LAST, up to %d, and a command",
        CLI_VIEW_MOST_FRAMES);
    return false;
}

static bool add_line(cli_view_script *script, const cli_view_script_line *line)
{
    size_t count = script->line_count;
    if ((count & (count - 1)) == 0) { // at powers of two
        cli_view_script_line *grown =
            realloc(script->line, (count ? 2 * count : 1) * sizeof *grown);
        if (!grown) return false;
        script->line = grown;
    }
    script->line[script->line_count++] = *line;
    return true;
}

bool cli_read_view_script(const char *path, cli_view_script *script)
{
    *script = (cli_view_script){ .path = path };
    FILE *file = fopen(path, "r");
    if (!file) {
        cli_error("%s: cannot be read: %s", path, strerror(errno));
        return false;
    }
    cli_view_script_line line = { .number = 0 };
    char *text = NULL, problem[CLI_VIEW_TEXT_LENGTH] = "out of memory";
    size_t capacity = 0;
    bool good = true;
    while (good && getline(&text, &capacity, file) > 0) {
        const char *start = text + strspn(text, " \t\r\n");
        line.number++;
        if (*start && *start != '#')
            good = read_line(start, &line, problem) && add_line(script, &line);
    }
    if (!good) cli_error("%s:%zu: %s", path, line.number, problem);
    if (ferror(file)) { // a folder
        cli_error("%s: cannot be read: %s", path, strerror(errno));
        good = false;
    }
    free(text);
    fclose(file);
    return good;
}

void cli_free_view_script(cli_view_script *script)
{
    free(script->line);
    *script = (cli_view_script){ 0 };
}

uint32_t cli_view_script_length(const cli_view_script *script)
{
    uint32_t frames = 0;
    for (size_t k = 0; k < script->line_count; k++)
        if (script->line[k].last >= frames) frames = script->line[k].last + 1;
    return frames;
}

bool cli_view_script_needs_light(const cli_view_script *script)
{
    for (size_t k = 0; k < script->line_count; k++)
        if (cli_view_needs_light(script->line[k].command.verb)) return true;
    return false;
}
