/// Coarse elements of a light whose scene moves, divided again where surfaces touch now.
#include "../core/parallel.h"
#include "light_motion.h"

#include "../elements/contact.h"
#include "../update/moved_elements.h"
#include "solve_constants.h"

#include <math.h>

void rsv_following_forget_photons(rsv_following *f)
{
    if (!f) return;
    rsv_photon_log_destroy(f->photons);
    f->photons = NULL;
}

void rsv_following_destroy(rsv_context *context, rsv_following *f)
{
    if (!f) return;
    rsv_elements_destroy(f->elements);
    rsv_elements_destroy(f->first);
    rsv_free(context, f->direct);
    rsv_following_forget_photons(f);
    rsv_free(context, f->waits);
    rsv_free(context, f->caustics_moved);
    rsv_free(context, f);
}

rsv_status rsv_following_create(rsv_light *s, rsv_following **following)
{
    const rsv_transport_scene *scene = &s->world->scene;
    rsv_status status;
    rsv_following *f = *following = rsv_alloc(s->context, 1, sizeof *f);
    RSV_TRY(f ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_elements_copy(s->elements, scene->view, scene->bsdf, &f->elements));
    RSV_TRY(rsv_elements_copy(s->elements, scene->view, scene->bsdf, &f->first));
    rsv_elements_unbridge(f->first); // so that all its nodes are known again
    f->contact_size = rsv_elements_contact_size(f->first);
    f->direct = rsv_alloc(s->context, s->elements->node_count, sizeof *f->direct);
    RSV_TRY(f->direct ? RSV_OK : RSV_ERROR_MEMORY);
cleanup:
    return status;
}

/// As many nodes as there may be: those of the start, and a share for contacts like that of a solve.
static size_t most_nodes(const rsv_light *s)
{
    const rsv_solve_desc *desc = &s->desc;
    float share = desc->contact_share > 0 ? desc->contact_share : 1;
    size_t first = s->following->first->node_count;
    size_t most = first + (size_t)(share * CONTACT_NODES * sqrt(desc->element_target));
    if (desc->max_elements && most > desc->max_elements) most = desc->max_elements;
    return most > first ? most : first;
}

typedef struct carry_job {
    const rsv_elements *then;
    const rsv_divided_elements *divided;
    const rsv_rgb *before;
    rsv_rgb *now;
} carry_job;

static void carry_nodes(void *data, rsv_span span)
{
    const carry_job *job = data;
    const rsv_elements *e = job->divided->elements;
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++) {
        uint32_t face, before = job->divided->node_before[n];
        float u, v;
        if (before != RSV_NONE) {
            job->now[n] = job->before[before];
            continue;
        }
        if (e->support_begin[n] == e->support_begin[n + 1]) continue;
        rsv_elements_place_node(e, n, &face, &u, &v);
        job->now[n] = rsv_elements_interpolate(job->then, job->before, face, u, v);
    }
}

/// A field on the new elements: unchanged at nodes that stay, interpolated at others.
static rsv_status carry(const rsv_elements *then, const rsv_divided_elements *d, rsv_rgb **field)
{
    const rsv_elements *e = d->elements;
    rsv_rgb *now = rsv_alloc(e->context, e->node_count, sizeof *now);
    if (!now) return RSV_ERROR_MEMORY;
    carry_job job = { then, d, *field, now };
    rsv_parallel_for(e->context, e->node_count, 256, carry_nodes, &job);
    rsv_free(e->context, *field);
    *field = now;
    return RSV_OK;
}

typedef struct paint_job {
    const rsv_light *light;
    const rsv_divided_elements *divided;
    rsv_rgb *albedo;
} paint_job;

static void paint_nodes(void *data, rsv_span span)
{
    const paint_job *job = data;
    const rsv_light *s = job->light;
    const rsv_rgb *then = rsv_operator_get_view(s->op)->albedo;
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++) {
        uint32_t before = job->divided->node_before[n];
        job->albedo[n] = before != RSV_NONE ? then[before]
                                            : rsv_element_albedo(&s->world->scene,
                                                  job->divided->elements, s->desc.seed, n);
    }
}

/// Albedos, found again at nodes that are new.
static rsv_status paint(rsv_light_motion *m, const rsv_divided_elements *d)
{
    const rsv_light *s = m->s;
    size_t nodes = d->elements->node_count;
    m->albedo = rsv_alloc(s->context, nodes, sizeof *m->albedo);
    if (!m->albedo) return RSV_ERROR_MEMORY;
    paint_job job = { s, d, m->albedo };
    rsv_parallel_for(s->context, nodes, 256, paint_nodes, &job);
    return RSV_OK;
}

static rsv_status carry_all(rsv_light_motion *m, const rsv_divided_elements *d)
{
    rsv_light *s = m->s;
    rsv_light_fields *f = &s->field;
    const rsv_elements *then = s->following->elements;
    rsv_status status;
    RSV_TRY(paint(m, d));
    RSV_TRY(carry(then, d, &s->following->direct));
    RSV_TRY(carry(then, d, &f->source));
    RSV_TRY(carry(then, d, &f->gathered));
    RSV_TRY(carry(then, d, &f->irradiance));
    RSV_TRY(carry(then, d, &f->indirect));
    rsv_light_drop_orders(s);
cleanup:
    return status;
}

/// Rows that are others now, of the new elements.
static rsv_status mark_anew(rsv_light_motion *m, const rsv_divided_elements *d)
{
    const rsv_elements *e = d->elements;
    uint8_t *anew = rsv_alloc(e->context, e->node_count, 1);
    if (!anew) return RSV_ERROR_MEMORY;
    for (size_t n = 0; n < e->node_count; n++)
        anew[n] = d->node_before[n] == RSV_NONE ? RSV_MOVE_TURN
                  : m->anew                     ? m->anew[d->node_before[n]]
                                                : RSV_MOVE_NONE;
    rsv_free(e->context, m->anew);
    m->anew = anew;
    return RSV_OK;
}

rsv_status rsv_light_divide(rsv_light_motion *m, bool from_first, rsv_divided_elements *d)
{
    rsv_light *s = m->s;
    rsv_following *f = s->following;
    rsv_status status;
    from_first = from_first || m->begins ||
                 (double)f->elements->node_count > MOST_DIVISION * (double)f->first->node_count;
    const rsv_elements_before before = { .start = from_first ? f->first : f->elements,
        .first = f->first,
        .elements = f->elements,
        .valid_points = f->valid_points,
        .change = &f->unsettled,
        .moved = m->moved,
        .contact_size = f->contact_size,
        .most_nodes = most_nodes(s),
        .draw = { RSV_SUPPORT_POINTS, s->desc.seed } };
    if (from_first) rsv_elements_find_areas(f->first);
    RSV_TRY(rsv_elements_divide(&s->world->scene, &before, d, &s->report.rays));
    RSV_TRY(mark_anew(m, d));
    RSV_TRY(carry_all(m, d));
    rsv_elements_destroy(f->elements);
    f->elements = d->elements;
    if (m->begins) rsv_free(s->context, f->valid_points);
    f->valid_points = d->valid_points;
    d->elements = NULL;
    d->valid_points = NULL;
    f->split = !from_first;
    if (from_first) f->unsettled.count = 0;
    m->divides = true;
cleanup:
    return status;
}
