/// A door swings open: the light of both rooms follows it, frame by frame, and is exact once the door rests.
///
///     door [FRAMES]
#include <resolvent/resolvent.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/// The scene with the door turned about its upright hinge. @param angle radians from where the file has it
static rsv_status turn_door(const rsv_scene *scene, float angle, rsv_scene **turned)
{
    const float c = cosf(angle), s = sinf(angle), hinge_z = -0.43f;
    const rsv_motion motion = { .object = rsv_scene_find_object(scene, "door"),
        .matrix = {
            c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0, -s * hinge_z, 0, hinge_z - c * hinge_z, 1 } };
    return rsv_scene_move(scene, &motion, 1, turned);
}

/// Irradiance on the floor of the dark room.
static rsv_status read_floor(const rsv_light *light, float *irradiance)
{
    const rsv_probe probe = { .position = { -1, 0.5f, 0 }, .normal = { 0, 1, 0 } };
    rsv_probe_desc desc = rsv_default_probe_desc();
    rsv_probe_reading reading;
    desc.mode = RSV_PROBE_LOOKUP;
    rsv_status status = rsv_probe_irradiance(light, &desc, &probe, 1, &reading);
    *irradiance = reading.irradiance.g;
    return status;
}

/// One frame. An engine would draw it here (rsv_frame_renderer of frame.h shows the change).
static rsv_status show(rsv_light *light, const rsv_scene *scene, float angle, float *irradiance)
{
    rsv_scene *turned = NULL;
    rsv_update_report report = { 0 };
    rsv_status status = turn_door(scene, angle, &turned);
    if (status == RSV_OK) status = rsv_light_follow(light, turned, &report);
    rsv_scene_destroy(turned); // the light keeps what it needs
    if (status == RSV_OK) status = read_floor(light, irradiance);
    if (status == RSV_OK)
        printf("%4.0f degrees: %.4f W/m2 on the floor of the dark room, %.2f s\n",
            (double)angle * 180 / 3.14159265, (double)*irradiance, report.seconds);
    return status;
}

int main(int argc, char **argv)
{
    const float shut = 0.18f, open = -0.9f;
    const int frames = argc > 1 ? atoi(argv[1]) : 2;
    float first = 0, last = 0;
    rsv_context *context = NULL;
    rsv_scene *scene = NULL;
    rsv_light *light = NULL;
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    solve.element_target = 200; // few elements and rays, for a quick start
    solve.rays_per_element = 64;
    solve.light_samples = 16;
    solve.direct_levels = 1;
    solve.refinements = 1;
    rsv_status status = rsv_context_create(NULL, &context);
    if (status == RSV_OK) status = rsv_scene_builtin(context, "two-rooms", &scene);
    if (status == RSV_OK) status = rsv_light_create(scene, &solve, &light);
    if (status == RSV_OK) status = show(light, scene, shut, &first);
    for (int k = 1; k <= frames && status == RSV_OK; k++)
        status = show(light, scene, shut + (open - shut) * (float)k / (float)frames, &last);
    // it rests: elements are now divided as a solve would divide them
    if (status == RSV_OK) status = show(light, scene, open, &last);
    if (status != RSV_OK) fprintf(stderr, "error: %s\n", rsv_last_error());
    rsv_light_destroy(light);
    rsv_scene_destroy(scene);
    rsv_context_destroy(context);
    return !(status == RSV_OK && last > 1.2f * first);
}
