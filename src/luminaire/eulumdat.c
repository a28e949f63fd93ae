/// EULUMDAT (Stockmar 1990): one fact a line, cd per 1000 lm of the lamps.
#include "luminaire_text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { symmetry_none, symmetry_round, symmetry_0_180, symmetry_90_270, symmetry_both };

/// The facts that matter here.
typedef struct eulumdat_facts {
    double type, symmetry, planes, plane_step, angles, angle_step, length, width, height;
    double bright_length, bright_width, bright_height; ///< of the luminous area, mm
    double conversion, sets, lumens, watts;
} eulumdat_facts;

static rsv_status skip_lines(rsv_luminaire_text *t, int count)
{
    char line[8];
    for (int k = 0; k < count; k++)
        if (!rsv_luminaire_line(t, line, sizeof line))
            return rsv_luminaire_complain(
                t, "the file ends early; is it really IES LM-63 or EULUMDAT?");
    return RSV_OK;
}

/// A number that has a line to itself, or is missing there: then 0.
static rsv_status read_line(
    rsv_luminaire_text *t, const char *name, const double bounds[2], double *value)
{
    char line[128];
    if (!rsv_luminaire_line(t, line, sizeof line))
        return rsv_luminaire_complain(
            t, "the file ends early; is it really IES LM-63 or EULUMDAT?");
    rsv_luminaire_text one = { t->context, t->path, line, line, t->to };
    *value = 0;
    for (char *c = line; *c; c++)
        if (*c == ',') *c = '.'; // some write decimals so
    if (line[strspn(line, " \t")] == '\0' && bounds[0] <= 0) return RSV_OK;
    if (rsv_luminaire_number_within(&one, name, bounds, value) == RSV_OK) return RSV_OK;
    char what[128];
    snprintf(
        what, sizeof what, "the line above: %s is not within %g to %g", name, bounds[0], bounds[1]);
    return rsv_luminaire_complain(t, what);
}

/// Lines 1 to 12.
static rsv_status read_head(rsv_luminaire_text *t, eulumdat_facts *f)
{
    static const double types[2] = { 0, 3 }, kinds[2] = { 0, 4 }, counts[2] = { 1, 1e6 },
                        steps[2] = { 0, 360 };
    rsv_status status;
    RSV_TRY(skip_lines(t, 1));
    RSV_TRY(read_line(t, "the type", types, &f->type));
    RSV_TRY(read_line(t, "the symmetry", kinds, &f->symmetry));
    RSV_TRY(read_line(t, "the number of C planes", counts, &f->planes));
    RSV_TRY(read_line(t, "the distance between C planes", steps, &f->plane_step));
    RSV_TRY(read_line(t, "the number of angles", counts, &f->angles));
    RSV_TRY(read_line(t, "the distance between angles", steps, &f->angle_step));
    RSV_TRY(skip_lines(t, 1));
    if (!rsv_luminaire_line(t, t->to->name, sizeof t->to->name)) RSV_TRY(skip_lines(t, 1));
    RSV_TRY(skip_lines(t, 3));
cleanup:
    return status;
}

/// Lines 13 to 26, of each set of lamps, and the direct ratios.
static rsv_status read_body(rsv_luminaire_text *t, eulumdat_facts *f)
{
    static const double sizes[2] = { 0, 1e6 }, any[2] = { -1e9, 1e9 }, sets[2] = { 1, 20 };
    rsv_status status;
    RSV_TRY(read_line(t, "the length", sizes, &f->length));
    RSV_TRY(read_line(t, "the width", sizes, &f->width));
    RSV_TRY(read_line(t, "the height", sizes, &f->height));
    RSV_TRY(read_line(t, "the length of the luminous area", sizes, &f->bright_length));
    RSV_TRY(read_line(t, "the width of the luminous area", sizes, &f->bright_width));
    for (int k = 0; k < 4; k++) {
        double height;
        RSV_TRY(read_line(t, "the height of the luminous area", sizes, &height));
        f->bright_height = fmax(f->bright_height, height);
    }
    RSV_TRY(skip_lines(t, 2));
    RSV_TRY(read_line(t, "the conversion factor", any, &f->conversion));
    RSV_TRY(skip_lines(t, 1));
    RSV_TRY(read_line(t, "the number of sets of lamps", sets, &f->sets));
    for (int k = 0; k < (int)f->sets; k++) {
        double lumens, watts;
        RSV_TRY(skip_lines(t, 2));
        RSV_TRY(read_line(t, "the luminous flux", any, &lumens));
        RSV_TRY(skip_lines(t, 2));
        RSV_TRY(read_line(t, "the power", any, &watts));
        if (k == 0)
            f->lumens = fabs(lumens), f->watts = fabs(watts); // further sets are alternatives
    }
    RSV_TRY(skip_lines(t, 10));
cleanup:
    return status;
}

/// How many planes the file holds, and the first of them.
static uint32_t stored_planes(const eulumdat_facts *f, uint32_t *first)
{
    uint32_t planes = (uint32_t)f->planes;
    *first = (int)f->symmetry == symmetry_90_270 ? planes / 4 : 0;
    switch ((int)f->symmetry) {
    case symmetry_round:
        return 1;
    case symmetry_0_180:
    case symmetry_90_270:
        return planes / 2 + 1;
    case symmetry_both:
        return planes / 4 + 1;
    default:
        return planes;
    }
}

/// All C angles are listed, of which the stored planes are some.
static rsv_status read_planes(
    rsv_luminaire_text *t, const eulumdat_facts *f, uint32_t first, uint32_t stored)
{
    rsv_luminaire *l = t->to;
    for (uint32_t k = 0; k < (uint32_t)f->planes; k++) {
        double value;
        rsv_status status = rsv_luminaire_number(t, "a C angle", &value);
        if (status != RSV_OK) return status;
        if (k >= first && k - first < stored) l->horizontal[k - first] = (float)value;
    }
    for (uint32_t k = 1; k < stored; k++)
        // planes up to C = 180 where the list ends before it
        if (!(l->horizontal[k] > l->horizontal[k - 1]))
            return rsv_luminaire_complain(t, "C angles do not ascend");
    return RSV_OK;
}

/// The luminous area; that of the housing where the file states none. Its length lies along C = 90, where LM-63 has the
/// width; without a width it is round.
static void set_opening(rsv_luminaire *l, const eulumdat_facts *f)
{
    bool stated = f->bright_length > 0;
    double length = (stated ? f->bright_length : f->length) / 1000,
           width = (stated ? f->bright_width : f->width) / 1000;
    bool round = length > 0 && width == 0;
    l->width = round ? -length : length;
    l->length = round ? -length : width;
    l->height = stated ? f->bright_height / 1000 : 0;
}

rsv_status rsv_luminaire_read_eulumdat(rsv_luminaire_text *t)
{
    eulumdat_facts f = { 0 };
    uint32_t first;
    rsv_luminaire *l = t->to;
    rsv_status status;
    RSV_TRY(read_head(t, &f));
    RSV_TRY(read_body(t, &f));
    uint32_t stored = stored_planes(&f, &first);
    RSV_TRY(first + stored <= (uint32_t)f.planes
                ? RSV_OK
                : rsv_luminaire_complain(t, "there are fewer C planes than the symmetry requires"));
    RSV_TRY(rsv_luminaire_reserve(t, (uint32_t)f.angles, stored));
    RSV_TRY(read_planes(t, &f, first, stored));
    RSV_TRY(rsv_luminaire_angles(t, "an angle G", l->vertical_count, l->vertical));
    RSV_TRY(rsv_luminaire_intensities(t, f.lumens / 1000 * (f.conversion > 0 ? f.conversion : 1)));
    l->type = RSV_PHOTOMETRY_C;
    rsv_luminaire_close(l);
    set_opening(l, &f);
    l->lamp_lumens = f.lumens, l->watts = f.watts;
cleanup:
    return status;
}
