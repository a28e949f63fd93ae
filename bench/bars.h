/// Bars side by side, as SVG.
#ifndef CLI_BARS_H
#define CLI_BARS_H

#include <stdbool.h>
#include <stddef.h>

enum { cli_max_groups = 12, cli_max_series = 4 };

/// Bars that stand together.
typedef struct cli_bar_group {
    const char *name;
    const char *note; ///< a second line below the name; may be NULL
    double value[cli_max_series];
} cli_bar_group;

typedef struct cli_bars {
    const char *title;                  ///< quantity that the height of the bars shows
    const char *series[cli_max_series]; ///< names; NULL after the last
    double scale;                       ///< values are shown times this
    cli_bar_group group[cli_max_groups];
    size_t group_count;
} cli_bars;

/// Prints errors on standard error.
bool cli_write_bars(const char *path, const cli_bars *bars);

#endif
