#include "plot.h"

#include <math.h>

void cli_axis_cover(cli_axis *axis, double low, double high)
{
    axis->low = pow(10, floor(log10(low)));
    axis->high = pow(10, ceil(log10(high)));
}

double cli_axis_place(const cli_axis *axis, double value)
{
    return axis->from +
           (axis->to - axis->from) * log10(value / axis->low) / log10(axis->high / axis->low);
}

void cli_plot_line(const cli_plot *p, const double from[2], const double to[2], const char *style)
{
    fprintf(p->svg, "<path d='M%.1f %.1fL%.1f %.1f' class='%s'/>\n", cli_axis_place(&p->x, from[0]),
        cli_axis_place(&p->y, from[1]), cli_axis_place(&p->x, to[0]), cli_axis_place(&p->y, to[1]),
        style);
}

static void draw_number(
    const cli_plot *p, double x, double y, const char *anchor, const cli_axis *axis, double value)
{
    fprintf(p->svg, "<text x='%.1f' y='%.1f' text-anchor='%s'>", x, y, anchor);
    fprintf(p->svg, axis->format, value / axis->unit);
    fprintf(p->svg, "</text>\n");
}

static void draw_upright_grid(const cli_plot *p)
{
    for (double decade = p->x.low; decade < 1.5 * p->x.high; decade *= 10) {
        for (int digit = 1; digit < 10 && digit * decade < 1.01 * p->x.high; digit++)
            cli_plot_line(p, (double[]){ digit * decade, p->y.low },
                (double[]){ digit * decade, p->y.high }, digit == 1 ? "decade" : "grid");
        draw_number(p, cli_axis_place(&p->x, decade), p->y.from + 20, "middle", &p->x, decade);
    }
}

static void draw_level_grid(const cli_plot *p)
{
    for (double decade = p->y.low; decade < 1.5 * p->y.high; decade *= 10) {
        for (int digit = 1; digit < 10 && digit * decade < 1.01 * p->y.high; digit++)
            cli_plot_line(p, (double[]){ p->x.low, digit * decade },
                (double[]){ p->x.high, digit * decade }, digit == 1 ? "decade" : "grid");
        draw_number(p, p->x.from - 8, cli_axis_place(&p->y, decade) + 4, "end", &p->y, decade);
    }
}

void cli_plot_grid(const cli_plot *p)
{
    draw_upright_grid(p);
    draw_level_grid(p);
}
