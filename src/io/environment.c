#include "../core/core.h"
#include "resolvent/image.h"
#include "resolvent/io.h"

rsv_status rsv_scene_load_environment(
    rsv_scene *scene, const char *path, float intensity, float rotation)
{
    rsv_image *image = NULL;
    rsv_status status = rsv_image_read(rsv_scene_get_context(scene), path, &image);
    if (status != RSV_OK) return status;
    rsv_environment environment = { .name = path,
        .pixels = rsv_image_const_pixels(image, 0),
        .width = rsv_image_width(image),
        .height = rsv_image_height(image),
        .intensity = intensity,
        .rotation = rotation };
    status = rsv_scene_set_environment(scene, &environment);
    rsv_image_destroy(image);
    return status;
}
