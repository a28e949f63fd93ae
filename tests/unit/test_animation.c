/// Animated glTF files: positions at a given time, compared with closed forms.
#include "gltf_fixture.h"

#include "resolvent/animation.h"

#include <math.h>

#define SQUARE "\"attributes\":{\"POSITION\":0},\"indices\":1"
#define SQUARES "\"meshes\":[{\"primitives\":[{" SQUARE "}]}],"

static rsv_animation *open_sketch(
    fixture *f, const folder *place, const sketch *s, const char *rest)
{
    rsv_animation *animation = NULL;
    if (rsv_animation_open(f->context, write_sketch(place, s, rest), NULL, &animation) != RSV_OK)
        fail_msg("%s", rsv_last_error());
    return animation;
}

static rsv_scene *scene_at(rsv_animation *animation, uint32_t clip, double time)
{
    rsv_scene *scene = NULL;
    if (rsv_animation_scene(animation, clip, time, &scene) != RSV_OK)
        fail_msg("%s", rsv_last_error());
    return scene;
}

/// Corner `k` of the first triangle.
static rsv_vec3 corner_at(rsv_animation *animation, uint32_t clip, double time, int k)
{
    rsv_scene *scene = scene_at(animation, clip, time);
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    rsv_vec3 p = view->position[view->triangle[0][k]];
    rsv_scene_destroy(scene);
    return p;
}

static void assert_near(rsv_vec3 found, rsv_vec3 wanted, double time)
{
    if (v3_max_abs(v3_sub(found, wanted)) > 2e-6f * fmaxf(1, v3_max_abs(wanted)))
        fail_msg("at %g s (%.8g %.8g %.8g), not (%.8g %.8g %.8g)", time, (double)found.x,
            (double)found.y, (double)found.z, (double)wanted.x, (double)wanted.y, (double)wanted.z);
}

/// One channel of node 0, accessor 2 over accessor 3.
#define ONE_CHANNEL(path, interpolation)                                                           \
    "\"animations\":[{\"name\":\"go\",\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,"        \
    "\"path\":\"" path "\"}}],\"samplers\":[{\"input\":2,\"output\":3" interpolation "}]}],"
#define ONE_NODE SQUARES "\"nodes\":[{\"mesh\":0}]"

// ---- interpolation --------------------------------------------------------------------------------

static void quaternion_about_z(double angle, float sign, float q[4])
{
    q[0] = q[1] = 0;
    q[2] = sign * (float)sin(angle / 2);
    q[3] = sign * (float)cos(angle / 2);
}

/// Rotation at constant speed along the shorter arc, for either sign of the quaternions.
static void rotations_go_along_the_arc(void **state)
{
    const float time[2] = { 2, 3 };
    static const double angles[] = { 2, 3.1, -2.5, 1e-4 };
    folder place = new_folder();
    for (int k = 0; k < 8; k++) {
        double angle = angles[k / 2];
        float turn[8];
        sketch s = square_sketch();
        quaternion_about_z(0.25, 1, turn);
        quaternion_about_z(0.25 + angle, k % 2 ? -1 : 1, turn + 4);
        add_vectors(&s, time, 2, 1);
        add_vectors(&s, turn, 2, 4);
        rsv_animation *a = open_sketch(*state, &place, &s, ONE_CHANNEL("rotation", "") ONE_NODE);
        for (int quarter = -1; quarter <= 5; quarter++) {
            double t = 2 + 0.25 * quarter, share = fmin(fmax(0.25 * quarter, 0), 1);
            double now = 0.25 + share * angle;
            assert_near(corner_at(a, 0, t, 1), v3((float)cos(now), (float)sin(now), 0), t);
        }
        rsv_animation_destroy(a);
    }
    remove_folder(place.path);
}

static void steps_hold_their_value(void **state)
{
    const float time[3] = { 0, 1, 1.5f }, place_at[9] = { 1, 0, 0, 2, 0, 0, 3, 5, 0 };
    static const double when[] = { -1, 0, 0.999, 1, 1.25, 1.5, 9 };
    static const float x[] = { 1, 1, 1, 2, 2, 3, 3 };
    folder place = new_folder();
    sketch s = square_sketch();
    add_vectors(&s, time, 3, 1);
    add_vectors(&s, place_at, 3, 3);
    rsv_animation *a = open_sketch(
        *state, &place, &s, ONE_CHANNEL("translation", ",\"interpolation\":\"STEP\"") ONE_NODE);
    for (int k = 0; k < 7; k++)
        assert_near(corner_at(a, 0, when[k], 0), v3(x[k], x[k] == 3 ? 5 : 0, 0), when[k]);
    rsv_animation_destroy(a);
    remove_folder(place.path);
}

/// A cubic of time is met exactly by a cubic spline through any of its keys.
static void cubic_splines_meet_a_cubic(void **state)
{
    const float time[3] = { 0, 0.5f, 2 };
    float key[27];
    for (int k = 0; k < 3; k++)
        for (int axis = 0; axis < 3; axis++) {
            float t = time[k], c = (float)(axis + 1);
            key[9 * k + axis] = key[9 * k + 6 + axis] = 3 * t * t - c; // slopes of t^3 - c t + 1
            key[9 * k + 3 + axis] = t * t * t - c * t + 1;
        }
    folder place = new_folder();
    sketch s = square_sketch();
    add_vectors(&s, time, 3, 1);
    add_vectors(&s, key, 9, 3);
    rsv_animation *a = open_sketch(*state, &place, &s,
        ONE_CHANNEL("translation", ",\"interpolation\":\"CUBICSPLINE\"") ONE_NODE);
    for (double t = 0; t <= 2; t += 0.125) {
        float v = (float)(t * t * t - t + 1), u = (float)t;
        assert_near(corner_at(a, 0, t, 0), v3(v, v - u, v - 2 * u), t);
    }
    rsv_animation_destroy(a);
    remove_folder(place.path);
}

/// Scales as normalised bytes without a buffer view but for what is sparse, rotations as shorts.
static void normalized_and_sparse_keys_are_read(void **state)
{
    const float time[2] = { 0, 1 };
    const int16_t turn[8] = { 0, 0, 0, 32767, 0, 0, 32767, 0 };
    const uint8_t index[1] = { 1 };
    const float wide[3] = { 3, 2, 1 };
    folder place = new_folder();
    sketch s = square_sketch();
    add_vectors(&s, time, 2, 1);
    add_accessor(&s, turn, sizeof turn, 5122, 2, "VEC4", ",\"normalized\":true");
    add_accessor(&s, index, sizeof index, 5121, 1, "SCALAR", "");
    add_vectors(&s, wide, 1, 3);
    append_text(s.accessors, sizeof s.accessors,
        ",{\"componentType\":5126,\"count\":2,\"type\":\"VEC3\",\"sparse\":{\"count\":1,"
        "\"indices\":{\"bufferView\":4,\"componentType\":5121},\"values\":{\"bufferView\":5}}}");
    rsv_animation *a = open_sketch(*state, &place, &s,
        "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":"
        "\"rotation\"}},{\"sampler\":1,\"target\":{\"node\":0,\"path\":\"scale\"}}],\"samplers\":"
        "[{\"input\":2,\"output\":3},{\"input\":2,\"output\":6}]}]," ONE_NODE);
    assert_string_equal(rsv_animation_clip(a, 0)->name, "animation 0");
    assert_int_equal(rsv_animation_clip(a, 0)->channel_count, 2);
    assert_near(corner_at(a, 0, 1, 1), v3(-3, 0, 0), 1);
    assert_near(corner_at(a, 0, 0.5, 1), v3(0, 1.5f, 0), 0.5); // a quarter turn, half of 3
    rsv_animation_destroy(a);
    remove_folder(place.path);
}

// ---- what moves -----------------------------------------------------------------------------------

/// A joint turns half of each corner's weight.
static void joints_bend_what_is_bound(void **state)
{
    const float time[2] = { 0, 1 }, turn[8] = { 0, 0, 0, 1, 0, 0, 1, 0 };
    const uint8_t joints[16] = { 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0 };
    const float weights[16] = { 1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0 };
    folder place = new_folder();
    sketch s = square_sketch();
    add_vectors(&s, time, 2, 1);
    add_vectors(&s, turn, 2, 4);
    add_accessor(&s, joints, sizeof joints, 5121, 4, "VEC4", "");
    add_vectors(&s, weights, 4, 4);
    rsv_animation *a = open_sketch(*state, &place, &s,
        "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":2,\"path\":"
        "\"rotation\"}}],\"samplers\":[{\"input\":2,\"output\":3}]}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"JOINTS_0\":4,\"WEIGHTS_0\":"
        "5},\"indices\":1}]}],\"skins\":[{\"joints\":[1,2]}],"
        "\"nodes\":[{\"mesh\":0,\"skin\":0},{\"children\":[2]},{}]");
    for (int k = 0; k < 4; k++) {
        double t = 0.25 * k, angle = 3.14159265358979 * t;
        float c = (float)cos(angle), n = (float)sin(angle);
        assert_near(corner_at(a, 0, t, 0), v3(0, 0, 0), t);
        assert_near(corner_at(a, 0, t, 1), v3(0.5f + 0.5f * c, 0.5f * n, 0), t);
        assert_near(corner_at(a, 0, t, 2), v3(c - n, n + c, 0), t);
    }
    rsv_animation_destroy(a);
    remove_folder(place.path);
}

static void weights_of_morph_targets_move(void **state)
{
    const float time[2] = { 0, 1 }, weight[4] = { 0, 1, 1, -1 };
    const float lift[12] = { 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1 };
    const float shift[12] = { 2, 0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0 };
    folder place = new_folder();
    sketch s = square_sketch();
    add_vectors(&s, time, 2, 1);
    add_vectors(&s, weight, 4, 1);
    add_vectors(&s, lift, 4, 3);
    add_vectors(&s, shift, 4, 3);
    rsv_animation *a = open_sketch(*state, &place, &s,
        ONE_CHANNEL("weights", "") "\"meshes\":[{\"primitives\":[{" SQUARE
                                   ",\"targets\":[{\"POSITION\":4},{\"POSITION\":5}]}]}],"
                                   "\"nodes\":[{\"mesh\":0},{\"mesh\":0}]");
    for (int k = 0; k <= 4; k++) {
        float t = 0.25f * (float)k;
        assert_near(corner_at(a, 0, (double)t, 0), v3(2 - 4 * t, 0, t), (double)t);
    }
    rsv_scene *scene = scene_at(a, 0, 1);
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_near(view->position[view->triangle[2][0]], v3(0, 0, 0), 1); // the other node does not
    rsv_scene_destroy(scene);
    rsv_animation_destroy(a);
    remove_folder(place.path);
}

#define LAMP                                                                                       \
    "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"spot\",\"intensity\":3}]}},"
#define LENS "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1}}],"

/// They are attached to nodes and move with them, also below a node that moves.
static void lights_and_cameras_move(void **state)
{
    const float time[2] = { 0, 1 }, go[6] = { 0, 0, 0, 4, 8, 0 };
    const float turn[8] = { 0, 0, 0, 1, 0, 1, 0, 0 };
    folder place = new_folder();
    sketch s = square_sketch();
    add_vectors(&s, time, 2, 1);
    add_vectors(&s, go, 2, 3);
    add_vectors(&s, turn, 2, 4);
    rsv_animation *a = open_sketch(*state, &place, &s,
        "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":1,\"path\":"
        "\"translation\"}},{\"sampler\":1,\"target\":{\"node\":2,\"path\":\"rotation\"}}],"
        "\"samplers\":[{\"input\":2,\"output\":3},{\"input\":2,\"output\":4}]}]," LAMP LENS SQUARES
        "\"nodes\":[{\"mesh\":0,\"children\":[]},{\"children\":[2,3]},{\"extensions\":{\"KHR_"
        "lights_"
        "punctual\":{\"light\":0}}},{\"camera\":0,\"translation\":[0,0,1]}]");
    rsv_scene *scene = scene_at(a, 0, 0.5);
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_near(view->light[0].position, v3(2, 4, 0), 0.5);
    assert_near(view->light[0].direction, v3(-1, 0, 0), 0.5); // -z, a quarter turn about y
    assert_near(view->camera[0].position, v3(2, 4, 1), 0.5);
    rsv_scene_destroy(scene);
    rsv_animation_destroy(a);
    remove_folder(place.path);
}

/// Keys that bring a square 2 m along x within a second.
static sketch going_sketch(void)
{
    const float time[2] = { 0, 1 }, go[6] = { 0, 0, 0, 2, 0, 0 };
    sketch s = square_sketch();
    add_vectors(&s, time, 2, 1);
    add_vectors(&s, go, 2, 3);
    return s;
}

/// Units of light and sides are understood as rsv_scene_load_with does; what is wanted once is kept.
static void moments_are_read_as_the_file_is(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    sketch s = going_sketch();
    const char *path = write_sketch(&place, &s,
        ONE_CHANNEL("translation", "") LAMP
        "\"materials\":[{\"emissiveFactor\":[1,0.5,0]}],\"meshes\":[{\"primitives\":[{" SQUARE
        ",\"material\":0}]}],\"nodes\":[{\"mesh\":0},{\"extensions\":{\"KHR_lights_punctual\":{"
        "\"light\":0}}}]");
    rsv_load_desc desc = rsv_default_load_desc();
    desc.light_units = RSV_LIGHT_UNITS_PHOTOMETRIC;
    desc.emit_both = true;
    rsv_scene *loaded = NULL;
    rsv_animation *a = NULL;
    assert_int_equal(rsv_scene_load_with(f->context, path, &desc, &loaded), RSV_OK);
    assert_int_equal(rsv_animation_open(f->context, path, &desc, &a), RSV_OK);
    rsv_scene *moment = scene_at(a, 0, 0);
    const rsv_scene_view *v = rsv_scene_get_view(loaded), *w = rsv_scene_get_view(moment);
    assert_true(v->light[0].intensity.r < 1); // by candelas; 3 W/sr otherwise
    assert_memory_equal(&v->light[0].intensity, &w->light[0].intensity, sizeof(rsv_rgb));
    assert_memory_equal(&v->material[0].emission, &w->material[0].emission, sizeof(rsv_rgb));
    assert_true(w->material[0].double_sided);
    rsv_scene_destroy(moment);
    rsv_scene_destroy(loaded);
    rsv_animation_destroy(a);
    remove_folder(place.path);
}

/// From the document that a scene keeps: lights and materials are those of the scene, transforms those of the document.
static void kept_documents_are_played(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    sketch s = going_sketch();
    const char *path = write_sketch(&place, &s,
        ONE_CHANNEL("translation", "") LAMP
        "\"materials\":[{\"emissiveFactor\":[1,0.5,0]}],\"meshes\":[{\"primitives\":[{" SQUARE
        ",\"material\":0}]}],\"nodes\":[{\"mesh\":0},{\"extensions\":{\"KHR_lights_punctual\":{"
        "\"light\":0}}}]");
    rsv_load_desc desc = rsv_default_load_desc();
    desc.light_units = RSV_LIGHT_UNITS_PHOTOMETRIC;
    desc.emit_both = true;
    rsv_scene *loaded = NULL, *edited = NULL;
    rsv_animation *a = NULL, *same = NULL;
    assert_int_equal(rsv_scene_load_with(f->context, path, &desc, &loaded), RSV_OK);
    assert_int_equal(rsv_animation_open(f->context, path, &desc, &same), RSV_OK);
    remove_folder(place.path); // what is kept is all there is
    if (rsv_animation_open_document(loaded, &a) != RSV_OK) fail_msg("%s", rsv_last_error());
    for (double t = 0; t <= 1; t += 0.5)
        assert_near(corner_at(a, 0, t, 1), corner_at(same, 0, t, 1), t);
    rsv_scene *moment = scene_at(a, 0, 0.5);
    const rsv_scene_view *v = rsv_scene_get_view(loaded), *w = rsv_scene_get_view(moment);
    assert_memory_equal(&v->light[0].intensity, &w->light[0].intensity, sizeof(rsv_rgb));
    assert_true(w->material[0].double_sided);
    rsv_scene_destroy(moment);
    rsv_animation_destroy(a);

    // a scene that has been moved away from its document, or keeps none
    const rsv_motion motion = { .object = 0,
        .matrix = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 1 } };
    assert_int_equal(rsv_scene_move(loaded, &motion, 1, &edited), RSV_OK);
    assert_int_equal(rsv_animation_open_document(edited, &a), RSV_ERROR_UNSUPPORTED);
    assert_non_null(strstr(rsv_last_error(), "do not fit"));
    rsv_scene_destroy(edited);
    rsv_scene_drop_document(loaded);
    assert_int_equal(rsv_animation_open_document(loaded, &a), RSV_ERROR_UNSUPPORTED);
    assert_non_null(strstr(rsv_last_error(), "keeps no glTF file"));
    rsv_animation_destroy(same);
    rsv_scene_destroy(loaded);
}

// ---- clips ----------------------------------------------------------------------------------------

static const char two_clips[] =
    "\"animations\":[{\"name\":\"right\",\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,"
    "\"path\":\"translation\"}}],\"samplers\":[{\"input\":2,\"output\":3}]},{\"name\":\"wide\","
    "\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"scale\"}}],\"samplers\":[{"
    "\"input\":2,\"output\":3}]}]," ONE_NODE;

static void clips_are_found_by_name_and_play_together(void **state)
{
    const float time[2] = { 0.5f, 1.5f }, go[6] = { 1, 1, 1, 3, 1, 1 };
    folder place = new_folder();
    sketch s = square_sketch();
    add_vectors(&s, time, 2, 1);
    add_vectors(&s, go, 2, 3);
    rsv_animation *a = open_sketch(*state, &place, &s, two_clips);
    assert_int_equal(rsv_animation_clip_count(a), 2);
    assert_int_equal(rsv_animation_find_clip(a, "wide"), 1);
    assert_int_equal(rsv_animation_find_clip(a, "left"), RSV_NONE);
    assert_true(rsv_animation_clip(a, 1)->start == 0.5 && rsv_animation_clip(a, 1)->end == 1.5);
    assert_near(corner_at(a, 0, 1, 1), v3(3, 1, 1), 1);
    assert_near(corner_at(a, 1, 1, 1), v3(2, 0, 0), 1);
    assert_near(corner_at(a, RSV_NONE, 1, 1), v3(4, 1, 1), 1);
    rsv_scene *scene = NULL;
    assert_int_equal(rsv_animation_scene(a, 2, 0, &scene), RSV_ERROR_ARGUMENT);
    assert_int_equal(rsv_animation_scene(a, 0, (double)NAN, &scene), RSV_ERROR_ARGUMENT);
    rsv_animation_destroy(a);
    remove_folder(place.path);
}

/// Parts that nothing moves are bit for bit the same as in the file at rest. The view of a scene without a camera does
/// not change.
static void what_rests_is_as_in_the_file(void **state)
{
    const float time[2] = { 0, 1 }, go[6] = { 0, 0, 0, 2, 0, 0 };
    folder place = new_folder();
    fixture *f = *state;
    sketch s = square_sketch();
    add_vectors(&s, time, 2, 1);
    add_vectors(&s, go, 2, 3);
    rsv_animation *a = open_sketch(f, &place, &s,
        ONE_CHANNEL("translation", "") SQUARES
        "\"materials\":[{\"name\":\"m\"}],\"nodes\":[{\"mesh\":0},{\"mesh\":0,\"translation\":[0.3,"
        "7,0],\"rotation\":[0.1,0.2,0.3,0.9]}]");
    rsv_scene *rest = load(f, path_in(&place, "shape.gltf"));
    rsv_scene *start = scene_at(a, 0, 0), *later = scene_at(a, 0, 1);
    const rsv_scene_view *r = rsv_scene_get_view(rest), *v = rsv_scene_get_view(start);
    const rsv_scene_view *w = rsv_scene_get_view(later);
    assert_int_equal(v->vertex_count, r->vertex_count);
    assert_int_equal(v->material_count, r->material_count);
    assert_memory_equal(v->position, r->position, r->vertex_count * sizeof *r->position);
    assert_memory_equal(v->normal, r->normal, r->vertex_count * sizeof *r->normal);
    assert_memory_equal(w->position + 6, r->position + 6, 6 * sizeof *r->position);
    assert_memory_equal(&w->camera[0].position, &r->camera[0].position, sizeof(rsv_vec3));
    assert_string_equal(w->camera[0].name, "framing");
    assert_int_equal(count_mentions(f->log, "'framing' is chosen"), 2); // by load, and at rest
    rsv_scene_destroy(later);
    rsv_scene_destroy(start);
    rsv_scene_destroy(rest);
    rsv_animation_destroy(a);
    remove_folder(place.path);
}

// ---- what is wrong --------------------------------------------------------------------------------

typedef struct bad_case {
    float time[3], go[9];
    const char *animation, *message;
} bad_case;

#define CLIP(channel, sampler)                                                                     \
    "\"animations\":[{\"name\":\"go\",\"channels\":[{" channel "}],\"samplers\":[{" sampler "}]}]" \
    ","
#define CHANNEL "\"sampler\":0,\"target\":{\"node\":0,\"path\":\"translation\"}"

static void broken_animations_are_refused(void **state)
{
    static const bad_case cases[] = {
        { { 0, 2, 1 }, { 0 }, CLIP(CHANNEL, "\"input\":2,\"output\":3"), "key 2 is at 1 s, after" },
        { { 0, NAN, 1 }, { 0 }, CLIP(CHANNEL, "\"input\":2,\"output\":3"),
            "animation 'go': accessor 2 holds a number that is not finite" },
        { { 0, 1, 2 }, { 0, INFINITY }, CLIP(CHANNEL, "\"input\":2,\"output\":3"),
            "animation 'go': accessor 3 holds a number that is not finite" },
        { { 0, 1, 2 }, { 0 }, CLIP(CHANNEL, "\"input\":2,\"output\":0"),
            "sampler 0 has 4 values where its 3 keys need 3" },
        { { 0, 1, 2 }, { 0 },
            CLIP(CHANNEL, "\"input\":2,\"output\":3,\"interpolation\":\"CUBICSPLINE\""),
            "sampler 0 has 3 values where its 3 keys need 9" },
        { { 0, 1, 2 }, { 0 }, CLIP(CHANNEL, "\"input\":2,\"output\":3,\"interpolation\":\"BENT\""),
            "is not LINEAR" },
        { { 0, 1, 2 }, { 0 }, CLIP(CHANNEL, "\"input\":9,\"output\":3"), "accessor 9 does not" },
        { { 0, 1, 2 }, { 0 }, CLIP(CHANNEL, "\"input\":3,\"output\":3"),
            "accessor 3 must hold SCALAR" },
        { { 0, 1, 2 }, { 0 }, CLIP("\"sampler\":4,\"target\":{\"node\":0,\"path\":\"scale\"}", ""),
            "sampler 4 does not exist" },
        { { 0, 1, 2 }, { 0 },
            CLIP("\"sampler\":0,\"target\":{\"node\":7,\"path\":\"scale\"}",
                "\"input\":2,\"output\":3"),
            "node 7 does not exist" },
        { { 0, 1, 2 }, { 0 },
            CLIP("\"sampler\":0,\"target\":{\"node\":0,\"path\":\"rotation\"}",
                "\"input\":2,\"output\":3"),
            "accessor 3 must hold VEC4" },
    };
    folder place = new_folder();
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char rest[2048];
        rsv_animation *a = NULL;
        fixture *f = *state;
        sketch s = square_sketch();
        add_vectors(&s, cases[k].time, 3, 1);
        add_vectors(&s, cases[k].go, 3, 3);
        snprintf(rest, sizeof rest, "%s" ONE_NODE, cases[k].animation);
        const char *path = write_sketch(&place, &s, rest);
        assert_int_equal(rsv_animation_open(f->context, path, NULL, &a), RSV_ERROR_FORMAT);
        assert_null(a);
        assert_mentions(rsv_last_error(), path);
        assert_mentions(rsv_last_error(), cases[k].message);
        rsv_scene_destroy(load(f, path)); // at rest, nothing is wrong with it
    }
    remove_folder(place.path);
}

static void what_is_not_played_is_named(void **state)
{
    static const struct {
        const char *channel, *node, *message;
    } cases[] = {
        { CHANNEL, "\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],",
            "(first: of node 'n') would move nodes that have a matrix" },
        { CHANNEL "},{" CHANNEL, "", "move something that another channel already moves" },
        { "\"sampler\":0,\"target\":{\"node\":0,\"path\":\"weights\"}", "",
            "have weights without morph targets" },
        { "\"sampler\":0,\"target\":{\"path\":\"pointer\",\"extensions\":{\"KHR_animation_"
          "pointer\":"
          "{\"pointer\":\"/nodes/0/scale\"}}}",
            "", "(KHR_animation_pointer?), and is not played" },
    };
    const float time[2] = { 0, 1 }, go[6] = { 0, 0, 0, 2, 0, 0 };
    folder place = new_folder();
    fixture *f = *state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char rest[2048];
        sketch s = square_sketch();
        add_vectors(&s, time, 2, 1);
        add_vectors(&s, go, 2, 3);
        snprintf(rest, sizeof rest,
            "\"animations\":[{\"channels\":[{%s}],\"samplers\":[{\"input\":2,\"output\":3}]}]"
            "," SQUARES "\"nodes\":[{%s\"name\":\"n\",\"mesh\":0}]",
            cases[k].channel, cases[k].node);
        f->log[0] = '\0';
        rsv_animation *a = open_sketch(f, &place, &s, rest);
        assert_mentions(f->log, cases[k].message);
        rsv_scene_destroy(scene_at(a, 0, 0.5));
        rsv_animation_destroy(a);
    }
    remove_folder(place.path);
}

/// A jump where two keys have the same time, a single key, and a rotation of length zero.
static void odd_keys_are_played(void **state)
{
    const float time[3] = { 0, 1, 1 }, go[9] = { 0, 0, 0, 2, 0, 0, 5, 0, 0 };
    folder place = new_folder();
    sketch s = square_sketch();
    add_vectors(&s, time, 3, 1);
    add_vectors(&s, go, 3, 3);
    rsv_animation *a = open_sketch(*state, &place, &s, ONE_CHANNEL("translation", "") ONE_NODE);
    assert_near(corner_at(a, 0, 0.75, 0), v3(1.5f, 0, 0), 0.75);
    assert_near(corner_at(a, 0, 1, 0), v3(5, 0, 0), 1);
    rsv_animation_destroy(a);
    const float once = 3, zero[4] = { 0 };
    sketch t = square_sketch();
    add_vectors(&t, &once, 1, 1);
    add_vectors(&t, zero, 1, 4);
    a = open_sketch(*state, &place, &t, ONE_CHANNEL("rotation", "") ONE_NODE);
    rsv_scene *scene = NULL;
    assert_int_equal(rsv_animation_scene(a, 0, 1, &scene), RSV_ERROR_FORMAT);
    assert_mentions(rsv_last_error(), "at 1 s the rotation of node 'node 0' is zero");
    rsv_animation_destroy(a);
    remove_folder(place.path);
}

static void memory_may_run_out(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    sketch s = going_sketch();
    const char *path = write_sketch(&place, &s, ONE_CHANNEL("translation", "") ONE_NODE);
    rsv_status status = RSV_ERROR_MEMORY;
    size_t alive = f->allocations_alive, k;
    for (k = 0; status != RSV_OK; k++) {
        rsv_animation *a = NULL;
        rsv_scene *scene = NULL;
        f->allocations_left = k;
        f->fails_once = true;
        status = rsv_animation_open(f->context, path, NULL, &a);
        if (status == RSV_OK) status = rsv_animation_scene(a, 0, 0.5, &scene);
        bool failed = !f->fails_once;
        f->fails_once = false;
        f->allocations_left = SIZE_MAX;
        assert_int_equal(status, failed ? RSV_ERROR_MEMORY : RSV_OK);
        rsv_scene_destroy(scene);
        rsv_animation_destroy(a);
        assert_int_equal(f->allocations_alive, alive);
    }
    assert_in_range(k, 20, 500);
    remove_folder(place.path);
}

// ---- a walking figure -----------------------------------------------------------------------------

static void assert_walks(rsv_animation *a, const rsv_clip *clip, double t)
{
    rsv_scene *scene = scene_at(a, 0, clip->start + t);
    const rsv_scene_view *v = rsv_scene_get_view(scene);
    assert_int_equal(v->triangle_count, 13676);
    assert_true(v->bounds_max.y > 1.6f && v->bounds_max.y < 1.95f);
    assert_true(v->bounds_min.y > -0.1f && v->bounds_min.y < 0.1f);
    rsv_scene_destroy(scene);
}

/// As tall as specified, with its feet on the floor; at the end it is back at the start.
static void a_figure_walks(void **state)
{
    const char *assets = getenv("RSV_ASSETS");
    char path[1024];
    fixture *f = *state;
    snprintf(path, sizeof path, "%s/animated/walker.glb", assets ? assets : "");
    if (!assets || access(path, R_OK) != 0) {
        print_message("skipped: no animated/walker.glb in RSV_ASSETS\n");
        skip();
    }
    rsv_animation *a = NULL;
    if (rsv_animation_open(f->context, path, NULL, &a) != RSV_OK) fail_msg("%s", rsv_last_error());
    const rsv_clip *clip = rsv_animation_clip(a, 0);
    assert_int_equal(rsv_animation_clip_count(a), 1);
    assert_string_equal(clip->name, "walk");
    assert_true(fabs(clip->end - clip->start - 32.0 / 24) < 1e-6);
    for (int k = 0; k < 4; k++)
        assert_walks(a, clip, k * (8.0 / 24) + 0.01);
    rsv_scene *first = scene_at(a, 0, clip->start), *last = scene_at(a, 0, clip->end);
    const rsv_scene_view *v = rsv_scene_get_view(first), *w = rsv_scene_get_view(last);
    float apart = 0;
    for (size_t k = 0; k < v->vertex_count && v->vertex_count == w->vertex_count; k++)
        apart = fmaxf(apart, v3_max_abs(v3_sub(v->position[k], w->position[k])));
    assert_int_equal(v->vertex_count, w->vertex_count);
    if (!(apart < 2e-3f)) fail_msg("the loop ends %g m from where it began", (double)apart);
    rsv_scene_destroy(first);
    rsv_scene_destroy(last);
    rsv_animation_destroy(a);
}

#define CASE(name) cmocka_unit_test_setup_teardown(name, fixture_setup, fixture_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        CASE(rotations_go_along_the_arc),
        CASE(steps_hold_their_value),
        CASE(cubic_splines_meet_a_cubic),
        CASE(normalized_and_sparse_keys_are_read),
        CASE(joints_bend_what_is_bound),
        CASE(weights_of_morph_targets_move),
        CASE(lights_and_cameras_move),
        CASE(moments_are_read_as_the_file_is),
        CASE(kept_documents_are_played),
        CASE(clips_are_found_by_name_and_play_together),
        CASE(what_rests_is_as_in_the_file),
        CASE(broken_animations_are_refused),
        CASE(what_is_not_played_is_named),
        CASE(odd_keys_are_played),
        CASE(memory_may_run_out),
        CASE(a_figure_walks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
