/// A self-contained HTML page: figures, coloured plans of the sensors, and the year hour by hour.
#ifndef CLI_DAYLIGHT_PAGE_H
#define CLI_DAYLIGHT_PAGE_H

#include "daylight_report.h"

/// @param result must include its hours. Prints errors on standard error.
bool cli_write_daylight_page(const char *path, const cli_daylight_result *result);

#endif
