#include "beam.h"

#include "../sources/double3.h"
#include "../trace/hierarchy.h"
#include "../trace/tracer_update.h"

/// Scenes of more triangles wait too long for a hierarchy, and their pictures show few large ones.
#define MOST_TRIANGLES 2000000

/// a x b / volume
static rsv_vec3 dual(rsv_vec3 a, rsv_vec3 b, double volume)
{
    rsv_double3 cross = d3_cross(d3_from(a), d3_from(b));
    return v3((float)(cross.x / volume), (float)(cross.y / volume), (float)(cross.z / volume));
}

rsv_beam_lens rsv_beam_lens_of(const rsv_lens *lens)
{
    const rsv_camera *c = &lens->camera;
    rsv_beam_lens b = { .lens = *lens };
    double volume = d3_dot(d3_cross(d3_from(c->right), d3_from(c->up)), d3_from(c->forward));
    b.across = dual(c->up, c->forward, volume);
    b.upwards = dual(c->forward, c->right, volume);
    b.depth = dual(c->right, c->up, volume);
    float x = lens->half_width * lens->pixel_size, y = lens->half_height * lens->pixel_size;
    float size = v3_length(c->forward) + x * v3_length(c->right) + y * v3_length(c->up);
    float skew = v3_length(b.across) + v3_length(b.upwards) + (x + y) * v3_length(b.depth);
    b.slack = lens->pixel_size / 16 + 0x1p-20f * size * skew;
    b.usable = c->vertical_fov != 0 && lens->pixel_size > 0 && b.slack < 1; // and a number
    return b;
}

rsv_status rsv_beams_create(const rsv_tracer *tracer, rsv_beams *beams)
{
    const rsv_scene_view *scene = rsv_scene_get_view(rsv_tracer_scene(tracer));
    *beams = (rsv_beams){ .tracer = tracer };
    if (rsv_tracer_is_apart(tracer) || scene->triangle_count > MOST_TRIANGLES) return RSV_OK;
    beams->hold = true;
    return rsv_tracer_hierarchy(tracer, &beams->bvh);
}

void rsv_beams_refresh(rsv_beams *beams, const rsv_tracer *tracer)
{
    if (tracer != beams->tracer || rsv_tracer_is_apart(tracer)) beams->hold = false;
    beams->tracer = tracer;
}
