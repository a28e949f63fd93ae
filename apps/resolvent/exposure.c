#include "exposure.h"

#include "output_file.h"

#include <stdio.h>
#include <unistd.h>

bool cli_exposes(cli_session *session, const char *name, float asked)
{
    char scene[256];
    if (!isnan(asked)) return false;
    if (!rsv_is_operator_file(name)) return access(name, F_OK) == 0 && !session->mesh;
    // errors of the file are reported by those who read all of it
    rsv_status status = rsv_operator_scene_name(session->context, name, scene, sizeof scene);
    return status == RSV_OK && !rsv_scene_is_builtin(scene);
}

float cli_expose(cli_session *session, bool wanted, float asked, const rsv_image *image)
{
    char line[128];
    if (!wanted) return isnan(asked) ? 0 : asked;
    float stops = rsv_image_exposure(image);
    snprintf(line, sizeof line,
        "exposure %+.2f stops, chosen for .png; --exposure 0 keeps the brightness", (double)stops);
    if (stops != 0) cli_note(session, line);
    return stops;
}

rsv_status cli_expose_light(
    cli_session *session, bool wanted, const rsv_light *light, uint32_t camera, float *stops)
{
    rsv_image *image = NULL;
    rsv_render_desc desc = rsv_default_render_desc();
    *stops = 0;
    if (!wanted) return RSV_OK;
    const rsv_camera *lens = &rsv_scene_get_view(rsv_light_scene(light))->camera[camera];
    cli_size size = cli_default_size(lens);
    desc.mode = RSV_RENDER_OPERATOR;
    desc.camera = camera;
    desc.width = (size.width + 3) / 4;
    desc.height = (size.height + 3) / 4;
    desc.samples = 4;
    rsv_status status = rsv_render(light, &desc, &image);
    if (status == RSV_OK) *stops = cli_expose(session, true, 0, image);
    rsv_image_destroy(image);
    return status;
}

bool cli_writes_png(const cli_list *outputs)
{
    for (size_t k = 0; k < outputs->count; k++)
        if (cli_ends_in(outputs->item[k], ".png")) return true;
    return false;
}
