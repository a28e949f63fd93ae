/// Diffusion profiles, and the rows that spread them over elements.
#include "diffusion/scatter_integral.h"
#include "diffusion/scatter_row.h"
#include "diffusion/subsurface.h"
#include "elements/spacing.h"
#include "light_fixture.h"
#include "subsurface/dipole.h"

#define assert_near(value, expected, tolerance)                                                    \
    do {                                                                                           \
        double got = (value), wanted = (expected);                                                 \
        if (!(fabs(got - wanted) <= (tolerance)))                                                  \
            fail_msg(#value " is %.9g, expected %.9g", got, wanted);                               \
    } while (0)

// ---- profiles -----------------------------------------------------------------------------------

static void distribution_function_inverts(void **state)
{
    (void)state;
    for (double u = 0; u < 1; u += 0.0137) {
        double r = rsv_diffusion_sample_radius(0.3, u);
        assert_near(rsv_diffusion_cdf(0.3, r), u, 1e-12);
    }
    assert_true(isfinite(rsv_diffusion_sample_radius(1, nextafter(1, 0))));
}

static void distribution_function_integrates_the_profile(void **state)
{
    (void)state;
    const double d = 0.7, end = 4, steps = 200000;
    double sum = 0;
    for (int k = 0; k < steps; k++) {
        double r = end * (k + 0.5) / steps;
        sum += 2 * M_PI * r * rsv_diffusion_profile(d, r) * end / steps;
    }
    assert_near(sum, rsv_diffusion_cdf(d, end), 1e-9);
}

static void dipole_albedo_inverts_its_reflectance(void **state)
{
    (void)state;
    for (double albedo = 0.05; albedo < 1; albedo += 0.1) {
        rsv_dipole dipole = rsv_dipole_create(albedo, 1 - albedo, 1.3);
        assert_near(rsv_dipole_albedo(rsv_dipole_reflectance(&dipole), 1.3), albedo, 1e-9);
    }
}

/// Published with the coefficients: diffuse reflectance of marble 0.83, 0.79, 0.75.
static void marble_reflects_as_published(void **state)
{
    (void)state;
    rsv_material marble;
    assert_true(rsv_material_preset("marble", &marble));
    assert_near(marble.base_color.r, 0.83, 0.005);
    assert_near(marble.base_color.g, 0.79, 0.005);
    assert_near(marble.base_color.b, 0.75, 0.005);
    assert_near(marble.scatter_distance.r, 1e-3 / 2.1921, 1e-9);
    assert_false(rsv_material_preset("granite", &marble));
    for (const char *const *name = rsv_material_preset_names(); *name; name++)
        assert_true(rsv_material_preset(*name, &marble));
}

// ---- integrals over triangles -------------------------------------------------------------------

/// The triangle cut into small ones, each by its centroid; the singularity must not lie within.
static void integrate_by_brute_force(
    const rsv_scatter_profile *profile, const rsv_vec3 corner[3], double weight[3])
{
    const int side = 1024;
    double area =
        0.5 * v3_length(v3_cross(v3_sub(corner[1], corner[0]), v3_sub(corner[2], corner[0])));
    weight[0] = weight[1] = weight[2] = 0;
    for (int j = 0; j < side; j++) {
        for (int k = 0; k < 2 * (side - j) - 1; k++) {
            float third = k & 1 ? 2.0f / 3 : 1.0f / 3;
            float u = ((float)(k / 2) + third) / side, v = ((float)j + third) / side;
            float r = v3_length(v3_barycentric(corner[0], corner[1], corner[2], u, v));
            double p = rsv_diffusion_profile(profile->d[0], r) * area / side / side;
            weight[0] += p * (1 - u - v), weight[1] += p * u, weight[2] += p * v;
        }
    }
}

static void check_integral(float d, const rsv_vec3 corner[3], double tolerance)
{
    rsv_scatter_profile profile = { { d, d, d } };
    rsv_rgb weight[3];
    double brute[3];
    rsv_scatter_integrate(&profile, corner, weight);
    integrate_by_brute_force(&profile, corner, brute);
    double sum = brute[0] + brute[1] + brute[2];
    for (int k = 0; k < 3; k++)
        assert_near(weight[k].r, brute[k], tolerance * sum);
}

static void integrals_over_triangles_agree_with_brute_force(void **state)
{
    (void)state;
    const rsv_vec3 beside[3] = { { 0.3f, -0.2f, 0 }, { 1.4f, 0.1f, 0 }, { 0.5f, 0.9f, 0 } };
    const rsv_vec3 above[3] = { { -0.5f, -0.4f, 0.3f }, { 1, -0.3f, 0.3f }, { -0.2f, 0.8f, 0.3f } };
    const rsv_vec3 around[3] = { { -0.5f, -0.4f, 0 }, { 1, -0.3f, 0 }, { -0.2f, 0.8f, 0 } };
    for (float d = 0.1f; d < 10; d *= 3) {
        check_integral(d, beside, 1e-3);
        check_integral(d, above, 0.02); // moments over raised triangles are approximate
        check_integral(d, around, 5e-3);
    }
}

static void a_corner_gets_all_of_a_narrow_profile(void **state)
{
    (void)state;
    const rsv_vec3 corner[3] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } };
    rsv_scatter_profile narrow = { { 1e-5f, 1e-5f, 1e-5f } };
    rsv_rgb weight[3];
    rsv_scatter_integrate(&narrow, corner, weight);
    assert_near(weight[0].r, 0.25, 1e-4); // a right angle
    assert_near(weight[1].r, 0, 1e-4);
    assert_near(weight[2].r, 0, 1e-4);
}

// ---- rows ---------------------------------------------------------------------------------------

/// Clusters stand for their cells to third order; what is left is of this size and changes sign from row to row.
#define CLUSTERS 5e-3

static rsv_material translucent(float albedo, float d)
{
    rsv_material m = lambert_material(albedo, 0);
    m.scatter_distance = rgb_gray(d * (float)rsv_diffuse_surface_scale(albedo));
    return m;
}

typedef struct bodies {
    world *w;
    rsv_elements *elements;
    rsv_subsurface *subsurface;
    rsv_rgb *in, *out;
} bodies;

static bodies spread_over(world *w, float spacing)
{
    bodies b = { .w = w };
    world_commit(w);
    assert_int_equal(
        rsv_elements_create(w->scene, w->bsdf, &(rsv_spacing){ .metres = spacing }, &b.elements),
        RSV_OK);
    assert_int_equal(rsv_subsurface_create(b.elements, &b.subsurface), RSV_OK);
    b.in = calloc(b.elements->node_count, sizeof *b.in);
    b.out = calloc(b.elements->node_count, sizeof *b.out);
    assert_true(b.in && b.out);
    return b;
}

static void end_bodies(bodies *b)
{
    free(b->in);
    free(b->out);
    rsv_subsurface_destroy(b->subsurface);
    rsv_elements_destroy(b->elements);
    world_end(b->w);
}

static void apply_to_one(bodies *b)
{
    for (size_t n = 0; n < b->elements->node_count; n++)
        b->in[n] = rgb_gray(1);
    rsv_subsurface_apply(b->subsurface, b->elements, b->in, b->out);
}

static rsv_vec3 place_of(const rsv_elements *e, uint32_t node)
{
    uint32_t support = e->support[e->support_begin[node]];
    return rsv_scatter_corner(e, support / 4, (int)(support & 3));
}

/// Caps of a sphere have the area pi r^2 of the flat disk of the same chord: what is missing is what the profile
/// would carry beyond the diameter.
static void a_sphere_keeps_what_the_profile_carries_within_its_diameter(void **state)
{
    (void)state;
    for (float d = 0.01f; d < 1; d *= 3) {
        world *w = world_begin(2);
        assert_int_equal(rsv_add_sphere(shape_of(w, world_material(w, translucent(0.8f, d))),
                             v3(0, 0, 0), 0.5f, 4),
            RSV_OK);
        bodies b = spread_over(w, 0.04f);
        apply_to_one(&b);
        double expected = rsv_diffusion_cdf(d, 1);
        for (size_t n = 0; n < b.elements->node_count; n++)
            assert_near(b.out[n].r, expected, CLUSTERS);
        end_bodies(&b);
    }
}

/// Fraction of a half plane's light that arrives at distance x > 0 from its edge, on the dark side.
static double beyond_edge(double d, double x)
{
    const int steps = 2000;
    double sum = 0, end = 60 * d;
    for (int k = 0; k < steps; k++) {
        double s = (k + 0.5) / steps, r = x + (end - x) * s * s; // dense at the edge
        sum += 2 * r * rsv_diffusion_profile(d, r) * acos(x / r) * (end - x) * 2 * s / steps;
    }
    return sum;
}

/// The same for light that fades to nothing over `width` about the edge, on both sides.
static double beyond_ramp(double d, double x, double width)
{
    const int steps = 64;
    double sum = 0;
    for (int k = 0; k < steps; k++) {
        double from = x - width * ((k + 0.5) / steps - 0.5);
        sum += from > 0 ? beyond_edge(d, from) : 1 - beyond_edge(d, -from);
    }
    return sum / steps;
}

static bodies slab(float d, float spacing)
{
    world *w = world_begin(2);
    world_quad(w, world_material(w, translucent(0.8f, d)), v3(-2, -2, 0), v3(2, -2, 0), v3(2, 2, 0),
        v3(-2, 2, 0));
    return spread_over(w, spacing);
}

static void a_large_slab_returns_all_light(void **state)
{
    (void)state;
    bodies b = slab(0.04f, 0.05f);
    apply_to_one(&b);
    for (uint32_t n = 0; n < b.elements->node_count; n++) {
        rsv_vec3 p = place_of(b.elements, n);
        if (fabsf(p.x) < 1.2f && fabsf(p.y) < 1.2f) assert_near(b.out[n].r, 1, CLUSTERS);
        assert_true(b.out[n].r < 1.0005f);
    }
    end_bodies(&b);
}

static void a_shadow_edge_blurs_by_the_profile(void **state)
{
    (void)state;
    const float d = 0.08f;
    bodies b = slab(d, 0.04f);
    float dark = INFINITY, lit = -INFINITY; // the columns of nodes beside the edge
    for (uint32_t n = 0; n < b.elements->node_count; n++) {
        float x = place_of(b.elements, n).x;
        bool beyond = x > 0.001f;
        if (beyond) dark = f_min(dark, x);
        if (!beyond) lit = f_max(lit, x);
        b.in[n] = rgb_gray(beyond ? 0 : 1);
    }
    rsv_subsurface_apply(b.subsurface, b.elements, b.in, b.out);
    for (uint32_t n = 0; n < b.elements->node_count; n++) {
        rsv_vec3 p = place_of(b.elements, n);
        float x = p.x - 0.5f * (dark + lit);
        if (fabsf(p.y) > 0.1f || fabsf(x) > 0.5f) continue;
        assert_near(b.out[n].r, beyond_ramp(d, x, dark - lit), CLUSTERS);
    }
    end_bodies(&b);
}

/// The light that a node receives and the light that it passes on are both at most 1, also on thin and sharp-edged
/// bodies.
static void nothing_gains_light(void **state)
{
    (void)state;
    const rsv_vec3 size[3] = { { 1, 1, 1 }, { 1, 0.05f, 1 }, { 0.1f, 0.1f, 1 } };
    for (int k = 0; k < 3; k++) {
        world *w = world_begin(2);
        world_box(w, world_material(w, translucent(0.8f, 0.1f)), v3(0, 0, 0), size[k]);
        bodies b = spread_over(w, 0.05f);
        apply_to_one(&b);
        double entered = 0, left = 0;
        for (uint32_t n = 0; n < b.elements->node_count; n++) {
            assert_true(b.out[n].r <= 1.0005f && b.out[n].r > 0.2f);
            float in = rsv_unit_float(rsv_hash(n / 7)); // patches
            b.in[n] = rgb_gray(in * in * in);
        }
        rsv_subsurface_apply(b.subsurface, b.elements, b.in, b.out);
        for (uint32_t n = 0; n < b.elements->node_count; n++) {
            entered += (double)(b.in[n].r * b.elements->node_area[n]);
            left += (double)(b.out[n].r * b.elements->node_area[n]);
        }
        assert_true(left <= 1.005 * entered && left > 0.3 * entered);
        end_bodies(&b);
    }
}

/// For any ratio of spacing and profile, diffusion moves light and loses none.
static void energy_does_not_depend_on_the_spacing(void **state)
{
    (void)state;
    for (float d = 0.001f; d < 0.1f; d *= 2.5f) {
        bodies b = slab(d, 0.1f);
        double entered = 0, left = 0;
        for (uint32_t n = 0; n < b.elements->node_count; n++) {
            rsv_vec3 p = place_of(b.elements, n);
            bool lit = p.x * p.x + p.y * p.y < 0.04f;
            b.in[n] = rgb_gray(lit ? 1 : 0);
            entered += lit ? (double)b.elements->node_area[n] : 0;
        }
        rsv_subsurface_apply(b.subsurface, b.elements, b.in, b.out);
        for (uint32_t n = 0; n < b.elements->node_count; n++)
            left += (double)(b.out[n].r * b.elements->node_area[n]);
        assert_near(left / entered, 1, 3e-3);
        end_bodies(&b);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(distribution_function_inverts),
        cmocka_unit_test(distribution_function_integrates_the_profile),
        cmocka_unit_test(dipole_albedo_inverts_its_reflectance),
        cmocka_unit_test(marble_reflects_as_published),
        cmocka_unit_test(integrals_over_triangles_agree_with_brute_force),
        cmocka_unit_test(a_corner_gets_all_of_a_narrow_profile),
        cmocka_unit_test(a_sphere_keeps_what_the_profile_carries_within_its_diameter),
        cmocka_unit_test(a_large_slab_returns_all_light),
        cmocka_unit_test(a_shadow_edge_blurs_by_the_profile),
        cmocka_unit_test(nothing_gains_light),
        cmocka_unit_test(energy_does_not_depend_on_the_spacing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
