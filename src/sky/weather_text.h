/// Reading weather files line by line, for both formats.
#ifndef RSV_WEATHER_TEXT_H
#define RSV_WEATHER_TEXT_H

#include "../core/core.h"
#include "resolvent/sky.h"

/// A file that is being read.
typedef struct rsv_weather_text {
    rsv_context *context;
    const char *path;
    char *rest; ///< text after the current line; NULL = none
    char *line; ///< the present one, without its end
    size_t number;
    rsv_weather *weather;
    size_t capacity; ///< of weather->hour
} rsv_weather_text;

/// Irradiances that a file leaves out, until they are filled in: of `record`, NAN.
rsv_status rsv_weather_read_epw(rsv_weather_text *text);
rsv_status rsv_weather_read_wea(rsv_weather_text *text);

/// Goes on to the next line. @return false at the end
bool rsv_weather_next_line(rsv_weather_text *text);

/// RSV_ERROR_FORMAT for the current line, with what is wrong.
rsv_status rsv_weather_complain(const rsv_weather_text *text, const char *what);

/// Appends an interval after checking its date.
rsv_status rsv_weather_append(rsv_weather_text *text, const rsv_weather_hour *hour);

/// The number that starts at `*cursor`, which moves behind it and one separator. @return false if there is none
bool rsv_weather_number(char **cursor, char separator, double *value);

rsv_status rsv_weather_check_site(const rsv_weather_text *text);

#endif
