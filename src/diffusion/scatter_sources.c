#include "scatter_sources.h"

#include "../core/index_map.h"
#include "../core/parallel.h"
#include "../elements/elements.h"

#include <stdlib.h>
#include <string.h>

#define LEAF_CELLS 4

static uint64_t body_key(const rsv_elements *e, uint32_t face)
{
    uint32_t triangle = e->face_triangle[face];
    uint64_t object = e->scene->triangle_object[triangle];
    return (object << 33) | ((uint64_t)e->scene->triangle_material[triangle] << 1) |
           e->face_back[face];
}

static rsv_status find_bodies(rsv_scatter_sources *s)
{
    const rsv_elements *e = s->elements;
    rsv_index_map bodies = { 0 };
    size_t capacity = 0;
    rsv_status status;
    RSV_TRY(rsv_index_map_create(s->context, 64, &bodies));
    for (uint32_t face = 0; face < e->face_count; face++) {
        const rsv_material *m =
            &e->scene->material[e->scene->triangle_material[e->face_triangle[face]]];
        s->face_body[face] = RSV_NONE;
        if (!rsv_material_scatters_below(m)) continue;
        uint32_t body = rsv_index_map_insert(&bodies, body_key(e, face), (uint32_t)s->body_count);
        if (body == UINT32_MAX) RSV_TRY(RSV_ERROR_MEMORY);
        if (body == s->body_count) {
            RSV_TRY(rsv_grow(
                s->context, (void **)&s->body, &capacity, s->body_count + 1, sizeof *s->body));
            s->body[s->body_count++] = (rsv_scatter_body){ .profile = rsv_scatter_profile_of(m) };
        }
        s->face_body[face] = body;
        s->body[body].area += (double)e->face_area[face];
    }
cleanup:
    rsv_index_map_destroy(&bodies);
    return status;
}

/// Counting sort of the cells by body.
static rsv_status list_cells(rsv_scatter_sources *s)
{
    const rsv_elements *e = s->elements;
    for (size_t c = 0; c < e->cell_count; c++) {
        uint32_t body = s->face_body[e->cell[c].face];
        if (body != RSV_NONE) s->body[body].cell_count++;
    }
    for (size_t b = 0; b < s->body_count; b++) {
        s->body[b].first_cell = (uint32_t)s->cell_count;
        s->cell_count += s->body[b].cell_count;
        s->body[b].cell_count = 0;
    }
    s->cell = rsv_alloc(s->context, s->cell_count, sizeof *s->cell);
    s->corner = rsv_alloc(s->context, s->cell_count, sizeof *s->corner);
    s->cluster = rsv_alloc(s->context, 2 * s->cell_count, sizeof *s->cluster);
    if (!s->cell || !s->corner || !s->cluster) return RSV_ERROR_MEMORY;
    for (size_t c = 0; c < e->cell_count; c++) {
        uint32_t body = s->face_body[e->cell[c].face];
        if (body == RSV_NONE) continue;
        s->cell[s->body[body].first_cell + s->body[body].cell_count++] = (uint32_t)c;
    }
    return RSV_OK;
}

rsv_vec3 rsv_scatter_corner(const rsv_elements *e, uint32_t cell, int k)
{
    float u, v;
    rsv_cell_corner(&e->cell[cell], k, &u, &v);
    const uint32_t *corner = e->scene->triangle[e->face_triangle[e->cell[cell].face]];
    return v3_barycentric(e->scene->position[corner[0]], e->scene->position[corner[1]],
        e->scene->position[corner[2]], u, v);
}

rsv_vec3 rsv_scatter_centroid(const rsv_vec3 corner[3])
{
    return v3_scale(v3_add(v3_add(corner[0], corner[1]), corner[2]), 1.0f / 3);
}

static float axis_of(rsv_vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

/// A cell while the tree is being built.
typedef struct placed_cell {
    rsv_vec3 centre;
    uint32_t cell;
} placed_cell;

static int compare_x(const void *a, const void *b)
{
    const placed_cell *p = a, *q = b;
    return p->centre.x != q->centre.x ? (p->centre.x > q->centre.x) - (p->centre.x < q->centre.x)
                                      : (p->cell > q->cell) - (p->cell < q->cell);
}
static int compare_y(const void *a, const void *b)
{
    const placed_cell *p = a, *q = b;
    return p->centre.y != q->centre.y ? (p->centre.y > q->centre.y) - (p->centre.y < q->centre.y)
                                      : (p->cell > q->cell) - (p->cell < q->cell);
}
static int compare_z(const void *a, const void *b)
{
    const placed_cell *p = a, *q = b;
    return p->centre.z != q->centre.z ? (p->centre.z > q->centre.z) - (p->centre.z < q->centre.z)
                                      : (p->cell > q->cell) - (p->cell < q->cell);
}

static int longest_axis(const placed_cell *cells, uint32_t count)
{
    rsv_vec3 low = cells[0].centre, high = low;
    for (uint32_t k = 1; k < count; k++) {
        low = v3_min(low, cells[k].centre);
        high = v3_max(high, cells[k].centre);
    }
    rsv_vec3 size = v3_sub(high, low);
    float longest = v3_max_abs(size);
    return axis_of(size, 0) == longest ? 0 : axis_of(size, 1) == longest ? 1 : 2;
}

/// Splits at the median, along the longest axis, down to a few cells.
static void build_cluster(
    rsv_scatter_sources *s, placed_cell *cells, uint32_t first, uint32_t count)
{
    static int (*const compare[3])(
        const void *, const void *) = { compare_x, compare_y, compare_z };
    rsv_scatter_cluster *c = &s->cluster[s->cluster_count++];
    *c = (rsv_scatter_cluster){ .first_cell = first, .cell_count = count };
    if (count <= LEAF_CELLS) return;
    qsort(cells + first, count, sizeof *cells, compare[longest_axis(cells + first, count)]);
    build_cluster(s, cells, first, count / 2);
    c->right = (uint32_t)s->cluster_count;
    build_cluster(s, cells, first + count / 2, count - count / 2);
}

/// Sums over the cells of a cluster: area, and its first moments.
static void find_centre(const rsv_scatter_sources *s, rsv_scatter_cluster *c)
{
    double x = 0, y = 0, z = 0, area = 0;
    for (uint32_t k = c->first_cell; k < c->first_cell + c->cell_count; k++) {
        double own = (double)rsv_cell_area(s->elements, s->cell[k]);
        rsv_vec3 p = rsv_scatter_centroid(s->corner[k]);
        x += own * (double)p.x, y += own * (double)p.y, z += own * (double)p.z, area += own;
    }
    c->area = (float)area;
    c->centre = area > 0 ? v3((float)(x / area), (float)(y / area), (float)(z / area))
                         : s->corner[c->first_cell][0];
}

static void measure_cluster(const rsv_scatter_sources *s, rsv_scatter_cluster *c)
{
    find_centre(s, c);
    double spread = 0;
    rsv_vec3 normal = v3(0, 0, 0);
    for (uint32_t k = c->first_cell; k < c->first_cell + c->cell_count; k++) {
        const rsv_vec3 *corner = s->corner[k];
        rsv_vec3 cross = v3_cross(v3_sub(corner[1], corner[0]), v3_sub(corner[2], corner[0]));
        rsv_vec3 middle = v3_sub(rsv_scatter_centroid(corner), c->centre);
        float squares = 9 * v3_dot(middle, middle);
        for (int i = 0; i < 3; i++) {
            rsv_vec3 arm = v3_sub(corner[i], c->centre);
            c->radius = f_max(c->radius, v3_length(arm));
            squares += v3_dot(arm, arm);
        }
        // the mean of a quadratic over a triangle is that of its corners and, nine times, its centroid
        spread += (double)(rsv_cell_area(s->elements, s->cell[k]) * squares) / 12;
        normal = v3_mad(normal, 0.5f, cross);
    }
    if (!(c->area > 0)) return;
    c->spread = (float)(spread / (double)c->area);
    c->normal = v3_scale(normal, 1 / c->area);
}

static void measure_clusters(void *job, rsv_span span)
{
    rsv_scatter_sources *s = job;
    for (size_t c = span.begin; c < span.end; c++)
        measure_cluster(s, &s->cluster[c]);
}

static rsv_status build_trees(rsv_scatter_sources *s)
{
    const rsv_elements *e = s->elements;
    placed_cell *cells = rsv_alloc(s->context, s->cell_count, sizeof *cells);
    if (!cells) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < s->cell_count; k++) {
        rsv_vec3 corner[3];
        for (int i = 0; i < 3; i++)
            corner[i] = rsv_scatter_corner(e, s->cell[k], i);
        cells[k] = (placed_cell){ rsv_scatter_centroid(corner), s->cell[k] };
    }
    for (size_t b = 0; b < s->body_count; b++) {
        s->body[b].root = (uint32_t)s->cluster_count;
        build_cluster(s, cells, s->body[b].first_cell, s->body[b].cell_count);
    }
    for (size_t k = 0; k < s->cell_count; k++) {
        s->cell[k] = cells[k].cell;
        for (int i = 0; i < 3; i++)
            s->corner[k][i] = rsv_scatter_corner(e, s->cell[k], i);
    }
    rsv_free(s->context, cells);
    rsv_parallel_for(s->context, s->cluster_count, 64, measure_clusters, s);
    return RSV_OK;
}

uint32_t rsv_scatter_body_of(const rsv_scatter_sources *s, uint32_t node)
{
    uint32_t face = s->elements->node_face[node]; // RSV_NONE in the air
    return face == RSV_NONE ? RSV_NONE : s->face_body[face];
}

static rsv_rgb leaf_mean(
    const rsv_scatter_sources *s, const rsv_scatter_cluster *c, const rsv_rgb *value)
{
    rsv_rgb sum = rgb_gray(0);
    for (uint32_t k = c->first_cell; k < c->first_cell + c->cell_count; k++) {
        const uint32_t *node = s->elements->cell_node[s->cell[k]];
        rsv_rgb all = rgb_add(rgb_add(value[node[0]], value[node[1]]), value[node[2]]);
        sum = rgb_mad(sum, rsv_cell_area(s->elements, s->cell[k]) / 3, all);
    }
    return rgb_scale(sum, c->area > 0 ? 1 / c->area : 0);
}

void rsv_scatter_collect(const rsv_scatter_sources *s, rsv_rgb *value)
{
    rsv_rgb *mean = value + s->elements->node_count;
    for (size_t i = s->cluster_count; i-- > 0;) { // children come after their parents
        const rsv_scatter_cluster *c = &s->cluster[i];
        if (c->right == 0) {
            mean[i] = leaf_mean(s, c, value);
            continue;
        }
        float left = s->cluster[i + 1].area, right = s->cluster[c->right].area;
        float share = left + right > 0 ? left / (left + right) : 0;
        mean[i] = rgb_mad(rgb_scale(mean[i + 1], share), 1 - share, mean[c->right]);
    }
}

static void spread_leaf(
    const rsv_scatter_sources *s, const rsv_scatter_cluster *c, rsv_rgb mean, rsv_rgb *weight)
{
    float share = c->area > 0 ? 1 / c->area : 0;
    for (uint32_t k = c->first_cell; k < c->first_cell + c->cell_count; k++)
        for (int corner = 0; corner < 3; corner++) {
            rsv_rgb *node = &weight[s->elements->cell_node[s->cell[k]][corner]];
            *node = rgb_mad(*node, share * rsv_cell_area(s->elements, s->cell[k]) / 3, mean);
        }
}

void rsv_scatter_collect_transpose(const rsv_scatter_sources *s, rsv_rgb *weight)
{
    rsv_rgb *mean = weight + s->elements->node_count;
    for (size_t i = 0; i < s->cluster_count; i++) {
        const rsv_scatter_cluster *c = &s->cluster[i];
        if (c->right == 0) {
            spread_leaf(s, c, mean[i], weight);
            continue;
        }
        float left = s->cluster[i + 1].area, right = s->cluster[c->right].area;
        float share = left + right > 0 ? left / (left + right) : 0;
        mean[i + 1] = rgb_mad(mean[i + 1], share, mean[i]);
        mean[c->right] = rgb_mad(mean[c->right], 1 - share, mean[i]);
    }
}

rsv_status rsv_scatter_sources_create(const rsv_elements *elements, rsv_scatter_sources **sources)
{
    rsv_status status;
    rsv_scatter_sources *s = rsv_alloc(elements->context, 1, sizeof *s);
    *sources = NULL;
    if (!s) return RSV_ERROR_MEMORY;
    s->context = elements->context;
    s->elements = elements;
    s->face_body = rsv_alloc(s->context, elements->face_count, sizeof *s->face_body);
    if (!s->face_body) {
        status = RSV_ERROR_MEMORY;
        goto cleanup;
    }
    RSV_TRY(find_bodies(s));
    if (s->body_count == 0) goto cleanup;
    RSV_TRY(list_cells(s));
    RSV_TRY(build_trees(s));
    *sources = s;
    s = NULL;
cleanup:
    rsv_scatter_sources_destroy(s);
    return status;
}

void rsv_scatter_sources_destroy(rsv_scatter_sources *s)
{
    if (!s) return;
    rsv_free(s->context, s->body);
    rsv_free(s->context, s->face_body);
    rsv_free(s->context, s->cell);
    rsv_free(s->context, s->corner);
    rsv_free(s->context, s->cluster);
    rsv_free(s->context, s);
}
