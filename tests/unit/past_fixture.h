/// A room that is edited and solved again, for the tests of what solves leave for each other.
#ifndef RSV_TEST_PAST_FIXTURE_H
#define RSV_TEST_PAST_FIXTURE_H

#include "elements/past_file.h"
#include "file_fixture.h"
#include "light_fixture.h"
#include "solve/solution.h"

/// What is edited. Metres.
typedef struct room {
    float box_at;   ///< x of a box on the floor
    float albedo;   ///< of that box
    float radiance; ///< of the lamp
} room;

static const room plain = { 0.5f, 0.5f, 1 };

static inline world *build(const room *r, int threads)
{
    world *w = world_begin(threads);
    uint32_t walls = world_lambert(w, 0.7f, 0), box = world_lambert(w, r->albedo, 0);
    uint32_t lamp = world_lambert(w, 0, r->radiance);
    world_room(w, walls, v3(0, 0, 0), v3(6, 2, 2));
    world_box(w, box, v3(r->box_at, 1e-4f, 0.5f), v3(r->box_at + 0.3f, 0.4f, 0.8f));
    world_box(w, lamp, v3(1, 1.9f, 0.8f), v3(1.3f, 1.95f, 1.2f));
    world_commit(w);
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

static inline rsv_solution *solve_as(
    const world *w, const char *rows, const char *earlier, uint32_t seed)
{
    rsv_solution *s = NULL;
    rsv_solve_desc desc = few_elements(rows, earlier);
    desc.seed = seed;
    if (rsv_solution_create(w->scene, &desc, &s) != RSV_OK) fail_msg("%s", rsv_last_error());
    return s;
}

static inline rsv_solution *solve(const world *w, const char *rows, const char *earlier)
{
    return solve_as(w, rows, earlier, 1);
}

/// Solves a room and leaves what it knows in `rows`.
static inline void leave_as(const room *r, const char *rows, const char *earlier, uint32_t seed)
{
    world *w = build(r, 2);
    rsv_solution_destroy(solve_as(w, rows, earlier, seed));
    world_end(w);
}

static inline void leave(const room *r, const char *rows, const char *earlier)
{
    leave_as(r, rows, earlier, 1);
}

/// The file of what a solve knew, in a folder. @return to be freed
static inline rsv_past_header *read_past(const char *folder_path, size_t *bytes)
{
    char path[512] = { 0 };
    DIR *directory = opendir(folder_path);
    for (struct dirent *entry; (entry = readdir(directory));)
        if (strstr(entry->d_name, ".past"))
            snprintf(path, sizeof path, "%.200s/%.200s", folder_path, entry->d_name);
    closedir(directory);
    return (rsv_past_header *)(void *)read_bytes(path, bytes);
}

static inline void write_past(const char *folder_path, rsv_past_header *h, size_t bytes)
{
    char path[512];
    assert_true(rsv_past_path(folder_path, h->settings, path, sizeof path));
    h->checksum = rsv_past_checksum(h, bytes);
    write_bytes(path, h, bytes);
}

#endif
