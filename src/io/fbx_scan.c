#include "fbx_scan.h"

#include "../core/number_text.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>

/// The whole of a file, mapped.
typedef struct file_bytes {
    const char *bytes;
    size_t size;
} file_bytes;

static file_bytes map_file(const char *path)
{
    file_bytes b = { NULL, 0 };
    struct stat info;
    FILE *file = fopen(path, "rb");
    if (file && fstat(fileno(file), &info) == 0 && info.st_size > 0) {
        void *bytes = mmap(NULL, (size_t)info.st_size, PROT_READ, MAP_PRIVATE, fileno(file), 0);
        if (bytes != MAP_FAILED) b = (file_bytes){ bytes, (size_t)info.st_size };
    }
    if (file) fclose(file);
    return b;
}

/// Passes over a text of a binary file: 'S', its length, and its letters. @return NULL = it is none
static const char *skip_text(const char *at, const char *end)
{
    uint32_t length;
    if (end - at < 5 || *at != 'S') return NULL;
    memcpy(&length, at + 1, sizeof length); // little-endian, as all machines here
    return (size_t)(end - at - 5) >= length ? at + 5 + length : NULL;
}

/// @param at behind the name and the type of the property: two texts follow, and a double
static bool is_zero_in_binary(const char *at, const char *end)
{
    double value;
    for (int k = 0; k < 2 && at; k++)
        at = skip_text(at, end);
    if (!at || end - at < 9 || *at != 'D') return false;
    memcpy(&value, at + 1, sizeof value);
    return value == 0;
}

/// @param at likewise: two texts between quotes, and a number
static bool is_zero_in_text(const char *at, const char *end)
{
    char number[32] = "", *after;
    size_t length = 0;
    for (int commas = 0; at < end && commas < 3; at++)
        commas += *at == ',';
    while (at < end && length < sizeof number - 1 && *at != '\n')
        number[length++] = *at++;
    double value = rsv_number_value(number, &after);
    return after != number && value == 0;
}

static size_t count(file_bytes b, const char *property, size_t length,
    bool (*is_zero)(const char *at, const char *end))
{
    size_t found = 0;
    const char *end = b.bytes + b.size, *at = b.bytes;
    while ((at = memmem(at, (size_t)(end - at), property, length))) {
        at += length;
        found += is_zero(at, end);
    }
    return found;
}

size_t rsv_fbx_count_invisible(const char *path)
{
    static const char binary[] = "S\x0a\0\0\0VisibilityS\x0a\0\0\0Visibility";
    static const char text[] = "\"Visibility\", \"Visibility\"";
    file_bytes b = map_file(path);
    if (!b.bytes) return 0;
    size_t found = count(b, binary, sizeof binary - 1, is_zero_in_binary) +
                   count(b, text, sizeof text - 1, is_zero_in_text);
    munmap((void *)(uintptr_t)b.bytes, b.size);
    return found;
}
