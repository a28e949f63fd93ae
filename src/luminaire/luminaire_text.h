/// Files of luminaires, number by number or line by line.
#ifndef RSV_LUMINAIRE_TEXT_H
#define RSV_LUMINAIRE_TEXT_H

#include "../core/core.h"
#include "resolvent/luminaire.h"

typedef struct rsv_luminaire_text {
    rsv_context *context;
    const char *path;
    char *start, *rest; ///< rest: not read yet
    rsv_luminaire *to;
} rsv_luminaire_text;

/// The present line, from 1.
size_t rsv_luminaire_line_number(const rsv_luminaire_text *text);

/// RSV_ERROR_FORMAT at the present line.
rsv_status rsv_luminaire_complain(const rsv_luminaire_text *text, const char *what);

/// The next number; blanks, line ends and commas part them. @param name of it, for messages
rsv_status rsv_luminaire_number(rsv_luminaire_text *text, const char *name, double *value);
/// The same within bounds.
rsv_status rsv_luminaire_number_within(
    rsv_luminaire_text *text, const char *name, const double bounds[2], double *value);

/// Copies the beginning of the next line, without its end. @return false if there is none
bool rsv_luminaire_line(rsv_luminaire_text *text, char *line, size_t size);

/// Allocates angles and intensities, and one more plane.
rsv_status rsv_luminaire_reserve(rsv_luminaire_text *text, uint32_t vertical, uint32_t horizontal);
/// Whether angles to the axis reach no farther than from pole to pole, and those around it no farther than one turn.
bool rsv_luminaire_is_on_sphere(const rsv_luminaire *luminaire);

/// Reads angles, which must ascend.
rsv_status rsv_luminaire_angles(
    rsv_luminaire_text *text, const char *name, uint32_t count, float *angle);
/// Reads all intensities, times `scale`. Negative ones become 0.
rsv_status rsv_luminaire_intensities(rsv_luminaire_text *text, double scale);

/// Repeats the first plane at the end if that completes the circle.
void rsv_luminaire_close(rsv_luminaire *luminaire);

rsv_status rsv_luminaire_read_ies(rsv_luminaire_text *text);
rsv_status rsv_luminaire_read_eulumdat(rsv_luminaire_text *text);

#endif
