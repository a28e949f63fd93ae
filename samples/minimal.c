/// Loads a glTF scene, solves its light once, and writes a picture.
///
///     minimal [SCENE.glb] [PICTURE.png]
#include <resolvent/resolvent.h>

#include <stdio.h>

#define TRY(call)                                                                                  \
    do {                                                                                           \
        if ((call) != RSV_OK) goto failed;                                                         \
    } while (0)

static void print_log(void *user, rsv_log_level level, const char *message)
{
    (void)user;
    fprintf(stderr, "%s%s\n", level == RSV_LOG_WARNING ? "warning: " : "", message);
}

int main(int argc, char **argv)
{
    rsv_context *context = NULL;
    rsv_scene *scene = NULL;
    rsv_light *solution = NULL;
    rsv_image *image = NULL;
    int exit_status = 1;

    rsv_context_desc context_desc = rsv_default_context_desc();
    context_desc.log = print_log;
    TRY(rsv_context_create(&context_desc, &context));
    if (argc > 1)
        TRY(rsv_scene_load(context, argv[1], &scene));
    else
        TRY(rsv_scene_builtin(context, "cornell-spheres", &scene));

    rsv_solve_desc solve_desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    TRY(rsv_light_create(scene, &solve_desc, &solution));
    printf("%zu elements, norm %.3f\n", rsv_light_report(solution)->elements,
        rsv_light_report(solution)->norm_inf);

    rsv_render_desc render_desc = rsv_default_render_desc();
    render_desc.mode = RSV_RENDER_OPERATOR;
    render_desc.width = render_desc.height = 256;
    TRY(rsv_render(solution, &render_desc, &image));
    TRY(rsv_image_write(image, argc > 2 ? argv[2] : "minimal.png", 0));
    exit_status = 0;

failed:
    if (exit_status) fprintf(stderr, "error: %s\n", rsv_last_error());
    rsv_image_destroy(image);
    rsv_light_destroy(solution);
    rsv_scene_destroy(scene);
    rsv_context_destroy(context);
    return exit_status;
}
