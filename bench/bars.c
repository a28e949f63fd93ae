#include "bars.h"

#include "output_file.h"

#include <stdio.h>
#include <stdlib.h>

enum { group_width = 170, chart_top = 60, chart_height = 260, margin = 30, label_height = 60 };

static const char *const colors[cli_max_series] = { "#c8401f", "#2a5d9f", "#7a9a3a", "#888888" };

static size_t series_count(const cli_bars *bars)
{
    size_t count = 0;
    while (count < cli_max_series && bars->series[count])
        count++;
    return count;
}

static double largest(const cli_bars *bars)
{
    double value = 1e-30;
    for (size_t g = 0; g < bars->group_count; g++)
        for (size_t k = 0; k < series_count(bars); k++)
            if (bars->group[g].value[k] > value) value = bars->group[g].value[k];
    return value;
}

static void draw_group(FILE *svg, const cli_bars *bars, size_t index)
{
    const cli_bar_group *group = &bars->group[index];
    size_t count = series_count(bars);
    double left = margin + (double)index * group_width, width = 0.8 * group_width / (double)count;
    double bottom = chart_top + chart_height, middle = left + 0.4 * group_width;
    for (size_t k = 0; k < count; k++) {
        double height = chart_height * group->value[k] / largest(bars);
        double x = left + (double)k * width;
        fprintf(svg, "<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f' fill='%s'/>\n", x,
            bottom - height, width - 3, height, colors[k]);
        fprintf(svg, "<text x='%.1f' y='%.1f' text-anchor='middle'>%.3g</text>\n", x + 0.5 * width,
            bottom - height - 5, bars->scale * group->value[k]);
    }
    fprintf(svg, "<text x='%.1f' y='%.1f' text-anchor='middle'>%s</text>\n", middle, bottom + 20,
        group->name);
    if (group->note)
        fprintf(svg, "<text x='%.1f' y='%.1f' text-anchor='middle'>%s</text>\n", middle,
            bottom + 38, group->note);
}

static void draw_legend(FILE *svg, const cli_bars *bars)
{
    fprintf(svg, "<text x='%d' y='20' font-weight='bold'>%s</text>\n", margin, bars->title);
    for (size_t k = 0; k < series_count(bars); k++) {
        double x = margin + (double)k * group_width;
        fprintf(svg, "<rect x='%.1f' y='29' width='10' height='10' fill='%s'/>\n", x, colors[k]);
        fprintf(svg, "<text x='%.1f' y='38'>%s</text>\n", x + 15, bars->series[k]);
    }
}

bool cli_write_bars(const char *path, const cli_bars *bars)
{
    char *text = NULL;
    size_t length = 0, columns = bars->group_count;
    FILE *svg = open_memstream(&text, &length);
    if (!svg) return false;
    if (columns < series_count(bars)) columns = series_count(bars);
    fprintf(svg,
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %zu %d' font-family='sans-serif' "
        "font-size='12'>\n<rect width='100%%' height='100%%' fill='#fff'/>\n",
        2 * margin + columns * group_width, chart_top + chart_height + label_height);
    draw_legend(svg, bars);
    for (size_t g = 0; g < bars->group_count; g++)
        draw_group(svg, bars, g);
    fputs("</svg>\n", svg);
    bool written = fclose(svg) == 0 && cli_write_file(path, text, length);
    free(text);
    return written;
}
