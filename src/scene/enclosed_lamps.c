#include "enclosed_lamps.h"

#include "../core/sampling.h"
#include "punctual.h"
#include "scene.h"
#include "tree_ray.h"

/// Rays per lamp, and maximum number of random reflections. Openings smaller than 1/256 of the sphere, or found only
/// after more reflections, are ignored.
#define RAYS 256
#define REFLECTIONS 6
/// Places on an emissive object that rays are sent from, at most.
#define PLACES 16

/// A body is no room if it is smaller than this many metres, or this part of the scene ...
#define SMALL 1.0f
#define SMALL_PART (1 / 20.0f)
/// ... and at any rate than this part of the scene, with no more than this share of its surface within.
#define MOST_PART (1 / 3.0f)
#define MOST_SURFACE 0.1

/// Warnings about single lamps.
#define MOST_NAMED 8

/// A lamp and the space around it that its light gets to.
typedef struct search {
    const rsv_scene_view *view;
    const rsv_twin_tree *tree;
    float size, limit;  ///< size of the scene, and size below which a body is not a room; metres
    rsv_vec3 low, high; ///< of the places that light was followed to
    bool reflected;     ///< some light was reflected; otherwise it hit only backs
    uint32_t object;    ///< that light met first, by majority (Boyer and Moore 1991)
    int votes;
} search;

static bool find_hit(const search *s, const rsv_ray *ray, rsv_hit *hit)
{
    float slack = 1e-6f * s->size;
    const rsv_tree_ray through = {
        .view = s->view, .tree = s->tree, .ray = *ray, .t_min = slack, .slack = slack
    };
    if (!rsv_tree_ray_closest(&through, hit)) return false;
    if (s->view->twins) rsv_twins_settle(s->view, ray->direction, hit);
    return true;
}

// ---- one lamp -----------------------------------------------------------------------------------

static void spread(search *s, rsv_vec3 place)
{
    s->low = v3_min(s->low, place);
    s->high = v3_max(s->high, place);
}

static bool is_large(const search *s) { return v3_max_abs(v3_sub(s->high, s->low)) > s->limit; }

static void vote(search *s, uint32_t object)
{
    if (s->votes == 0) s->object = object;
    s->votes += object == s->object ? 1 : -1;
}

static rsv_vec3 random_around(rsv_vec3 normal, uint32_t stream, uint32_t k)
{
    rsv_vec3 d = rsv_square_to_cosine_hemisphere(
        rsv_unit_float(rsv_hash2(2 * stream, k)), rsv_unit_float(rsv_hash2(2 * stream + 1, k)));
    return v3_turned_to(normal, d);
}

/// A coordinate of a place on a triangle, moved inwards: from its edge, rays would pass the wall that stands there.
static float inner(float u) { return u + 1e-3f * (1 / 3.0f - u); }

/// Follows light from a lamp. @return whether it may stay near the lamp, as far as this ray shows
static bool stays(search *s, rsv_ray ray, uint32_t index)
{
    const rsv_scene_view *view = s->view;
    for (uint32_t step = 0; step <= REFLECTIONS; step++) {
        rsv_hit hit;
        if (!find_hit(s, &ray, &hit)) return false;
        uint32_t material = view->triangle_material[hit.triangle];
        const rsv_material *m = &view->material[material];
        if (!rsv_twin_is_opaque(view, material) || m->diffuse_transmission > 0) return false;
        if (step == 0) vote(s, view->triangle_object[hit.triangle]);
        rsv_twin_plane plane = rsv_twin_plane_of(view, hit.triangle);
        rsv_vec3 normal = v3_normalize(plane.normal);
        bool back = v3_dot(normal, ray.direction) > 0;
        spread(s, v3_mad(ray.origin, hit.t, ray.direction));
        if (back && !m->double_sided) return !(s->reflected && is_large(s));
        s->reflected = true;
        if (is_large(s)) return false;
        if (back) normal = v3_neg(normal);
        ray.origin = rsv_twin_point(&plane, inner(hit.u), inner(hit.v));
        ray.direction = random_around(normal, step + 1, index);
    }
    return true;
}

static bool is_within(const search *s, rsv_vec3 p)
{
    return p.x >= s->low.x && p.x <= s->high.x && p.y >= s->low.y && p.y <= s->high.y &&
           p.z >= s->low.z && p.z <= s->high.z;
}

static bool has_camera(const search *s)
{
    for (size_t k = 0; k < s->view->camera_count; k++)
        if (is_within(s, s->view->camera[k].position)) return true;
    return false;
}

/// Whether the space that light reaches is a room and not a body: it contains a camera or many objects.
static bool is_room(const search *s)
{
    const rsv_scene_view *view = s->view;
    double within = 0, all = 0;
    if (has_camera(s)) return true;
    for (uint32_t t = 0; t < view->triangle_count; t++) {
        const uint32_t *corner = view->triangle[t];
        rsv_vec3 a = view->position[corner[0]], b = view->position[corner[1]],
                 c = view->position[corner[2]];
        double area = (double)v3_length(v3_cross(v3_sub(b, a), v3_sub(c, a)));
        all += area;
        if (is_within(s, a) && is_within(s, b) && is_within(s, c)) within += area;
    }
    return within > MOST_SURFACE * all;
}

static void begin(search *s, rsv_vec3 place)
{
    s->low = s->high = place;
    s->reflected = false;
    s->votes = 0;
}

/// A space with only backs around it is dark, whatever its size.
static bool is_enclosed(const search *s) { return !s->reflected || (!is_large(s) && !is_room(s)); }

static bool is_light_enclosed(search *s, const rsv_punctual_light *light)
{
    bool spot = rsv_punctual_has_cone(light);
    float least = spot ? cosf(light->outer_cone_angle) : -1;
    rsv_vec3 t, b, axis = spot ? light->direction : v3(0, 1, 0);
    if (rsv_punctual_is_distant(light) || rgb_is_black(light->intensity)) return false;
    begin(s, light->position);
    v3_frame(axis, &t, &b);
    for (uint32_t k = 0; k < RAYS; k++) {
        // Fibonacci's spiral
        float z = 1 - (1 - least) * ((float)k + 0.5f) / RAYS, r = sqrtf(f_max(1 - z * z, 0));
        float turn = 2.39996323f * (float)k + 0.1f;
        rsv_vec3 d = v3_mad(v3_scale(t, r * cosf(turn)), r * sinf(turn), b);
        rsv_ray ray = { light->position, v3_mad(d, z, axis), INFINITY };
        if (!stays(s, ray, k) || has_camera(s)) return false;
    }
    return is_enclosed(s);
}

static bool emits(const rsv_scene_view *view, uint32_t triangle)
{
    const rsv_material *m = &view->material[view->triangle_material[triangle]];
    return !rgb_is_black(m->emission) && !m->unlit && !rsv_twins_hide(view, triangle, false);
}

/// Whether light from a few places all over the emissive faces of an object stays near.
/// @param first, end of the object's triangles @param count of those that emit
static bool is_object_enclosed(search *s, uint32_t first, uint32_t end, uint32_t count)
{
    const rsv_scene_view *view = s->view;
    uint32_t places = count < PLACES ? count : PLACES, taken = 0, seen = 0;
    for (uint32_t t = first; t < end; t++) {
        if (!emits(view, t) || (uint64_t)seen++ * places < (uint64_t)taken * count) continue;
        rsv_twin_plane plane = rsv_twin_plane_of(view, t);
        rsv_vec3 normal = v3_normalize(plane.normal), from = rsv_twin_point(&plane, 0.3f, 0.3f);
        int sides = view->material[view->triangle_material[t]].double_sided ? 2 : 1;
        if (taken++ == 0) begin(s, from);
        spread(s, from);
        for (uint32_t k = 0; k < RAYS / places; k++) {
            rsv_vec3 side = k % (uint32_t)sides ? v3_neg(normal) : normal;
            rsv_ray ray = { from, random_around(side, 0, taken * RAYS + k), INFINITY };
            if (!stays(s, ray, taken * RAYS + k) || has_camera(s)) return false;
        }
    }
    return is_enclosed(s);
}

// ---- all ----------------------------------------------------------------------------------------

static void warn(const search *s, const rsv_context *context, const char *kind, const char *name,
    uint32_t *count)
{
    if ((*count)++ >= MOST_NAMED) return;
    rsv_log(context, RSV_LOG_WARNING,
        "%s '%s': the opaque object '%s' encloses it and blocks all of its light; give that object a "
        "transparent material (KHR_materials_transmission), open it, or delete it",
        kind, name, s->view->object_name[s->object]);
}

/// @return whether all emissive objects are enclosed, if there are any
/// @param warned NULL = look until one is not, and say nothing @param found out: the last that is
static bool look_into_objects(
    search *s, const rsv_context *context, uint32_t *warned, const char **found)
{
    const rsv_scene_view *view = s->view;
    bool all = true;
    for (uint32_t first = 0, end; first < view->triangle_count && (all || warned); first = end) {
        uint32_t object = view->triangle_object[first], emissive = 0;
        for (end = first; end < view->triangle_count && view->triangle_object[end] == object; end++)
            emissive += emits(view, end);
        if (!emissive) continue;
        bool enclosed = is_object_enclosed(s, first, end, emissive);
        all = all && enclosed;
        if (enclosed) *found = view->object_name[object];
        if (enclosed && warned) warn(s, context, "lamp", view->object_name[object], warned);
    }
    return all;
}

/// The same for punctual lights.
static bool look_around_lights(
    search *s, const rsv_context *context, uint32_t *warned, const char **found)
{
    const rsv_scene_view *view = s->view;
    bool all = true;
    for (size_t k = 0; k < view->light_count && (all || warned); k++) {
        if (rgb_is_black(view->light[k].intensity)) continue;
        bool enclosed = is_light_enclosed(s, &view->light[k]);
        all = all && enclosed;
        if (enclosed) *found = view->light[k].name;
        if (enclosed && warned) warn(s, context, "light", view->light[k].name, warned);
    }
    return all;
}

/// Bodies of any size, if they are closed around all lamps there are: then pictures are black.
static void look_for_darkness(search *s, const rsv_context *context)
{
    const char *found = NULL;
    uint32_t count = 0;
    s->limit = INFINITY;
    if (s->view->environment || !look_around_lights(s, context, NULL, &found)) return;
    const char *light = found;
    if (look_into_objects(s, context, NULL, &found) && found)
        warn(s, context, found == light ? "light" : "lamp", found, &count);
}

void rsv_warn_of_enclosed_lamps(const rsv_scene *scene, const rsv_twin_tree *tree)
{
    const rsv_scene_view *view = &scene->view;
    float size = v3_max_abs(v3_sub(view->bounds_max, view->bounds_min));
    search s = { .view = view, .tree = tree, .size = size };
    const char *found = NULL;
    uint32_t count = 0;
    s.limit = f_min(f_max(SMALL, SMALL_PART * size), MOST_PART * size);
    look_around_lights(&s, scene->context, &count, &found);
    look_into_objects(&s, scene->context, &count, &found);
    if (count > MOST_NAMED)
        rsv_log(scene->context, RSV_LOG_WARNING, "%u more lamps are enclosed by something opaque",
            count - MOST_NAMED);
    if (count == 0) look_for_darkness(&s, scene->context);
}
