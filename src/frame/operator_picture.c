/// Mode operator as a sum of frames.
#include "../core/descriptor.h"
#include "../core/team.h"
#include "../solve/light.h"
#include "../trace/backs.h"
#include "../trace/film.h"
#include "glossy_material.h"
#include "resolvent/frame.h"

/// Pixels along a side that frames have at most.
#define LARGEST_SIDE 16384

static bool is_frame_size(const rsv_render_desc *d)
{
    return d->width > 0 && d->width <= LARGEST_SIDE && d->height > 0 && d->height <= LARGEST_SIDE &&
           d->samples > 0;
}

/// Whether frames can render the picture. In fog they interpolate. rsv_render reports errors of the description.
static bool is_for_frames(const rsv_light_view *s, const rsv_render_desc *d, rsv_frame_gloss gloss)
{
    bool plain = d->mode == RSV_RENDER_OPERATOR && rsv_film_is_plain(&d->film) && !d->layers &&
                 d->noise == 0 && !d->shared_pattern && !d->gather_rays;
    bool sees = d->camera < s->scene.view->camera_count;
    return plain && sees && is_frame_size(d) && !rsv_team_of(s->context) && !s->scene.view->fog &&
           (gloss == RSV_GLOSS_REUSED || !rsv_any_glossy(&s->scene));
}

static rsv_status render_frames(
    const rsv_light_view *s, rsv_frame_renderer *renderer, const rsv_camera *camera, uint32_t count)
{
    rsv_frame_view view = { .camera = { *camera, *camera } };
    rsv_status status = RSV_OK;
    for (uint32_t k = 0; k < count && status == RSV_OK; k++) {
        status = rsv_frame_render(renderer, &view, NULL);
        if (status == RSV_OK) status = rsv_progress(s->context, "render", (k + 1) / (double)count);
    }
    return status;
}

static rsv_status render_picture(
    const rsv_light *light, const rsv_render_desc *d, rsv_frame_gloss gloss, rsv_image **image)
{
    const rsv_light_view *s = rsv_light_get_view(light);
    const rsv_camera *camera = d->viewpoint ? d->viewpoint : &s->scene.view->camera[d->camera];
    rsv_frame_renderer *renderer = NULL;
    rsv_image *made = NULL;
    rsv_status status;
    rsv_frame_desc frame = rsv_default_frame_desc();
    frame.width = d->width;
    frame.height = d->height;
    frame.path_depth = d->path_depth;
    frame.seed = d->seed;
    frame.gloss = gloss;
    frame.frames = d->samples;
    RSV_TRY(rsv_film_check(&d->film, camera));
    rsv_warn_of_view(s->tracer, camera);
    RSV_TRY(rsv_frame_renderer_create(light, &frame, &renderer));
    RSV_TRY(render_frames(s, renderer, camera, d->samples));
    RSV_TRY(rsv_image_create(s->context, d->width, d->height, 1, &made));
    rsv_frame_radiance(renderer, 0, rsv_image_pixels(made, 0));
    *image = made;
    made = NULL;
cleanup:
    rsv_image_destroy(made);
    rsv_frame_renderer_destroy(renderer);
    return status;
}

rsv_status rsv_render_operator(
    const rsv_light *light, const rsv_render_desc *desc, rsv_frame_gloss gloss, rsv_image **image)
{
    rsv_render_desc settings = rsv_default_render_desc();
    rsv_status status = RSV_READ_DESC(rsv_render_desc, &settings, desc);
    if (status != RSV_OK) return status;
    if (!is_for_frames(rsv_light_get_view(light), &settings, gloss))
        return rsv_render(light, &settings, image);
    return render_picture(light, &settings, gloss, image);
}
