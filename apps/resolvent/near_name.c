#include "near_name.h"

#include <string.h>

static size_t least(size_t a, size_t b) { return a < b ? a : b; }

static size_t changes(const char *a, const char *b)
{
    size_t rows = strnlen(a, CLI_NAME_LENGTH), columns = strnlen(b, CLI_NAME_LENGTH);
    // changes from the first i characters of a to the first j of b
    size_t from[CLI_NAME_LENGTH + 1][CLI_NAME_LENGTH + 1];
    for (size_t i = 0; i <= rows; i++) {
        for (size_t j = 0; j <= columns; j++) {
            if (i == 0 || j == 0) {
                from[i][j] = i + j;
                continue;
            }
            from[i][j] = least(from[i - 1][j - 1] + (a[i - 1] != b[j - 1]),
                1 + least(from[i - 1][j], from[i][j - 1]));
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                from[i][j] = least(from[i][j], 1 + from[i - 2][j - 2]);
        }
    }
    return from[rows][columns];
}

const char *cli_near_name(const char *name, const char *const *candidates, size_t count)
{
    const char *nearest = NULL;
    size_t fewest = (strnlen(name, CLI_NAME_LENGTH) + 2) / 3;
    for (size_t k = 0; k < count; k++) {
        size_t own = changes(name, candidates[k]);
        if (own >= fewest) continue;
        fewest = own;
        nearest = candidates[k];
    }
    return nearest;
}
