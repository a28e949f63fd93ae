/// A page that stands alone: figures, plans of the sensors in colour, and the year hour by hour.
#ifndef CLI_DAYLIGHT_PAGE_H
#define CLI_DAYLIGHT_PAGE_H

#include "daylight_report.h"

/// @param result with its hours. Says what went wrong on standard error.
bool cli_write_daylight_page(const char *path, const cli_daylight_result *result);

#endif
