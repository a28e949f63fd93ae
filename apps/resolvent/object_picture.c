#include "object_picture.h"

#include "resolvent/frame.h"

static rsv_status render_frames(
    rsv_frame_renderer *renderer, const rsv_camera *camera, uint32_t count)
{
    rsv_frame_view view = { .camera = { *camera, *camera } };
    rsv_status status = RSV_OK;
    for (uint32_t k = 0; k < count && status == RSV_OK; k++)
        status = rsv_frame_render(renderer, &view, NULL);
    return status;
}

rsv_status cli_render_object(const rsv_light *solution, const rsv_scene *body, rsv_vec3 offset,
    const rsv_render_desc *desc, rsv_image **image)
{
    rsv_mover *mover = NULL;
    rsv_frame_renderer *renderer = NULL;
    const rsv_scene *scene = rsv_light_scene(solution);
    rsv_frame_desc frame = rsv_default_frame_desc();
    frame.width = desc->width;
    frame.height = desc->height;
    frame.path_depth = desc->path_depth;
    frame.seed = desc->seed;
    frame.gloss = RSV_GLOSS_PATHS;
    rsv_status status = rsv_mover_create(solution, body, NULL, &mover);
    if (status == RSV_OK) status = rsv_mover_place(mover, offset, 0);
    if (status == RSV_OK) status = rsv_frame_renderer_create(solution, &frame, &renderer);
    if (status == RSV_OK) {
        rsv_frame_renderer_put(renderer, mover);
        status = render_frames(
            renderer, &rsv_scene_get_view(scene)->camera[desc->camera], desc->samples);
    }
    if (status == RSV_OK)
        status =
            rsv_image_create(rsv_scene_get_context(scene), desc->width, desc->height, 1, image);
    if (status == RSV_OK) rsv_frame_radiance(renderer, 0, rsv_image_pixels(*image, 0));
    rsv_frame_renderer_destroy(renderer);
    rsv_mover_destroy(mover);
    return status;
}
