/// What packets of camera paths take for granted: clear distances and the list of media, against rays and bodies one by
/// one.
#include "frame/clearance.h"
#include "frame/specular_media.h"

#include "light_fixture.h"

/// Glass of other bodies near curved ones, a curved mirror, a fold with sharp edges.
static world *curved_world(void)
{
    world *w = world_begin(2);
    uint32_t glass = world_material(w, glass_material());
    uint32_t mirror = world_material(w, mirror_material(0.9f));
    world_quad(
        w, world_lambert(w, 0.5f, 0), v3(-2, -1, 2), v3(2, -1, 2), v3(2, -1, -2), v3(-2, -1, -2));
    world_sphere(w, glass, v3(0, 0, 0), 0.999f, 4);
    world_sphere(w, mirror, v3(0.2f, 0.1f, 0), 0.5f, 3);
    world_sphere(w, glass, v3(1.2f, 0, 0), 0.4f, 3); // cuts the first
    world_box(w, glass, v3(-1.5f, -1, 0.5f), v3(-0.9f, 0, 1.5f));
    world_commit(w);
    return w;
}

typedef struct bundle {
    uint32_t clear, rays;
} bundle;

/// A ray from anywhere on a triangle into either half space.
static void shoot(const world *w, const rsv_clearances *c, rsv_random *random, bundle *b)
{
    const rsv_scene_view *view = rsv_scene_get_view(w->scene);
    uint32_t triangle = c->first + rsv_random_bits(random) % c->count;
    float u = rsv_random_float(random), v = rsv_random_float(random);
    bool back = rsv_random_bits(random) & 1;
    if (u + v > 1) u = 1 - u, v = 1 - v;
    if (rsv_random_bits(random) % 4 == 0) v = 0; // on an edge
    rsv_surface_point point = rsv_surface_point_at(view, triangle, u, v, back);
    rsv_ray ray = { .t_max = INFINITY };
    ray.direction = v3_normalize(v3(rsv_random_float(random) - 0.5f,
        rsv_random_float(random) - 0.5f, rsv_random_float(random) - 0.5f));
    float cosine = v3_dot(ray.direction, point.geometric);
    if (cosine < 0) ray.direction = v3_neg(ray.direction), cosine = -cosine;
    ray.origin = rsv_moved_off(point.position, point.geometric, point.extent);
    float distance = rsv_clear_distance(rsv_clearance_of(c, triangle), back, cosine);
    rsv_hit hit;
    b->rays++;
    if (distance == 0) return;
    b->clear++;
    if (rsv_tracer_closest(w->tracer, &ray, &hit) && hit.t < distance)
        fail_msg("triangle %u meets %u at %g m, said to be clear for %g", triangle, hit.triangle,
            (double)hit.t, (double)distance);
}

static void nothing_is_met_within_clear_distances(void **state)
{
    (void)state;
    world *w = curved_world();
    rsv_specular_media media = { 0 };
    rsv_clearances clearances;
    rsv_random random = rsv_random_from(1, 2, 3);
    bundle rays = { 0, 0 };
    assert_int_equal(rsv_specular_media_create(w->context, &w->transport, &media), RSV_OK);
    assert_int_equal(rsv_clearances_create(w->context, &media, true, &clearances), RSV_OK);
    for (int k = 0; k < 200000; k++)
        shoot(w, &clearances, &random, &rays);
    // spheres of few triangles look at wide surroundings, and some are cut
    if (rays.clear < rays.rays / 3) fail_msg("only %u of %u rays are clear", rays.clear, rays.rays);
    rsv_clearances_destroy(&clearances);
    rsv_specular_media_destroy(&media);
    world_end(w);
}

enum { many = 70 }; // more bodies than are listed

static bool is_medium(const rsv_specular_media *m, uint8_t number, const rsv_medium *medium)
{
    const rsv_medium *listed = &m->medium[number];
    if (number == RSV_MEDIUM_UNLISTED) return true;
    return listed->depth == medium->depth &&
           memcmp(listed->body, medium->body, medium->depth * sizeof *medium->body) == 0;
}

/// From any listed medium, through the surface of any body.
static void media_follow_the_bodies(void **state)
{
    (void)state;
    world *w = world_begin(1);
    rsv_specular_media m = { 0 };
    for (int k = 0; k < many; k++)
        world_sphere(w, world_material(w, glass_material()), v3((float)k, 0, 0), 0.3f, 0);
    world_commit(w);
    assert_int_equal(rsv_specular_media_create(w->context, &w->transport, &m), RSV_OK);
    assert_int_equal(m.count, RSV_MEDIA);
    for (uint32_t from = 0; from < m.count; from++)
        for (uint32_t material = 0; material < many; material++)
            for (int back = 0; back < 2; back++) {
                uint8_t body = m.material[material].body;
                rsv_medium inside = m.medium[from], beyond = m.medium[from];
                rsv_medium_arrive_inside(&inside, material);
                rsv_medium_cross(&beyond, material, back);
                assert_true(is_medium(&m, m.inside[body][from], &inside));
                assert_true(is_medium(&m, m.cross[back][body][from], &beyond));
            }
    // from outside into each of the listed bodies and out again
    for (uint32_t material = 0; material < RSV_MEDIA_BODIES; material++) {
        uint8_t body = m.material[material].body, in = m.cross[0][body][0];
        assert_int_not_equal(in, RSV_MEDIUM_UNLISTED);
        assert_int_equal(m.cross[1][body][in], 0);
    }
    rsv_specular_media_destroy(&m);
    world_end(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_is_met_within_clear_distances),
        cmocka_unit_test(media_follow_the_bodies),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
