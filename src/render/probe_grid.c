#include "probe_grid.h"

#include "../core/parallel.h"

#include <string.h>

#define PI 3.14159265358979323846
#define NORMALS 32
#define HARMONICS RSV_PROBE_HARMONICS
#define MOST_PROBES ((size_t)1 << 20)
/// Number of probes along the longest side, if no spacing is given.
#define PROBES_ALONG 16
/// A probe that sees more backs than this share is inside something.
#define MOST_BACKS 0.25f
/// Backs of double-sided surfaces may be a room's walls. A probe that sees more of them than this fraction is inside
/// something if it receives less than this fraction of the mean of surfaces.
#define MOST_DOUBLE_SIDED 0.75f
#define DARK 0.01

/// Of radiance in irradiance, by harmonic.
static const double kept[HARMONICS] = { PI, 2 * PI / 3, 2 * PI / 3, 2 * PI / 3, PI / 4, PI / 4,
    PI / 4, PI / 4, PI / 4 };

/// @param weight sum 1
static void choose_normals(rsv_vec3 normal[NORMALS], double weight[NORMALS])
{
    const float golden = 1.6180339887f;
    int n = 0;
    for (int k = 0; k < 12; k++) { // cyclic permutations of (0, +-1, +-golden)
        float v[3] = { 0, 0, 0 };
        v[(k / 4 + 1) % 3] = k & 1 ? -1.0f : 1.0f;
        v[(k / 4 + 2) % 3] = k & 2 ? -golden : golden;
        normal[n] = v3_normalize(v3(v[0], v[1], v[2]));
        weight[n++] = 5.0 / 168;
    }
    for (int k = 0; k < 8; k++) {
        normal[n] = v3_normalize(v3(k & 1 ? -1 : 1, k & 2 ? -1 : 1, k & 4 ? -1 : 1));
        weight[n++] = 9.0 / 280;
    }
    for (int k = 0; k < 12; k++) { // cyclic permutations of (0, +-golden, +-1 / golden)
        float v[3] = { 0, 0, 0 };
        v[(k / 4 + 1) % 3] = k & 1 ? -golden : golden;
        v[(k / 4 + 2) % 3] = k & 2 ? -1 / golden : 1 / golden;
        normal[n] = v3_normalize(v3(v[0], v[1], v[2]));
        weight[n++] = 9.0 / 280;
    }
}

/// Real spherical harmonics of a unit vector, in the order (0,0) (1,-1) (1,0) (1,1) (2,-2) .. (2,2).
static void harmonics(rsv_vec3 n, double y[HARMONICS])
{
    double x = (double)n.x, v = (double)n.y, z = (double)n.z;
    const double value[HARMONICS] = { 0.28209479177, 0.48860251190 * v, 0.48860251190 * z,
        0.48860251190 * x, 1.09254843059 * x * v, 1.09254843059 * v * z,
        0.31539156525 * (3 * z * z - 1), 1.09254843059 * x * z, 0.54627421529 * (x * x - v * v) };
    memcpy(y, value, sizeof value);
}

// ---- the grid -------------------------------------------------------------------------------------

static rsv_status lay_grid(rsv_probe_grid *g, float spacing)
{
    const rsv_scene_view *view = g->solution->scene.view;
    rsv_vec3 extent = v3_sub(view->bounds_max, view->bounds_min);
    if (spacing <= 0) spacing = v3_max_abs(extent) / PROBES_ALONG;
    double all = 1;
    float *origin = &g->origin.x, *step = &g->spacing.x;
    for (int a = 0; a < 3; a++) {
        float length = (&extent.x)[a], cells = ceilf(length / spacing - 1e-3f);
        all *= fmax((double)cells, 1);
        if (all > (double)MOST_PROBES)
            return rsv_fail(RSV_ERROR_ARGUMENT,
                "probes %g m apart would be more than %zu; ask for a wider spacing",
                (double)spacing, MOST_PROBES);
        g->size[a] = cells < 1 ? 1 : (uint32_t)cells;
        step[a] = length > 0 ? length / (float)g->size[a] : spacing;
        origin[a] = (&view->bounds_min.x)[a] + 0.5f * step[a];
    }
    g->count = (size_t)all;
    return RSV_OK;
}

static rsv_vec3 place_of(const rsv_probe_grid *g, size_t probe)
{
    size_t x = probe % g->size[0], y = probe / g->size[0] % g->size[1];
    size_t z = probe / g->size[0] / g->size[1];
    return v3(g->origin.x + (float)x * g->spacing.x, g->origin.y + (float)y * g->spacing.y,
        g->origin.z + (float)z * g->spacing.z);
}

typedef enum sight { SEES_ELSE, SEES_BACK, SEES_DOUBLE_SIDED_BACK } sight;

/// The first hit of a ray from a probe: the back of something opaque, or anything else.
static sight look(const rsv_probe_grid *g, rsv_vec3 from, rsv_vec3 direction)
{
    const rsv_scene_view *view = g->solution->scene.view;
    const rsv_ray ray = { .origin = from, .direction = direction, .t_max = INFINITY };
    rsv_hit hit;
    if (!rsv_tracer_closest(g->solution->tracer, &ray, &hit)) return SEES_ELSE;
    const uint32_t *v = view->triangle[hit.triangle];
    const rsv_material *m = &view->material[view->triangle_material[hit.triangle]];
    rsv_vec3 normal = v3_cross(v3_sub(view->position[v[1]], view->position[v[0]]),
        v3_sub(view->position[v[2]], view->position[v[0]]));
    if (v3_dot(normal, direction) <= 0 || m->transmission > 0) return SEES_ELSE;
    return m->double_sided ? SEES_DOUBLE_SIDED_BACK : SEES_BACK;
}

static void judge_places(void *job, rsv_span span)
{
    const rsv_probe_grid *g = job;
    rsv_vec3 normal[NORMALS];
    double weight[NORMALS];
    choose_normals(normal, weight);
    for (size_t k = span.begin; k < span.end; k++) {
        rsv_vec3 place = place_of(g, k);
        int seen[3] = { 0 };
        for (int n = 0; n < NORMALS; n++)
            seen[look(g, place, normal[n])]++;
        int backs = seen[SEES_BACK] + seen[SEES_DOUBLE_SIDED_BACK];
        g->valid[k] = (float)seen[SEES_BACK] > MOST_BACKS * NORMALS ? 0
                      : (float)backs > MOST_DOUBLE_SIDED * NORMALS  ? RSV_PROBE_ENCLOSED
                                                                    : 1;
    }
}

rsv_status rsv_probe_grid_create(const rsv_light_view *solution, float spacing, uint32_t samples,
    bool sources, rsv_probe_grid *g)
{
    *g = (rsv_probe_grid){ .solution = solution,
        .job = rsv_probe_job_of(solution, samples, solution->desc.seed, sources) };
    rsv_status status = lay_grid(g, spacing);
    if (status != RSV_OK) return status;
    g->coefficient = rsv_alloc(solution->context, g->count, sizeof *g->coefficient);
    g->valid = rsv_alloc(solution->context, g->count, 1);
    g->lit = rsv_alloc(solution->context, g->count, 1);
    if (g->coefficient && g->valid && g->lit) {
        rsv_parallel_for(solution->context, g->count, 16, judge_places, g);
        return RSV_OK;
    }
    rsv_probe_grid_destroy(g);
    return RSV_ERROR_MEMORY;
}

void rsv_probe_grid_destroy(rsv_probe_grid *g)
{
    if (!g->solution) return;
    rsv_free(g->solution->context, g->coefficient);
    rsv_free(g->solution->context, g->valid);
    rsv_free(g->solution->context, g->lit);
    *g = (rsv_probe_grid){ 0 };
}

// ---- light ----------------------------------------------------------------------------------------

static void add_reading(rsv_rgb irradiance, rsv_vec3 normal, double weight, double sum[][3])
{
    double y[HARMONICS];
    harmonics(normal, y);
    for (int h = 0; h < HARMONICS; h++)
        for (int c = 0; c < 3; c++)
            sum[h][c] += 4 * PI * weight * y[h] / kept[h] * (double)(&irradiance.r)[c];
}

/// Readings of a probe by all normals.
typedef struct reading_job {
    const rsv_probe_job *job;
    rsv_vec3 place, normal[NORMALS];
    rsv_rgb irradiance[NORMALS];
} reading_job;

static void read_normals(void *user, rsv_span span)
{
    reading_job *r = user;
    for (size_t n = span.begin; n < span.end; n++) {
        const rsv_probe receiver = { .position = r->place, .normal = r->normal[n] };
        r->irradiance[n] = rsv_probe_read(r->job, &receiver, (uint32_t)n).irradiance;
    }
}

void rsv_probe_grid_light(rsv_probe_grid *g, size_t probe)
{
    double weight[NORMALS], sum[HARMONICS][3] = { { 0 } };
    reading_job readings = { .job = &g->job, .place = place_of(g, probe) };
    choose_normals(readings.normal, weight);
    rsv_parallel_for(g->solution->context, NORMALS, 1, read_normals, &readings);
    for (int n = 0; n < NORMALS; n++)
        add_reading(readings.irradiance[n], readings.normal[n], weight[n], sum);
    for (int h = 0; h < HARMONICS; h++)
        g->coefficient[probe][h] = rgb((float)sum[h][0], (float)sum[h][1], (float)sum[h][2]);
    g->lit[probe] = 1;
}

void rsv_probe_grid_judge(rsv_probe_grid *g)
{
    double mean = g->solution->report.mean_irradiance;
    for (size_t k = 0; k < g->count; k++) {
        if (g->valid[k] != RSV_PROBE_ENCLOSED) continue;
        // of equal radiance all around, the first harmonic is 2 sqrt(pi) times it
        double irradiance = (double)rgb_luminance(g->coefficient[k][0]) * sqrt(PI) / 2;
        g->valid[k] = irradiance >= DARK * mean;
        if (!g->valid[k]) memset(g->coefficient[k], 0, sizeof g->coefficient[k]);
    }
}

void rsv_probe_grid_darken(rsv_probe_grid *g) { memset(g->lit, 0, g->count); }

void rsv_probe_grid_around(
    const rsv_probe_grid *g, rsv_vec3 point, size_t probe[8], float weight[8])
{
    size_t low[3], high[3];
    float share[3];
    for (int a = 0; a < 3; a++) {
        float last = (float)(g->size[a] - 1);
        float at = ((&point.x)[a] - (&g->origin.x)[a]) / (&g->spacing.x)[a];
        at = f_min(f_max(at, 0), last);
        low[a] = (size_t)at;
        high[a] = low[a] + 1 < g->size[a] ? low[a] + 1 : low[a];
        share[a] = at - (float)low[a];
    }
    for (int k = 0; k < 8; k++) {
        size_t x = k & 1 ? high[0] : low[0], y = k & 2 ? high[1] : low[1];
        size_t z = k & 4 ? high[2] : low[2];
        probe[k] = (z * g->size[1] + y) * g->size[0] + x;
        weight[k] = (k & 1 ? share[0] : 1 - share[0]) * (k & 2 ? share[1] : 1 - share[1]) *
                    (k & 4 ? share[2] : 1 - share[2]);
    }
}

static rsv_rgb irradiance_of(const rsv_rgb *coefficient, rsv_vec3 normal)
{
    double y[HARMONICS];
    rsv_rgb sum = rgb_gray(0);
    harmonics(normal, y);
    for (int h = 0; h < HARMONICS; h++)
        sum = rgb_mad(sum, (float)(kept[h] * y[h]), coefficient[h]);
    return rgb_positive(sum);
}

static bool sees_probe(const rsv_probe_grid *g, rsv_vec3 origin, size_t probe)
{
    rsv_ray ray = { origin, v3_sub(place_of(g, probe), origin), 1 };
    return !rsv_tracer_occluded(g->solution->tracer, &ray);
}

rsv_rgb rsv_probe_grid_irradiance(const rsv_probe_grid *g, rsv_vec3 point, rsv_vec3 normal)
{
    const rsv_light_view *s = g->solution;
    size_t probe[8];
    float weight[8], total = 0;
    rsv_rgb sum = rgb_gray(0);
    rsv_vec3 origin = rsv_offset_origin(point, normal, rsv_scene_extent(s->scene.view));
    rsv_probe_grid_around(g, point, probe, weight);
    for (int k = 0; k < 8; k++) {
        if (weight[k] <= 0 || !g->lit[probe[k]] || !sees_probe(g, origin, probe[k])) continue;
        sum = rgb_mad(sum, weight[k], irradiance_of(g->coefficient[probe[k]], normal));
        total += weight[k];
    }
    if (total > 0) return rgb_scale(sum, 1 / total);
    const rsv_probe receiver = { .position = point, .normal = normal };
    return rsv_probe_read(&g->job, &receiver, 0).irradiance;
}
