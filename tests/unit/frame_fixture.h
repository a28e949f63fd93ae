/// Frames of a small size, and the pictures they are compared with.
#ifndef RSV_TEST_FRAME_FIXTURE_H
#define RSV_TEST_FRAME_FIXTURE_H

#include "resolvent/frame.h"

#include "light_fixture.h"
#include "resolvent/render.h"
#include "slow_tests.h"

enum { width = 70, height = 50, pixel_count = width * height };

static inline rsv_light *solve_for_frames(const world *w, uint32_t elements, uint32_t photons)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = UNLESS_SANITIZED(elements, elements / 4);
    desc.rays_per_element = 64;
    desc.photon_count = UNLESS_SANITIZED(photons, photons / 4);
    rsv_light *solution;
    assert_int_equal(rsv_light_create(w->scene, &desc, &solution), RSV_OK);
    return solution;
}

static inline rsv_frame_desc frame_desc(void)
{
    rsv_frame_desc desc = rsv_default_frame_desc();
    desc.width = width;
    desc.height = height;
    desc.gloss = RSV_GLOSS_PATHS;
    return desc;
}

static inline rsv_frame_view view_of(const world *w)
{
    const rsv_camera *camera = rsv_scene_get_view(w->scene)->camera;
    return (rsv_frame_view){ .camera = { camera[0], camera[0] } };
}

/// @param camera NULL = the scene's first
static inline rsv_image *render_picture(
    const rsv_light *solution, const rsv_camera *camera, uint32_t samples, bool layers)
{
    rsv_render_desc desc = rsv_default_render_desc();
    desc.mode = RSV_RENDER_OPERATOR;
    desc.width = width;
    desc.height = height;
    desc.samples = samples;
    desc.path_depth = 8;
    desc.shared_pattern = true;
    desc.layers = layers;
    desc.viewpoint = camera;
    rsv_image *image;
    assert_int_equal(rsv_render(solution, &desc, &image), RSV_OK);
    return image;
}

static inline bool alike(float a, float b) { return fabsf(a - b) <= 1e-5f * (1 + fabsf(b)); }

/// Pixels that differ by more than rounding. @param shown [pixel_count] the eye's radiance, out
static inline size_t count_different(
    const rsv_frame_renderer *renderer, uint32_t eye, const rsv_rgb *picture, rsv_rgb *shown)
{
    size_t different = 0;
    rsv_frame_radiance(renderer, eye, shown);
    for (size_t k = 0; k < pixel_count; k++)
        different += !alike(shown[k].r, picture[k].r) || !alike(shown[k].g, picture[k].g) ||
                     !alike(shown[k].b, picture[k].b);
    return different;
}

#endif
