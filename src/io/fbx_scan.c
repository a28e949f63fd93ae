#include "fbx_scan.h"

#include "../core/number_text.h"
#include "file_source.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/// A property whose type has its own name, and the type that says the same.
typedef struct odd_property {
    const char *name, *type;
} odd_property;

/// A text of a binary file: 'S', its length in four bytes, and its letters.
static size_t put_text(char *to, const char *text, size_t length)
{
    to[0] = 'S';
    for (int k = 0; k < 4; k++)
        to[1 + k] = (char)(length >> 8 * k & 0xff);
    memset(to + 5, ' ', length);
    for (size_t k = 0; k < length && text[k]; k++)
        to[5 + k] = text[k];
    return 5 + length;
}

/// The type and the label follow the name. The new type is shorter; the label, which is empty, is padded by the
/// difference.
static bool change_binary(char *at, const char *end, const odd_property *p)
{
    char before[128];
    size_t length = strlen(p->name), rest = length - strlen(p->type);
    size_t size = put_text(before, p->name, length);
    size += put_text(before + size, "", 0);
    if ((size_t)(end - at) < size || memcmp(at, before, size) != 0) return false;
    size = put_text(at, p->type, strlen(p->type));
    put_text(at + size, "", rest);
    return true;
}

/// The type follows behind a comma, between quotes.
static bool change_text(char *at, const char *end, const odd_property *p)
{
    size_t length = strlen(p->name), type = strlen(p->type);
    while (at < end && strchr(" \t,", *at) && *at)
        at++;
    if ((size_t)(end - at) < length + 2 || *at != '"' || at[length + 1] != '"' ||
        memcmp(at + 1, p->name, length) != 0)
        return false;
    memcpy(at + 1, p->type, type);
    at[type + 1] = '"';
    memset(at + type + 2, ' ', length - type);
    return true;
}

static size_t change_all(char *bytes, size_t size, const odd_property *p)
{
    size_t count = 0, length = strlen(p->name);
    char *end = bytes + size, *at = bytes;
    while ((at = memmem(at, (size_t)(end - at), p->name, length))) {
        at += length;
        count += *at == 'S' ? change_binary(at, end, p) : *at == '"' && change_text(at + 1, end, p);
    }
    return count;
}

/// The number of a property whose name ends at `at`: behind type, label and flags, as 'D' and its eight bytes. 0 =
/// there is none
static double binary_number(const char *at, const char *end)
{
    double value = 0;
    for (int k = 0; k < 3; k++) {
        if (end - at < 5 || *at != 'S') return 0;
        size_t length = 0;
        for (int i = 4; i > 0; i--)
            length = length << 8 | (unsigned char)at[i];
        if (length > (size_t)(end - at) - 5) return 0;
        at += 5 + length;
    }
    if (end - at < 9 || *at != 'D') return 0;
    memcpy(&value, at + 1, sizeof value);
    return value;
}

/// In text: `"FilmOffsetX", "Number", "", "A",0.1`. @param at behind the name
static double text_number(const char *at, const char *end)
{
    for (int commas = 0; at < end && *at != '\n'; at++)
        if (*at == ',' && ++commas == 4) return rsv_number_value(at + 1, NULL);
    return 0;
}

bool rsv_fbx_shifts_film(const char *bytes, size_t size)
{
    static const char *const names[] = { "FilmOffsetX", "FilmOffsetY" };
    const char *end = bytes + size;
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        const char *at = bytes;
        while ((at = memmem(at, (size_t)(end - at), names[k], strlen(names[k])))) {
            at += strlen(names[k]);
            if (at < end && (*at == 'S' ? binary_number(at, end) : text_number(at, end)) != 0)
                return true;
        }
    }
    return false;
}

char *rsv_fbx_clean(FILE *file, size_t *size)
{
    static const odd_property odd[] = { { "Visibility", "double" },
        { "Visibility Inheritance", "int" } };
    char *bytes = rsv_stream_read(file, size);
    size_t count = 0;
    for (size_t k = 0; bytes && k < sizeof odd / sizeof *odd; k++)
        count += change_all(bytes, *size, &odd[k]);
    if (count) return bytes;
    free(bytes);
    return NULL;
}
