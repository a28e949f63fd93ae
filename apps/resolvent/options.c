#include "options.h"

#include "command.h"
#include "crew.h"
#include "help.h"
#include "near_name.h"

#include <assert.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// A bit of `given` for each.
#define MOST_OPTIONS 64
/// The limit of rsv_image_create.
#define MOST_PIXELS (1u << 28)

int cli_usage_error(const char *command, const char *format, ...)
{
    va_list arguments;
    if (!cli_crew_speaks()) return CLI_BAD_USAGE;
    va_start(arguments, format);
    fputs("error: ", stderr);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fprintf(stderr, "; see `resolvent %s%s--help`\n", command ? command : "", command ? " " : "");
    return CLI_BAD_USAGE;
}

/// A decimal number that fills all of `text`. The program never calls setlocale, so the decimal
/// separator is a point everywhere.
static bool read_number(const char *text, double *number)
{
    char *end;
    *number = strtod(text, &end);
    return end != text && *end == '\0' && isfinite(*number);
}

static bool read_count(const char *text, const cli_option *option, uint32_t *count)
{
    double number;
    if (*text < '0' || *text > '9' || !read_number(text, &number)) return false;
    if (number != floor(number) || number < option->min || number > option->max) return false;
    *count = (uint32_t)number;
    return true;
}

static bool read_size(const char *text, const cli_option *option, cli_size *size)
{
    char width[16];
    const char *separator = strchr(text, 'x');
    if (!separator || (size_t)(separator - text) >= sizeof width) return false;
    memcpy(width, text, (size_t)(separator - text));
    width[separator - text] = '\0';
    return read_count(width, option, &size->width) &&
           read_count(separator + 1, option, &size->height) &&
           (uint64_t)size->width * size->height <= MOST_PIXELS;
}

/// "640x480", or "256" for 256x256.
static bool read_sides(const char *text, const cli_option *option, cli_size *size)
{
    if (strchr(text, 'x')) return read_size(text, option, size);
    if (!read_count(text, option, &size->width)) return false;
    size->height = size->width;
    return (uint64_t)size->width * size->height <= MOST_PIXELS;
}

static bool read_choice(const char *text, const cli_option *option, int *choice)
{
    for (int i = 0; option->choices[i]; i++)
        if (strcmp(option->choices[i], text) == 0) {
            *choice = i;
            return true;
        }
    return false;
}

static bool read_real(const char *text, const cli_option *option, float *real)
{
    double number;
    if (!read_number(text, &number) || number < option->min || number > option->max) return false;
    *real = (float)number;
    return true;
}

/// "1%" or "0.01".
static bool read_share(const char *text, const cli_option *option, float *share)
{
    char number[32];
    size_t length = strlen(text);
    if (length == 0 || length >= sizeof number) return false;
    bool percent = text[length - 1] == '%';
    memcpy(number, text, length + 1);
    if (percent) number[length - 1] = '\0';
    double value;
    if (!read_number(number, &value)) return false;
    if (percent) value /= 100;
    if (value < option->min || value > option->max) return false;
    *share = (float)value;
    return true;
}

/// A positive number with a unit; without one it would be anybody's guess.
static bool read_bytes(const char *text, size_t *bytes)
{
    static const struct {
        const char *name;
        double bytes;
    } unit[] = { { "KiB", 1024.0 }, { "MiB", 1048576.0 }, { "GiB", 1073741824.0 },
        { "TiB", 1099511627776.0 }, { "KB", 1e3 }, { "MB", 1e6 }, { "GB", 1e9 }, { "TB", 1e12 } };
    char *end;
    double number = strtod(text, &end);
    if (end == text || !(number > 0) || *text == '+') return false;
    for (size_t k = 0; k < sizeof unit / sizeof *unit; k++) {
        if (strcmp(end, unit[k].name) != 0 || number * unit[k].bytes > 1e18) continue;
        *bytes = (size_t)(number * unit[k].bytes);
        return *bytes > 0;
    }
    return false;
}

static bool append(cli_list *list, const char *text)
{
    if (list->count == CLI_LIST_CAPACITY) return false;
    list->item[list->count++] = text;
    return true;
}

static bool store_value(const cli_option *option, const char *text)
{
    switch (option->kind) {
    case CLI_FLAG:
        *(bool *)option->value = true;
        return true;
    case CLI_TEXT:
        *(const char **)option->value = text;
        return *text != '\0';
    case CLI_LIST:
        return *text != '\0' && append(option->value, text);
    case CLI_COUNT:
        return read_count(text, option, option->value);
    case CLI_REAL:
        return read_real(text, option, option->value);
    case CLI_SHARE:
        return read_share(text, option, option->value);
    case CLI_CHOICE:
        return read_choice(text, option, option->value);
    case CLI_BYTES:
        return read_bytes(text, option->value);
    case CLI_SIZE:
        return read_size(text, option, option->value);
    case CLI_SIDES:
        return read_sides(text, option, option->value);
    }
    return false;
}

static int report_bad_value(const cli_usage *usage, const cli_option *option, const char *text)
{
    char expected[160] = "a name";
    switch (option->kind) {
    case CLI_LIST:
        snprintf(expected, sizeof expected, "a name, given at most %d times", CLI_LIST_CAPACITY);
        break;
    case CLI_COUNT:
        snprintf(expected, sizeof expected, "a whole number from %.0f to %.0f", option->min,
            option->max);
        break;
    case CLI_REAL:
        snprintf(expected, sizeof expected, "a number from %g to %g", option->min, option->max);
        break;
    case CLI_SHARE:
        snprintf(expected, sizeof expected, "a share from %g%% to %g%%", 100 * option->min,
            100 * option->max);
        break;
    case CLI_SIDES:
    case CLI_SIZE:
        snprintf(expected, sizeof expected,
            "WIDTHxHEIGHT such as 640x480, each from %.0f to %.0f, and at most %u pixels in all",
            option->min, option->max, MOST_PIXELS);
        break;
    case CLI_BYTES:
        snprintf(expected, sizeof expected, "an amount of memory such as 500MiB or 2GiB");
        break;
    case CLI_CHOICE:
        expected[0] = '\0';
        for (int i = 0; option->choices[i]; i++) {
            strncat(expected, i ? ", " : "one of ", sizeof expected - strlen(expected) - 1);
            strncat(expected, option->choices[i], sizeof expected - strlen(expected) - 1);
        }
        break;
    case CLI_FLAG:
    case CLI_TEXT:
        break;
    }
    return cli_usage_error(usage->command, "%s: '%s' is not %s", option->name, text, expected);
}

/// Finds the option that `argument` names, up to its end or to '='.
static const cli_option *find_option(const cli_usage *usage, const char *argument)
{
    size_t length = strcspn(argument, "=");
    for (const cli_option *option = usage->options; option->name; option++)
        if (strlen(option->name) == length && strncmp(option->name, argument, length) == 0)
            return option;
    return NULL;
}

int cli_unknown_name(const char *command, const char *name, const char *kind,
    const char *const *candidates, size_t count)
{
    const char *near = cli_near_name(name, candidates, count);
    return cli_usage_error(command, "'%s' is not %s%s%s%s", name, kind,
        near ? " (did you mean '" : "", near ? near : "", near ? "'?)" : "");
}

static int report_unknown_option(const cli_usage *usage, const char *argument)
{
    const char *names[MOST_OPTIONS], *value = strchr(argument, '=');
    char name[CLI_NAME_LENGTH];
    size_t count = 0;
    for (; usage->options[count].name; count++)
        names[count] = usage->options[count].name;
    snprintf(
        name, sizeof name, "%.*s", value ? (int)(value - argument) : CLI_NAME_LENGTH, argument);
    return cli_unknown_name(usage->command, name, "an option", names, count);
}

/// Reads the option at argv[*index] and moves *index past its value.
/// @param given bit n for option n
static int parse_option(const cli_usage *usage, int argc, char **argv, int *index, uint64_t *given)
{
    const char *argument = argv[(*index)++];
    const cli_option *option = find_option(usage, argument);
    if (!option) return report_unknown_option(usage, argument);
    *given |= UINT64_C(1) << (option - usage->options);
    const char *value = strchr(argument, '=');
    if (option->kind == CLI_FLAG) {
        if (value) return cli_usage_error(usage->command, "%s takes no value", option->name);
        value = "";
    } else if (value) {
        value++;
    } else if (*index < argc && strncmp(argv[*index], "--", 2) != 0) {
        value = argv[(*index)++];
    } else {
        return cli_usage_error(usage->command, "%s needs a value", option->name);
    }
    return store_value(option, value) ? CLI_SUCCESS : report_bad_value(usage, option, value);
}

/// Whether the user gave `company`: "--option" or "--option=choice".
static bool is_chosen(const cli_usage *usage, const char *company, uint64_t given)
{
    const cli_option *option = find_option(usage, company);
    assert(option);
    const char *choice = strchr(company, '=');
    if (!(given >> (option - usage->options) & 1)) return false;
    return !choice || strcmp(option->choices[*(const int *)option->value], choice + 1) == 0;
}

/// Options that do nothing without others must not look as if they did.
static int check_company(const cli_usage *usage, uint64_t given)
{
    for (const cli_option *option = usage->options; option->name; option++) {
        if (!(given >> (option - usage->options) & 1) || !option->goes_with) continue;
        if (is_chosen(usage, option->goes_with, given)) continue;
        const char *choice = strchr(option->goes_with, '=');
        return cli_usage_error(usage->command, "%s requires %.*s%s%s", option->name,
            (int)strcspn(option->goes_with, "="), option->goes_with, choice ? " " : "",
            choice ? choice + 1 : "");
    }
    return CLI_SUCCESS;
}

bool cli_parse(
    const cli_usage *usage, int argc, char **argv, const char **operands, int *exit_status)
{
    size_t operand_count = 0;
    uint64_t given = 0;
    bool options_ended = false;
    for (size_t i = 0; i < usage->operand_max; i++)
        operands[i] = NULL;
    *exit_status = CLI_SUCCESS;
    for (int i = 0; i < argc;) {
        const char *argument = argv[i];
        if (!options_ended && (strcmp(argument, "--help") == 0 || strcmp(argument, "-h") == 0)) {
            cli_print_help(usage, i + 1 < argc && strcmp(argv[i + 1], "all") == 0);
            return false;
        }
        if (!options_ended && strcmp(argument, "--") == 0) {
            options_ended = true;
            i++;
        } else if (!options_ended && argument[0] == '-') {
            *exit_status = parse_option(usage, argc, argv, &i, &given);
        } else if (operand_count < usage->operand_max) {
            operands[operand_count++] = argv[i++];
        } else {
            *exit_status =
                cli_usage_error(usage->command, "'%s' is one argument too many", argument);
        }
        if (*exit_status != CLI_SUCCESS) return false;
    }
    if (operand_count < usage->operand_min) {
        *exit_status = cli_usage_error(usage->command, "%s is missing", usage->operands);
        return false;
    }
    *exit_status = check_company(usage, given);
    return *exit_status == CLI_SUCCESS;
}
