#include "bake_sources.h"

#include "../core/core.h"

#include "../core/vec.h"
#include "bake_constants.h"

enum { ARRAYS = 11 };

static void list_arrays(rsv_bake_sources *q, float **array[ARRAYS])
{
    float **const all[ARRAYS] = { &q->x, &q->y, &q->z, &q->nx, &q->ny, &q->nz, &q->radius, &q->r,
        &q->g, &q->b, &q->both };
    for (int k = 0; k < ARRAYS; k++)
        array[k] = all[k];
}

static void set_emitter(rsv_bake_sources *q, uint32_t k, const rsv_emitter *e)
{
    rsv_vec3 middle = v3_scale(v3_add(v3_add(e->corner[0], e->corner[1]), e->corner[2]), 1.0f / 3);
    for (int c = 0; c < 3; c++)
        q->radius[k] = f_max(q->radius[k], v3_length(v3_sub(e->corner[c], middle)));
    q->x[k] = middle.x, q->y[k] = middle.y, q->z[k] = middle.z;
    q->nx[k] = e->normal.x * e->area;
    q->ny[k] = e->normal.y * e->area;
    q->nz[k] = e->normal.z * e->area;
    q->r[k] = e->radiance.r, q->g[k] = e->radiance.g, q->b[k] = e->radiance.b;
    q->both[k] = e->double_sided;
}

rsv_status rsv_bake_sources_create(
    rsv_context *context, const rsv_lights *lights, rsv_bake_sources *q)
{
    float **array[ARRAYS];
    *q = (rsv_bake_sources){ .context = context, .lights = lights };
    if (lights->sampled_count > RSV_BAKE_WEIGHED) return RSV_OK;
    q->count = (uint32_t)lights->sampled_count;
    list_arrays(q, array);
    for (int k = 0; k < ARRAYS; k++) {
        *array[k] = rsv_alloc(context, q->count, sizeof **array[k]);
        if (!*array[k]) return RSV_ERROR_MEMORY;
    }
    for (uint32_t k = 0; k < q->count; k++)
        set_emitter(q, k, &lights->emitter[lights->sampled[k]]);
    return RSV_OK;
}

void rsv_bake_sources_destroy(rsv_bake_sources *q)
{
    float **array[ARRAYS];
    if (!q->context) return;
    list_arrays(q, array);
    for (int k = 0; k < ARRAYS; k++)
        rsv_free(q->context, *array[k]);
    *q = (rsv_bake_sources){ .context = NULL };
}

/// Irradiance of radiance 1 from emitters that are small and far; -1 = one is not, or the horizon may cut it.
static void weigh_far(const rsv_bake_sources *q, rsv_vec3 p, rsv_vec3 n, float *restrict weight)
{
    const float near = NEAR_EMITTER * NEAR_EMITTER;
#pragma omp simd
    for (uint32_t k = 0; k < q->count; k++) {
        float x = q->x[k] - p.x, y = q->y[k] - p.y, z = q->z[k] - p.z;
        float square = x * x + y * y + z * z, height = x * n.x + y * n.y + z * n.z;
        float facing = -(x * q->nx[k] + y * q->ny[k] + z * q->nz[k]);
        facing = q->both[k] != 0 ? fabsf(facing) : facing;
        float product = f_max(height, 0) * f_max(facing, 0);
        bool close = square < near * q->radius[k] * q->radius[k] || fabsf(height) < q->radius[k];
        weight[k] = close ? -1 : product / (square * square);
    }
}

static void weigh_emitters(const rsv_bake_sources *q, const rsv_receiver *r, rsv_bake_weights *w)
{
    rsv_vec3 p = r->point.position, n = r->point.normal;
    rsv_rgb sum = rgb_gray(0);
    weigh_far(q, p, n, w->weight);
    for (uint32_t k = 0; k < q->count; k++) {
        if (w->weight[k] < 0)
            w->weight[k] =
                rsv_projected_solid_angle(&q->lights->emitter[q->lights->sampled[k]], p, n);
        if (w->weight[k] > 0) { // of a bulb, half face away
            rsv_rgb light = rgb_scale(rgb(q->r[k], q->g[k], q->b[k]), w->weight[k]);
            sum = rgb_add(sum, light);
            w->sum += rgb_luminance(light);
        }
        w->weight[k] = w->sum;
    }
    w->unshadowed = sum;
}

void rsv_bake_weigh(const rsv_bake_sources *q, const rsv_receiver *receiver, rsv_bake_weights *w)
{
    w->sum = w->emitters = 0;
    w->unshadowed = rgb_gray(0);
    if (q->count == 0) {
        rsv_receiver_weigh(receiver, q->lights, &w->local);
        w->unshadowed = w->local.unshadowed;
        return;
    }
    weigh_emitters(q, receiver, w);
    for (int k = 0; k < RSV_BAKE_VIEWS; k++)
        w->view[k].emitter = RSV_NONE;
    w->local.lights = q->lights;
    w->local.point = receiver->point.position;
    w->local.normal = receiver->point.normal;
    w->local.count = 0;
    w->local.tree_share = w->local.tree_estimate = 0;
    w->local.unshadowed = rgb_gray(0);
    float sky = rsv_weigh_environment(&w->local);
    w->unshadowed = rgb_add(w->unshadowed, w->local.unshadowed);
    w->emitters = rsv_weight_share(w->sum, sky);
    for (uint32_t k = 0; k < rsv_entry_count(&w->local) && sky > 0; k++)
        w->local.probability[k] *= (1 - w->emitters) / sky;
}

/// The emitter in whose share of the sum a number falls. @param share out: its own
static uint32_t choose(const rsv_bake_sources *q, const rsv_bake_weights *w, float u, float *share)
{
    uint32_t low = 0, high = q->count - 1;
    while (low < high) {
        uint32_t middle = (low + high) / 2;
        if (w->weight[middle] > u * w->sum)
            high = middle;
        else
            low = middle + 1;
    }
    *share = (w->weight[low] - (low > 0 ? w->weight[low - 1] : 0)) / w->sum;
    return low;
}

static bool is_far(const rsv_bake_sources *q, uint32_t k, rsv_vec3 p)
{
    rsv_vec3 way = v3_sub(v3(q->x[k], q->y[k], q->z[k]), p);
    return v3_dot(way, way) > FAR_EMITTER * FAR_EMITTER * q->radius[k] * q->radius[k];
}

/// A point sampled by area. @return false = the plane is too close to edge-on for single precision
static bool sample_far(const rsv_bake_sources *q, const rsv_bake_weights *w, uint32_t chosen,
    const float u[2], rsv_light_sample *result)
{
    float a, b;
    const rsv_emitter *e = &q->lights->emitter[q->lights->sampled[chosen]];
    rsv_square_to_triangle(u[0], u[1], &a, &b);
    rsv_vec3 place = v3_barycentric(e->corner[0], e->corner[1], e->corner[2], a, b);
    rsv_vec3 way = v3_sub(place, w->local.point);
    float square = v3_dot(way, way), distance = sqrtf(square);
    result->direction = v3_scale(way, 1 / distance);
    float facing = -v3_dot(e->normal, result->direction);
    if (e->double_sided) facing = fabsf(facing);
    if (facing < EDGE_ON || e->varies) return false;
    result->emitter = q->lights->sampled[chosen];
    result->from_sky = false;
    result->distance = distance;
    result->radiance = result->mean_radiance = e->radiance;
    result->pdf_solid_angle = square / (e->area * facing);
    return true;
}

static const rsv_bake_view *view_of(const rsv_bake_sources *q, rsv_bake_weights *w, uint32_t chosen)
{
    rsv_bake_view *view = &w->view[chosen % RSV_BAKE_VIEWS];
    if (view->emitter == chosen) return view;
    view->emitter = chosen;
    view->faces = rsv_view_emitter(
        &q->lights->emitter[q->lights->sampled[chosen]], w->local.point, &view->triangle);
    return view;
}

/// @param result out: all but that the emitter was one of many to choose from
static bool sample_chosen(const rsv_bake_sources *q, rsv_bake_weights *w, uint32_t chosen,
    const float u[2], rsv_light_sample *result)
{
    bool far = is_far(q, chosen, w->local.point);
    if (far && sample_far(q, w, chosen, u, result)) return true;
    if (far) return rsv_sample_far_emitter(&w->local, chosen, 1, u[0], u[1], result);
    const rsv_bake_view *view = view_of(q, w, chosen);
    result->emitter = q->lights->sampled[chosen];
    if (!view->faces) return false;
    rsv_sample_view(&q->lights->emitter[result->emitter], &view->triangle, u[0], u[1], result);
    result->pdf_solid_angle =
        (float)rsv_triangle_pdf(&view->triangle, result->direction, result->distance);
    return true;
}

static bool sample(
    const rsv_bake_sources *q, rsv_bake_weights *w, const float u[3], rsv_light_sample *result)
{
    if (!(u[0] < w->emitters))
        return rsv_local_lights_sample(&w->local, u[0] - w->emitters, u[1], u[2], result);
    float share;
    uint32_t chosen = choose(q, w, u[0] / w->emitters, &share);
    if (!(share > 0) || !sample_chosen(q, w, chosen, &u[1], result)) return false;
    result->pdf_solid_angle *= w->emitters * share;
    const rsv_emitter *emitter = &q->lights->emitter[result->emitter];
    if (emitter->varies)
        result->radiance =
            rsv_emitter_radiance(q->lights, result->emitter, result->back, result->u, result->v);
    return v3_dot(result->direction, w->local.normal) > 0 && result->pdf_solid_angle > 0 &&
           isfinite(result->pdf_solid_angle);
}

void rsv_bake_draw(const rsv_bake_sources *q, rsv_bake_weights *w, const rsv_receiver *receiver,
    const rsv_entrance *entrance, const float u[3], rsv_next_event *event)
{
    rsv_light_sample drawn;
    if (q->count == 0)
        rsv_next_event_draw(receiver, entrance, &w->local, u, event);
    else if (sample(q, w, u, &drawn))
        rsv_next_event_diffuse(receiver, entrance, q->lights, &drawn, event);
    else
        rsv_next_event_clear(event);
}
