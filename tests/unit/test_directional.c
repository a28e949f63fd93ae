/// Maps of light by direction beside dense sums over the same rays, closed forms and traced lobes.
#include "directional/directional_internal.h"
#include "directional/look_up_kernels.h"
#include "elements/burial.h"
#include "elements/contact.h"
#include "elements/spacing.h"
#include "light_fixture.h"
#include "light_view.h"
#include "operator/row_tracer.h"
#include "reference/reference_internal.h"
#include "resolvent/render.h"

#include <stdio.h>

// ---- rows and maps --------------------------------------------------------------------------------

/// Rows of a scene, as the solver makes them, and maps of them.
typedef struct maps {
    world *w;
    rsv_elements *elements;
    uint16_t *valid_points;
    rsv_transport *transport;
    rsv_directional *directional;
    rsv_rgb *exitance;
} maps;

#define SEED 1

static maps maps_of(world *w, float spacing, uint32_t rays)
{
    maps m = { .w = w };
    uint64_t count = 0;
    world_commit(w);
    const rsv_spacing wanted = { .metres = spacing };
    assert_int_equal(rsv_elements_create(w->scene, w->bsdf, &wanted, &m.elements), RSV_OK);
    assert_int_equal(rsv_elements_separate(&w->transport, NULL, m.elements, &count), RSV_OK);
    m.valid_points = calloc(m.elements->node_count, sizeof *m.valid_points);
    m.exitance = calloc(m.elements->node_count, sizeof *m.exitance);
    assert_true(m.valid_points && m.exitance);
    assert_int_equal(rsv_find_buried(&w->transport, m.elements, RSV_SUPPORT_POINTS, SEED, NULL,
                         m.valid_points, &count),
        RSV_OK);
    assert_int_equal(rsv_transport_create(&w->transport, w->lights, m.elements, m.valid_points,
                         rays, SEED, &m.transport),
        RSV_OK);
    assert_int_equal(rsv_directional_create(m.elements, m.transport, &m.directional), RSV_OK);
    return m;
}

static void maps_end(maps *m)
{
    world *w = m->w;
    rsv_directional_destroy(m->directional);
    rsv_transport_destroy(m->transport);
    rsv_elements_destroy(m->elements);
    free(m->valid_points);
    free(m->exitance);
    world_end(w);
}

/// A closed room with a box in it, and a pane of glass that is not quite clear.
static world *furnished(int threads)
{
    world *w = world_begin(threads);
    rsv_material glass = glass_material();
    glass.thickness = 0;
    glass.base_color = rgb(0.9f, 0.8f, 0.6f);
    world_room(w, world_lambert(w, 0.6f, 1), v3(0, 0, 0), v3(4, 3, 5));
    world_box(w, world_lambert(w, 0.4f, 0), v3(1, 0.1f, 1), v3(2, 1, 2));
    world_quad(
        w, world_material(w, glass), v3(3, 0.2f, 1), v3(3, 2, 1), v3(3, 2, 4), v3(3, 0.2f, 4));
    return w;
}

static void refresh(maps *m)
{
    assert_int_equal(rsv_directional_refresh(m->directional, m->exitance), RSV_OK);
}

static void fill_even(maps *m, rsv_rgb radiance)
{
    for (size_t n = 0; n < m->elements->node_count; n++)
        m->exitance[n] = rgb_scale(radiance, RSV_PI);
    refresh(m);
}

/// Uneven and coloured, over two decades.
static void fill_uneven(maps *m, uint32_t seed)
{
    for (uint32_t n = 0; n < m->elements->node_count; n++) {
        float level = expf(4.6f * rsv_unit_float(rsv_hash3(seed, n, 0)));
        m->exitance[n] = rgb(level * rsv_unit_float(rsv_hash3(seed, n, 1)),
            level * rsv_unit_float(rsv_hash3(seed, n, 2)),
            level * rsv_unit_float(rsv_hash3(seed, n, 3)));
    }
    refresh(m);
}

static rsv_vec3 random_direction(uint32_t seed, uint32_t k)
{
    float z = 2 * rsv_unit_float(rsv_hash3(seed, k, 10)) - 1;
    float phi = 2 * RSV_PI * rsv_unit_float(rsv_hash3(seed, k, 11)), r = sqrtf(1 - z * z);
    return v3(r * cosf(phi), r * sinf(phi), z);
}

/// A place somewhere on the elements, and a lobe there that is not bent. @return whether its node knows light
static bool draw_place(
    const maps *m, uint32_t k, rsv_directional_place *place, rsv_directional_lobe *lobe)
{
    const rsv_elements *e = m->elements;
    uint32_t cell = rsv_hash3(5, k, 0) % (uint32_t)e->cell_count, face = e->cell[cell].face;
    float a = rsv_unit_float(rsv_hash3(5, k, 1)), b = rsv_unit_float(rsv_hash3(5, k, 2));
    float root = sqrtf(a);
    const float weight[3] = { 1 - root, root * (1 - b), root * b };
    bool known = false;
    for (int c = 0; c < 3; c++) {
        place->node[c] = e->cell_node[cell][c], place->weight[c] = weight[c];
        known |= m->transport->scale[place->node[c]] > 0;
    }
    rsv_surface_point p = rsv_surface_point_at(
        e->scene, e->face_triangle[face], weight[1], weight[2], e->face_back[face] != 0);
    place->normal = lobe->normal = p.normal;
    do
        lobe->outgoing = random_direction(6, k);
    while (k += 1u << 20, v3_dot(lobe->outgoing, p.normal) < 0.05f);
    lobe->alpha = rsv_unit_float(rsv_hash3(5, k, 3));
    return known;
}

static void assert_rgb_close(rsv_rgb value, rsv_rgb expected, double tolerance)
{
    assert_close((double)value.r, (double)expected.r, tolerance);
    assert_close((double)value.g, (double)expected.g, tolerance);
    assert_close((double)value.b, (double)expected.b, tolerance);
}

/// A closed room without anything in it that dims light.
static void even_light_comes_out_as_it_is(void **state)
{
    (void)state;
    world *w = world_begin(2);
    world_room(w, world_lambert(w, 0.6f, 1), v3(0, 0, 0), v3(4, 3, 5));
    world_box(w, world_lambert(w, 0.4f, 0), v3(1, 0.1f, 1), v3(2, 1, 2));
    maps m = maps_of(w, 0.5f, 256);
    const rsv_rgb radiance = rgb(3, 1.2f, 0.4f);
    size_t seen = 0;
    fill_even(&m, radiance);
    for (uint32_t k = 0; k < 1000; k++) {
        rsv_directional_place place;
        rsv_directional_lobe lobe;
        if (!draw_place(&m, k, &place, &lobe)) continue;
        // means are stored with four digits
        assert_rgb_close(rsv_directional_look_up(m.directional, &place, &lobe), radiance, 5e-4);
        seen++;
    }
    assert_true(seen > 900);
    maps_end(&m);
}

static void no_light_is_black(void **state)
{
    (void)state;
    maps m = maps_of(furnished(2), 0.5f, 64);
    rsv_directional_place place;
    rsv_directional_lobe lobe;
    fill_uneven(&m, 1);
    fill_even(&m, rgb_gray(0));
    for (uint32_t k = 0; k < 100; k++) {
        draw_place(&m, k, &place, &lobe);
        assert_rgb_close(rsv_directional_look_up(m.directional, &place, &lobe), rgb_gray(0), 0);
    }
    maps_end(&m);
}

static void refreshed_maps_take(maps *m, uint32_t count, rsv_rgb *value)
{
    for (uint32_t k = 0; k < count; k++) {
        rsv_directional_place place;
        rsv_directional_lobe lobe;
        draw_place(m, k, &place, &lobe);
        value[k] = rsv_directional_look_up(m->directional, &place, &lobe);
    }
}

static rsv_rgb rgb_difference(rsv_rgb a, rsv_rgb b)
{
    return rgb(fabsf(a.r - b.r), fabsf(a.g - b.g), fabsf(a.b - b.b));
}

static float largest_of(rsv_rgb c) { return f_max(c.r, f_max(c.g, c.b)); }

/// Codes have eight bits: each map errs by half a percent of the largest radiance around it at most.
static void light_adds_up(void **state)
{
    (void)state;
    enum { count = 400 };
    maps m = maps_of(furnished(2), 0.5f, 256);
    size_t nodes = m.elements->node_count;
    rsv_rgb value[3][count], *sum = calloc(nodes, sizeof *sum);
    assert_non_null(sum);
    for (uint32_t light = 0; light < 2; light++) {
        fill_uneven(&m, light);
        for (size_t n = 0; n < nodes; n++)
            sum[n] = rgb_mad(sum[n], light ? 0.25f : 1, m.exitance[n]);
        refreshed_maps_take(&m, count, value[light]);
    }
    memcpy(m.exitance, sum, nodes * sizeof *sum);
    refresh(&m);
    refreshed_maps_take(&m, count, value[2]);
    double squares = 0, all = 0;
    for (int k = 0; k < count; k++) {
        rsv_rgb expected = rgb_mad(value[0][k], 0.25f, value[1][k]);
        float error = largest_of(rgb_difference(value[2][k], expected));
        assert_true(error < 0.05f * largest_of(expected) + 0.5f);
        squares += (double)(error * error), all += (double)largest_of(expected);
    }
    assert_close(sqrt(squares / count), 0, 0.01 * all / count);
    free(sum);
    maps_end(&m);
}

// ---- maps beside the rays of the rows -------------------------------------------------------------

static double luma_of(rsv_rgb c) { return 0.25 * ((double)c.r + 2 * (double)c.g + (double)c.b); }

/// Mean luminance of the rays of each bin; rays that end nowhere are black.
static void sum_rays(const maps *m, const rsv_row_tracer *tracer, const rsv_row_scratch *s,
    double mean[RSV_DIRECTION_BINS])
{
    const rsv_directions *d = &tracer->directions;
    size_t first = rsv_directions_of(d, SEED, s->index);
    uint32_t rays[RSV_DIRECTION_BINS] = { 0 };
    memset(mean, 0, RSV_DIRECTION_BINS * sizeof *mean);
    for (uint32_t ray = 0; ray < d->count; ray++) {
        rays[d->bin[first + ray]]++;
        if (s->column[ray] != RSV_NONE)
            mean[d->bin[first + ray]] += luma_of(m->exitance[s->column[ray]]);
    }
    for (uint32_t k = 0; k < s->tinted_count; k++)
        if (s->tinted_ray[k] != RSV_NO_RAY)
            mean[d->bin[first + s->tinted_ray[k]]] +=
                luma_of(rgb_mul(s->tinted_weight[k], m->exitance[s->tinted_column[k]]));
    for (uint32_t bin = 0; bin < RSV_DIRECTION_BINS; bin++)
        mean[bin] /= RSV_PI * rays[bin];
}

/// Each code stands for what is within half a step of its square root.
static void check_map(const rsv_directional_map *map, const double *mean)
{
    for (uint32_t bin = 0; bin < RSV_DIRECTION_BINS; bin++) {
        double root = map->luma[bin] / 255.0;
        assert_close(root, sqrt(mean[bin] / (double)map->scale), 0.502 / 255);
    }
}

static void maps_are_means_of_the_rays_by_direction(void **state)
{
    (void)state;
    maps m = maps_of(furnished(1), 0.5f, 1024);
    world *w = m.w;
    rsv_row_tracer tracer = { &w->transport, w->lights, m.elements, m.valid_points, .seed = SEED };
    rsv_row_scratch scratch = { 0 };
    size_t receiver = 0, tinted = 0;
    assert_int_equal(rsv_row_tracer_begin(&tracer, 1024), RSV_OK);
    assert_int_equal(rsv_row_scratch_create(w->context, 1024, &scratch), RSV_OK);
    fill_uneven(&m, 3);
    for (uint32_t n = 0; n < m.elements->node_count; n++) {
        double mean[RSV_DIRECTION_BINS];
        if (!m.valid_points[n]) continue;
        rsv_row_trace(&tracer, n, &scratch);
        sum_rays(&m, &tracer, &scratch, mean);
        check_map(&m.directional->map[receiver++], mean);
        tinted += scratch.tinted_count;
    }
    assert_int_equal(receiver, rsv_directional_count(m.directional));
    assert_true(tinted > 1000);
    rsv_row_scratch_destroy(w->context, &scratch);
    rsv_row_tracer_end(&tracer);
    maps_end(&m);
}

static void maps_take_256_bytes_a_receiver_at_most(void **state)
{
    (void)state;
    maps m = maps_of(furnished(1), 0.3f, 256);
    assert_true(rsv_directional_bytes(m.directional) <= 256 * rsv_directional_count(m.directional));
    maps_end(&m);
}

static void maps_are_the_same_bytes_for_any_thread_count(void **state)
{
    (void)state;
    uint64_t hash[2];
    for (int k = 0; k < 2; k++) {
        maps m = maps_of(furnished(1 + 4 * k), 0.5f, 256);
        fill_uneven(&m, 1);
        size_t bytes = m.directional->rows->count * sizeof *m.directional->map;
        hash[k] = hash_bytes(HASH_START, m.directional->map, bytes);
        maps_end(&m);
    }
    assert_true(hash[0] == hash[1]);
}

// ---- lookups --------------------------------------------------------------------------------------

static void set_lane(rsv_directional_packet *p, int k, const rsv_directional_place *place,
    const rsv_directional_lobe *lobe)
{
    for (int c = 0; c < 3; c++)
        p->node[c][k] = place->node[c], p->weight[c][k] = place->weight[c];
    p->surface_x[k] = place->normal.x, p->surface_y[k] = place->normal.y;
    p->surface_z[k] = place->normal.z;
    p->normal_x[k] = lobe->normal.x, p->normal_y[k] = lobe->normal.y;
    p->normal_z[k] = lobe->normal.z;
    p->outgoing_x[k] = lobe->outgoing.x, p->outgoing_y[k] = lobe->outgoing.y;
    p->outgoing_z[k] = lobe->outgoing.z;
    p->alpha[k] = lobe->alpha;
}

static void check_packets(const maps *m)
{
    for (uint32_t packet = 0; packet < 20; packet++) {
        rsv_directional_packet p = { 0 };
        rsv_rgb alone[RSV_DIRECTIONAL_LANES];
        for (int k = 0; k < RSV_DIRECTIONAL_LANES; k++) {
            rsv_directional_place place;
            rsv_directional_lobe lobe;
            draw_place(m, 16 * packet + (uint32_t)k, &place, &lobe);
            set_lane(&p, k, &place, &lobe);
            alone[k] = rsv_directional_look_up(m->directional, &place, &lobe);
        }
        rsv_directional_look_up_packet(m->directional, &p);
        for (int k = 0; k < RSV_DIRECTIONAL_LANES; k++)
            assert_rgb_close(rgb(p.red[k], p.green[k], p.blue[k]), alone[k],
                1e-5 * (double)largest_of(alone[k]));
    }
}

/// With all instruction sets that the processor has.
static void packets_find_what_lookups_find_alone(void **state)
{
    (void)state;
    maps m = maps_of(furnished(2), 0.5f, 256);
    const rsv_look_up_kernels *best = rsv_look_up_kernels_best();
    fill_uneven(&m, 1);
    check_packets(&m);
    m.directional->kernels = &rsv_look_up_kernels_portable;
    check_packets(&m);
#if defined(__x86_64__)
    if (best != &rsv_look_up_kernels_portable) m.directional->kernels = &rsv_look_up_kernels_avx2;
    check_packets(&m);
#endif
    (void)best;
    maps_end(&m);
}

// ---- maps beside traced lobes ---------------------------------------------------------------------

#define LOBE_RAYS 2048

/// Mean over a lobe of what a path tracer sees of surfaces: what sources send themselves, without a diffuse reflection
/// on the way, is left out.
static rsv_rgb trace_lobe(const rsv_path_tracer *tracer, const rsv_surface_point *p,
    const rsv_directional_lobe *lobe, uint32_t stream)
{
    rsv_vec3 t, b;
    rsv_rgb sum = rgb_gray(0);
    double weights = 0;
    v3_frame(lobe->normal, &t, &b);
    rsv_vec3 wo = v3(
        v3_dot(lobe->outgoing, t), v3_dot(lobe->outgoing, b), v3_dot(lobe->outgoing, lobe->normal));
    for (uint32_t k = 0; k < LOBE_RAYS; k++) {
        float u1, u2;
        rsv_path_light light;
        rsv_medium outside = { 0 };
        rsv_sobol_2d(k, stream, &u1, &u2);
        rsv_vec3 h = rsv_ggx_sample_visible(wo, lobe->alpha, u1, u2), wi = rsv_mirrored(wo, h);
        if (!(wi.z > 0)) continue;
        float weight = rsv_ggx_visibility(wo.z, wi.z, lobe->alpha);
        rsv_vec3 d = v3_mad(v3_mad(v3_scale(lobe->normal, wi.z), wi.x, t), wi.y, b);
        rsv_ray ray = { rsv_offset_origin(p->position, p->geometric, p->extent), d, INFINITY };
        rsv_trace_camera_path(tracer, &ray, &outside, (rsv_path_id){ k, stream }, &light);
        for (int order = 1; order < RSV_PATH_ORDERS; order++)
            sum = rgb_mad(sum, weight, light.order[order]);
        weights += (double)weight;
    }
    return rgb_scale(sum, (float)(1 / weights));
}

/// A room that a lamp under the ceiling lights, with boxes in it and walls of different colours.
static world *lit_room(void)
{
    world *w = world_begin(2);
    uint32_t red, green;
    assert_int_equal(
        rsv_add_lambert(w->scene, "red", rgb(0.6f, 0.1f, 0.1f), rgb_gray(0), &red), RSV_OK);
    assert_int_equal(
        rsv_add_lambert(w->scene, "green", rgb(0.1f, 0.5f, 0.2f), rgb_gray(0), &green), RSV_OK);
    world_room(w, world_lambert(w, 0.6f, 0), v3(0, 0, 0), v3(4, 3, 5));
    world_box(w, red, v3(0.6f, 0.01f, 1), v3(1.4f, 0.9f, 2));
    world_box(w, green, v3(2.5f, 0.01f, 3), v3(3.2f, 1.6f, 3.8f));
    world_quad(w, world_lambert(w, 0, 10), v3(1.5f, 2.9f, 2), v3(2.5f, 2.9f, 2), v3(2.5f, 2.9f, 3),
        v3(1.5f, 2.9f, 3));
    return w;
}

/// Maps of the light of a room, and what judges them.
typedef struct lit_maps {
    maps m;
    rsv_light *light;
    rsv_path_tracer *tracer;
} lit_maps;

static lit_maps light_up(world *w)
{
    lit_maps l = { .m = { .w = w } };
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    world_commit(w);
    assert_int_equal(rsv_light_create(w->scene, &desc, &l.light), RSV_OK);
    const rsv_light_view *view = inside(l.light);
    l.m.elements = rsv_elements_retain(rsv_operator_get_view(view->op)->elements);
    l.m.exitance = calloc(view->elements->node_count, sizeof *l.m.exitance);
    assert_non_null(l.m.exitance);
    assert_int_equal(
        rsv_directional_create(view->elements, view->transport, &l.m.directional), RSV_OK);
    assert_int_equal(rsv_light_view_exitance(view, l.m.exitance), RSV_OK);
    refresh(&l.m);
    l.m.transport = (rsv_transport *)(uintptr_t)view->transport;
    assert_int_equal(rsv_path_tracer_create(w->scene, &l.tracer), RSV_OK);
    return l;
}

static void put_out(lit_maps *l)
{
    rsv_path_tracer_destroy(l->tracer);
    rsv_light_destroy(l->light);
    l->m.transport = NULL;
    maps_end(&l->m);
}

static rsv_surface_point point_of(const maps *m, uint32_t k)
{
    const rsv_elements *e = m->elements;
    uint32_t cell = rsv_hash3(5, k, 0) % (uint32_t)e->cell_count, face = e->cell[cell].face;
    uint32_t triangle = e->face_triangle[face];
    float root = sqrtf(rsv_unit_float(rsv_hash3(5, k, 1)));
    float b = rsv_unit_float(rsv_hash3(5, k, 2)), u = 0, v = 0;
    const float weight[3] = { 1 - root, root * (1 - b), root * b };
    for (int c = 0; c < 3; c++) {
        float corner_u, corner_v;
        rsv_cell_corner(&e->cell[cell], c, &corner_u, &corner_v);
        u += weight[c] * corner_u, v += weight[c] * corner_v;
    }
    return rsv_surface_point_at(e->scene, triangle, u, v, e->face_back[face] != 0);
}

/// Error of lookups at one roughness, relative to the mean of the lobes. @param bias of the mean
static double lobe_error(const lit_maps *l, float roughness, double *bias)
{
    double squares = 0, sum = 0, errors = 0;
    int count = 0;
    for (uint32_t k = 0; k < 120; k++) {
        rsv_directional_place place;
        rsv_directional_lobe lobe;
        if (!draw_place(&l->m, k, &place, &lobe)) continue;
        rsv_surface_point p = point_of(&l->m, k);
        lobe.alpha = roughness * roughness;
        double exact = luma_of(trace_lobe(l->tracer, &p, &lobe, k));
        double found = luma_of(rsv_directional_look_up(l->m.directional, &place, &lobe));
        squares += (found - exact) * (found - exact);
        errors += found - exact, sum += exact;
        count++;
    }
    *bias = errors / sum;
    return sqrt(squares / count) / (sum / count);
}

static void lookups_are_close_to_traced_lobes(void **state)
{
    (void)state;
    const float roughness[] = { 0.3f, 0.4f, 0.5f, 0.7f };
    const double most[] = { 0.25, 0.2, 0.15, 0.1 };
    lit_maps l = light_up(lit_room());
    for (int k = 0; k < 4; k++) {
        double bias, error = lobe_error(&l, roughness[k], &bias);
        printf("    roughness %.1f: error %.3f, bias %+.3f\n", (double)roughness[k], error, bias);
        assert_true(error < most[k]);
        assert_close(bias, 0, 0.03);
    }
    put_out(&l);
}

static void bad_memory_is_reported(void **state)
{
    (void)state;
    maps m = maps_of(furnished(1), 0.5f, 64);
    rsv_directional_destroy(m.directional);
    for (long k = 0;; k++) {
        m.directional = NULL;
        m.w->until_failure = k;
        rsv_status status = rsv_directional_create(m.elements, m.transport, &m.directional);
        m.w->until_failure = -1;
        if (status == RSV_OK) break;
        assert_int_equal(status, RSV_ERROR_MEMORY);
        assert_null(m.directional);
    }
    maps_end(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(even_light_comes_out_as_it_is),
        cmocka_unit_test(no_light_is_black),
        cmocka_unit_test(light_adds_up),
        cmocka_unit_test(maps_are_means_of_the_rays_by_direction),
        cmocka_unit_test(maps_take_256_bytes_a_receiver_at_most),
        cmocka_unit_test(maps_are_the_same_bytes_for_any_thread_count),
        cmocka_unit_test(packets_find_what_lookups_find_alone),
        cmocka_unit_test(lookups_are_close_to_traced_lobes),
        cmocka_unit_test(bad_memory_is_reported),
    };
    return cmocka_run_group_tests_name("directional", tests, NULL, NULL);
}
