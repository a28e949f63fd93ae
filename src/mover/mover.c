#include "mover.h"
#include "../core/descriptor.h"

#include "../core/parallel.h"
#include "../trace/passage.h"

#include <string.h>

void rsv_mover_desc_init(rsv_mover_desc *desc, size_t size)
{
    const rsv_mover_desc defaults = {
        .size = sizeof defaults, .probe_samples = 64, .light_samples = 16
    };
    rsv_desc_fill(desc, size, &defaults);
}

// ---- place --------------------------------------------------------------------------------------

rsv_vec3 rsv_mover_point(const rsv_mover *m, rsv_vec3 p)
{
    return v3_add(rsv_mover_turn(m, v3_sub(p, m->middle)), v3_add(m->middle, m->offset));
}

// ---- light --------------------------------------------------------------------------------------

/// A sphere around all sources at a finite distance.
static void bound_lamps(rsv_mover *m)
{
    const rsv_lights *lights = m->solution->lights;
    const rsv_scene_view *scene = lights->scene;
    rsv_vec3 low = v3(INFINITY, INFINITY, INFINITY), high = v3_neg(low);
    for (size_t k = 0; k < lights->sampled_count; k++)
        for (int c = 0; c < 3; c++) {
            rsv_vec3 p = lights->emitter[lights->sampled[k]].corner[c];
            low = v3_min(low, p), high = v3_max(high, p);
        }
    for (size_t k = lights->distant_count; k < lights->punctual_count; k++) {
        rsv_vec3 p = scene->light[lights->punctual[k]].position;
        float r = rsv_punctual_radius(&scene->light[lights->punctual[k]]);
        low = v3_min(low, v3_sub(p, v3(r, r, r))), high = v3_max(high, v3_add(p, v3(r, r, r)));
    }
    m->lamps_bounded = !lights->environment && lights->distant_count == 0;
    m->lamps = (rsv_ball){ v3_scale(v3_add(low, high), 0.5f), 0.5f * v3_length(v3_sub(high, low)) };
}

/// Lights the probes around all vertices.
static void light_probes(rsv_mover *m)
{
    for (size_t v = 0; v < m->body->vertex_count; v++) {
        size_t probe[8];
        float weight[8];
        rsv_probe_grid_around(&m->grid, rsv_mover_point(m, m->body->position[v]), probe, weight);
        for (int k = 0; k < 8; k++)
            if (weight[k] > 0 && m->grid.valid[probe[k]] && !m->grid.lit[probe[k]])
                rsv_probe_grid_light(&m->grid, probe[k]);
    }
}

static rsv_rgb irradiance_at(const rsv_mover *m, size_t vertex)
{
    rsv_vec3 point = rsv_mover_point(m, m->body->position[vertex]);
    rsv_vec3 normal = rsv_mover_turn(m, m->body->normal[vertex]);
    float extent =
        v3_max_abs(point) + rsv_scene_extent(m->body) + rsv_scene_extent(m->solution->scene.view);
    rsv_receiver receiver =
        rsv_receiver_in_space(point, normal, rsv_offset_origin(point, normal, extent));
    rsv_next_event event[RSV_MOST_AIMED];
    uint32_t stream = rsv_hash2((uint32_t)vertex, 0x6d6fu);
    uint32_t count = rsv_mover_aim(m, &receiver, m->desc.light_samples, stream, event);
    rsv_rgb sum = rsv_probe_grid_irradiance(&m->grid, point, normal);
    for (uint32_t k = 0; k < count; k++) {
        float passed = rsv_mover_passed(m, &event[k].ray);
        if (passed > 0) passed *= rsv_next_event_passed(m->solution->tracer, &event[k]);
        sum = rgb_mad(sum, passed, event[k].light);
    }
    return sum;
}

static void light_span(void *job, rsv_span span)
{
    rsv_mover *m = job;
    for (size_t v = span.begin; v < span.end; v++)
        m->irradiance[v] = irradiance_at(m, v);
}

static void light_vertices(rsv_mover *m)
{
    light_probes(m);
    rsv_parallel_for(m->context, m->body->vertex_count, 16, light_span, m);
}

void rsv_mover_refresh(rsv_mover *m)
{
    bound_lamps(m);
    rsv_probe_grid_darken(&m->grid);
    light_vertices(m);
}

rsv_status rsv_mover_place(rsv_mover *m, rsv_vec3 offset, float turn)
{
    if (!isfinite(offset.x + offset.y + offset.z + turn) || v3_max_abs(offset) > 1e6f)
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "mover: its place must be within 1e6 m and its turn finite");
    float angle = fmodf(turn, 360) * (RSV_PI / 180);
    m->offset = v3_add(m->base, offset);
    m->sine = sinf(angle);
    m->cosine = cosf(angle);
    m->ball.centre = v3_add(m->middle, m->offset);
    light_vertices(m);
    return RSV_OK;
}

const rsv_rgb *rsv_mover_irradiance(const rsv_mover *m) { return m->irradiance; }

// ---- creation -----------------------------------------------------------------------------------

static rsv_status check_desc(const rsv_mover_desc *d)
{
    if (!(d->probe_spacing >= 0 && isfinite(d->probe_spacing)))
        return rsv_fail(RSV_ERROR_ARGUMENT, "mover: a probe spacing of %g m is not 0 or more",
            (double)d->probe_spacing);
    if (d->probe_samples < 32 || d->probe_samples > 65536)
        return rsv_fail(RSV_ERROR_ARGUMENT, "mover: %u rays per direction are not in 32 .. 65536",
            d->probe_samples);
    if (d->light_samples < 1 || d->light_samples > 64)
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "mover: %u shadow rays are not in 1 .. 64", d->light_samples);
    return RSV_OK;
}

static void set_body(rsv_mover *m)
{
    const rsv_scene_view *b = m->body;
    m->middle = v3_scale(v3_add(b->bounds_min, b->bounds_max), 0.5f);
    const double *own = b->origin, *room = m->solution->scene.view->origin;
    m->base = m->offset =
        v3((float)(own[0] - room[0]), (float)(own[1] - room[1]), (float)(own[2] - room[2]));
    m->ball.centre = v3_add(m->middle, m->offset);
    for (size_t v = 0; v < b->vertex_count; v++)
        m->ball.radius = f_max(m->ball.radius, v3_length(v3_sub(b->position[v], m->middle)));
    for (size_t k = 0; k < b->material_count; k++)
        m->albedo[k] = b->material[k].base_color;
    m->cosine = 1;
}

rsv_status rsv_mover_create(
    const rsv_light *light, const rsv_scene *body, const rsv_mover_desc *desc, rsv_mover **mover)
{
    const rsv_light_view *solution = rsv_light_get_view(light);
    rsv_mover_desc settings = rsv_default_mover_desc();
    rsv_status status = RSV_READ_DESC(rsv_mover_desc, &settings, desc);
    if (status == RSV_OK) status = check_desc(&settings);
    if (status == RSV_OK) status = rsv_light_refuse_fog(solution, "a moving object");
    if (status != RSV_OK) return status;
    rsv_mover *m = rsv_alloc(solution->context, 1, sizeof *m);
    if (!m) return RSV_ERROR_MEMORY;
    m->context = solution->context;
    m->solution = solution;
    m->body = rsv_scene_get_view(body);
    m->desc = settings;
    m->irradiance = rsv_alloc(m->context, m->body->vertex_count, sizeof *m->irradiance);
    m->albedo = rsv_alloc(m->context, m->body->material_count, sizeof *m->albedo);
    RSV_TRY(m->irradiance && m->albedo ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_tracer_create(body, &m->tracer));
    RSV_TRY(rsv_probe_grid_create(
        solution, settings.probe_spacing, settings.probe_samples, false, &m->grid));
    set_body(m);
    rsv_mover_refresh(m);
    *mover = m;
    return RSV_OK;
cleanup:
    rsv_mover_destroy(m);
    return status;
}

void rsv_mover_destroy(rsv_mover *m)
{
    if (!m) return;
    rsv_probe_grid_destroy(&m->grid);
    rsv_tracer_destroy(m->tracer);
    rsv_free(m->context, m->irradiance);
    rsv_free(m->context, m->albedo);
    rsv_free(m->context, m);
}
