#include "bake_sky.h"

#include "../io/atomic_file.h"
#include "resolvent/image.h"

#include <stdio.h>
#include <string.h>

rsv_status rsv_bake_check_sky(const rsv_light_view *light)
{
    if (light->scene.view->environment) return RSV_OK;
    return rsv_fail(
        RSV_ERROR_ARGUMENT, "bake: there is no environment to write; add one, or leave it out");
}

rsv_status rsv_bake_write_sky(const rsv_light_view *light, const char *output)
{
    rsv_image *image = NULL;
    const rsv_environment *sky = light->scene.view->environment;
    char path[RSV_PATH_BYTES];
    rsv_status status;
    snprintf(path, sizeof path, "%.*s.hdr", (int)(strrchr(output, '.') - output), output);
    RSV_TRY(rsv_image_create(light->context, sky->width, sky->height, 1, &image));
    memcpy(rsv_image_pixels(image, 0), sky->pixels,
        (size_t)sky->width * sky->height * sizeof *sky->pixels);
    RSV_TRY(rsv_image_write(image, path, 0));
cleanup:
    rsv_image_destroy(image);
    return status;
}
