#include "luminaire_text.h"

#include "../core/number_text.h"
#include "../core/text_file.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define MOST_BYTES ((size_t)1 << 27)
#define MOST_VALUES ((uint64_t)1 << 24)

size_t rsv_luminaire_line_number(const rsv_luminaire_text *t)
{
    size_t line = 1;
    for (const char *c = t->start; c < t->rest; c++)
        line += *c == '\n';
    return line;
}

rsv_status rsv_luminaire_complain(const rsv_luminaire_text *t, const char *what)
{
    return rsv_fail(RSV_ERROR_FORMAT, "%s:%zu: %s", t->path, rsv_luminaire_line_number(t), what);
}

rsv_status rsv_luminaire_number(rsv_luminaire_text *t, const char *name, double *value)
{
    char what[128], *end = NULL;
    t->rest += strspn(t->rest, " \t\r\n,;");
    *value = rsv_number_value(t->rest, &end);
    if (end == t->rest || !isfinite(*value) || fabs(*value) > 1e30) {
        snprintf(what, sizeof what, "%s is missing or not a number", name);
        return rsv_luminaire_complain(t, what);
    }
    t->rest = end;
    return RSV_OK;
}

rsv_status rsv_luminaire_number_within(
    rsv_luminaire_text *t, const char *name, const double bounds[2], double *value)
{
    char what[128];
    rsv_status status = rsv_luminaire_number(t, name, value);
    if (status != RSV_OK || (*value >= bounds[0] && *value <= bounds[1])) return status;
    snprintf(
        what, sizeof what, "%s is %g, not within %g to %g", name, *value, bounds[0], bounds[1]);
    return rsv_luminaire_complain(t, what);
}

bool rsv_luminaire_line(rsv_luminaire_text *t, char *line, size_t size)
{
    size_t length = strcspn(t->rest, "\n"), kept = length;
    if (!*t->rest) return false;
    while (kept > 0 && strchr(" \t\r", t->rest[kept - 1]))
        kept--;
    snprintf(line, size, "%.*s", (int)(kept < size ? kept : size - 1), t->rest);
    t->rest += length;
    if (*t->rest) t->rest++;
    return true;
}

rsv_status rsv_luminaire_reserve(rsv_luminaire_text *t, uint32_t vertical, uint32_t horizontal)
{
    rsv_luminaire *l = t->to;
    if ((uint64_t)vertical * horizontal > MOST_VALUES)
        return rsv_luminaire_complain(t, "there are more than 16 million intensities");
    l->vertical = rsv_alloc(t->context, vertical, sizeof *l->vertical);
    l->horizontal = rsv_alloc(t->context, (size_t)horizontal + 1, sizeof *l->horizontal);
    l->intensity = rsv_alloc(t->context, (size_t)vertical * (horizontal + 1), sizeof *l->intensity);
    l->vertical_count = vertical, l->horizontal_count = horizontal;
    return l->vertical && l->horizontal && l->intensity ? RSV_OK : RSV_ERROR_MEMORY;
}

rsv_status rsv_luminaire_angles(
    rsv_luminaire_text *t, const char *name, uint32_t count, float *angle)
{
    static const double degrees[2] = { -360, 360 };
    for (uint32_t k = 0; k < count; k++) {
        double value;
        rsv_status status = rsv_luminaire_number_within(t, name, degrees, &value);
        if (status != RSV_OK) return status;
        angle[k] = (float)value;
        if (k > 0 && !(angle[k] > angle[k - 1]))
            return rsv_luminaire_complain(t, "angles do not ascend; are their numbers right?");
    }
    return RSV_OK;
}

rsv_status rsv_luminaire_intensities(rsv_luminaire_text *t, double scale)
{
    rsv_luminaire *l = t->to;
    size_t count = (size_t)l->vertical_count * l->horizontal_count, dark = 0;
    for (size_t k = 0; k < count; k++) {
        double value;
        rsv_status status = rsv_luminaire_number(t, "an intensity", &value);
        if (status != RSV_OK) return status;
        dark += value < 0;
        l->intensity[k] = (float)fmin(fmax(value, 0) * scale, 1e30);
    }
    if (dark)
        rsv_log(
            t->context, RSV_LOG_WARNING, "%s: %zu negative intensities count as 0", t->path, dark);
    return RSV_OK;
}

void rsv_luminaire_close(rsv_luminaire *l)
{
    uint32_t count = l->horizontal_count, angles = l->vertical_count;
    float span = l->horizontal[count - 1] - l->horizontal[0];
    if (l->type != RSV_PHOTOMETRY_C || span < 180.5f || span > 359.99f) return;
    l->horizontal[count] = l->horizontal[0] + 360;
    memcpy(l->intensity + (size_t)count * angles, l->intensity, angles * sizeof *l->intensity);
    l->horizontal_count++;
}

/// Line ends of old Macintosh files.
static void end_lines(char *content)
{
    for (char *c = content; *c; c++)
        if (*c == '\r' && c[1] != '\n') *c = '\n';
}

/// @param content ends with a zero
static rsv_status read_content(
    rsv_context *context, const char *path, char *content, rsv_luminaire *luminaire)
{
    rsv_luminaire_text t = { context, path, content, content, luminaire };
    if (strncmp(content, "\xef\xbb\xbf", 3) == 0) t.rest += 3;
    end_lines(content);
    bool ies = strstr(content, "TILT=") || strncmp(t.rest, "IESNA", 5) == 0;
    rsv_status status = ies ? rsv_luminaire_read_ies(&t) : rsv_luminaire_read_eulumdat(&t);
    if (status != RSV_OK || rsv_luminaire_is_on_sphere(luminaire)) return status;
    return rsv_fail(RSV_ERROR_FORMAT,
        "%s: angles to the axis must lie within 0 and 180 degrees (types A and B: latitudes within "
        "-90 and 90), those around it within one turn",
        path);
}

rsv_status rsv_luminaire_read(rsv_context *context, const char *path, rsv_luminaire *luminaire)
{
    char *content = NULL;
    rsv_status status;
    *luminaire = (rsv_luminaire){ 0 };
    RSV_TRY(rsv_read_text_file(context, path, "a luminaire", MOST_BYTES, &content));
    RSV_TRY(read_content(context, path, content, luminaire));
cleanup:
    rsv_free(context, content);
    return status;
}

rsv_status rsv_luminaire_parse(rsv_context *context, const char *name, const char *text,
    size_t bytes, rsv_luminaire *luminaire)
{
    *luminaire = (rsv_luminaire){ 0 };
    if (bytes > MOST_BYTES || (bytes && memchr(text, 0, bytes)))
        return rsv_fail(RSV_ERROR_FORMAT, "%s: is not a luminaire: it is not text", name);
    char *content = rsv_alloc(context, bytes + 1, 1);
    if (!content) return RSV_ERROR_MEMORY;
    if (bytes) memcpy(content, text, bytes);
    content[bytes] = 0;
    rsv_status status = read_content(context, name, content, luminaire);
    rsv_free(context, content);
    return status;
}

void rsv_luminaire_free(rsv_context *context, rsv_luminaire *l)
{
    rsv_free(context, l->vertical);
    rsv_free(context, l->horizontal);
    rsv_free(context, l->intensity);
    *l = (rsv_luminaire){ 0 };
}
