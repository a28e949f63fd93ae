#include "direct_receiver.h"

#include "direct_constants.h"

#include <math.h>

void rsv_direct_receive(
    const rsv_direct_job *job, uint32_t node, uint32_t valid, rsv_node_receivers *r)
{
    const rsv_elements *e = job->elements;
    const rsv_scene_view *view = job->scene->view;
    uint32_t points = job->setting.points;
    rsv_support_point sample[RSV_DIRECT_LANES];
    r->node = rsv_elements_draw_of(e, node);
    r->valid = valid;
    rsv_elements_sample_support(e, node, points, job->setting.seed, sample);
    r->entry = rsv_elements_entry(e, node, sample, points, valid);
    for (uint32_t k = 0; k < points; k++) {
        if (!(valid >> k & 1)) continue;
        uint32_t face = e->cell[sample[k].support / 4].face;
        uint32_t triangle = e->face_triangle[face];
        bool back = e->face_back[face];
        rsv_surface_point point = rsv_surface_point_seen(
            view, triangle, sample[k].u, sample[k].v, back, rsv_direct_width(e, node));
        r->at[k] =
            rsv_receiver_at(view, job->scene->tracer, triangle, sample[k].u, sample[k].v, point);
    }
    const rsv_receiver *speaks = &r->at[__builtin_ctz(valid)];
    r->medium = rsv_medium_above(&job->scene->media, speaks->origin, speaks->point.geometric);
}

bool rsv_direct_previews(const rsv_direct_job *job)
{
    return job->samples < RSV_DIRECT_LANES && !job->setting.lights->emitter_tree;
}

uint32_t rsv_direct_preview_points(const rsv_direct_job *job, uint32_t node)
{
    uint32_t few = 0, valid = job->valid_points[node];
    for (uint32_t k = 0; k < PREVIEW_POINTS && valid; k++, valid &= valid - 1)
        few |= valid & -valid;
    return few;
}

rsv_direct_rays rsv_direct_preview_rays(const rsv_direct_job *job)
{
    return (rsv_direct_rays){ job->setting.points, job->setting.points };
}

rsv_direct_rays rsv_direct_look_rays(const rsv_direct_job *job)
{
    uint32_t samples = job->samples < RSV_DIRECT_LANES ? RSV_DIRECT_LANES : job->samples;
    return (rsv_direct_rays){ samples, RSV_DIRECT_LANES };
}

uint32_t rsv_direct_samples_by_share(
    const rsv_direct_job *job, uint32_t node, rsv_rgb unshadowed, uint32_t samples)
{
    float share = 0;
    const rsv_rgb whole = job->whole[node];
    for (int c = 0; c < 3; c++)
        if ((&whole.r)[c] > 0) share = f_max(share, (&unshadowed.r)[c] / (&whole.r)[c]);
    if (share >= 1) return samples;
    uint32_t packets = (uint32_t)ceilf(share * (float)samples / RSV_DIRECT_LANES);
    return (packets > 0 ? packets : 1) * RSV_DIRECT_LANES;
}
