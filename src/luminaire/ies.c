/// IES LM-63: lines of keywords, TILT=, and then nothing but numbers.
#include "luminaire_text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#define METRES_PER_FOOT 0.3048

/// Values of the two lines after TILT.
typedef struct ies_facts {
    double lamps, lumens, multiplier, vertical, horizontal, type, units, size[3], ballast, factor,
        watts;
} ies_facts;

/// What follows TILT= on its line, in any case and with blanks around the sign; NULL = it is another line.
static const char *tilt_of(const char *line)
{
    if (strncasecmp(line, "TILT", 4) != 0) return NULL;
    line += 4 + strspn(line + 4, " \t");
    return *line == '=' ? line + 1 + strspn(line + 1, " \t") : NULL;
}

/// Reads lines to that with TILT=. @return RSV_OK with `rest` behind it. @param old of LM-63-1986 to 1995
static rsv_status read_keywords(rsv_luminaire_text *t, bool *old, bool *tilted)
{
    char line[256];
    *old = true;
    while (rsv_luminaire_line(t, line, sizeof line)) {
        if (strstr(line, "LM-63-2002") || strstr(line, "LM-63-2019")) *old = false;
        if (strncmp(line, "[LUMINAIRE]", 11) == 0)
            snprintf(t->to->name, sizeof t->to->name, "%.120s", line + 11 + strspn(line + 11, " "));
        const char *tilt = tilt_of(line);
        if (!tilt) continue;
        *tilted = strncasecmp(tilt, "INCLUDE", 7) == 0;
        if (*tilted || strncasecmp(tilt, "NONE", 4) == 0) return RSV_OK;
        return rsv_luminaire_complain(
            t, "TILT is in a file of its own, which is not read: only NONE and INCLUDE are");
    }
    t->rest = t->start;
    return rsv_luminaire_complain(
        t, "there is no line TILT=; add TILT=NONE between keywords and numbers");
}

/// What a lamp gives at tilts of its luminaire, relative to the intensities of the file.
typedef struct tilt_table {
    int count;
    float *angle, *factor; ///< [count] degrees from straight down, ascending
} tilt_table;

static rsv_status read_tilt_values(rsv_luminaire_text *t, tilt_table *table)
{
    static const double angles[2] = { 0, 180 }, factors[2] = { 0, 1e3 };
    for (int k = 0; k < 2 * table->count; k++) {
        bool is_angle = k < table->count;
        double value;
        rsv_status status =
            rsv_luminaire_number_within(t, is_angle ? "an angle of TILT" : "a factor of TILT",
                is_angle ? angles : factors, &value);
        if (status != RSV_OK) return status;
        if (is_angle)
            table->angle[k] = (float)value;
        else
            table->factor[k - table->count] = (float)value;
        if (is_angle && k > 0 && table->angle[k] <= table->angle[k - 1])
            return rsv_luminaire_complain(t, "the angles of TILT do not ascend");
    }
    return RSV_OK;
}

/// Of a luminaire that points straight down, as it does where intensities are measured.
static double factor_straight_down(const rsv_luminaire_text *t, const tilt_table *table)
{
    float least = INFINITY, most = 0;
    for (int k = 0; k < table->count; k++) {
        least = fminf(least, table->factor[k]);
        most = fmaxf(most, table->factor[k]);
    }
    double factor = table->count > 0 ? (double)table->factor[0] : 1;
    if (least < most)
        rsv_log(t->context, RSV_LOG_WARNING,
            "%s: TILT: intensities are those of a luminaire that points straight down (factor %g); "
            "the factors of other tilts, %g to %g, are not applied",
            t->path, factor, (double)least, (double)most);
    return factor;
}

/// @param factor out: of all intensities
static rsv_status read_tilt(rsv_luminaire_text *t, double *factor)
{
    static const double geometries[2] = { 1, 3 }, counts[2] = { 0, 1e4 };
    double geometry, count;
    tilt_table table = { 0 };
    rsv_status status;
    RSV_TRY(rsv_luminaire_number_within(t, "the lamp's geometry of TILT", geometries, &geometry));
    RSV_TRY(rsv_luminaire_number_within(t, "the number of TILT's angles", counts, &count));
    table.count = (int)count;
    table.angle = rsv_alloc(t->context, (size_t)table.count, sizeof *table.angle);
    table.factor = rsv_alloc(t->context, (size_t)table.count, sizeof *table.factor);
    RSV_TRY(table.angle && table.factor ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(read_tilt_values(t, &table));
    *factor = factor_straight_down(t, &table);
cleanup:
    rsv_free(t->context, table.angle);
    rsv_free(t->context, table.factor);
    return status;
}

static rsv_status read_facts(rsv_luminaire_text *t, ies_facts *f)
{
    static const double any[2] = { -1e9, 1e9 };
    const struct {
        const char *name;
        double *value, bounds[2];
    } fact[] = { { "the number of lamps", &f->lamps, { 0, 1e6 } },
        { "the lumens of a lamp", &f->lumens, { -1, 1e9 } },
        { "the multiplier of intensities", &f->multiplier, { 0, 1e9 } },
        { "the number of vertical angles", &f->vertical, { 1, 1e6 } },
        { "the number of horizontal angles", &f->horizontal, { 1, 1e6 } },
        { "the type of photometry", &f->type, { 1, 3 } }, { "the units", &f->units, { 1, 2 } },
        { "the width", &f->size[0], { any[0], any[1] } },
        { "the length", &f->size[1], { any[0], any[1] } },
        { "the height", &f->size[2], { any[0], any[1] } },
        { "the ballast factor", &f->ballast, { 0, 1e3 } },
        { "the second factor", &f->factor, { 0, 1e3 } }, { "the watts", &f->watts, { -1, 1e9 } } };
    for (size_t k = 0; k < sizeof fact / sizeof *fact; k++) {
        rsv_status status =
            rsv_luminaire_number_within(t, fact[k].name, fact[k].bounds, fact[k].value);
        if (status != RSV_OK) return status;
    }
    return RSV_OK;
}

static void keep_facts(rsv_luminaire *l, const ies_facts *f)
{
    double metres = f->units < 1.5 ? METRES_PER_FOOT : 1;
    l->type = f->type < 1.5   ? RSV_PHOTOMETRY_C
              : f->type < 2.5 ? RSV_PHOTOMETRY_B
                              : RSV_PHOTOMETRY_A;
    l->width = metres * f->size[0], l->length = metres * f->size[1],
    l->height = metres * f->size[2];
    l->lamp_lumens = f->lumens > 0 ? f->lamps * f->lumens : 0;
    l->watts = f->watts > 0 ? f->watts : 0;
}

/// There are more numbers than the angles require, so one of the counts may be wrong.
static void warn_of_rest(rsv_luminaire_text *t)
{
    const char *blank = " \t\r\n,;\x1a"; // the last one ends files of old
    t->rest += strspn(t->rest, blank);
    if (!*t->rest) return;
    rsv_log(t->context, RSV_LOG_WARNING,
        "%s:%zu: text after the last intensity is ignored; are the numbers of angles right?",
        t->path, rsv_luminaire_line_number(t));
}

rsv_status rsv_luminaire_read_ies(rsv_luminaire_text *t)
{
    bool old, tilted = false;
    double tilt = 1;
    ies_facts f = { 0 };
    rsv_luminaire *l = t->to;
    rsv_status status;
    RSV_TRY(read_keywords(t, &old, &tilted));
    if (tilted) RSV_TRY(read_tilt(t, &tilt));
    RSV_TRY(read_facts(t, &f));
    keep_facts(l, &f);
    RSV_TRY(rsv_luminaire_reserve(t, (uint32_t)f.vertical, (uint32_t)f.horizontal));
    RSV_TRY(rsv_luminaire_angles(t, "a vertical angle", l->vertical_count, l->vertical));
    RSV_TRY(rsv_luminaire_angles(t, "a horizontal angle", l->horizontal_count, l->horizontal));
    // since 2002 the second factor is no factor
    RSV_TRY(rsv_luminaire_intensities(t, f.multiplier * f.ballast * tilt * (old ? f.factor : 1)));
    warn_of_rest(t);
    rsv_luminaire_close(l);
cleanup:
    return status;
}
