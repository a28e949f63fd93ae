#include "frame_path.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// Where the number of a frame goes: the length of "%0Nd" or "%d", 0 if there is none.
static size_t number_at(const char *path, const char **start, int *digits)
{
    char *end;
    *start = strchr(path, '%');
    if (!*start) return 0;
    *digits = (int)strtol(*start + 1, &end, 10);
    return *end == 'd' && *digits >= 0 && *digits < 10 && !strchr(end, '%')
               ? (size_t)(end + 1 - *start)
               : 0;
}

bool cli_frame_path(const char *pattern, uint32_t frame, char path[PATH_MAX])
{
    const char *start;
    int digits;
    size_t cut = number_at(pattern, &start, &digits);
    if (!cut) return false;
    int length = snprintf(
        path, PATH_MAX, "%.*s%0*u%s", (int)(start - pattern), pattern, digits, frame, start + cut);
    return length > 0 && length < PATH_MAX;
}
