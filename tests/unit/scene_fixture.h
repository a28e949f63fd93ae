/// A context that records log messages, for the tests of scenes and files.
#ifndef RSV_TEST_SCENE_FIXTURE_H
#define RSV_TEST_SCENE_FIXTURE_H

#include "core/core.h"
#include "core/vec.h"
#include "resolvent/scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

typedef struct fixture {
    rsv_context *context;
    char log[65536];                ///< all messages, one a line, warnings marked "warning: "
    atomic_size_t allocations_left; ///< SIZE_MAX = unlimited; at 0 every allocation fails
    atomic_bool fails_once;         ///< only the next of them does; false again when it has
    atomic_size_t allocations_alive;
} fixture;

static inline void fixture_log(void *user, rsv_log_level level, const char *message)
{
    fixture *f = user;
    size_t used = strlen(f->log);
    snprintf(f->log + used, sizeof f->log - used, "%s%s\n",
        level == RSV_LOG_WARNING ? "warning: " : "", message);
}

static inline void *fixture_allocate(void *user, size_t bytes)
{
    fixture *f = user;
    if (!f->allocations_left) {
        if (f->fails_once) f->allocations_left = SIZE_MAX;
        f->fails_once = false;
        return NULL;
    }
    if (f->allocations_left != SIZE_MAX) f->allocations_left--;
    f->allocations_alive++;
    return aligned_alloc(64, bytes);
}

static inline void fixture_release(void *user, void *memory)
{
    fixture *f = user;
    f->allocations_alive--;
    free(memory);
}

static inline int fixture_setup(void **state)
{
    fixture *f = calloc(1, sizeof *f);
    assert_non_null(f);
    f->allocations_left = SIZE_MAX;
    rsv_context_desc desc = rsv_default_context_desc();
    desc.log = fixture_log;
    desc.allocate = fixture_allocate;
    desc.release = fixture_release;
    desc.user = f;
    assert_int_equal(rsv_context_create(&desc, &f->context), RSV_OK);
    *state = f;
    return 0;
}

static inline int fixture_teardown(void **state)
{
    fixture *f = *state;
    rsv_context_destroy(f->context);
    assert_int_equal(f->allocations_alive, 0); // nothing leaked through the context
    free(f);
    return 0;
}

static inline void assert_mentions(const char *text, const char *part)
{
    if (!strstr(text, part)) fail_msg("'%s' does not mention '%s'", text, part);
}

static inline size_t count_mentions(const char *text, const char *part)
{
    size_t count = 0;
    for (const char *found = strstr(text, part); found; found = strstr(found + 1, part))
        count++;
    return count;
}

static inline rsv_vec3 geometric_normal(const rsv_scene_view *view, size_t t)
{
    const uint32_t *c = view->triangle[t];
    rsv_vec3 a = view->position[c[0]];
    return v3_normalize(v3_cross(v3_sub(view->position[c[1]], a), v3_sub(view->position[c[2]], a)));
}

static inline rsv_vec3 centroid(const rsv_scene_view *view, size_t t)
{
    const uint32_t *c = view->triangle[t];
    return v3_barycentric(
        view->position[c[0]], view->position[c[1]], view->position[c[2]], 1.0f / 3, 1.0f / 3);
}

static inline const char *object_of(const rsv_scene_view *view, size_t t)
{
    return view->object_name[view->triangle_object[t]];
}

#endif
