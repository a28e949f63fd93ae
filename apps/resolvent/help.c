/// A help text has a usage line and a description, then options ("  --name ..."), further sections, and
/// "examples:". The first screen is cut from it, so there is only one text to maintain.
#include "help.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

enum { MOST_EXAMPLES = 3, NAME_LENGTH = 32 };

static const cli_option *find_option(const cli_usage *usage, const char *name)
{
    for (const cli_option *option = usage->options; option->name; option++)
        if (strcmp(option->name, name) == 0) return option;
    return NULL;
}

static void print_choices(const cli_usage *usage, const char *name)
{
    const cli_option *option = find_option(usage, name);
    assert(option && option->choices);
    for (size_t k = 0; option && option->choices[k]; k++)
        printf("%s%s", k ? ", " : "", option->choices[k]);
}

static void print_text(const cli_usage *usage, const char *text, const char *end)
{
    const char *brace;
    while ((brace = strstr(text, "{--")) && brace < end) {
        char name[NAME_LENGTH];
        snprintf(name, sizeof name, "%.*s", (int)strcspn(brace + 1, "}"), brace + 1);
        fwrite(text, 1, (size_t)(brace - text), stdout);
        print_choices(usage, name);
        text = strchr(brace, '}') + 1;
    }
    fwrite(text, 1, (size_t)(end - text), stdout);
}

static const char *next_line(const char *line)
{
    const char *end = strchr(line, '\n');
    return end ? end + 1 : line + strlen(line);
}

static bool begins_with(const char *line, const char *word)
{
    return strncmp(line, word, strlen(word)) == 0;
}

/// "examples:" and the first of them; one may take several lines.
static void print_examples(const cli_usage *usage, const char *examples)
{
    const char *line = next_line(examples);
    for (unsigned count = 0; *line; line = next_line(line))
        if (begins_with(line, "  resolvent ") && ++count > MOST_EXAMPLES) break;
    print_text(usage, examples, line);
}

/// Whether the option that a line explains is one of `common`.
static bool is_common(const char *common, const char *line)
{
    const char *name = line + strspn(line, " ");
    size_t length = strcspn(name, " \n");
    for (const char *word = common; *word; word += strspn(word, " ")) {
        size_t own = strcspn(word, " ");
        if (own == length && strncmp(word, name, length) == 0) return true;
        word += own;
    }
    return false;
}

static void print_common_options(const cli_usage *usage, const char *options, const char *end)
{
    bool shown = false;
    for (const char *line = options; line < end; line = next_line(line)) {
        if (begins_with(line, "  -"))
            shown = is_common(usage->common, line);
        else if (!begins_with(line, "   "))
            shown = false;
        if (shown) print_text(usage, line, next_line(line));
    }
}

void cli_print_help(const cli_usage *usage, bool all)
{
    const char *text = usage->help, *options = strstr(text, "\n  -"),
               *examples = strstr(text, "\nexamples:");
    assert(options && examples);
    if (all || !usage->common || !options || !examples) {
        print_text(usage, text, text + strlen(text));
        return;
    }
    print_text(usage, text, ++options);
    print_examples(usage, ++examples);
    printf("\ncommon options:\n");
    print_common_options(usage, options, examples);
    printf("\n`resolvent %s --help all` lists all options.\n", usage->command);
}
