#include "daylight_page.h"

#include "color_scale.h"
#include "output_file.h"
#include "session.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    plan_width = 420,
    compass_width = 44,
    carpet_width = 880,
    day_height = 9,
    scale_steps = 64,
    bands = 24
};

/// Escapes characters that have a meaning in HTML.
static void print_escaped(FILE *f, const char *text)
{
    for (; *text; text++)
        switch (*text) {
        case '&':
            fputs("&amp;", f);
            break;
        case '<':
            fputs("&lt;", f);
            break;
        case '>':
            fputs("&gt;", f);
            break;
        case '"':
            fputs("&quot;", f);
            break;
        default:
            fputc(*text, f);
        }
}

static void print_color(FILE *f, double t)
{
    double srgb[3];
    cli_scale_color(t, srgb);
    fputc('#', f);
    for (int c = 0; c < 3; c++)
        fprintf(f, "%02x", (unsigned)lround(srgb[c]));
}

static void print_figure(FILE *f, rsv_figure_facts facts, rsv_figure figure)
{
    bool share = strcmp(facts.unit, "1") == 0;
    double scale = share ? 100 : 1;
    int digits = share ? 1 : fabs(figure.value) < 100 ? 1 : 0;
    fprintf(f, "<tr><td>%s</td><td>%.*f</td><td>&plusmn; %.2g</td><td>%s</td></tr>\n", facts.title,
        digits, scale * figure.value, scale * figure.standard_error, share ? "%" : facts.unit);
}

static void print_summary(FILE *f, const cli_daylight_result *r)
{
    bool rooflit = cli_daylight_is_rooflit(r->rooflit, r->run->room_count);
    fputs("<table><tr><th>Figure</th><th>Value</th><th>Standard error</th><th></th></tr>\n", f);
    for (int k = 0; k < RSV_SPACE_FIGURES; k++)
        print_figure(f, rsv_space_figure_facts((rsv_space_figure)k), r->report->space[k]);
    fprintf(f,
        "<tr><td>EN 17037, daylight provision%s</td><td>%s</td><td></td><td></td></tr></table>\n",
        rooflit ? ", horizontal openings" : "", cli_daylight_class_name(r->report->space, rooflit));
}

/// Room by room, if there are several.
static void print_rooms(FILE *f, const cli_daylight_result *r)
{
    static const rsv_space_figure shown[] = { RSV_SPACE_MEAN, RSV_SPACE_SDA, RSV_SPACE_ASE,
        RSV_SPACE_UDI_AUTONOMOUS, RSV_SPACE_DAYLIGHT_FACTOR };
    static const char *const title[] = { "Mean, lux", "sDA, %", "ASE, %", "UDI, %",
        "Daylight factor, %" };
    const int columns = sizeof shown / sizeof *shown;
    if (r->run->room_count < 2) return;
    fputs("<h2>Rooms</h2>\n<table class=\"rooms\"><tr><th>Room</th><th>Sensors</th>", f);
    for (int c = 0; c < columns; c++)
        fprintf(f, "<th>%s</th>", title[c]);
    const double *shaded = r->report->room_shaded_hours;
    fprintf(f, "%s<th>EN 17037</th></tr>\n", shaded ? "<th>Shades down, h</th>" : "");
    for (size_t k = 0; k < r->run->room_count; k++) {
        const rsv_figure *room = r->report->room[k];
        size_t count = 0;
        for (size_t s = 0; s < r->points->count; s++)
            count += r->run->room[s] == k;
        fprintf(f, "<tr><td>%zu</td><td>%zu</td>", k, count);
        for (int c = 0; c < columns; c++) {
            double scale = shown[c] == RSV_SPACE_MEAN ? 1 : 100;
            fprintf(f, "<td>%.4g &plusmn; %.2g</td>", scale * room[shown[c]].value,
                scale * room[shown[c]].standard_error);
        }
        if (shaded) fprintf(f, "<td>%.6g</td>", shaded[k]);
        fprintf(f, "<td>%s%s</td></tr>\n", cli_daylight_class_name(room, r->rooflit[k]),
            r->rooflit[k] ? " (rooflights)" : "");
    }
    fputs("</table>\n<p>Point at a sensor in a plan to read its room.</p>\n", f);
}

// ---- plans ----------------------------------------------------------------------------------------

/// Outline of the sensors from above, and the side of the square that each one has.
typedef struct plan {
    double low[2], high[2], side, scale, height;
} plan;

/// The least distance between sensors in x or z: of a grid, its spacing.
static double spacing_of(const cli_points *p)
{
    double least = INFINITY;
    size_t count = p->count < 2000 ? p->count : 2000;
    for (size_t k = 1; k < count; k++)
        for (size_t j = 0; j < k; j++) {
            double dx = fabs(p->given[k][0] - p->given[j][0]),
                   dz = fabs(p->given[k][2] - p->given[j][2]);
            double apart = fmax(dx, dz);
            if (apart > 1e-6 && apart < least) least = apart;
        }
    return isfinite(least) ? least : 1;
}

static plan plan_of(const cli_points *p)
{
    plan made = { { INFINITY, INFINITY }, { -INFINITY, -INFINITY }, spacing_of(p), 1, 1 };
    for (size_t k = 0; k < p->count; k++)
        for (int axis = 0; axis < 2; axis++) {
            double value = p->given[k][2 * axis];
            made.low[axis] = fmin(made.low[axis], value);
            made.high[axis] = fmax(made.high[axis], value);
        }
    for (int axis = 0; axis < 2; axis++) {
        made.low[axis] -= made.side / 2;
        made.high[axis] += made.side / 2;
    }
    double wide = made.high[0] - made.low[0], deep = made.high[1] - made.low[1];
    made.scale = plan_width / fmax(wide, deep);
    made.height = deep * made.scale;
    return made;
}

static void print_scale(FILE *f, double width, double top, double most, const char *unit)
{
    for (int k = 0; k < scale_steps; k++) {
        fprintf(f, "<rect x=\"%.2f\" y=\"%.1f\" width=\"%.2f\" height=\"10\" fill=\"",
            width * k / scale_steps, top, width / scale_steps + 0.5);
        print_color(f, (k + 0.5) / scale_steps);
        fputs("\"/>", f);
    }
    for (int k = 0; k <= 4; k += width < 320 ? 2 : 1)
        fprintf(f, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">%.6g%s</text>", width * k / 4,
            top + 24,
            k == 0   ? "start"
            : k == 4 ? "end"
                     : "middle",
            most * k / 4, k == 4 ? unit : "");
    fputc('\n', f);
}

/// An arrow to the north of a plan whose up is -z.
static void print_compass(FILE *f, double north, double x)
{
    fprintf(f,
        "<g transform=\"translate(%.1f 20) rotate(%.4g)\"><path d=\"M0 -16 L6 8 L0 3 L-6 8 Z\" "
        "fill=\"#444\"/><text y=\"-18\" text-anchor=\"middle\">N</text></g>\n",
        x, north);
}

/// The figure at each sensor, from above. Where sensors stand above each other, the last one shows.
static void print_plan(FILE *f, const cli_daylight_result *r, rsv_sensor_figure figure, double most)
{
    plan p = plan_of(r->points);
    rsv_figure_facts facts = rsv_sensor_figure_facts(figure);
    bool share = strcmp(facts.unit, "1") == 0;
    double scale = share ? 100 : 1, side = p.side * p.scale,
           width = (p.high[0] - p.low[0]) * p.scale;
    fprintf(f, "<figure><figcaption>%s</figcaption><svg viewBox=\"-2 -14 %d %.1f\" width=\"%d\">\n",
        facts.title, plan_width + compass_width, p.height + 52, plan_width);
    for (size_t k = 0; k < r->points->count; k++) {
        const rsv_figure *value = &r->report->sensor[k][figure];
        fprintf(f, "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"",
            (r->points->given[k][0] - p.low[0]) * p.scale - side / 2,
            (r->points->given[k][2] - p.low[1]) * p.scale - side / 2, side + 0.3, side + 0.3);
        print_color(f, scale * value->value / most);
        fprintf(f, "\"><title>sensor %zu", k);
        if (r->run->room_count > 1) fprintf(f, ", room %u", r->run->room[k]);
        fprintf(f, ": %.4g &#177; %.2g %s</title></rect>\n", scale * value->value,
            scale * value->standard_error, share ? "%" : facts.unit);
    }
    print_compass(f, r->desc->north, fmax(width, 160) + 24);
    print_scale(f, fmax(width, 160), p.height + 6, most,
        share                  ? " %"
        : facts.unit[0] == 'l' ? " lux"
                               : " h");
    fputs("</svg></figure>\n", f);
}

/// A round number at or above the largest value of a figure.
static double most_of(const cli_daylight_result *r, rsv_sensor_figure figure)
{
    double most = 0;
    bool share = strcmp(rsv_sensor_figure_facts(figure).unit, "1") == 0;
    for (size_t k = 0; k < r->points->count; k++)
        most = fmax(most, (share ? 100 : 1) * r->report->sensor[k][figure].value);
    if (!(most > 0)) return 1;
    double power = pow(10, floor(log10(most)));
    for (int k = 2; k < 10; k++)
        if (most <= k * power) return k * power;
    return 10 * power;
}

static void print_plans(FILE *f, const cli_daylight_result *r)
{
    static const rsv_sensor_figure shown[] = { RSV_SENSOR_MEAN, RSV_SENSOR_DA,
        RSV_SENSOR_UDI_AUTONOMOUS, RSV_SENSOR_SUN_HOURS, RSV_SENSOR_DAYLIGHT_FACTOR,
        RSV_SENSOR_MEDIAN };
    fputs("<div class=\"plans\">\n", f);
    for (size_t k = 0; k < sizeof shown / sizeof *shown; k++) {
        bool whole = shown[k] == RSV_SENSOR_DA || shown[k] == RSV_SENSOR_UDI_AUTONOMOUS;
        print_plan(f, r, shown[k], whole ? 100 : most_of(r, shown[k]));
    }
    fputs("</div>\n", f);
}

// ---- the year -------------------------------------------------------------------------------------

/// Mean lux over the sensors, by day of the year and hour: [366][bands], and how many records each is of.
typedef struct carpet {
    double sum[366][bands], count[366][bands], most;
} carpet;

static void fill_carpet(const cli_daylight_result *r, carpet *c)
{
    size_t sensors = r->points->count;
    for (size_t h = 0; h < r->weather->count; h++) {
        const rsv_moment *m = &r->weather->hour[h].moment;
        int day = rsv_day_of_year(r->weather->leap ? 2000 : 2001, m->month, m->day) - 1;
        int hour = m->hour >= 24 ? bands - 1 : (int)m->hour;
        double sum = 0;
        for (size_t k = 0; k < sensors; k++)
            sum += (double)r->hourly[h * sensors + k];
        c->sum[day % 366][hour] += sum / (double)sensors;
        c->count[day % 366][hour]++;
    }
    for (int day = 0; day < 366; day++)
        for (int hour = 0; hour < bands; hour++) {
            if (c->count[day][hour] > 0) c->sum[day][hour] /= c->count[day][hour];
            c->most = fmax(c->most, c->sum[day][hour]);
        }
}

/// Runs of days of one colour are one rectangle: most of the night is.
static void print_hour(FILE *f, const carpet *c, int hour)
{
    const double wide = (double)carpet_width / 366;
    const int levels = 48;
    for (int day = 0; day < 366;) {
        int end = day, level = (int)(levels * sqrt(c->sum[day][hour] / c->most));
        bool known = c->count[day][hour] > 0;
        while (end < 366 && (c->count[end][hour] > 0) == known &&
               (int)(levels * sqrt(c->sum[end][hour] / c->most)) == level)
            end++;
        if (known) {
            fprintf(f, "<rect x=\"%.2f\" y=\"%d\" width=\"%.2f\" height=\"%d\" fill=\"", wide * day,
                day_height * (bands - 1 - hour), wide * (end - day) + 0.05, day_height);
            print_color(f, (double)level / levels);
            fputs("\"/>", f);
        }
        day = end;
    }
    fputc('\n', f);
}

static void print_carpet(FILE *f, const cli_daylight_result *r, carpet *c)
{
    static const char *const month[] = { "Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug",
        "Sep", "Oct", "Nov", "Dec" };
    fill_carpet(r, c);
    if (!(c->most > 0)) c->most = 1;
    fprintf(f,
        "<figure><figcaption>Mean over the sensors, day by day from left to right, 0 to 24 h "
        "standard time from below; colours by the square root, to %.4g lux</figcaption>\n"
        "<svg viewBox=\"-28 -4 %d %d\" width=\"%d\" class=\"carpet\">\n",
        c->most, carpet_width + 32, day_height * bands + 24, carpet_width);
    for (int hour = 0; hour < bands; hour++)
        print_hour(f, c, hour);
    for (int k = 0; k < 12; k++)
        fprintf(f, "<text x=\"%.1f\" y=\"%d\">%s</text>",
            carpet_width * (rsv_day_of_year(2000, k + 1, 1) - 1) / 366.0, day_height * bands + 14,
            month[k]);
    for (int hour = 0; hour <= 24; hour += 6)
        fprintf(f, "<text x=\"-4\" y=\"%d\" text-anchor=\"end\">%d</text>",
            day_height * (bands - hour) + 4, hour);
    fputs("\n</svg></figure>\n", f);
}

// ---- the page -------------------------------------------------------------------------------------

static void print_head(FILE *f, const cli_daylight_result *r)
{
    fputs("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Daylight: ", f);
    print_escaped(f, r->scene);
    fputs(
        "</title><style>body{font:15px/1.5 sans-serif;max-width:960px;margin:2em auto;padding:0 "
        "1em;"
        "color:#222}table{border-collapse:collapse}td,th{padding:.2em 1em .2em 0;text-align:left;"
        "border-bottom:1px solid "
        "#ddd}td:nth-child(2),td:nth-child(3){text-align:right}figure{margin:1em 0}"
        "figcaption{margin-bottom:.3em}svg{max-width:100%;height:auto}svg text{font:11px "
        "sans-serif;fill:#444}"
        ".rooms td,.rooms th{text-align:right}.plans{display:flex;flex-wrap:wrap;gap:1.5em}</style></head><body>\n<h1>Daylight</"
        "h1>\n<p>",
        f);
    print_escaped(f, r->scene);
    fputs(" under the weather of ", f);
    print_escaped(f, r->weather->name);
    fprintf(f,
        " (%.2f&deg;, %.2f&deg;); %zu sensors, %.0f hours, of which %.0f occupied (%g to %g h). "
        "North lies %g&deg; clockwise from -z.%s</p>\n",
        r->weather->site.latitude, r->weather->site.longitude, r->points->count, r->report->hours,
        r->report->occupied_hours, r->run->from, r->run->to, r->desc->north,
        r->run->sky_only ? " The sun is left out: sky and ground alone." : "");
    if (r->weather->filled || r->weather->missing || r->buried)
        fprintf(f,
            "<p>%zu records had no irradiances and took those of the nearest day; %zu hours of the "
            "year are missing; %zu sensors lie within walls or furniture.</p>\n",
            r->weather->filled, r->weather->missing, r->buried);
}

static void print_page(FILE *f, const cli_daylight_result *r, carpet *c)
{
    print_head(f, r);
    fputs("<h2>Figures</h2>\n", f);
    print_summary(f, r);
    print_rooms(f, r);
    fputs("<h2>Plans</h2>\n<p>Seen from above, +x to the right, +z down. Point at a sensor to read "
          "it.</p>\n",
        f);
    print_plans(f, r);
    fputs("<h2>The year</h2>\n", f);
    print_carpet(f, r, c);
    fprintf(f,
        "<p>Resolvent %s. Standard errors cover sampling, noise and interpolation; not the "
        "weather, nor "
        "the materials.</p>\n</body></html>\n",
        rsv_version());
}

bool cli_write_daylight_page(const char *path, const cli_daylight_result *result)
{
    char *text = NULL;
    size_t length = 0;
    carpet *c = calloc(1, sizeof *c);
    FILE *stream = c ? open_memstream(&text, &length) : NULL;
    if (stream) print_page(stream, result, c);
    bool complete = stream && !ferror(stream);
    if (stream && fclose(stream) != 0) complete = false;
    if (!complete) cli_error("%s: out of memory writing the report", path);
    bool written = complete && cli_write_file(path, text, length);
    free(text);
    free(c);
    return written;
}
