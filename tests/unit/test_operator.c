/// Rows of G, specular paths and light shooting.
#include "direct/photons.h"
#include "elements/burial.h"
#include "elements/contact.h"
#include "elements/spacing.h"
#include "light_fixture.h"
#include "operator/directions.h"
#include "operator/transport_columns.h"
#include "operator/transport_rows.h"
#include "resolvent/render.h"

// ---- directions ---------------------------------------------------------------------------------

/// Inverse of rsv_square_to_disk.
static void disk_to_square(double dx, double dy, double *x, double *y)
{
    double r = hypot(dx, dy), phi = atan2(dy, dx), a, b, quarter = RSV_PI / 4;
    if (phi < -quarter) phi += 2 * RSV_PI;
    if (phi < quarter)
        a = r, b = phi * a / quarter;
    else if (phi < 3 * quarter)
        b = r, a = -(phi - 2 * quarter) * b / quarter;
    else if (phi < 5 * quarter)
        a = -r, b = (phi - 4 * quarter) * a / quarter;
    else
        b = -r, a = -(phi - 6 * quarter) * b / quarter;
    *x = (a + 1) / 2;
    *y = (b + 1) / 2;
}

/// Bounds of sixteen directions in the unit square, and whether they fit into one cell of a net.
static void check_packet(const rsv_directions *d, size_t first, int across, int down, uint8_t *seen)
{
    double low_x = 1, low_y = 1, high_x = 0, high_y = 0;
    for (size_t k = first; k < first + 16; k++) {
        double x, y;
        disk_to_square(d->x[k], d->y[k], &x, &y);
        low_x = fmin(low_x, x), high_x = fmax(high_x, x);
        low_y = fmin(low_y, y), high_y = fmax(high_y, y);
    }
    int column = (int)((low_x + high_x) / 2 * across), row = (int)((low_y + high_y) / 2 * down);
    assert_true(low_x * across > column - 1e-3 && high_x * across < column + 1 + 1e-3);
    assert_true(low_y * down > row - 1e-3 && high_y * down < row + 1 + 1e-3);
    assert_false(seen[row * across + column]); // every cell has one packet
    seen[row * across + column] = 1;
}

static void every_packet_of_directions_lies_in_one_cell(void **state)
{
    (void)state;
    world *w = world_begin(1);
    const struct {
        uint32_t count;
        int across, down;
    } net[] = { { 64, 2, 2 }, { 128, 4, 2 }, { 256, 4, 4 }, { 512, 8, 4 } };
    for (size_t n = 0; n < 4; n++) {
        rsv_directions d;
        assert_int_equal(rsv_directions_create(w->context, net[n].count, 7, &d), RSV_OK);
        for (size_t set = 0; set < RSV_DIRECTION_SETS; set++) {
            uint8_t seen[64] = { 0 };
            for (uint32_t first = 0; first < net[n].count; first += 16)
                check_packet(&d, set * net[n].count + first, net[n].across, net[n].down, seen);
        }
        rsv_directions_destroy(&d);
    }
    world_end(w);
}

static void directions_are_cosine_distributed(void **state)
{
    (void)state;
    world *w = world_begin(1);
    rsv_directions d;
    assert_int_equal(rsv_directions_create(w->context, 256, 3, &d), RSV_OK);
    size_t total = (size_t)RSV_DIRECTION_SETS * d.count;
    double mean[3] = { 0 }, second = 0;
    for (size_t k = 0; k < total; k++) {
        rsv_vec3 v = v3(d.x[k], d.y[k], d.z[k]);
        assert_close(v3_length(v), 1, 1e-5);
        assert_true(v.z > 0);
        mean[0] += v.x, mean[1] += v.y, mean[2] += v.z, second += v.z * v.z;
    }
    // 16384 directions would err by 0.0018 if they were independent; nets do far better
    assert_close(mean[0] / (double)total, 0, 1e-3);
    assert_close(mean[1] / (double)total, 0, 1e-3);
    assert_close(mean[2] / (double)total, 2.0 / 3, 5e-4);
    assert_close(second / (double)total, 0.5, 5e-4);
    rsv_directions_destroy(&d);
    world_end(w);
}

// ---- rows ---------------------------------------------------------------------------------------

/// Elements with rows, as the solver makes them.
typedef struct rows {
    world *w;
    rsv_elements *elements;
    uint16_t *valid_points;
    rsv_transport *transport;
    uint64_t rays;
} rows;

static rows create_rows(world *w, float spacing, uint32_t ray_count)
{
    rows r = { .w = w };
    world_commit(w);
    assert_int_equal(
        rsv_elements_create(w->scene, w->bsdf, &(rsv_spacing){ .metres = spacing }, &r.elements),
        RSV_OK);
    assert_int_equal(rsv_elements_separate(&w->transport, NULL, r.elements, &r.rays), RSV_OK);
    r.valid_points = calloc(r.elements->node_count, sizeof *r.valid_points);
    assert_non_null(r.valid_points);
    assert_int_equal(
        rsv_find_buried(&w->transport, r.elements, (rsv_support_draw){ RSV_SUPPORT_POINTS, 1 },
            NULL, r.valid_points, &r.rays),
        RSV_OK);
    assert_int_equal(rsv_elements_bridge_buried(r.elements, r.valid_points), RSV_OK);
    assert_int_equal(rsv_transport_create(&(rsv_transport_desc){ &w->transport, w->lights,
                                              r.elements, r.valid_points, ray_count, 1 },
                         &r.transport),
        RSV_OK);
    return r;
}

static void destroy_rows(rows *r)
{
    rsv_transport_destroy(r->transport);
    rsv_elements_destroy(r->elements);
    free(r->valid_points);
    world_end(r->w);
}

static uint64_t hash_rows(const rsv_transport *t)
{
    uint64_t hash = HASH_START;
    for (size_t k = 0; k < t->row_count; k++) {
        rsv_transport_row row = rsv_transport_row_at(t, k);
        hash = hash_bytes(hash, &row.count, sizeof row.count);
        hash = hash_bytes(hash, &row.tinted_count, sizeof row.tinted_count);
        hash = hash_bytes(hash, row.column, row.count * sizeof *row.column);
        hash = hash_bytes(hash, row.tinted_column, row.tinted_count * sizeof *row.tinted_column);
        hash = hash_bytes(hash, row.tinted_weight, row.tinted_count * sizeof *row.tinted_weight);
    }
    hash = hash_bytes(hash, t->scale, t->row_count * sizeof *t->scale);
    return hash_bytes(hash, t->gathered, t->row_count * sizeof *t->gathered);
}

static size_t count_tinted(const rsv_transport *t)
{
    size_t count = 0;
    for (size_t row = 0; row < t->row_count; row++)
        count += rsv_transport_row_at(t, row).tinted_count;
    return count;
}

/// Smallest and largest row sum of the free rows.
static void row_sums(const rows *r, double *low, double *high)
{
    size_t count = r->transport->row_count;
    rsv_rgb *one = calloc(count, sizeof *one), *sum = calloc(count, sizeof *sum);
    assert_true(one && sum);
    for (size_t n = 0; n < count; n++)
        one[n] = rgb_gray(1);
    rsv_transport_apply(r->transport, one, sum);
    *low = INFINITY, *high = 0;
    for (size_t n = 0; n < count; n++) {
        if (r->transport->scale[n] == 0) {
            assert_true(rgb_is_black(sum[n]));
            continue;
        }
        *low = fmin(*low, fmin(sum[n].r, fmin(sum[n].g, sum[n].b)));
        *high = fmax(*high, rgb_max(sum[n]));
    }
    free(one);
    free(sum);
}

static void rows_of_a_closed_room_sum_to_one(void **state)
{
    (void)state;
    world *w = world_begin(2);
    world_room(w, world_lambert(w, 0.5f, 0), v3(0, 0, 0), v3(2, 1, 1.5f));
    rows r = create_rows(w, 0.25f, 256);
    double low, high;
    row_sums(&r, &low, &high);
    assert_close(low, 1, 1e-6);
    assert_close(high, 1, 1e-6);
    destroy_rows(&r);
}

/// Facets with interpolated normals trap one ray in ten thousand for ever; no other light is lost.
static void rows_of_a_room_with_mirror_and_glass_sum_to_one(void **state)
{
    (void)state;
    world *w = world_begin(2);
    world_room(w, world_lambert(w, 0.5f, 0), v3(0, 0, 0), v3(2, 1, 1.5f));
    world_sphere(w, world_material(w, glass_material()), v3(0.5f, 0.5f, 0.7f), 0.3f, 3);
    world_sphere(w, world_material(w, mirror_material(1)), v3(1.4f, 0.5f, 0.7f), 0.3f, 2);
    rows r = create_rows(w, 0.25f, 256);
    double low, high;
    row_sums(&r, &low, &high);
    assert_close(low, 1, 1.0 / 256 + 1e-6); // one ray of one row at most
    assert_close(high, 1, 1e-6);
    destroy_rows(&r);
}

/// Coloured glass, metal, blocks on the floor and an open front: no path gains energy.
static void no_row_sums_to_more_than_one(void **state)
{
    (void)state;
    world *w = world_begin(2);
    uint32_t white = world_lambert(w, 0.7f, 0);
    rsv_material green = glass_material();
    green.base_color = rgb(0.3f, 0.9f, 0.4f);
    green.attenuation_color = rgb(0.2f, 0.8f, 0.5f);
    green.attenuation_distance = 0.2f;
    rsv_material coated = rsv_default_material();
    coated.base_color = rgb(0.9f, 0.5f, 0.2f);
    coated.roughness = 0;
    coated.metallic = 0;
    world_room(w, white, v3(0, 0, 0), v3(2, 1, 1.5f));
    world_sphere(w, world_material(w, green), v3(0.5f, 0.4f, 0.7f), 0.35f, 2);
    world_box(w, world_material(w, coated), v3(1.1f, 0, 0.3f), v3(1.5f, 0.5f, 0.7f));
    rows r = create_rows(w, 0.25f, 256);
    double low, high;
    row_sums(&r, &low, &high);
    assert_true(low >= 0);
    assert_true(high <= 1 + 1e-6);
    destroy_rows(&r);
}

/// Two unit squares that face each other at distance 1, nothing else.
static rows create_facing_squares(void)
{
    world *w = world_begin(2);
    uint32_t white = world_lambert(w, 0.5f, 0);
    world_quad(w, white, v3(0, 0, 0), v3(0, 0, 1), v3(1, 0, 1), v3(1, 0, 0)); // faces up
    world_quad(w, white, v3(0, 1, 0), v3(1, 1, 0), v3(1, 1, 1), v3(0, 1, 1)); // faces down
    return create_rows(w, 0.125f, 1024);
}

static rsv_vec3 node_place(const rsv_elements *e, uint32_t node)
{
    uint32_t support = e->support[e->support_begin[node]];
    const rsv_cell *cell = &e->cell[support / 4];
    float u, v;
    rsv_cell_corner(cell, (int)(support & 3), &u, &v);
    return rsv_surface_point_at(
        e->scene, e->face_triangle[cell->face], u, v, e->face_back[cell->face])
        .position;
}

/// Sum over rows of one region and columns of another of A_i G_ij.
static double exchange(const rows *r, bool (*receives)(rsv_vec3), bool (*sends)(rsv_vec3))
{
    size_t count = r->transport->row_count;
    rsv_rgb *exitance = calloc(count, sizeof *exitance), *e = calloc(count, sizeof *e);
    assert_true(exitance && e);
    for (uint32_t n = 0; n < count; n++)
        exitance[n] = rgb_gray(sends(node_place(r->elements, n)));
    rsv_transport_apply(r->transport, exitance, e);
    double sum = 0;
    for (uint32_t n = 0; n < count; n++)
        if (receives(node_place(r->elements, n))) sum += (double)e[n].g * r->elements->node_area[n];
    free(exitance);
    free(e);
    return sum;
}

static bool is_floor(rsv_vec3 p) { return p.y < 0.5f; }
static bool is_ceiling(rsv_vec3 p) { return p.y > 0.5f; }
static bool is_floor_corner(rsv_vec3 p) { return p.y < 0.5f && p.x < 0.4f && p.z < 0.4f; }
static bool is_ceiling_side(rsv_vec3 p) { return p.y > 0.5f && p.x > 0.5f; }

/// Form factor of directly opposed unit squares at distance 1 (closed form, e.g. Howell's catalogue C-11).
static void facing_squares_exchange_their_form_factor(void **state)
{
    (void)state;
    rows r = create_facing_squares();
    const double form_factor = 0.199824895698;
    // 80 rows of 1024 rays each would err by 0.7 % if the rays were independent; 4 standard errors of
    // what stratification leaves of it
    assert_close(exchange(&r, is_floor, is_ceiling), form_factor, 0.005 * form_factor);
    assert_close(exchange(&r, is_ceiling, is_floor), form_factor, 0.005 * form_factor);
    destroy_rows(&r);
}

static void exchange_is_reciprocal(void **state)
{
    (void)state;
    rows r = create_facing_squares();
    double there = exchange(&r, is_floor_corner, is_ceiling_side);
    double back = exchange(&r, is_ceiling_side, is_floor_corner);
    assert_true(there > 0.01);
    // 9 and 40 rows with a few per cent of 1024 rays each: at most 2 % without stratification
    assert_close(there, back, 0.04 * there);
    destroy_rows(&r);
}

static rows create_glass_room(int threads)
{
    world *w = world_begin(threads);
    rsv_material glass = glass_material();
    glass.base_color = rgb(0.9f, 0.7f, 0.5f);
    world_room(w, world_lambert(w, 0.5f, 1), v3(0, 0, 0), v3(1, 1, 1));
    world_sphere(w, world_material(w, glass), v3(0.5f, 0.5f, 0.5f), 0.3f, 2);
    return create_rows(w, 0.15f, 64);
}

static uint64_t hash_of_rows_with(int threads)
{
    rows r = create_glass_room(threads);
    assert_true(count_tinted(r.transport) > 0);
    uint64_t hash = hash_rows(r.transport);
    destroy_rows(&r);
    return hash;
}

static void rows_are_the_same_bytes_for_any_thread_count(void **state)
{
    (void)state;
    uint64_t one = hash_of_rows_with(1);
    assert_true(one == hash_of_rows_with(2));
    assert_true(one == hash_of_rows_with(3));
}

// ---- another representation -----------------------------------------------------------------------

/// A matrix with all its zeros.
typedef struct dense_rows {
    rsv_transport transport;
    uint32_t *column; ///< [row_count] 0, 1, ...
    rsv_rgb *weight;  ///< [row_count][row_count]
} dense_rows;

static void dense_destroy(rsv_transport *t)
{
    dense_rows *d = (dense_rows *)t;
    rsv_free(t->context, d->column);
    rsv_free(t->context, d->weight);
}

static rsv_transport_row dense_row(const rsv_transport *t, size_t row)
{
    const dense_rows *d = (const dense_rows *)t;
    return (rsv_transport_row){ .tinted_column = d->column,
        .tinted_weight = d->weight + row * t->row_count,
        .tinted_count = t->row_count };
}

static size_t dense_entries(const rsv_transport *t) { return t->row_count * t->row_count; }

static size_t dense_bytes(const rsv_transport *t) { return dense_entries(t) * sizeof(rsv_rgb); }

static rsv_status dense_complete(rsv_transport *t)
{
    (void)t;
    return RSV_OK; // in one process, all rows are there
}

static const rsv_transport_table dense_table = { dense_destroy, dense_row, rsv_gather_by_rows,
    rsv_residual_by_rows, dense_complete, dense_entries, dense_bytes };

static rsv_transport *make_dense(const rsv_transport *from)
{
    size_t count = from->row_count;
    dense_rows *d = rsv_alloc(from->context, 1, sizeof *d);
    d->transport =
        (rsv_transport){ .table = &dense_table, .context = from->context, .row_count = count };
    d->transport.scale = rsv_alloc(from->context, count, sizeof(float));
    d->column = rsv_alloc(from->context, count, sizeof *d->column);
    d->weight = rsv_alloc(from->context, count * count, sizeof *d->weight);
    for (size_t n = 0; n < count; n++) {
        rsv_transport_row row = rsv_transport_row_at(from, n);
        rsv_rgb *weight = d->weight + n * count;
        d->transport.scale[n] = from->scale[n];
        d->column[n] = (uint32_t)n;
        for (size_t k = 0; k < row.count; k++)
            weight[row.column[k]] = rgb_add(weight[row.column[k]], rgb_gray(1));
        for (size_t k = 0; k < row.tinted_count; k++)
            weight[row.tinted_column[k]] =
                rgb_add(weight[row.tinted_column[k]], row.tinted_weight[k]);
    }
    return &d->transport;
}

static void assert_same_field(const rsv_rgb *a, const rsv_rgb *b, size_t count)
{
    for (size_t n = 0; n < count; n++)
        assert_close(rgb_max(rgb_sub(a[n], b[n])), 0, 1e-5 + 1e-5 * (double)rgb_max(a[n]));
}

/// Transposed products of eleven fields are those of each. @param single that of `field`
static void assert_fields_are_apart(
    const rsv_transport_columns *columns, size_t count, const rsv_rgb *field, const rsv_rgb *single)
{
    enum { fields = 11 };
    rsv_rgb *all = calloc(fields * count, sizeof *all);
    rsv_rgb *scratch = calloc(fields * count, sizeof *scratch);
    rsv_rgb *product = calloc(fields * count, sizeof *product);
    assert_true(all && scratch && product);
    for (size_t k = 0; k < fields * count; k++)
        all[k] = rgb_scale(field[k / fields], ldexpf(1, (int)(k % fields)));
    rsv_transport_apply_transpose(columns, fields, all, scratch, product);
    for (size_t k = 0; k < fields * count; k++)
        product[k] = rgb_scale(product[k], ldexpf(1, -(int)(k % fields)));
    for (size_t k = 0; k < fields * count; k++)
        assert_memory_equal(&product[k], &single[k / fields], sizeof *product);
    free(all), free(scratch), free(product);
}

/// Products, transposed products and residuals access rows only through their table.
static void a_dense_matrix_stands_in_for_stored_rows(void **state)
{
    (void)state;
    rows r = create_glass_room(2);
    rsv_transport *t[2] = { r.transport, make_dense(r.transport) };
    size_t count = r.transport->row_count;
    rsv_rgb *field = calloc(count, sizeof *field), *scratch = calloc(count, sizeof *scratch);
    rsv_rgb *product[2], *transposed[2], *residual[2];
    assert_true(field && scratch);
    for (size_t n = 0; n < count; n++)
        field[n] = rgb(1 + (float)(n % 7), 2, (float)(n % 3));
    for (int k = 0; k < 2; k++) {
        rsv_transport_columns *columns;
        product[k] = calloc(count, sizeof *field);
        transposed[k] = calloc(count, sizeof *field);
        residual[k] = calloc(count, sizeof *field);
        assert_true(product[k] && transposed[k] && residual[k]);
        rsv_transport_gather(t[k], 1, field, 0, count, product[k]);
        rsv_transport_residual(t[k], 1, field, field, field, residual[k]);
        assert_int_equal(rsv_transport_columns_create(t[k], &columns), RSV_OK);
        rsv_transport_apply_transpose(columns, 1, field, scratch, transposed[k]);
        assert_fields_are_apart(columns, count, field, transposed[k]);
        rsv_transport_columns_destroy(columns);
    }
    assert_same_field(product[0], product[1], count);
    assert_same_field(residual[0], residual[1], count);
    assert_same_field(transposed[0], transposed[1], count);
    for (int k = 0; k < 2; k++)
        free(product[k]), free(transposed[k]), free(residual[k]);
    free(field), free(scratch);
    rsv_transport_destroy(t[1]);
    destroy_rows(&r);
}

/// Ends on split cells take another path than ends on the regular grid.
static void split_cells_receive_their_share(void **state)
{
    (void)state;
    world *w = world_begin(1);
    uint32_t white = world_lambert(w, 0.5f, 0);
    world_quad(w, white, v3(0, 0, 0), v3(0, 0, 1), v3(1, 0, 1), v3(1, 0, 0));
    world_quad(w, white, v3(0, 1, 0), v3(1, 1, 0), v3(1, 1, 1), v3(0, 1, 1));
    rows r = create_rows(w, 0.25f, 1024);
    uint8_t *split = calloc(r.elements->cell_count, 1);
    assert_non_null(split);
    for (size_t c = 0; c < r.elements->cell_count; c++)
        split[c] = c % 5 == 0;
    rsv_elements *finer;
    assert_int_equal(rsv_elements_refine(r.elements, split, &finer), RSV_OK);
    free(split);
    rsv_elements_destroy(r.elements);
    rsv_transport_destroy(r.transport);
    r.elements = finer;
    r.valid_points = realloc(r.valid_points, finer->node_count * sizeof *r.valid_points);
    assert_int_equal(
        rsv_find_buried(&w->transport, finer, (rsv_support_draw){ RSV_SUPPORT_POINTS, 1 }, NULL,
            r.valid_points, &r.rays),
        RSV_OK);
    assert_int_equal(rsv_transport_create(&(rsv_transport_desc){ &w->transport, w->lights, finer,
                                              r.valid_points, 1024, 1 },
                         &r.transport),
        RSV_OK);
    assert_close(exchange(&r, is_floor, is_ceiling), 0.199824895698, 0.002);
    destroy_rows(&r);
}

// ---- specular paths -------------------------------------------------------------------------------------

static bool no_emission(const void *user, uint32_t triangle, uint32_t events)
{
    (void)user, (void)triangle, (void)events;
    return false;
}

/// One gather specular path from a free point.
static rsv_gather gather_from(const world *w, rsv_vec3 origin, rsv_vec3 direction, uint32_t index)
{
    rsv_ray ray = { origin, direction, INFINITY };
    rsv_hit hit;
    assert_true(rsv_tracer_closest(w->tracer, &ray, &hit));
    rsv_random random = rsv_random_from(11, index, 0);
    rsv_specular_path path = rsv_specular_begin(&w->transport, NULL, direction, hit);
    return rsv_specular_gather(&w->transport, path, &random, no_emission, NULL);
}

static rsv_vec3 sphere_direction(uint32_t index)
{
    float x, y;
    rsv_sobol_2d(index, 5, &x, &y);
    return rsv_square_to_sphere(x, y);
}

/// Every specular path through clear glass ends on the wall with weight 1, by any route.
static void chains_through_clear_glass_keep_their_weight(void **state)
{
    (void)state;
    world *w = world_begin(1);
    uint32_t glass = world_material(w, glass_material());
    world_room(w, world_lambert(w, 0.5f, 0), v3(-1, -1, -1), v3(1, 1, 1));
    world_sphere(w, glass, v3(0, 0, 0), 0.4f, 3);
    world_box(w, glass, v3(-0.9f, 0.6f, -0.9f), v3(0.9f, 0.7f, 0.9f));
    world_commit(w);
    uint32_t bent = 0, count = 4000, lost = 0;
    for (uint32_t k = 0; k < count; k++) {
        rsv_gather gather = gather_from(w, v3(0.8f, 0.1f, 0.2f), sphere_direction(k), k);
        bent += gather.path.events > 0;
        if (gather.end != RSV_SPECULAR_DIFFUSE) {
            assert_true(gather.path.events >= RSV_SPECULAR_MAX_EVENTS); // trapped in the box
            lost++;
            continue;
        }
        assert_close(gather.path.weight.r, 1, 1e-4);
        assert_close(gather.path.weight.b, 1, 1e-4);
    }
    assert_true(bent > count / 10);
    assert_true(lost < count / 200);
    world_end(w);
}

/// A slab of thickness 0.1 m between a gatherer and a wall that takes everything.
static world *create_slab(rsv_rgb attenuation_color, float distance)
{
    world *w = world_begin(1);
    rsv_material glass = glass_material();
    glass.attenuation_color = attenuation_color;
    glass.attenuation_distance = distance;
    world_room(w, world_lambert(w, 0.5f, 0), v3(-5, -5, -1), v3(5, 5, 1));
    world_box(w, world_material(w, glass), v3(-4, -4, 0), v3(4, 4, 0.1f));
    world_commit(w);
    return w;
}

/// Mean weights of specular paths along -z that end beyond and before the slab.
static void measure_slab(const world *w, uint32_t count, double through[3], double back[3])
{
    memset(through, 0, 3 * sizeof *through);
    memset(back, 0, 3 * sizeof *back);
    for (uint32_t k = 0; k < count; k++) {
        rsv_gather gather = gather_from(w, v3(0.1f, 0.2f, 0.5f), v3(0, 0, -1), k);
        if (gather.end != RSV_SPECULAR_DIFFUSE) continue;
        double *sum = gather.path.direction.z < 0 ? through : back;
        sum[0] += gather.path.weight.r / count;
        sum[1] += gather.path.weight.g / count;
        sum[2] += gather.path.weight.b / count;
    }
}

/// With F = 0.04 per interface and a = exp(-sigma d) per crossing, the geometric series of the
/// reflections between the faces gives T = (1-F)^2 a / (1 - F^2 a^2), R = F + F (1-F)^2 a^2 / (1 - F^2 a^2).
static void a_slab_transmits_by_fresnel_and_beer_lambert(void **state)
{
    (void)state;
    const float color[3] = { 0.3f, 0.6f, 0.9f };
    const uint32_t count = 40000;
    world *w = create_slab(rgb(color[0], color[1], color[2]), 0.05f);
    double through[3], back[3];
    measure_slab(w, count, through, back);
    for (int c = 0; c < 3; c++) {
        double f = 0.04, a = pow(color[c], 0.1 / 0.05), pass = (1 - f) * (1 - f);
        double t = pass * a / (1 - f * f * a * a), r = f + f * pass * a * a / (1 - f * f * a * a);
        // weights lie in [0, 1 / a_max]; four standard errors of a Bernoulli variable, scaled
        assert_close(through[c], t, 4 * sqrt(t * (1 - t) / count) + 1e-4);
        assert_close(back[c], r, 4 * sqrt(r / count) + 1e-4);
    }
    world_end(w);
}

static void a_clear_slab_splits_light_and_loses_none(void **state)
{
    (void)state;
    world *w = create_slab(rgb_gray(1), INFINITY);
    double through[3], back[3];
    measure_slab(w, 20000, through, back);
    assert_close(through[0] + back[0], 1, 1e-4);
    assert_close(through[0], (1 - 0.04) / (1 + 0.04), 4 * sqrt(0.92 * 0.08 / 20000));
    world_end(w);
}

/// Trapped paths, each ended by Russian roulette.
typedef struct endings {
    double events; ///< of all paths after those that every path may have
    uint32_t count;
} endings;

/// A trapped path does not escape. Its weight after roulette makes up for the paths that ended before.
static void note_ending(endings *e, const rsv_gather *gather)
{
    assert_int_equal(gather->end, RSV_SPECULAR_ABSORBED);
    assert_true(gather->path.events >= RSV_SPECULAR_MAX_EVENTS);
    uint32_t beyond = gather->path.events - RSV_SPECULAR_MAX_EVENTS;
    assert_close(gather->path.weight.g * powf(RSV_SPECULAR_LONG_SURVIVAL, (float)beyond), 1, 1e-3);
    e->events += beyond;
    e->count++;
}

/// How often a path wins is distributed geometrically: both mean and standard deviation are s / (1 - s).
static void check_endings(const endings *e)
{
    double mean = (double)RSV_SPECULAR_LONG_SURVIVAL / (1 - (double)RSV_SPECULAR_LONG_SURVIVAL);
    assert_close(e->events / e->count, mean, 4 * mean / sqrt(e->count));
}

/// In a cube of index 1.5 a direction that meets all faces at more than 41.8 degrees is trapped for ever:
/// it must neither escape nor be followed without end.
static void total_internal_reflection_traps_light_and_ends(void **state)
{
    (void)state;
    world *w = world_begin(1);
    world_room(w, world_lambert(w, 0.5f, 0), v3(-3, -3, -3), v3(3, 3, 3));
    world_box(w, world_material(w, glass_material()), v3(-1, -1, -1), v3(1, 1, 1));
    world_commit(w);
    endings trapped = { 0 };
    for (uint32_t k = 0; k < 300; k++) {
        rsv_random random = rsv_random_from(17, k, 0);
        float a = 0.5f + 0.18f * rsv_random_float(&random),
              b = 0.5f + 0.18f * rsv_random_float(&random);
        float c = sqrtf(1 - a * a - b * b);
        assert_true(c < 0.745f); // cosine of the critical angle: 0.7454
        rsv_gather gather = gather_from(w, v3(0.1f, -0.2f, 0.3f), v3(a, -b, c), k);
        note_ending(&trapped, &gather);
    }
    check_endings(&trapped);
    world_end(w);
}

static void light_below_the_critical_angle_leaves(void **state)
{
    (void)state;
    world *w = world_begin(1);
    world_room(w, world_lambert(w, 0.5f, 0), v3(-3, -3, -3), v3(3, 3, 3));
    world_box(w, world_material(w, glass_material()), v3(-1, -1, -1), v3(1, 1, 1));
    world_commit(w);
    for (uint32_t k = 0; k < 200; k++) {
        rsv_gather gather =
            gather_from(w, v3(0.1f, -0.2f, 0.3f), v3_normalize(v3(0.2f, 0.1f, 1)), k);
        assert_int_equal(gather.end, RSV_SPECULAR_DIFFUSE);
        // radiance inside is denser by the square of the index
        assert_close(gather.path.weight.g, 2.25, 1e-4);
    }
    world_end(w);
}

static void paths_between_mirrors_end_by_roulette(void **state)
{
    (void)state;
    world *w = world_begin(1);
    uint32_t mirror = world_material(w, mirror_material(1));
    world_room(w, mirror, v3(-1, -1, -1), v3(1, 1, 1));
    world_commit(w);
    endings reflected = { 0 };
    for (uint32_t k = 0; k < 100; k++) {
        rsv_gather gather = gather_from(w, v3(0.1f, 0.2f, 0.3f), sphere_direction(k), k);
        note_ending(&reflected, &gather);
        assert_true(gather.path.rays <= gather.path.events + 1);
    }
    check_endings(&reflected);
    world_end(w);
}

// ---- light shooting -----------------------------------------------------------------------------

/// A narrow spot light of 1 W/sr at `position`.
static void add_spot(world *w, rsv_vec3 position, rsv_vec3 direction, float angle)
{
    rsv_punctual_light light = { .name = "spot",
        .kind = RSV_PUNCTUAL_SPOT,
        .position = position,
        .direction = v3_normalize(direction),
        .intensity = rgb(1, 2, 3),
        .outer_cone_angle = angle,
        .inner_cone_angle = angle };
    assert_int_equal(rsv_scene_add_light(w->scene, &light), RSV_OK);
}

/// Flux (W, red) of a spot of intensity 1 in a cone of half angle `angle`.
static double spot_flux(float angle) { return 2 * RSV_PI * (1 - cos(angle)); }

typedef struct shot {
    world *w;
    rsv_elements *elements;
    rsv_photon_map map;
    uint64_t rays;
} shot;

static shot shoot(world *w, float spacing, uint32_t count)
{
    shot s = { .w = w };
    world_commit(w);
    assert_int_equal(
        rsv_elements_create(w->scene, w->bsdf, &(rsv_spacing){ .metres = spacing }, &s.elements),
        RSV_OK);
    const rsv_elements *const target[1] = { s.elements };
    assert_int_equal(rsv_photons_shoot(&w->transport, w->lights, count, 1,
                         &(rsv_photon_targets){ target, &s.map, 1 }, &s.rays),
        RSV_OK);
    return s;
}

static void destroy_shot(shot *s)
{
    rsv_photon_map_destroy(&s->map);
    rsv_elements_destroy(s->elements);
    world_end(s->w);
}

/// Flux received below y = `height`.
static rsv_rgb received_below(const shot *s, float height)
{
    double sum[3] = { 0 };
    for (uint32_t n = 0; n < s->elements->node_count; n++) {
        if (s->elements->node_area[n] == 0 || node_place(s->elements, n).y >= height) continue;
        for (int c = 0; c < 3; c++)
            sum[c] += (double)s->map.flux[n][c] * s->map.unit;
    }
    return rgb((float)sum[0], (float)sum[1], (float)sum[2]);
}

/// A spot that looks along x into a mirror at 45 degrees, above a floor.
static world *floor_below_mirror(void)
{
    world *w = world_begin(2);
    world_quad(
        w, world_lambert(w, 0.5f, 0), v3(-3, 0, -3), v3(-3, 0, 3), v3(3, 0, 3), v3(3, 0, -3));
    world_quad(w, world_material(w, mirror_material(1)), v3(-0.5f, 0.5f, -1), v3(0.5f, 1.5f, -1),
        v3(0.5f, 1.5f, 1), v3(-0.5f, 0.5f, 1));
    add_spot(w, v3(2, 1, 0), v3(-1, 0, 0), 0.1f);
    return w;
}

/// One shooter for many rounds: each round finds the same as a new shooter would, and no pilot ray is traced again.
static void a_shooter_may_be_used_again(void **state)
{
    (void)state;
    enum { count = 4096 };
    shot own = shoot(floor_below_mirror(), 0.5f, count);
    const rsv_elements *const target[1] = { own.elements };
    const world *w = own.w;
    rsv_photon_shooter *shooter = NULL;
    uint64_t pilot = 0;
    assert_int_equal(
        rsv_photon_shooter_create(&w->transport, w->lights, 1, NULL, &shooter, &pilot), RSV_OK);
    for (int round = 0; round < 2; round++) {
        rsv_photon_map map;
        uint64_t rays = 0;
        assert_int_equal(
            rsv_photons_deposit(shooter, count, &(rsv_photon_targets){ target, &map, 1 }, &rays),
            RSV_OK);
        assert_memory_equal(map.flux, own.map.flux, own.elements->node_count * sizeof *map.flux);
        assert_int_equal(rays + pilot, own.rays);
        rsv_photon_map_destroy(&map);
    }
    rsv_photon_shooter_destroy(shooter);
    rsv_photon_shooter_destroy(NULL);
    destroy_shot(&own);
}

/// All of its light is thrown onto the floor.
static void an_ideal_mirror_passes_all_flux_on(void **state)
{
    (void)state;
    const float angle = 0.1f;
    world *w = floor_below_mirror();
    shot s = shoot(w, 0.3f, 40000);
    rsv_rgb received = received_below(&s, 0.1f);
    // unguided photons (a tenth) and the guide's noise in density: 0.2 % standard error, four of them
    assert_close(received.r, spot_flux(angle), 0.008 * spot_flux(angle));
    assert_close(received.b, 3 * spot_flux(angle), 0.008 * 3 * spot_flux(angle));
    destroy_shot(&s);
}

static void a_clear_slab_passes_flux_times_transmittance(void **state)
{
    (void)state;
    const float angle = 0.03f;
    world *w = world_begin(2);
    world_quad(
        w, world_lambert(w, 0.5f, 0), v3(-3, 0, -3), v3(-3, 0, 3), v3(3, 0, 3), v3(3, 0, -3));
    world_box(w, world_material(w, glass_material()), v3(-1, 1, -1), v3(1, 1.1f, 1));
    add_spot(w, v3(0.1f, 2, 0.05f), v3(0, -1, 0), angle);
    shot s = shoot(w, 0.3f, 40000);
    rsv_rgb received = received_below(&s, 0.1f);
    double expected = spot_flux(angle) * (1 - 0.04) / (1 + 0.04);
    // 92 % of 36,000 guided photons arrive: 0.16 % standard error, four of them
    assert_close(received.r, expected, 0.007 * expected);
    assert_close(received.g, 2 * expected, 0.007 * 2 * expected);
    assert_close(received.b, 3 * expected, 0.007 * 3 * expected);
    destroy_shot(&s);
}

static uint64_t hash_of_photons_with(int threads)
{
    world *w = world_begin(threads);
    world_room(w, world_lambert(w, 0.5f, 0), v3(0, 0, 0), v3(1, 1, 1));
    world_sphere(w, world_material(w, glass_material()), v3(0.5f, 0.4f, 0.5f), 0.2f, 2);
    uint32_t lamp = world_lambert(w, 0, 5);
    world_quad(w, lamp, v3(0.4f, 0.99f, 0.4f), v3(0.6f, 0.99f, 0.4f), v3(0.6f, 0.99f, 0.6f),
        v3(0.4f, 0.99f, 0.6f));
    shot s = shoot(w, 0.2f, 20000);
    assert_true(received_below(&s, 0.5f).r > 0);
    uint64_t hash = hash_bytes(HASH_START, s.map.flux, s.elements->node_count * sizeof *s.map.flux);
    hash = hash_bytes(hash, s.map.hits, s.elements->node_count * sizeof *s.map.hits);
    destroy_shot(&s);
    return hash;
}

static void photons_are_the_same_bytes_for_any_thread_count(void **state)
{
    (void)state;
    uint64_t one = hash_of_photons_with(1);
    assert_true(one == hash_of_photons_with(2));
    assert_true(one == hash_of_photons_with(3));
}

static void a_scene_without_specular_surfaces_shoots_no_photons(void **state)
{
    (void)state;
    for (int specular = 0; specular < 2; specular++) {
        world *w = world_begin(1);
        world_quad(
            w, world_lambert(w, 0.5f, 0), v3(-3, 0, -3), v3(-3, 0, 3), v3(3, 0, 3), v3(3, 0, -3));
        if (specular) world_sphere(w, world_material(w, glass_material()), v3(0, 1, 0), 0.3f, 1);
        add_spot(w, v3(0, 2, 0), v3(0, -1, 0), 0.5f);
        world_commit(w);
        assert_int_equal(rsv_photons_wanted(&w->transport, w->lights), specular);
        world_end(w);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_packet_of_directions_lies_in_one_cell),
        cmocka_unit_test(directions_are_cosine_distributed),
        cmocka_unit_test(rows_of_a_closed_room_sum_to_one),
        cmocka_unit_test(rows_of_a_room_with_mirror_and_glass_sum_to_one),
        cmocka_unit_test(no_row_sums_to_more_than_one),
        cmocka_unit_test(facing_squares_exchange_their_form_factor),
        cmocka_unit_test(exchange_is_reciprocal),
        cmocka_unit_test(rows_are_the_same_bytes_for_any_thread_count),
        cmocka_unit_test(a_dense_matrix_stands_in_for_stored_rows),
        cmocka_unit_test(split_cells_receive_their_share),
        cmocka_unit_test(chains_through_clear_glass_keep_their_weight),
        cmocka_unit_test(a_slab_transmits_by_fresnel_and_beer_lambert),
        cmocka_unit_test(a_clear_slab_splits_light_and_loses_none),
        cmocka_unit_test(total_internal_reflection_traps_light_and_ends),
        cmocka_unit_test(light_below_the_critical_angle_leaves),
        cmocka_unit_test(paths_between_mirrors_end_by_roulette),
        cmocka_unit_test(a_shooter_may_be_used_again),
        cmocka_unit_test(an_ideal_mirror_passes_all_flux_on),
        cmocka_unit_test(a_clear_slab_passes_flux_times_transmittance),
        cmocka_unit_test(photons_are_the_same_bytes_for_any_thread_count),
        cmocka_unit_test(a_scene_without_specular_surfaces_shoots_no_photons),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
