/// A room that is edited and solved again, for the tests of files that solves keep for the next one.
#ifndef RSV_TEST_HISTORY_FIXTURE_H
#define RSV_TEST_HISTORY_FIXTURE_H

#include "file_fixture.h"
#include "light_fixture.h"
#include "light_view.h"
#include "update/history_file.h"

#include <math.h>

/// The properties that are edited. Metres.
typedef struct room {
    float box_at;   ///< x of a box on the floor
    float albedo;   ///< of that box
    float radiance; ///< of the lamp
    float sky;      ///< radiance of the brighter half of the sky; 0 = the room is closed
} room;

static const room plain = { 0.5f, 0.5f, 1, 0 };
static const room moved = { 0.8f, 0.5f, 1, 0 };

/// A floor and a wall under a sky, which is brighter on one side.
static inline void build_outdoors(world *w, uint32_t walls, float radiance)
{
    rsv_rgb pixels[4 * 2];
    for (int k = 0; k < 8; k++)
        pixels[k] = rgb_gray(k % 4 < 2 ? radiance : 0.2f * radiance);
    const rsv_environment sky = {
        .name = "sky", .pixels = pixels, .width = 4, .height = 2, .intensity = 1
    };
    assert_int_equal(rsv_scene_set_environment(w->scene, &sky), RSV_OK);
    world_box(w, walls, v3(0, -0.1f, 0), v3(6, 0, 2));
    world_box(w, walls, v3(0, 1e-4f, 2), v3(6, 2, 2.1f));
}

static inline void furnish(world *w, const room *r)
{
    uint32_t walls = world_lambert(w, 0.7f, 0), box = world_lambert(w, r->albedo, 0);
    uint32_t lamp = world_lambert(w, 0, r->radiance);
    if (r->sky > 0)
        build_outdoors(w, walls, r->sky);
    else
        world_room(w, walls, v3(0, 0, 0), v3(6, 2, 2));
    world_box(w, box, v3(r->box_at, 1e-4f, 0.5f), v3(r->box_at + 0.3f, 0.4f, 0.8f));
    world_box(w, lamp, v3(1, 1.9f, 0.8f), v3(1.3f, 1.95f, 1.2f));
    world_commit(w);
}

static inline world *build(const room *r, int threads)
{
    world *w = world_begin(threads);
    furnish(w, r);
    return w;
}

static inline rsv_solve_desc few_elements(const char *rows, const char *earlier)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 400;
    desc.rays_per_element = 64;
    desc.refinements = 1;
    desc.direct_levels = 2;
    desc.checkpoint = rows;
    desc.earlier = earlier;
    return desc;
}

static inline rsv_light *solve_as(
    const world *w, const char *rows, const char *earlier, uint32_t seed)
{
    rsv_light *s = NULL;
    rsv_solve_desc desc = few_elements(rows, earlier);
    desc.seed = seed;
    if (rsv_light_create(w->scene, &desc, &s) != RSV_OK) fail_msg("%s", rsv_last_error());
    return s;
}

static inline rsv_light *solve(const world *w, const char *rows, const char *earlier)
{
    return solve_as(w, rows, earlier, 1);
}

/// Solves a room and keeps its results in `rows`.
static inline void leave_as(const room *r, const char *rows, const char *earlier, uint32_t seed)
{
    world *w = build(r, 2);
    rsv_light_destroy(solve_as(w, rows, earlier, seed));
    world_end(w);
}

static inline void leave(const room *r, const char *rows, const char *earlier)
{
    leave_as(r, rows, earlier, 1);
}

/// A room that was solved, edited, and solved again from the kept results.
typedef struct edited_room {
    folder before, after;
    world *w; ///< as it is now
    rsv_light *s;
} edited_room;

static inline edited_room edit(const room *then, const room *now)
{
    edited_room r = { .before = new_folder(), .after = new_folder(), .w = build(now, 2) };
    leave(then, r.before.path, NULL);
    r.s = solve(r.w, r.after.path, r.before.path);
    return r;
}

static inline void end_edit(edited_room *r)
{
    rsv_light_destroy(r->s);
    world_end(r->w);
    remove_folder(r->before.path);
    remove_folder(r->after.path);
}

/// Metres around the box, before and after it is moved: its shadow, and the light that it returns.
static inline bool is_near_the_box(rsv_vec3 p)
{
    return p.x > 0.2f && p.x < 1.4f && p.y < 0.5f && p.z > 0.2f && p.z < 1.1f;
}

/// Mean difference of irradiance at points of the surfaces near the box, over its mean.
static inline double difference(const rsv_light *a, const rsv_light *b)
{
    double sum = 0, all = 0;
    for (uint32_t t = 0; t < inside(a)->scene.view->triangle_count; t++)
        for (uint32_t k = 0; k < 512; k++) {
            float x, y;
            rsv_sobol_2d(k, t, &x, &y);
            float root = sqrtf(x), u = 1 - root, v = root * y;
            if (!is_near_the_box(
                    rsv_surface_point_at(inside(a)->scene.view, t, u, v, false).position))
                continue;
            double area = (double)rsv_triangle_area(inside(a)->scene.view, t);
            double p = (double)rgb_luminance(rsv_light_irradiance(a, t, u, v, false, RSV_NONE));
            double q = (double)rgb_luminance(rsv_light_irradiance(b, t, u, v, false, RSV_NONE));
            sum += area * fabs(p - q);
            all += area * (p + q) / 2;
        }
    return sum / all;
}

/// The history file in a folder. @return to be freed
static inline rsv_history_header *read_past(const char *folder_path, size_t *bytes)
{
    char path[512] = { 0 };
    DIR *directory = opendir(folder_path);
    for (struct dirent *entry; (entry = readdir(directory));)
        if (strstr(entry->d_name, ".history"))
            snprintf(path, sizeof path, "%.200s/%.200s", folder_path, entry->d_name);
    closedir(directory);
    return (rsv_history_header *)(void *)read_bytes(path, bytes);
}

static inline void write_past(const char *folder_path, rsv_history_header *h, size_t bytes)
{
    char path[512];
    char name[RSV_STORE_NAME_BYTES];
    rsv_history_name(h->settings, name);
    snprintf(path, sizeof path, "%.200s/%s", folder_path, name);
    h->checksum = rsv_history_checksum(h, bytes);
    write_bytes(path, h, bytes);
}

/// The files that a solve left in a folder.
typedef struct opened {
    rsv_store *store;
    rsv_history *history; ///< NULL = nothing that is sound
} opened;

static inline opened open_history(const rsv_transport_scene *scene, const rsv_lights *lights,
    const char *folder_path, uint64_t settings)
{
    opened o = { 0 };
    assert_int_equal(rsv_store_folder(lights->context, folder_path, &o.store), RSV_OK);
    assert_int_equal(rsv_history_open(scene, lights, o.store, settings, &o.history), RSV_OK);
    return o;
}

static inline void close_history(opened *o)
{
    rsv_history_close(o->history);
    rsv_store_destroy(o->store);
}

#endif
