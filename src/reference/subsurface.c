#include "subsurface.h"

#include "../core/parallel.h"

#include <string.h>

/// Probes end where this share of the profile lies within.
#define REACH 27.0f ///< over d: all but one ten-thousandth
#define MAX_HITS 64
/// Points distributed over a body: this many per d^2, within bounds; and probe rays for each.
#define POINTS_PER_D2 8.0
#define FEWEST_POINTS 512.0
#define MOST_POINTS 4096.0
#define PROBES 384u
/// Points that an average of N takes in.
#define AVERAGED 12.0

typedef struct probe_frame {
    rsv_vec3 axis[3]; ///< normal and two tangents
} probe_frame;

static const float axis_chance[3] = { 0.5f, 0.25f, 0.25f };

static probe_frame frame_at(const rsv_body_point *p)
{
    probe_frame f = { .axis = { p->geometric } };
    v3_frame(p->geometric, &f.axis[1], &f.axis[2]);
    return f;
}

static const rsv_scatter_profile *profile_of(const rsv_bodies *b, uint32_t triangle)
{
    return &b->profile[b->scene->triangle_material[triangle]];
}

static rsv_body_point point_on(const rsv_bodies *b, uint32_t triangle, float u, float v)
{
    const uint32_t *corner = b->scene->triangle[triangle];
    rsv_vec3 p0 = b->scene->position[corner[0]], p1 = b->scene->position[corner[1]];
    rsv_vec3 p2 = b->scene->position[corner[2]];
    rsv_vec3 normal = v3_normalize(v3_cross(v3_sub(p1, p0), v3_sub(p2, p0)));
    return (rsv_body_point){ v3_barycentric(p0, p1, p2, u, v), normal, triangle, u, v };
}

/// Share p / density of a point that a probe from `exit` found, whichever axis and channel had led there.
static rsv_rgb share_of(const rsv_bodies *b, const rsv_body_point *exit, const probe_frame *frame,
    const rsv_body_point *found)
{
    const rsv_scatter_profile *profile = profile_of(b, exit->triangle);
    rsv_vec3 away = v3_sub(found->point, exit->point);
    double distance = fmax((double)v3_length(away), 1e-12), density = 0;
    for (int k = 0; k < 3; k++) {
        rsv_vec3 flat = v3_mad(away, -v3_dot(away, frame->axis[k]), frame->axis[k]);
        double r = fmax((double)v3_length(flat), 1e-12), disk = 0;
        for (int c = 0; c < 3; c++)
            disk += rsv_diffusion_profile((double)profile->d[c], r) / 3;
        density +=
            (double)axis_chance[k] * disk * fabs((double)v3_dot(found->geometric, frame->axis[k]));
    }
    if (!(density > 0)) return rgb_gray(0);
    double share[3];
    for (int c = 0; c < 3; c++)
        share[c] = rsv_diffusion_profile((double)profile->d[c], distance) / density;
    return rgb((float)share[0], (float)share[1], (float)share[2]);
}

/// A probe ray: along the chord of the sphere of reach, at radius r and angle phi about an axis.
typedef struct probe {
    rsv_ray ray; ///< of unit direction
    uint32_t body;
} probe;

/// How a probe is drawn. Numbers lie in [0, 1).
typedef struct probe_draw {
    int axis, channel;
    float u_radius, u_angle;
} probe_draw;

static bool aim_probe(const rsv_bodies *b, const rsv_body_point *exit, const probe_frame *frame,
    const probe_draw *draw, probe *result)
{
    int axis = draw->axis;
    const rsv_scatter_profile *profile = profile_of(b, exit->triangle);
    float reach = REACH * rsv_scatter_profile_widest(profile);
    float r = (float)rsv_diffusion_sample_radius(
        (double)profile->d[draw->channel], (double)draw->u_radius);
    if (r >= reach) return false;
    float phi = 2 * RSV_PI * draw->u_angle, half = sqrtf(reach * reach - r * r);
    rsv_vec3 along = frame->axis[axis];
    rsv_vec3 s = frame->axis[(axis + 1) % 3], t = frame->axis[(axis + 2) % 3];
    rsv_vec3 centre = v3_mad(v3_mad(exit->point, r * cosf(phi), s), r * sinf(phi), t);
    // a reach far beyond the scene would cost the ray its precision
    rsv_vec3 size = v3_sub(b->scene->bounds_max, b->scene->bounds_min);
    half = f_min(half, 2 * v3_length(size));
    result->ray = (rsv_ray){ v3_mad(centre, half, along), v3_neg(along), 2 * half };
    result->body = b->triangle_body[exit->triangle];
    return true;
}

/// The probe's next point on the body; moves the ray beyond it. False at the end.
static bool next_hit(const rsv_bodies *b, probe *p, rsv_body_point *found)
{
    rsv_hit hit;
    for (int k = 0; k < MAX_HITS && p->ray.t_max > 0; k++) {
        if (!rsv_tracer_closest(b->tracer, &p->ray, &hit)) return false;
        *found = point_on(b, hit.triangle, hit.u, hit.v);
        bool ahead = v3_dot(found->geometric, p->ray.direction) > 0;
        rsv_vec3 beyond = ahead ? found->geometric : v3_neg(found->geometric);
        rsv_vec3 origin =
            rsv_offset_origin(found->point, beyond, rsv_triangle_extent(b->scene, hit.triangle));
        p->ray.t_max -= v3_length(v3_sub(origin, p->ray.origin));
        p->ray.origin = origin;
        if (b->triangle_body[hit.triangle] == p->body) return true;
    }
    return false;
}

// ---- N ------------------------------------------------------------------------------------------

static rsv_rgb probe_sum(const rsv_bodies *b, const rsv_body_point *at, uint32_t stream)
{
    static const int axes[4] = { 0, 0, 1, 2 }; // as often as their chances say
    probe_frame frame = frame_at(at);
    rsv_rgb sum = rgb_gray(0);
    for (uint32_t k = 0; k < PROBES; k++) {
        uint32_t stratum = k % 12;
        probe_draw draw = { .axis = axes[stratum % 4], .channel = (int)(stratum / 4) };
        rsv_sobol_2d(k / 12, rsv_hash2(stream, stratum), &draw.u_radius, &draw.u_angle);
        probe p;
        rsv_body_point found;
        if (!aim_probe(b, at, &frame, &draw, &p)) continue;
        for (int hits = 0; hits < MAX_HITS && next_hit(b, &p, &found); hits++)
            sum = rgb_add(sum, share_of(b, at, &frame, &found));
    }
    return rgb_scale(sum, 1.0f / PROBES);
}

static uint64_t grid_key(int32_t x, int32_t y, int32_t z)
{
    return ((uint64_t)(uint32_t)(x & 0x1fffff) << 42) | ((uint64_t)(uint32_t)(y & 0x1fffff) << 21) |
           (uint64_t)(uint32_t)(z & 0x1fffff);
}

typedef struct grid_place {
    int32_t x, y, z;
} grid_place;

static grid_place place_in_grid(const rsv_bodies *b, const rsv_body_sums *body, rsv_vec3 p)
{
    rsv_vec3 q = v3_scale(v3_sub(p, b->scene->bounds_min), 1 / body->cell);
    return (grid_place){ (int32_t)floorf(q.x), (int32_t)floorf(q.y), (int32_t)floorf(q.z) };
}

/// max(1, N) at a point of the body: an average over the strewn points around it.
static rsv_rgb sum_at(const rsv_bodies *b, const rsv_body_point *at)
{
    const rsv_body_sums *body = &b->body[b->triangle_body[at->triangle]];
    grid_place g = place_in_grid(b, body, at->point);
    rsv_rgb sum = rgb_gray(0);
    float weights = 0;
    for (int n = 0; n < 27; n++) {
        uint64_t key = grid_key(g.x + n % 3 - 1, g.y + n / 3 % 3 - 1, g.z + n / 9 - 1);
        uint32_t k = rsv_index_map_find(&body->grid, key);
        for (; k != RSV_NONE; k = body->next[k]) {
            rsv_vec3 away = v3_sub(body->point[k], at->point);
            float weight = 1 - v3_dot(away, away) / (body->cell * body->cell);
            if (weight <= 0) continue;
            sum = rgb_mad(sum, weight, body->sum[k]);
            weights += weight;
        }
    }
    if (weights == 0) return rgb_gray(1);
    sum = rgb_scale(sum, 1 / weights);
    return rgb(f_max(sum.r, 1), f_max(sum.g, 1), f_max(sum.b, 1));
}

static double triangle_area(const rsv_scene_view *scene, uint32_t t)
{
    rsv_vec3 a = scene->position[scene->triangle[t][0]];
    rsv_vec3 e1 = v3_sub(scene->position[scene->triangle[t][1]], a);
    rsv_vec3 e2 = v3_sub(scene->position[scene->triangle[t][2]], a);
    return 0.5 * (double)v3_length(v3_cross(e1, e2));
}

/// Points over the body with equal areas between them, walking over its triangles.
static void strew_points(const rsv_bodies *b, uint32_t index, rsv_body_point *points, uint32_t seed)
{
    const rsv_body_sums *body = &b->body[index];
    double below = 0;
    size_t k = 0;
    for (uint32_t t = 0; t < b->scene->triangle_count && k < body->count; t++) {
        if (b->triangle_body[t] != index) continue;
        double area = triangle_area(b->scene, t);
        for (; k < body->count; k++) {
            double jitter = (double)rsv_unit_float(rsv_hash3(seed, (uint32_t)k, 1));
            if ((double)k + jitter >= (below + area) / body->area * (double)body->count) break;
            float x, y, u, v;
            rsv_sobol_2d((uint32_t)k, rsv_hash2(seed, 2), &x, &y);
            rsv_square_to_triangle(x, y, &u, &v);
            points[k] = point_on(b, t, u, v);
        }
        below += area;
    }
    for (; k > 0 && k < body->count; k++) // rounding of the areas' sum
        points[k] = points[k - 1];
}

static rsv_status fill_grid(const rsv_bodies *b, rsv_body_sums *body)
{
    rsv_status status = rsv_index_map_create(b->context, body->count, &body->grid);
    for (size_t k = 0; k < body->count && status == RSV_OK; k++) {
        grid_place g = place_in_grid(b, body, body->point[k]);
        uint64_t key = grid_key(g.x, g.y, g.z);
        uint32_t first = rsv_index_map_insert(&body->grid, key, (uint32_t)k);
        if (first == UINT32_MAX) return RSV_ERROR_MEMORY;
        body->next[k] = RSV_NONE;
        if (first == k) continue;
        body->next[k] = body->next[first];
        body->next[first] = (uint32_t)k;
    }
    return status;
}

typedef struct sum_job {
    const rsv_bodies *bodies;
    uint32_t index; ///< of the body
    const rsv_body_point *point;
} sum_job;

static void sum_points(void *user, rsv_span span)
{
    const sum_job *job = user;
    const rsv_body_sums *body = &job->bodies->body[job->index];
    for (size_t k = span.begin; k < span.end; k++) {
        body->point[k] = job->point[k].point;
        if (!rsv_cancelled(job->bodies->context))
            body->sum[k] =
                probe_sum(job->bodies, &job->point[k], rsv_hash2((uint32_t)k, job->index));
    }
}

static rsv_status estimate_sums(rsv_bodies *b, uint32_t index, float widest)
{
    rsv_body_sums *body = &b->body[index];
    double wanted = POINTS_PER_D2 * body->area / ((double)widest * (double)widest);
    body->count = (size_t)fmin(fmax(wanted, FEWEST_POINTS), MOST_POINTS);
    body->cell = (float)sqrt(AVERAGED / M_PI * body->area / (double)body->count);
    body->point = rsv_alloc(b->context, body->count, sizeof *body->point);
    body->sum = rsv_alloc(b->context, body->count, sizeof *body->sum);
    body->next = rsv_alloc(b->context, body->count, sizeof *body->next);
    rsv_body_point *points = rsv_alloc(b->context, body->count, sizeof *points);
    if (!body->point || !body->sum || !body->next || !points) {
        rsv_free(b->context, points);
        return RSV_ERROR_MEMORY;
    }
    strew_points(b, index, points, index);
    sum_job job = { b, index, points };
    rsv_parallel_for(b->context, body->count, 16, sum_points, &job);
    rsv_free(b->context, points);
    return fill_grid(b, body);
}

// ---- bodies -------------------------------------------------------------------------------------

static rsv_status find_bodies(rsv_bodies *b)
{
    rsv_index_map keys = { 0 };
    size_t capacity = 0;
    rsv_status status;
    RSV_TRY(rsv_index_map_create(b->context, 64, &keys));
    for (uint32_t t = 0; t < b->scene->triangle_count; t++) {
        uint32_t material = b->scene->triangle_material[t];
        b->triangle_body[t] = RSV_NONE;
        if (!rsv_material_scatters_below(&b->scene->material[material])) continue;
        uint64_t key = (uint64_t)b->scene->triangle_object[t] << 32 | material;
        uint32_t index = rsv_index_map_insert(&keys, key, (uint32_t)b->count);
        if (index == UINT32_MAX) RSV_TRY(RSV_ERROR_MEMORY);
        if (index == b->count) {
            RSV_TRY(
                rsv_grow(b->context, (void **)&b->body, &capacity, b->count + 1, sizeof *b->body));
            b->body[b->count++] = (rsv_body_sums){ .key = key };
        }
        b->triangle_body[t] = index;
        b->body[index].area += triangle_area(b->scene, t);
    }
cleanup:
    rsv_index_map_destroy(&keys);
    return status;
}

rsv_status rsv_bodies_create(const rsv_scene *scene, const rsv_tracer *tracer, rsv_bodies **result)
{
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_status status;
    rsv_bodies *b = rsv_alloc(context, 1, sizeof *b);
    if (!b) return RSV_ERROR_MEMORY;
    b->context = context;
    b->scene = rsv_scene_get_view(scene);
    b->tracer = tracer;
    b->triangle_body = rsv_alloc(context, b->scene->triangle_count, sizeof *b->triangle_body);
    b->profile = rsv_alloc(context, b->scene->material_count, sizeof *b->profile);
    if (!b->triangle_body || !b->profile) {
        status = RSV_ERROR_MEMORY;
        goto cleanup;
    }
    for (size_t m = 0; m < b->scene->material_count; m++)
        b->profile[m] = rsv_scatter_profile_of(&b->scene->material[m]);
    RSV_TRY(find_bodies(b));
    for (uint32_t k = 0; k < b->count; k++) {
        uint32_t material = (uint32_t)b->body[k].key;
        RSV_TRY(estimate_sums(b, k, rsv_scatter_profile_widest(&b->profile[material])));
        RSV_TRY(rsv_progress(context, "subsurface", (double)(k + 1) / (double)b->count));
    }
    *result = b;
    b = NULL;
cleanup:
    rsv_bodies_destroy(b);
    return status;
}

void rsv_bodies_destroy(rsv_bodies *b)
{
    if (!b) return;
    for (size_t k = 0; k < b->count; k++) {
        rsv_free(b->context, b->body[k].point);
        rsv_free(b->context, b->body[k].sum);
        rsv_free(b->context, b->body[k].next);
        rsv_index_map_destroy(&b->body[k].grid);
    }
    rsv_free(b->context, b->body);
    rsv_free(b->context, b->triangle_body);
    rsv_free(b->context, b->profile);
    rsv_free(b->context, b);
}

bool rsv_bodies_sample_entry(const rsv_bodies *b, const rsv_body_point *exit, rsv_random *random,
    rsv_body_point *entry, rsv_rgb *weight)
{
    probe_frame frame = frame_at(exit);
    float choice = rsv_random_float(random);
    probe_draw draw = { .axis = choice < 0.5f ? 0 : choice < 0.75f ? 1 : 2 };
    draw.u_radius = rsv_random_float(random);
    draw.channel = (int)(3 * rsv_random_float(random));
    draw.u_angle = rsv_random_float(random);
    probe p;
    if (!aim_probe(b, exit, &frame, &draw, &p)) return false;
    rsv_body_point found;
    int hits = 0;
    while (hits < MAX_HITS && next_hit(b, &p, &found))
        if (rsv_random_float(random) * (float)++hits < 1) *entry = found;
    if (hits == 0) return false;
    rsv_rgb here = sum_at(b, exit), there = sum_at(b, entry);
    *weight = rgb_scale(share_of(b, exit, &frame, entry), (float)hits);
    weight->r /= f_max(here.r, there.r);
    weight->g /= f_max(here.g, there.g);
    weight->b /= f_max(here.b, there.b);
    return !rgb_is_black(*weight);
}
