#include "glare.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define DEGREES (180 / M_PI)
#define USUAL_FACTOR 5 ///< of the mean luminance, as evalglare takes it without a task

typedef struct picture {
    const float *luminance;
    uint32_t width, height;
    double radius; ///< of the half space, pixels
} picture;

/// Direction and solid angle of a pixel. @return false beyond the half space
static bool look(const picture *p, uint32_t x, uint32_t y, double direction[3], double *solid_angle)
{
    double right = x + 0.5 - 0.5 * p->width, up = 0.5 * p->height - y - 0.5;
    double away = hypot(right, up), angle = away / p->radius * M_PI / 2;
    if (away >= p->radius) return false;
    double sine = sin(angle), step = M_PI / 2 / p->radius;
    direction[0] = away > 0 ? right / away * sine : 0;
    direction[1] = away > 0 ? up / away * sine : 0;
    direction[2] = cos(angle);
    *solid_angle = step * step * (angle > 0 ? sine / angle : 1);
    return true;
}

/// Guth's, as fitted by Levin; tau from the vertical and sigma from the line of sight, degrees.
static double position_above(double tau, double sigma)
{
    double first = 35.2 - 0.31889 * tau - 1.22 * exp(-2 * tau / 9);
    double second = 21 + 0.26667 * tau - 0.002963 * tau * tau;
    return exp(1e-3 * first * sigma + 1e-5 * second * sigma * sigma);
}

double cli_position_index(const double d[3])
{
    double ahead = fmax(d[2], 1e-6), away = hypot(d[0], d[1]);
    if (d[1] >= 0) {
        double tau = away > 0 ? acos(fmin(d[1] / away, 1)) * DEGREES : 0;
        return fmin(position_above(tau, acos(fmin(ahead, 1)) * DEGREES), 16);
    }
    double ratio = away / ahead; // Iwata et al.
    return fmin(1 + (ratio < 0.6 ? 0.8 : 1.2) * ratio, 16);
}

// ---- sources ----------------------------------------------------------------------------------------

/// Sums over the pixels of a source.
typedef struct sums {
    double solid_angle, light, illuminance, direction[3];
} sums;

static void add_pixel(const picture *p, uint32_t at, sums *s)
{
    double d[3], solid_angle;
    if (!look(p, at % p->width, at / p->width, d, &solid_angle)) return;
    double light = (double)p->luminance[at] * solid_angle;
    s->solid_angle += solid_angle;
    s->light += light;
    s->illuminance += light * d[2];
    for (int c = 0; c < 3; c++)
        s->direction[c] += light * d[c];
}

static cli_glare_source source_of(const sums *s)
{
    const double *d = s->direction;
    double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    cli_glare_source source = { .luminance = s->light / s->solid_angle,
        .solid_angle = s->solid_angle,
        .illuminance = s->illuminance,
        .direction = { d[0] / length, d[1] / length, d[2] / length } };
    source.position = cli_position_index(source.direction);
    return source;
}

/// Collects a source from one of its pixels on. @param glares [pixels] cleared where collected @param stack [pixels]
static cli_glare_source collect(const picture *p, uint32_t from, uint8_t *glares, uint32_t *stack)
{
    sums s = { 0 };
    size_t count = 0;
    stack[count++] = from;
    glares[from] = 0;
    while (count) {
        uint32_t at = stack[--count];
        int x = (int)(at % p->width), y = (int)(at / p->width);
        add_pixel(p, at, &s);
        for (int k = 0; k < 9; k++) {
            int nx = x + k % 3 - 1, ny = y + k / 3 - 1;
            if (nx < 0 || ny < 0 || nx >= (int)p->width || ny >= (int)p->height) continue;
            uint32_t next = (uint32_t)ny * p->width + (uint32_t)nx;
            if (!glares[next]) continue;
            glares[next] = 0;
            stack[count++] = next;
        }
    }
    return source_of(&s);
}

static int compare_sources(const void *a, const void *b)
{
    double x = ((const cli_glare_source *)a)->luminance,
           y = ((const cli_glare_source *)b)->luminance;
    return (x < y) - (x > y);
}

static bool find_sources(const picture *p, cli_glare *glare, uint8_t *glares, uint32_t *stack)
{
    size_t capacity = 0;
    double d[3], solid_angle;
    uint32_t pixels = p->width * p->height;
    for (uint32_t at = 0; at < pixels; at++)
        glares[at] = look(p, at % p->width, at / p->width, d, &solid_angle) &&
                     (double)p->luminance[at] > glare->threshold;
    for (uint32_t at = 0; at < pixels; at++) {
        if (!glares[at]) continue;
        if (glare->count == capacity) {
            capacity = capacity ? 2 * capacity : 64;
            void *grown = realloc(glare->source, capacity * sizeof *glare->source);
            if (!grown) return false;
            glare->source = grown;
        }
        glare->source[glare->count++] = collect(p, at, glares, stack);
    }
    if (glare->count) qsort(glare->source, glare->count, sizeof *glare->source, compare_sources);
    return true;
}

// ---- figures ----------------------------------------------------------------------------------------

/// Wienold and Christoffersen (2006), with evalglare's factor for dim views.
static double find_dgp(const cli_glare *glare)
{
    double sum = 0, ev = glare->vertical;
    for (size_t k = 0; k < glare->count; k++) {
        const cli_glare_source *s = &glare->source[k];
        sum += s->luminance * s->luminance * s->solid_angle /
               (pow(ev, 1.87) * s->position * s->position);
    }
    double dgp = 5.87e-5 * ev + 0.0918 * log10(1 + sum) + 0.16;
    double dim = exp(0.024 * fmin(ev, 1000) - 4);
    return fmin(ev < 1000 ? dgp * dim / (1 + dim) : dgp, 1);
}

/// CIE 117.
static double find_ugr(const cli_glare *glare)
{
    double sum = 0;
    for (size_t k = 0; k < glare->count; k++) {
        const cli_glare_source *s = &glare->source[k];
        sum += s->luminance * s->luminance * s->solid_angle / (s->position * s->position);
    }
    if (!(sum > 0)) return -INFINITY;
    return 8 * log10(0.25 / fmax(glare->background, 1e-6) * sum);
}

bool cli_find_glare(
    const float *luminance, uint32_t width, uint32_t height, double threshold, cli_glare *glare)
{
    const picture p = { luminance, width, height, 0.5 * (width < height ? width : height) };
    sums all = { 0 };
    *glare = (cli_glare){ 0 };
    for (uint32_t at = 0; at < width * height; at++)
        add_pixel(&p, at, &all);
    glare->vertical = all.illuminance;
    glare->mean = all.solid_angle > 0 ? all.light / all.solid_angle : 0;
    glare->threshold = threshold > 0 ? threshold : USUAL_FACTOR * glare->mean;
    uint8_t *glares = calloc((size_t)width * height, sizeof *glares);
    uint32_t *stack = calloc((size_t)width * height, sizeof *stack);
    bool good = glares && stack && find_sources(&p, glare, glares, stack);
    free(glares);
    free(stack);
    if (!good) return false;
    double direct = 0;
    for (size_t k = 0; k < glare->count; k++)
        direct += glare->source[k].illuminance;
    glare->background = fmax(glare->vertical - direct, 0) / M_PI;
    glare->dgp = glare->vertical > 0 ? find_dgp(glare) : 0;
    glare->ugr = find_ugr(glare);
    return true;
}

void cli_glare_free(cli_glare *glare)
{
    free(glare->source);
    *glare = (cli_glare){ 0 };
}
