#include "gltf_geometry.h"

#include "../core/core.h"
#include "gltf_accessor.h"

#include <string.h>

/// State while a primitive is read.
typedef struct reading {
    rsv_context *context;
    const rsv_gltf_document *document;
    const rsv_gltf_primitive *primitive;
    rsv_gltf_weights weights;
    const char *owner;
} reading;

void rsv_gltf_release_geometry(rsv_context *context, rsv_gltf_geometry *g)
{
    rsv_free(context, g->position);
    rsv_free(context, g->normal);
    rsv_free(context, g->uv[0]);
    rsv_free(context, g->uv[1]);
    rsv_free(context, g->tangent);
    rsv_free(context, g->color);
    rsv_free(context, g->index);
    *g = (rsv_gltf_geometry){ 0 };
}

rsv_gltf_weights rsv_gltf_weights_of(const rsv_gltf_document *document, const rsv_gltf_node *node)
{
    const rsv_gltf_mesh *mesh = &document->mesh[node->mesh];
    if (node->weight) return (rsv_gltf_weights){ node->weight, node->weight_count };
    return (rsv_gltf_weights){ mesh->weight, mesh->weight_count };
}

// ---- attributes -----------------------------------------------------------------------------------

/// One attribute, by its accessors.
typedef struct attribute {
    const char *what; ///< for messages
    int accessor;
    size_t least_width, most_width;
} attribute;

/// @param width out: how many floats each vertex has
static rsv_status read_attribute(
    const reading *r, attribute a, size_t vertex_count, float **values, size_t *width)
{
    rsv_gltf_attribute read;
    rsv_status status =
        rsv_gltf_read_attribute(r->context, r->document, a.accessor, r->owner, &read);
    if (status != RSV_OK) return status;
    *values = read.values;
    *width = read.width;
    if (*width < a.least_width || *width > a.most_width)
        return rsv_fail(RSV_ERROR_FORMAT, "mesh '%s': accessor %d must hold VEC%zu%s as %s",
            r->owner, a.accessor, a.least_width, a.least_width < a.most_width ? " or VEC4" : "",
            a.what);
    if (read.count != vertex_count)
        return rsv_fail(RSV_ERROR_FORMAT, "mesh '%s': accessor %d holds %zu %s for %zu positions",
            r->owner, a.accessor, read.count, a.what, vertex_count);
    return RSV_OK;
}

/// Adds a morph target's offsets, times its weight, to the first components of each vertex.
static rsv_status add_target(
    const reading *r, attribute a, float weight, size_t vertex_count, float *values, size_t width)
{
    float *change = NULL;
    size_t change_width = 0;
    if (a.accessor < 0 || weight == 0) return RSV_OK;
    rsv_status status = read_attribute(r, a, vertex_count, &change, &change_width);
    size_t shared = change_width < width ? change_width : width;
    for (size_t i = 0; status == RSV_OK && i < vertex_count; i++)
        for (size_t k = 0; k < shared; k++)
            values[i * width + k] += weight * change[i * change_width + k];
    rsv_free(r->context, change);
    return status;
}

/// Returns the target's accessor for an attribute.
typedef int (*accessor_of)(const rsv_gltf_target *target);

static int target_position(const rsv_gltf_target *t) { return t->position; }
static int target_normal(const rsv_gltf_target *t) { return t->normal; }
static int target_tangent(const rsv_gltf_target *t) { return t->tangent; }
static int target_uv0(const rsv_gltf_target *t) { return t->uv[0]; }
static int target_uv1(const rsv_gltf_target *t) { return t->uv[1]; }
static int target_color(const rsv_gltf_target *t) { return t->color; }

/// An attribute with its morph targets; absent ones stay NULL.
static rsv_status read_morphed(
    const reading *r, attribute a, accessor_of in_target, size_t vertex_count, float **values)
{
    size_t width;
    attribute change = a;
    if (a.accessor < 0) return RSV_OK;
    rsv_status status = read_attribute(r, a, vertex_count, values, &width);
    if (change.least_width == 4) change.least_width = change.most_width = 3; // tangents, not sides
    for (size_t t = 0; t < r->primitive->target_count && status == RSV_OK; t++) {
        change.accessor = in_target(&r->primitive->target[t]);
        status = add_target(r, change, t < r->weights.count ? r->weights.value[t] : 0, vertex_count,
            *values, width);
    }
    return status;
}

/// Colours of vertices have three components or four.
static rsv_status read_colors(const reading *r, bool opaque, rsv_gltf_geometry *g)
{
    rsv_status status = RSV_OK;
    const rsv_gltf_primitive *p = r->primitive;
    float *values = NULL;
    if (p->color < 0) return RSV_OK;
    RSV_TRY(read_morphed(
        r, (attribute){ "colours", p->color, 3, 4 }, target_color, g->vertex_count, &values));
    size_t width = (size_t)r->document->accessor[p->color].component_count;
    g->color = rsv_alloc(r->context, g->vertex_count, 4 * sizeof *g->color);
    if (!g->color) status = RSV_ERROR_MEMORY;
    for (size_t i = 0; g->color && i < 4 * g->vertex_count; i++) {
        size_t k = i % 4;
        g->color[i] = k < 3 || (width == 4 && !opaque) ? values[i / 4 * width + k] : 1;
    }
cleanup:
    rsv_free(r->context, values);
    return status;
}

static rsv_status read_positions(const reading *r, rsv_gltf_geometry *g)
{
    int accessor = r->primitive->position;
    g->vertex_count =
        (size_t)accessor < r->document->accessor_count ? r->document->accessor[accessor].count : 0;
    return read_morphed(r, (attribute){ "positions", accessor, 3, 3 }, target_position,
        g->vertex_count, (float **)&g->position);
}

static rsv_status read_vertices(const reading *r, rsv_gltf_geometry *g)
{
    rsv_status status;
    const rsv_gltf_primitive *p = r->primitive;
    const accessor_of target_uv[2] = { target_uv0, target_uv1 };
    bool opaque = p->material < 0 || r->document->material[p->material].opaque;
    RSV_TRY(read_positions(r, g));
    RSV_TRY(read_morphed(r, (attribute){ "normals", p->normal, 3, 3 }, target_normal,
        g->vertex_count, (float **)&g->normal));
    for (int set = 0; set < 2; set++)
        RSV_TRY(read_morphed(r, (attribute){ "texture coordinates", p->uv[set], 2, 2 },
            target_uv[set], g->vertex_count, &g->uv[set]));
    RSV_TRY(read_morphed(r, (attribute){ "tangents", p->tangent, 4, 4 }, target_tangent,
        g->vertex_count, &g->tangent));
    RSV_TRY(read_colors(r, opaque, g));
cleanup:
    return status;
}

// ---- triangles ------------------------------------------------------------------------------------

/// Turns a strip or fan into separate triangles; both keep the winding of the specification.
static rsv_status unroll(const reading *r, rsv_gltf_geometry *g)
{
    size_t triangle_count = g->index_count < 3 ? 0 : g->index_count - 2;
    uint32_t *list = rsv_alloc(r->context, triangle_count, 3 * sizeof *list);
    if (!list) return RSV_ERROR_MEMORY;
    for (size_t t = 0; t < triangle_count; t++) {
        size_t strip[3] = { t, t + 1 + t % 2, t + 2 - t % 2 }, fan[3] = { t + 1, t + 2, 0 };
        const size_t *corner = r->primitive->mode == RSV_GLTF_TRIANGLE_STRIP ? strip : fan;
        for (int k = 0; k < 3; k++)
            list[3 * t + k] = g->index ? g->index[corner[k]] : (uint32_t)corner[k];
    }
    rsv_free(r->context, g->index);
    g->index = list;
    g->index_count = 3 * triangle_count;
    return RSV_OK;
}

static rsv_status read_indices(const reading *r, rsv_gltf_geometry *g)
{
    rsv_status status = RSV_OK;
    rsv_gltf_indices read = { NULL, g->vertex_count };
    if (r->primitive->indices >= 0)
        RSV_TRY(rsv_gltf_read_indices(
            r->context, r->document, r->primitive->indices, r->owner, g->vertex_count, &read));
    g->index = read.index;
    g->index_count = read.count;
    if (g->vertex_count >= RSV_NONE)
        return rsv_fail(RSV_ERROR_UNSUPPORTED, "mesh '%s': too many vertices", r->owner);
    if (r->primitive->mode != RSV_GLTF_TRIANGLES) RSV_TRY(unroll(r, g));
cleanup:
    return status;
}

rsv_status rsv_gltf_read_geometry(rsv_context *context, const rsv_gltf_document *document,
    const rsv_gltf_primitive *primitive, rsv_gltf_weights weights, const char *owner,
    rsv_gltf_geometry *geometry)
{
    const reading r = { context, document, primitive, weights, owner };
    rsv_status status = read_vertices(&r, geometry);
    return status == RSV_OK ? read_indices(&r, geometry) : status;
}
