/// Faces that are there twice. Those that lie in the plane of others and overlap them only in part are none: a rug on a
/// floor, slivers at a fold that meet by rounding.
#include "check_internal.h"

#include "../core/vec.h"
#include "../scene/twins.h"

#include <stdlib.h>

/// A triangle by the places of its corners, from the smallest to the largest.
typedef struct face {
    rsv_vec3 corner[3];
    uint32_t triangle;
} face;

static int compare_corners(const face *e, const face *f)
{
    int order = 0;
    for (int k = 0; k < 3 && !order; k++)
        order = compare_places(e->corner[k], f->corner[k]);
    return order;
}

static int compare_faces(const void *p, const void *q)
{
    const face *e = p, *f = q;
    int order = compare_corners(e, f);
    return order ? order : (e->triangle > f->triangle) - (e->triangle < f->triangle);
}

static face face_of(const rsv_scene_view *view, uint32_t triangle)
{
    face f = { .triangle = triangle };
    for (int k = 0; k < 3; k++) {
        int at = k;
        rsv_vec3 place = view->position[view->triangle[triangle][k]];
        for (; at > 0 && compare_places(place, f.corner[at - 1]) < 0; at--)
            f.corner[at] = f.corner[at - 1];
        f.corner[at] = place;
    }
    return f;
}

/// Adds up copies by object. @param faces [count] sorted @param doubled [object_count]
static void count_copies(
    const rsv_scene_view *view, const face *faces, size_t count, size_t *doubled)
{
    for (size_t k = 0; k < count; k++) {
        bool same = (k > 0 && compare_corners(&faces[k], &faces[k - 1]) == 0) ||
                    (k + 1 < count && compare_corners(&faces[k], &faces[k + 1]) == 0);
        uint32_t triangle = faces[k].triangle;
        if (same && (view->twins->flags[triangle] & RSV_TWIN_COPY))
            doubled[view->triangle_object[triangle]]++;
    }
}

static rsv_status tell_all(rsv_checker *c, const size_t *doubled)
{
    rsv_status status = RSV_OK;
    for (size_t k = 0; k < c->view->object_count; k++) {
        const char *name = c->view->object_name[k];
        const rsv_finding found = { .mistake = RSV_MISTAKE_DOUBLED_FACES, .count = doubled[k] };
        if (doubled[k])
            RSV_TRY(rsv_check_tell(c, &found, name,
                "object '%.100s': %zu faces lie in the same place as others; delete the copies",
                name, doubled[k]));
    }
cleanup:
    return status;
}

rsv_status rsv_check_doubled(rsv_checker *c)
{
    rsv_status status = RSV_OK;
    const rsv_scene_view *view = c->view;
    size_t count = 0;
    if (!view->twins) return RSV_OK;
    size_t *doubled = rsv_alloc(c->context, view->object_count, sizeof *doubled);
    face *faces = rsv_alloc(c->context, view->triangle_count, sizeof *faces);
    if (!doubled || !faces) RSV_TRY(RSV_ERROR_MEMORY);
    for (uint32_t t = 0; t < view->triangle_count; t++)
        if (view->twins->flags[t]) faces[count++] = face_of(view, t);
    qsort(faces, count, sizeof *faces, compare_faces);
    count_copies(view, faces, count, doubled);
    RSV_TRY(tell_all(c, doubled));
cleanup:
    rsv_free(c->context, doubled);
    rsv_free(c->context, faces);
    return status;
}
