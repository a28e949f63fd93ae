#include "bake_texels.h"

#include "../core/parallel.h"
#include "../core/vec.h"
#include "bake_constants.h"

/// A triangle in the map.
typedef struct flat_triangle {
    float p[3][2];
    float area; ///< twice, signed
} flat_triangle;

static void barycentric(const flat_triangle *f, float x, float y, float w[3])
{
    for (int k = 0; k < 3; k++) {
        const float *a = f->p[(k + 1) % 3], *b = f->p[(k + 2) % 3];
        w[k] = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / f->area;
    }
}

/// Weights of the point of edge a-b nearest to (x, y); its squared distance.
static float nearest_on_edge(const flat_triangle *f, int a, int b, float x, float y, float w[3])
{
    float dx = f->p[b][0] - f->p[a][0], dy = f->p[b][1] - f->p[a][1];
    float length = dx * dx + dy * dy;
    float t = length > 0 ? ((x - f->p[a][0]) * dx + (y - f->p[a][1]) * dy) / length : 0;
    t = f_min(f_max(t, 0), 1);
    w[0] = w[1] = w[2] = 0;
    w[a] = 1 - t;
    w[b] = t;
    float ex = f->p[a][0] + t * dx - x, ey = f->p[a][1] + t * dy - y;
    return ex * ex + ey * ey;
}

/// Weights of the triangle's point nearest to (x, y); its distance, 0 inside.
static float nearest(const flat_triangle *f, float x, float y, float w[3])
{
    barycentric(f, x, y, w);
    bool is_flat = w[0] + w[1] + w[2] < 0.5f; // not 1, as of others
    if (!is_flat && w[0] >= 0 && w[1] >= 0 && w[2] >= 0) return 0;
    float best = INFINITY;
    for (int k = 0; k < 3; k++) {
        float on_edge[3], distance = nearest_on_edge(f, k, (k + 1) % 3, x, y, on_edge);
        if (distance >= best) continue;
        best = distance;
        w[0] = on_edge[0], w[1] = on_edge[1], w[2] = on_edge[2];
    }
    return sqrtf(best);
}

/// Texels from a point within the triangle to its nearest edge or, where more, the share of its height: many triangles
/// are smaller than a texel.
static float depth_of(const flat_triangle *f, float x, float y)
{
    float depth = INFINITY, share[3], w[3];
    barycentric(f, x, y, share);
    for (int k = 0; k < 3; k++)
        depth = f_min(depth, nearest_on_edge(f, k, (k + 1) % 3, x, y, w));
    return f_max(sqrtf(depth), f_min(f_min(share[0], share[1]), share[2]));
}

/// The receiver at weights `w`.
static rsv_bake_receiver receive(const rsv_bake_part *part, uint32_t triangle, const float w[3])
{
    rsv_bake_receiver r = { .triangle = part->triangle[triangle], .back = part->back[triangle] };
    rsv_bake_place(part, w[1], w[2], &r.u, &r.v);
    return r;
}

/// Lets a receiver at weights `w` stand for a texel at (x, y) beyond the border there.
static void extend(const flat_triangle *f, const rsv_bake_part *part, const float w[3], float x,
    float y, rsv_bake_receiver *r)
{
    float on_x = 0, on_y = 0, back[3];
    for (int k = 0; k < 3; k++)
        on_x += w[k] * f->p[k][0], on_y += w[k] * f->p[k][1];
    barycentric(f, 2 * on_x - x, 2 * on_y - y, back);
    if (back[0] < 0 || back[1] < 0 || back[2] < 0) return;
    rsv_bake_place(part, back[1], back[2], &r->u_back, &r->v_back);
    r->beyond = 1;
}

typedef struct rasterizer {
    const rsv_bake_charts *charts;
    const rsv_bake_part *parts;
    rsv_bake_map *map;
    float reach; ///< texels beyond borders
    uint8_t *overlap;
} rasterizer;

static void take_texel(const rasterizer *q, const flat_triangle *f, const rsv_bake_chart *chart,
    uint32_t k, uint32_t x, uint32_t y)
{
    rsv_bake_map *map = q->map;
    size_t texel = (size_t)y * map->width + x;
    float w[3], px = (float)x + 0.5f, py = (float)y + 0.5f;
    float distance = nearest(f, px, py, w);
    bool twice = q->overlap && distance == 0 && map->distance[texel] == 0 &&
                 depth_of(f, px, py) > OVERLAP_DEPTH;
    if (twice) q->overlap[k] = 1;
    if (distance > q->reach || distance >= map->distance[texel]) return;
    const rsv_bake_part *part = &q->parts[chart->part];
    map->distance[texel] = distance;
    map->owner[texel] = k;
    map->receiver[texel] = receive(part, q->charts->triangle[k], w);
    if (distance != 0) extend(f, part, w, px, py, &map->receiver[texel]);
}

static void draw_triangle(const rasterizer *q, const rsv_bake_chart *chart, uint32_t k)
{
    flat_triangle f;
    float low[2] = { INFINITY, INFINITY }, high[2] = { 0, 0 };
    for (int v = 0; v < 3; v++) {
        rsv_bake_chart_point(chart, q->charts->corner[k][v], f.p[v]);
        for (int a = 0; a < 2; a++) {
            low[a] = f_min(low[a], f.p[v][a]);
            high[a] = f_max(high[a], f.p[v][a]);
        }
    }
    f.area = (f.p[1][0] - f.p[0][0]) * (f.p[2][1] - f.p[0][1]) -
             (f.p[2][0] - f.p[0][0]) * (f.p[1][1] - f.p[0][1]);
    if (f.area == 0) f.area = 1e-30f; // flat in the map: its edges still are places
    uint32_t begin[2], end[2]; // within the chart's rectangle, beyond which filtering does not read
    for (int a = 0; a < 2; a++) {
        begin[a] = (uint32_t)f_max(low[a] - q->reach, (float)chart->at[a]);
        end[a] = (uint32_t)f_min(high[a] + q->reach + 1, (float)(chart->at[a] + chart->texels[a]));
    }
    for (uint32_t y = begin[1]; y < end[1]; y++)
        for (uint32_t x = begin[0]; x < end[0]; x++)
            take_texel(q, &f, chart, k, x, y);
}

/// Fills empty texels with the value of the nearest others: smaller mip levels, and lookups beyond the border at
/// silhouettes, would otherwise be dark.
static rsv_status fill_gaps(rsv_context *context, rsv_bake_map *map)
{
    size_t texels = (size_t)map->width * map->height, count = 0;
    uint32_t *queue = rsv_alloc(context, texels, sizeof *queue);
    if (!queue) return RSV_ERROR_MEMORY;
    for (uint32_t k = 0; k < texels; k++)
        if (map->receiver[k].triangle != RSV_NONE) queue[count++] = k;
    for (size_t n = 0; n < count; n++) {
        uint32_t k = queue[n], x = k % map->width, y = k / map->width;
        const bool inside[4] = { x > 0, x + 1 < map->width, y > 0, y + 1 < map->height };
        const uint32_t next[4] = { k - 1, k + 1, k - map->width, k + map->width };
        for (int side = 0; side < 4; side++) {
            if (!inside[side] || map->receiver[next[side]].triangle != RSV_NONE) continue;
            map->receiver[next[side]] = map->receiver[k];
            map->repeats[next[side]] = map->owner[k] == RSV_NONE ? map->repeats[k] : k;
            queue[count++] = next[side];
        }
    }
    rsv_free(context, queue);
    return RSV_OK;
}

rsv_status rsv_bake_map_create(const rsv_bake_charts *charts, const rsv_bake_part *parts,
    rsv_bake_extent extent, rsv_bake_map *map, uint8_t *overlap)
{
    rsv_context *context = charts->context;
    size_t texels = (size_t)extent.width * extent.height;
    *map = (rsv_bake_map){ .width = extent.width,
        .height = extent.height,
        .receiver = rsv_alloc(context, texels, sizeof *map->receiver),
        .distance = rsv_alloc(context, texels, sizeof *map->distance),
        .owner = rsv_alloc(context, texels, sizeof *map->owner),
        .repeats = rsv_alloc(context, texels, sizeof *map->repeats),
        .light = rsv_alloc(context, texels, sizeof *map->light) };
    if (!map->receiver || !map->distance || !map->owner || !map->repeats || !map->light)
        return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < texels; k++) {
        map->distance[k] = INFINITY;
        map->receiver[k].triangle = RSV_NONE;
        map->owner[k] = map->repeats[k] = RSV_NONE;
    }
    // filtering reaches a texel and a half beyond a border; charts keep their distance for that
    const float reach = f_min(1.5f, 0.5f * (float)extent.padding + 0.5f);
    const rasterizer q = { charts, parts, map, reach, overlap };
    for (size_t c = 0; c < charts->count; c++)
        for (uint32_t k = 0; k < charts->chart[c].triangle_count; k++)
            draw_triangle(&q, &charts->chart[c], charts->chart[c].first + k);
    return fill_gaps(context, map);
}

void rsv_bake_map_destroy(rsv_context *context, rsv_bake_map *map)
{
    rsv_free(context, map->receiver);
    rsv_free(context, map->distance);
    rsv_free(context, map->owner);
    rsv_free(context, map->repeats);
    rsv_free(context, map->light);
    *map = (rsv_bake_map){ 0 };
}

/// Keeps texels beyond a border close to the value on it.
static float limit(float beyond, rsv_rgb on, rsv_rgb back)
{
    float change = f_max(fabsf(on.r - back.r), f_max(fabsf(on.g - back.g), fabsf(on.b - back.b)));
    float most = MOST_BEYOND * f_min(on.r, f_min(on.g, on.b));
    if (change <= most) return beyond;
    return change > 0 ? most / change : 0;
}

static rsv_rgb light_of(const rsv_light_view *s, rsv_bake_receiver r)
{
    if (r.beyond > 0)
        r.beyond = limit(r.beyond, rsv_bake_shown(s, r.triangle, r.back, r.u, r.v),
            rsv_bake_shown(s, r.triangle, r.back, r.u_back, r.v_back));
    return rsv_bake_irradiance(s, &r);
}

typedef struct light_job {
    const rsv_light_view *light;
    const rsv_bake_map *map;
} light_job;

static void light_texels(void *job, rsv_span span)
{
    const light_job *q = job;
    for (size_t k = span.begin; k < span.end; k++)
        q->map->light[k] = light_of(q->light, q->map->receiver[k]);
}

void rsv_bake_map_light(const rsv_light_view *s, rsv_bake_map *map)
{
    size_t texels = (size_t)map->width * map->height;
    rsv_parallel_for(s->context, texels, 1024, light_texels, &(light_job){ s, map });
}

double rsv_bake_map_sum(const rsv_bake_map *map)
{
    double sum = 0;
    for (size_t k = 0; k < (size_t)map->width * map->height; k++)
        if (map->distance[k] < 0.5f) sum += (double)rgb_luminance(map->light[k]);
    return sum;
}

void rsv_bake_map_locate(
    const rsv_bake_map *map, const float point[2], uint32_t at[2], float part[2])
{
    const uint32_t size[2] = { map->width, map->height };
    for (int a = 0; a < 2; a++) {
        float x = f_min(f_max(point[a] - 0.5f, 0), (float)(size[a] - 2));
        at[a] = (uint32_t)x;
        part[a] = f_min(f_max(point[a] - 0.5f - (float)at[a], 0), 1);
    }
}

rsv_rgb rsv_bake_map_lookup(const rsv_bake_map *map, const float point[2])
{
    uint32_t at[2];
    float part[2];
    rsv_bake_map_locate(map, point, at, part);
    const rsv_rgb *row = map->light + (size_t)at[1] * map->width + at[0], *next = row + map->width;
    rsv_rgb low = rgb_mad(rgb_scale(row[0], 1 - part[0]), part[0], row[1]);
    rsv_rgb high = rgb_mad(rgb_scale(next[0], 1 - part[0]), part[0], next[1]);
    return rgb_mad(rgb_scale(low, 1 - part[1]), part[1], high);
}

double rsv_bake_map_coverage(const rsv_bake_map *map)
{
    size_t shown = 0, texels = (size_t)map->width * map->height;
    for (size_t k = 0; k < texels; k++)
        shown += map->distance[k] < 0.5f;
    return texels ? (double)shown / (double)texels : 0;
}
