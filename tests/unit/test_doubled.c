/// Coincident faces: a room whose walls are written twice equals the room.
#include "bvh/bvh_trace.h"
#include "copies_fixture.h"
#include "core/sampling.h"
#include "frame_fixture.h"
#include "resolvent/certify.h"
#include "trace/packet.h"

#include <stdio.h>

// ---- rays ---------------------------------------------------------------------------------------

static rsv_ray random_ray(uint32_t k, bool outside)
{
    float x[5];
    for (uint32_t d = 0; d < 5; d++)
        x[d] = rsv_unit_float(rsv_hash2(7 + d, k));
    rsv_vec3 inside = v3(0.2f + 3.6f * x[0], 0.1f + 0.3f * x[1], 2 + 2.8f * x[2]);
    rsv_vec3 direction = rsv_square_to_sphere(x[3], x[4]);
    if (!outside) return (rsv_ray){ inside, direction, INFINITY };
    return (rsv_ray){ v3_mad(inside, 20, direction), v3_neg(direction), INFINITY };
}

static bool meets_front(const rsv_scene_view *view, const rsv_ray *ray, uint32_t triangle)
{
    return v3_dot(rsv_twin_plane_of(view, triangle).normal, ray->direction) < 0;
}

/// Hits in a room of copied walls, and in the plain one. From outside, rays hit the copies.
static void check_rays(copies kind, const world *plain, const world *w, bool outside)
{
    const rsv_scene_view *view = rsv_scene_get_view(w->scene);
    rsv_bvh bvh;
    assert_int_equal(rsv_bvh_build_scene(w->scene, &bvh), RSV_OK);
    for (uint32_t first = 0; first < 4096; first += 16) {
        rsv_ray_packet packet = { 0 };
        memset(packet.mask, 0xff, sizeof packet.mask);
        for (uint32_t k = 0; k < 16; k++)
            rsv_packet_set_ray(&packet, k, random_ray(first + k, outside));
        rsv_tracer_closest_packet(w->tracer, &packet, false);
        for (uint32_t k = 0; k < 16; k++) {
            rsv_ray ray = random_ray(first + k, outside);
            rsv_hit hit, expected, other;
            assert_true(rsv_tracer_closest(plain->tracer, &ray, &expected));
            assert_true(rsv_tracer_closest(w->tracer, &ray, &hit));
            assert_true(rsv_bvh_closest(&bvh.view, &ray, &other));
            assert_close(hit.t, expected.t, 3e-6 * SIDE_Z * 20);
            if (!meets_front(view, &ray, hit.triangle))
                fail_msg("%s: ray %u meets a back", name_of_copies(kind), first + k);
            rsv_rgb seen = view->material[view->triangle_material[hit.triangle]].base_color;
            const rsv_scene_view *of = rsv_scene_get_view(plain->scene);
            rsv_rgb wanted = of->material[of->triangle_material[expected.triangle]].base_color;
            if (kind == COLORED && outside) wanted = rgb(0.05f, 0.06f, 0.8f);
            // from below, the crate's bottom is as good as the floor's copy
            if (!outside || ray.direction.y <= 0) assert_memory_equal(&seen, &wanted, sizeof seen);
            assert_int_equal(packet.triangle[k], hit.triangle);
            assert_true(packet.normal_x[k] * ray.direction.x +
                            packet.normal_y[k] * ray.direction.y +
                            packet.normal_z[k] * ray.direction.z <
                        0);
            // neighbours may tie at an edge
            if (other.triangle != hit.triangle)
                assert_true(meets_front(view, &ray, other.triangle));
        }
    }
    rsv_bvh_destroy(&bvh);
}

/// A place on a triangle, some at its very edge, and a direction.
static rsv_hit random_place(uint32_t k, uint32_t triangle, rsv_vec3 *direction)
{
    float x[4];
    for (uint32_t d = 0; d < 4; d++)
        x[d] = rsv_unit_float(rsv_hash2(31 + d, k));
    if (x[0] + x[1] > 1) x[0] = 1 - x[0], x[1] = 1 - x[1];
    *direction = rsv_square_to_sphere(x[2], x[3]);
    return (rsv_hit){ triangle, 1, x[0], k % 8 ? x[1] : 1 - x[0] };
}

/// The copies that are listed for a face are those that a search finds.
static void lists_the_copies_of_faces(void **state)
{
    (void)state;
    for (copies kind = AFTER; kind < KINDS; kind++) {
        world *w = create_copied_room(NULL, kind);
        const rsv_scene_view *view = rsv_scene_get_view(w->scene);
        rsv_scene_view searched = *view;
        rsv_twins twins = *view->twins;
        uint32_t known = 0, count = (uint32_t)view->triangle_count;
        twins.first_rival = twins.rival = NULL;
        searched.twins = &twins;
        for (uint32_t k = 0; k < 64 * count; k++) {
            rsv_vec3 direction;
            rsv_hit hit = random_place(k, k % count, &direction), expected = hit;
            if (!twins.flags[hit.triangle]) continue;
            bool opposite = rsv_twins_search(&searched, direction, &expected);
            assert_int_equal(rsv_twins_search(view, direction, &hit), opposite);
            assert_memory_equal(&hit, &expected, sizeof hit);
        }
        for (uint32_t t = 0; t < count; t++)
            known += view->twins->first_rival[t + 1] > view->twins->first_rival[t] &&
                     view->twins->rival[view->twins->first_rival[t]] != RSV_NONE;
        assert_true(known > 0);
        world_end(w);
    }
}

/// Packets whose rays all hit few triangles find the same hits as single rays.
static void packets_see_what_single_rays_see(void **state)
{
    (void)state;
    for (copies kind = AFTER; kind < KINDS; kind++) {
        world *w = create_copied_room(NULL, kind);
        for (uint32_t first = 0; first < 4096; first += 16) {
            rsv_ray_packet packet = { 0 };
            rsv_ray ray[16], lead = random_ray(first, false);
            memset(packet.mask, 0xff, sizeof packet.mask);
            for (uint32_t k = 0; k < 16; k++) {
                ray[k] = lead;
                ray[k].direction = v3_normalize(
                    v3_mad(lead.direction, 0.1f, random_ray(first + k, false).direction));
                rsv_packet_set_ray(&packet, k, ray[k]);
            }
            rsv_tracer_closest_packet(w->tracer, &packet, true);
            for (uint32_t k = 0; k < 16; k++) {
                rsv_hit hit;
                assert_true(rsv_tracer_closest(w->tracer, &ray[k], &hit));
                assert_int_equal(packet.triangle[k], hit.triangle);
                assert_close(packet.u[k], hit.u, 1e-4);
                assert_close(packet.v[k], hit.v, 1e-4);
            }
        }
        world_end(w);
    }
}

static void shows_the_side_that_faces_the_ray(void **state)
{
    (void)state;
    world *plain = create_copied_room(NULL, SINGLE);
    for (copies kind = AFTER; kind < KINDS; kind++) {
        world *w = create_copied_room(NULL, kind);
        check_rays(kind, plain, w, false);
        if (kind != SAME_WAY) check_rays(kind, plain, w, true);
        world_end(w);
    }
    world_end(plain);
}

// ---- light --------------------------------------------------------------------------------------

enum { pictures = 4 };

/// What all modes show of a scene.
typedef struct readings {
    rsv_image *image[pictures]; ///< reference, operator, final, occlusion
    double frame;               ///< mean
    double probe[3];
    double certificate[2]; ///< where the residual lies by 95 %
} readings;

static rsv_image *render_mode(const world *w, const rsv_light *s, rsv_render_mode mode)
{
    rsv_render_desc desc = rsv_default_render_desc();
    rsv_image *image;
    desc.mode = mode;
    desc.width = width;
    desc.height = height;
    desc.samples = mode == RSV_RENDER_REFERENCE ? UNLESS_SANITIZED(4, 1) : 1;
    rsv_status status =
        mode == RSV_RENDER_REFERENCE   ? rsv_render_reference(w->scene, &desc, &image, NULL)
        : mode == RSV_RENDER_OCCLUSION ? rsv_render_occlusion(w->scene, &desc, &image)
                                       : rsv_render(s, &desc, &image);
    assert_int_equal(status, RSV_OK);
    return image;
}

static double frame_mean(const world *w, const rsv_light *s)
{
    static rsv_rgb shown[pixel_count];
    rsv_frame_desc desc = frame_desc();
    rsv_frame_renderer *renderer;
    assert_int_equal(rsv_frame_renderer_create(s, &desc, &renderer), RSV_OK);
    rsv_frame_view view = view_of(w);
    double sum = 0;
    for (int k = 0; k < 4; k++)
        assert_int_equal(rsv_frame_render(renderer, &view, NULL), RSV_OK);
    rsv_frame_radiance(renderer, 0, shown);
    for (size_t k = 0; k < pixel_count; k++)
        sum += (double)rgb_luminance(shown[k]) / pixel_count;
    rsv_frame_renderer_destroy(renderer);
    return sum;
}

static readings read_all(const world *w)
{
    static const rsv_render_mode mode[pictures] = { RSV_RENDER_REFERENCE, RSV_RENDER_OPERATOR,
        RSV_RENDER_FINAL, RSV_RENDER_OCCLUSION };
    readings r;
    rsv_light *s = solve_for_frames(w, 1500, 1000);
    for (int k = 0; k < pictures; k++)
        r.image[k] = render_mode(w, s, mode[k]);
    r.frame = frame_mean(w, s);
    const rsv_probe probe = { { 2.5f, 0, 2.5f }, { 0, 1, 0 } };
    for (int k = 0; k < 3; k++) {
        rsv_probe_reading reading;
        assert_int_equal(
            rsv_probe_irradiance(s,
                &(rsv_probe_desc){ sizeof(rsv_probe_desc), (rsv_probe_mode)k, 1024, 0 }, &probe, 1,
                &reading),
            RSV_OK);
        r.probe[k] = (double)rgb_luminance(reading.irradiance);
    }
    rsv_certify_desc certify = rsv_default_certify_desc();
    rsv_certificate certificate;
    certify.samples = 4096; // most of the residual is in few of them, behind the mirror
    certify.gather_rays = 32;
    assert_int_equal(rsv_certify(s, &certify, &certificate), RSV_OK);
    r.certificate[0] = certificate.residual_ci95[0];
    r.certificate[1] = certificate.residual_ci95[1];
    rsv_light_destroy(s);
    return r;
}

static void readings_release(readings *r)
{
    for (int k = 0; k < pictures; k++)
        rsv_image_destroy(r->image[k]);
}

static double mean_of(const rsv_image *image)
{
    double sum = 0;
    for (size_t k = 0; k < pixel_count; k++)
        sum += (double)rgb_luminance(rsv_image_const_pixels(image, 0)[k]) / pixel_count;
    return sum;
}

/// RMS difference of pixels, over their mean.
static double difference(const rsv_image *a, const rsv_image *b)
{
    double sum = 0;
    for (size_t k = 0; k < pixel_count; k++) {
        double d = (double)rgb_luminance(rsv_image_const_pixels(a, 0)[k]) -
                   (double)rgb_luminance(rsv_image_const_pixels(b, 0)[k]);
        sum += d * d / pixel_count;
    }
    return sqrt(sum) / mean_of(b);
}

static void check_ratio(copies kind, double ratio, double expected)
{
    if (!(fabs(ratio / expected - 1) < 0.01))
        fail_msg("%s: modes differ by %.4f, not by %.4f", name_of_copies(kind), ratio, expected);
}

/// Elements lie elsewhere where walls are copied: pixels differ by what draft quality leaves, the path tracer's by rounding.
static void check_light(copies kind, const readings *plain, const readings *r)
{
    static const double most[pictures] = { 5e-3, 0.04, 0.04, 5e-3 };
    for (int k = 0; k < pictures; k++) {
        double d = difference(r->image[k], plain->image[k]);
        if (!(d < most[k])) fail_msg("%s: picture %d differs by %.4f", name_of_copies(kind), k, d);
        assert_close(mean_of(r->image[k]) / mean_of(plain->image[k]), 1, 0.01);
    }
    // the modes agree with one another as in the plain room, except for the effect of different elements
    for (int k = 1; k < 3; k++)
        check_ratio(kind, mean_of(r->image[k]) / mean_of(r->image[0]),
            mean_of(plain->image[k]) / mean_of(plain->image[0]));
    check_ratio(kind, r->frame / mean_of(r->image[1]), plain->frame / mean_of(plain->image[1]));
    for (int k = 0; k < 3; k++)
        assert_close(r->probe[k] / plain->probe[k], 1, k == 0 ? 0.03 : 0.01);
    // copies that are lit as well take half of the elements: what is left is coarser
    bool shares = kind == SAME_WAY || kind == TWO_SIDED;
    if (!shares && !(r->certificate[0] < plain->certificate[1]))
        fail_msg("%s: residual %.4f", name_of_copies(kind), r->certificate[0]);
}

static void check_kinds(const copies *kinds, size_t count)
{
    world *w = create_copied_room(NULL, SINGLE);
    readings plain = read_all(w);
    for (size_t k = 0; k < count; k++) {
        world *copied = create_copied_room(NULL, kinds[k]);
        readings r = read_all(copied);
        check_light(kinds[k], &plain, &r);
        readings_release(&r);
        world_end(copied);
    }
    readings_release(&plain);
    world_end(w);
}

static void light_is_that_of_single_walls(void **state)
{
    (void)state;
    static const copies kinds[] = { MIXED, INSIDE };
    check_kinds(kinds, UNLESS_SANITIZED(2, 1));
}

static void light_is_that_of_single_walls_however_copied(void **state)
{
    (void)state;
    static const copies kinds[] = { TWO_SIDED, SAME_WAY, AFTER, BEFORE, COLORED, OUTSIDE, THREEFOLD,
        DIAGONAL, FINE, FINER, SHARED };
    check_kinds(kinds, sizeof kinds / sizeof kinds[0]);
}

// ---- lamps --------------------------------------------------------------------------------------

static world *create_lamps(int count, bool double_sided)
{
    world *w = world_begin(2);
    world_room(w, world_lambert(w, 0.5f, 0), v3(-1, -1, -1), v3(1, 1, 1));
    rsv_material lamp = lambert_material(0, 5);
    lamp.double_sided = double_sided;
    for (int k = 0; k < count; k++) {
        wall_mesh s;
        make_sheet(
            &(plain_wall){ { -0.2f, 0.5f, -0.2f }, { { 0.4f, 0, 0 }, { 0, 0, 0.4f } } }, 1, 0, &s);
        if (double_sided && k % 2) turn_over(&s);
        add_sheet(w, world_material(w, lamp), &s);
    }
    world_commit(w);
    return w;
}

static double power_of(const world *w)
{
    double power = 0;
    for (size_t g = 0; g < w->lights->group_count; g++)
        power += w->lights->group[g].power;
    return power;
}

static void copies_of_a_lamp_give_no_light_of_their_own(void **state)
{
    (void)state;
    for (int two = 0; two < 2; two++) {
        world *one = create_lamps(1, two), *three = create_lamps(3, two);
        assert_close(power_of(three) / power_of(one), 1, 1e-6);
        world_end(one);
        world_end(three);
    }
}

static rsv_image *trace_paths(const world *w);

static void add_lamp(world *w, uint32_t lamp, float from, float to, float depth)
{
    world_quad(w, lamp, v3(from, 2.8f, 2), v3(to, 2.8f, 2), v3(to, 2.8f, 2 + depth),
        v3(from, 2.8f, 2 + depth));
}

/// The power of all lamps, and the mean of a path-traced picture. Takes the world over.
static void read_light(world *w, const rsv_camera *camera, double *power, double *mean)
{
    assert_int_equal(rsv_scene_add_camera(w->scene, camera), RSV_OK);
    world_commit(w);
    *power = power_of(w);
    rsv_image *image = trace_paths(w);
    *mean = mean_of(image);
    rsv_image_destroy(image);
    world_end(w);
}

/// Lamps that overlap in part shine once where they do.
static void overlapping_lamps_shine_once(void **state)
{
    (void)state;
    double power[4], mean[4];
    for (int kind = 0; kind < 4; kind++) {
        world *w = world_begin(2);
        uint32_t lamp = world_lambert(w, 0, 10);
        world_room(w, world_lambert(w, 0.5f, 0), v3(0, 0, 0), v3(4, 3, 5));
        // the other lamps: side by side, or a single one
        if (kind == 0) add_lamp(w, lamp, 1.5f, 2, 1), add_lamp(w, lamp, 2, 2.75f, 1);
        if (kind == 1) add_lamp(w, lamp, 1.5f, 2.25f, 1), add_lamp(w, lamp, 2, 2.75f, 1);
        if (kind == 2) add_lamp(w, lamp, 1.5f, 2.5f, 1);
        if (kind == 3) add_lamp(w, lamp, 1.5f, 2.5f, 1), add_lamp(w, lamp, 1.8f, 2.2f, 0.4f);
        rsv_camera camera =
            rsv_camera_look_at("inside", v3(2.1f, 1.6f, 4.7f), v3(1.9f, 1, 2), 1.0f, 1.4f);
        read_light(w, &camera, &power[kind], &mean[kind]);
    }
    for (int kind = 1; kind < 4; kind += 2) {
        assert_close(power[kind] / power[kind - 1], 1, 0.02);
        assert_close(mean[kind] / mean[kind - 1], 1, UNLESS_SANITIZED(0.02, 0.1));
    }
}

/// A double-sided lamp with half of its back covered by a black face gives the light of a double-sided lamp next to a
/// single-sided one.
static void backs_of_lamps_shine_where_nothing_covers_them(void **state)
{
    (void)state;
    double power[2], mean[2];
    for (int kind = 0; kind < 2; kind++) {
        world *w = world_begin(2);
        uint32_t black = world_lambert(w, 0, 0);
        rsv_material shining = lambert_material(0, 10);
        shining.double_sided = true;
        uint32_t lamp = world_material(w, shining), one_sided = world_lambert(w, 0, 10);
        world_room(w, world_lambert(w, 0.5f, 0), v3(0, 0, 0), v3(4, 3, 5));
        // fronts look down, and so does the cover's back
        if (kind == 0) add_lamp(w, lamp, 1, 2, 2), add_lamp(w, one_sided, 2, 3, 2);
        if (kind == 1) {
            add_lamp(w, lamp, 1, 3, 2);
            world_quad(w, black, v3(2, 2.8f, 4), v3(3, 2.8f, 4), v3(3, 2.8f, 2), v3(2, 2.8f, 2));
        }
        rsv_camera camera =
            rsv_camera_look_at("above", v3(0.3f, 2.9f, 0.3f), v3(2.5f, 2.95f, 4), 1.0f, 1.4f);
        read_light(w, &camera, &power[kind], &mean[kind]);
    }
    assert_close(power[1] / power[0], 1, 0.02);
    assert_close(mean[1] / mean[0], 1, UNLESS_SANITIZED(0.02, 0.1));
}

/// A lamp in the plane of a ceiling, before or after it in the scene.
static void a_lamp_in_a_ceiling_shines(void **state)
{
    (void)state;
    for (int first = 0; first < 2; first++) {
        world *w = world_begin(2);
        const rsv_vec3 corner[4] = { { -0.2f, 1, -0.2f }, { 0.2f, 1, -0.2f }, { 0.2f, 1, 0.2f },
            { -0.2f, 1, 0.2f } };
        uint32_t lamp = world_lambert(w, 0, 5);
        if (first) world_quad(w, lamp, corner[0], corner[1], corner[2], corner[3]);
        world_room(w, world_lambert(w, 0.5f, 0), v3(-1, -1, -1), v3(1, 1, 1));
        if (!first) world_quad(w, lamp, corner[0], corner[1], corner[2], corner[3]);
        world_commit(w);
        rsv_hit hit;
        rsv_ray up = { v3(0.05f, 0, 0.02f), v3(0.01f, 1, 0), INFINITY };
        assert_true(rsv_tracer_closest(w->tracer, &up, &hit));
        assert_int_equal(rsv_scene_get_view(w->scene)->triangle_material[hit.triangle], lamp);
        assert_int_equal(w->lights->emitter_count, 2);
        world_end(w);
    }
}

// ---- bodies of glass ----------------------------------------------------------------------------

/// How the surface of a body is written twice: its other faces look inwards.
typedef enum shell_copy {
    SHELL_SINGLE,
    SHELL_AFTER,
    SHELL_BEFORE,
    SHELL_SHARED, ///< all in one mesh, now the one face first, now the other
    SHELL_NEAR,   ///< a millionth of the body off
    SHELL_PIECES, ///< each face an object
    SHELLS
} shell_copy;

/// The faces of a cube, each a wall whose front looks out.
static plain_wall cube_face(int k, float size)
{
    rsv_vec3 centre = v3(2, 1, 2.5f);
    plain_wall face = { room_wall[k].corner, { room_wall[k].edge[1], room_wall[k].edge[0] } };
    rsv_vec3 *part[3] = { &face.corner, &face.edge[0], &face.edge[1] };
    for (int i = 0; i < 3; i++)
        *part[i] = v3(part[i]->x / SIDE_X, part[i]->y / SIDE_Y, part[i]->z / SIDE_Z);
    face.corner = v3_mad(centre, size, v3_sub(face.corner, v3(0.5f, 0.5f, 0.5f)));
    face.edge[0] = v3_scale(face.edge[0], size);
    face.edge[1] = v3_scale(face.edge[1], size);
    return face;
}

typedef struct shell {
    rsv_vec3 position[48];
    uint32_t index[72];
    uint32_t vertex_count, triangle_count;
} shell;

static void add_faces(shell *s, const wall_mesh *face)
{
    for (uint32_t k = 0; k < 3 * face->triangle_count; k++)
        s->index[3 * s->triangle_count + k] = s->vertex_count + face->index[k];
    memcpy(&s->position[s->vertex_count], face->position, 4 * sizeof *face->position);
    s->vertex_count += 4;
    s->triangle_count += 2;
}

static void finish_shell(world *w, uint32_t glass, shell *s)
{
    if (s->triangle_count)
        world_triangles(w, glass, s->position, s->vertex_count, s->index, s->triangle_count);
    *s = (shell){ .vertex_count = 0 };
}

static void add_shells(world *w, shell_copy kind, uint32_t glass)
{
    bool separate = kind == SHELL_AFTER || kind == SHELL_BEFORE || kind == SHELL_NEAR;
    shell s = { .vertex_count = 0 };
    wall_mesh face;
    for (int side = 0; side < (kind == SHELL_SINGLE ? 1 : 2); side++) {
        for (int k = 0; k < WALLS; k++) {
            bool turned = side != (kind == SHELL_BEFORE || (!separate && kind && k % 2));
            plain_wall of = cube_face(k, side && kind == SHELL_NEAR ? 1.000002f : 1);
            make_sheet(&of, 1, 0, &face);
            if (turned) turn_over(&face);
            add_faces(&s, &face);
            if (kind == SHELL_PIECES) finish_shell(w, glass, &s);
        }
        if (separate) finish_shell(w, glass, &s);
    }
    finish_shell(w, glass, &s);
}

/// A red cube of glass above the floor, another body around it if wanted.
static world *create_glass(shell_copy kind, bool nested)
{
    world *w = world_begin(2);
    rsv_material glass = glass_material();
    glass.attenuation_distance = 0.5f;
    glass.attenuation_color = rgb(0.9f, 0.5f, 0.3f);
    world_room(w, world_lambert(w, 0.7f, 0), v3(0, 0, 0), v3(4, 3, 5));
    world_quad(w, world_lambert(w, 0, 10), v3(1.5f, 2.8f, 2), v3(2.5f, 2.8f, 2), v3(2.5f, 2.8f, 3),
        v3(1.5f, 2.8f, 3));
    uint32_t material = world_material(w, glass);
    if (nested) world_box(w, material, v3(1.2f, 0.2f, 1.7f), v3(2.8f, 1.8f, 3.3f));
    add_shells(w, kind, material);
    rsv_camera camera =
        rsv_camera_look_at("inside", v3(2.1f, 1.6f, 4.7f), v3(1.9f, 1, 2), 1.0f, 1.4f);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    world_commit(w);
    return w;
}

static rsv_image *trace_paths(const world *w)
{
    rsv_render_desc desc = rsv_default_render_desc();
    rsv_image *image;
    desc.width = width;
    desc.height = height;
    desc.samples = UNLESS_SANITIZED(16, 1);
    assert_int_equal(rsv_render_reference(w->scene, &desc, &image, NULL), RSV_OK);
    return image;
}

/// Glass that is written twice equals the glass: rays that enter hit only outward faces, and so do rays that leave.
static void doubled_bodies_refract_once(void **state)
{
    (void)state;
    for (int nested = 0; nested < 2; nested++) {
        world *plain = create_glass(SHELL_SINGLE, nested);
        rsv_image *expected = trace_paths(plain);
        for (shell_copy kind = SHELL_AFTER; kind < SHELLS; kind++) {
            if (nested && kind == SHELL_PIECES)
                continue; // which of the two a piece is of is not said
            world *w = create_glass(kind, nested);
            rsv_image *image = trace_paths(w);
            double d = difference(image, expected);
            // with two bodies and inexact copies, single paths take other directions: nested ones differ by 2.8 % with
            // 16 samples, 0.35 % with 128, 0.04 % with 1,024, where other random numbers make 57, 21 and 7 %
            double most = nested || kind == SHELL_NEAR ? 0.05 : 1e-3;
            if (!(d < most)) fail_msg("shell %d, nested %d: differs by %.4f", kind, nested, d);
            assert_close(mean_of(image) / mean_of(expected), 1, 2e-3);
            rsv_image_destroy(image);
            world_end(w);
        }
        rsv_image_destroy(expected);
        world_end(plain);
    }
}

// ---- burial -------------------------------------------------------------------------------------

/// Bodies that touch hide from each other what lies inside of them.
static void crates_on_crates_stay_dark_inside(void **state)
{
    (void)state;
    world *w = world_begin(2);
    uint32_t paint = world_lambert(w, 0.7f, 0);
    world_room(w, paint, v3(-2, 0, -2), v3(2, 3, 2));
    world_box(w, paint, v3(-0.5f, 0, -0.5f), v3(0.5f, 1, 0.5f));
    world_box(w, paint, v3(-0.5f, 1, -0.5f), v3(0.5f, 2, 0.5f));
    world_quad(w, world_lambert(w, 0, 10), v3(1, 2.9f, -1), v3(2, 2.9f, -1), v3(2, 2.9f, 1),
        v3(1, 2.9f, 1));
    world_commit(w);
    rsv_light *s = solve_for_frames(w, 2000, 500);
    for (int k = 0; k < 32; k++) {
        // along the foot of the lower crate, on its lit side
        float z = -0.4f + 0.8f * (float)k / 31;
        rsv_probe place = { v3(0.52f, 0, z), v3(0, 1, 0) };
        rsv_probe_reading stored, exact;
        assert_int_equal(rsv_probe_irradiance(s,
                             &(rsv_probe_desc){ sizeof(rsv_probe_desc), RSV_PROBE_LOOKUP, 1, 0 },
                             &place, 1, &stored),
            RSV_OK);
        assert_int_equal(
            rsv_probe_irradiance(s,
                &(rsv_probe_desc){ sizeof(rsv_probe_desc), RSV_PROBE_OPERATOR, 1024, 0 }, &place, 1,
                &exact),
            RSV_OK);
        assert_close(stored.irradiance.g / exact.irradiance.g, 1, 0.25);
    }
    rsv_light_destroy(s);
    world_end(w);
}

/// A sheet that faces down, 3 cm above a floor that is written twice, in a landscape of 20 km: one sees its back from above.
static void landscapes_do_not_blur_what_stands_on_them(void **state)
{
    (void)state;
    world *w = world_begin(1);
    uint32_t soil = world_lambert(w, 0.3f, 0), cloth = world_lambert(w, 0.7f, 0);
    for (int side = 0; side < 2; side++) {
        rsv_vec3 a = v3(-1e4f, 0, -1e4f), b = v3(1e4f, 0, -1e4f), c = v3(1e4f, 0, 1e4f),
                 d = v3(-1e4f, 0, 1e4f);
        world_quad(w, soil, a, side ? d : b, c, side ? b : d);
    }
    world_quad(w, cloth, v3(0, 0.03f, 0), v3(1, 0.03f, 0), v3(1, 0.03f, 1), v3(0, 0.03f, 1));
    world_commit(w);
    const rsv_scene_view *view = rsv_scene_get_view(w->scene);
    for (uint32_t k = 0; k < 64; k++) {
        rsv_hit hit;
        rsv_ray down = { v3(0.07f + 0.013f * (float)k, 2, 0.4f), v3(0, -1, 0), INFINITY };
        assert_true(rsv_tracer_closest(w->tracer, &down, &hit));
        assert_int_equal(view->triangle_material[hit.triangle], cloth);
        assert_close(hit.t, 1.97f, 1e-4);
        rsv_ray beside = { v3(2.07f + 0.013f * (float)k, 2, 0.4f), v3(0, -1, 0), INFINITY };
        assert_true(rsv_tracer_closest(w->tracer, &beside, &hit));
        assert_int_equal(view->triangle_material[hit.triangle], soil);
        assert_true(meets_front(view, &beside, hit.triangle));
    }
    world_end(w);
}

/// A finely divided ball of 10 cm above a landscape. No faces coincide, and the search must find this without comparing
/// every pair of the ball's triangles.
static void small_things_in_large_scenes_have_no_copies(void **state)
{
    (void)state;
    enum { side = 128 };
    world *w = world_begin(1);
    uint32_t soil = world_lambert(w, 0.3f, 0), next = 0;
    world_quad(
        w, soil, v3(-1e3f, 0, -1e3f), v3(-1e3f, 0, 1e3f), v3(1e3f, 0, 1e3f), v3(1e3f, 0, -1e3f));
    rsv_vec3 *p = calloc((side + 1) * (side + 1), sizeof *p);
    uint32_t *index = calloc(6 * side * side, sizeof *index);
    for (uint32_t k = 0; k < (side + 1) * (side + 1); k++) {
        float a = 2 * RSV_PI * (float)(k % (side + 1)) / side;
        float b = 0.1f + 2.9f * (float)(k / (side + 1)) / side;
        p[k] = v3(0.05f * sinf(b) * cosf(a), 1 + 0.05f * cosf(b), 0.05f * sinf(b) * sinf(a));
    }
    for (uint32_t k = 0; k < side * side; k++) {
        uint32_t a = k / side * (side + 1) + k % side, d = a + side + 2;
        const uint32_t corner[6] = { a, a + 1, d, a, d, d - 1 };
        memcpy(&index[next], corner, sizeof corner);
        next += 6;
    }
    world_triangles(w, soil, p, (side + 1) * (side + 1), index, next / 3);
    world_commit(w);
    assert_null(rsv_scene_get_view(w->scene)->twins);
    free(p);
    free(index);
    world_end(w);
}

// ---- many ---------------------------------------------------------------------------------------

/// A hilly field of squares, each written twice, as the squares of a game's blocks.
static void many_copies_are_found_quickly(void **state)
{
    (void)state;
    enum { side = UNLESS_SANITIZED(128, 32) };
    world *w = world_begin(2);
    rsv_vec3 *p = calloc((side + 1) * (side + 1), sizeof *p);
    uint32_t *index = calloc(12 * side * side, sizeof *index), next = 0;
    for (uint32_t k = 0; k < (side + 1) * (side + 1); k++) {
        float x = (float)(k % (side + 1)), z = (float)(k / (side + 1));
        p[k] = v3(x, 3 * sinf(0.1f * x) * cosf(0.07f * z), z);
    }
    for (uint32_t k = 0; k < side * side; k++) {
        uint32_t a = k / side * (side + 1) + k % side, d = a + side + 2;
        const uint32_t corner[12] = { a, d, a + 1, a, d - 1, d, a, a + 1, d, a, d, d - 1 };
        memcpy(&index[next], corner, sizeof corner);
        next += 12;
    }
    world_triangles(w, world_lambert(w, 0.5f, 0), p, (side + 1) * (side + 1), index, next / 3);
    double start = rsv_thread_seconds();
    world_commit(w);
    assert_true(rsv_thread_seconds() - start < UNLESS_SANITIZED(4, 40));
    const rsv_scene_view *view = rsv_scene_get_view(w->scene);
    assert_int_equal(view->twins->face_count, next / 3);
    for (uint32_t k = 0; k < 1000; k++) {
        rsv_hit hit;
        float x = side * rsv_unit_float(rsv_hash2(1, k)),
              z = side * rsv_unit_float(rsv_hash2(2, k));
        rsv_ray down = { v3(x, 50, z), v3(0.01f, -1, 0.02f), INFINITY };
        if (!rsv_tracer_closest(w->tracer, &down, &hit)) continue;
        assert_true(meets_front(view, &down, hit.triangle));
    }
    free(p);
    free(index);
    world_end(w);
}

/// The time for many copies of one triangle must not grow with the square of their number.
static void a_heap_of_copies_takes_no_square(void **state)
{
    (void)state;
    enum { count = UNLESS_SANITIZED(20000, 2000) };
    world *w = world_begin(2);
    static const rsv_vec3 p[3] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } };
    uint32_t *index = calloc(3 * count, sizeof *index);
    for (uint32_t k = 0; k < 3 * count; k++)
        index[k] = k / 3 % 2 ? 2 - k % 3 : k % 3;
    world_triangles(w, world_lambert(w, 0.5f, 0), p, 3, index, count);
    double start = rsv_thread_seconds();
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    assert_true(rsv_thread_seconds() - start < 30);
    free(index);
    world_end(w);
}

// ---- words --------------------------------------------------------------------------------------

static void note(void *user, rsv_log_level level, const char *message)
{
    if (level == RSV_LOG_WARNING) snprintf(user, 1024, "%s", message);
}

/// @param flip whether the second face turns the other way
static void warning_for(bool flip, bool same_material, char *warning)
{
    rsv_context_desc desc = rsv_default_context_desc();
    rsv_context *context;
    rsv_scene *scene;
    *warning = 0;
    desc.log = note;
    desc.user = warning;
    assert_int_equal(rsv_context_create(&desc, &context), RSV_OK);
    assert_int_equal(rsv_scene_create(context, &scene), RSV_OK);
    for (int k = 0; k < 2; k++) {
        wall_mesh s;
        uint32_t paint = 0, mesh;
        rsv_material m = lambert_material(0.5f, 0);
        m.name = k ? "wallpaper" : "plaster";
        if (k == 0 || !same_material)
            assert_int_equal(rsv_scene_add_material(scene, &m, &paint), RSV_OK);
        make_sheet(&room_wall[0], 1, 0, &s);
        if (k && flip) turn_over(&s);
        rsv_mesh_desc d = { .size = sizeof d,
            .name = k ? "second" : "first",
            .positions = s.position,
            .vertex_count = s.vertex_count,
            .indices = s.index,
            .triangle_count = s.triangle_count,
            .material = paint };
        assert_int_equal(rsv_scene_add_mesh(scene, &d, &mesh), RSV_OK);
        assert_int_equal(rsv_scene_add_instance(scene, mesh, NULL, NULL), RSV_OK);
    }
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    rsv_scene_destroy(scene);
    rsv_context_destroy(context);
}

static void says_so_where_it_had_to_guess(void **state)
{
    (void)state;
    char warning[1024];
    warning_for(true, false, warning);
    assert_string_equal(warning, "");
    warning_for(false, true, warning);
    assert_string_equal(warning, "");
    warning_for(false, false, warning);
    static const char *const part[] = { "'first'", "'second'", "'plaster'", "'wallpaper'",
        "in the same place" };
    for (int k = 0; k < 5; k++)
        if (!strstr(warning, part[k])) fail_msg("'%s' lacks %s", warning, part[k]);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lists_the_copies_of_faces),
        cmocka_unit_test(packets_see_what_single_rays_see),
        cmocka_unit_test(shows_the_side_that_faces_the_ray),
        cmocka_unit_test(light_is_that_of_single_walls),
        cmocka_unit_test(copies_of_a_lamp_give_no_light_of_their_own),
        cmocka_unit_test(overlapping_lamps_shine_once),
        cmocka_unit_test(backs_of_lamps_shine_where_nothing_covers_them),
        cmocka_unit_test(a_lamp_in_a_ceiling_shines),
        cmocka_unit_test(doubled_bodies_refract_once),
        cmocka_unit_test(crates_on_crates_stay_dark_inside),
        cmocka_unit_test(landscapes_do_not_blur_what_stands_on_them),
        cmocka_unit_test(small_things_in_large_scenes_have_no_copies),
        cmocka_unit_test(many_copies_are_found_quickly),
        cmocka_unit_test(a_heap_of_copies_takes_no_square),
        cmocka_unit_test(says_so_where_it_had_to_guess),
    };
    const struct CMUnitTest longest[] = {
        cmocka_unit_test(light_is_that_of_single_walls_however_copied),
    };
    return RUN_HALF(argc, argv, tests, longest);
}
