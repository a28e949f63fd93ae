/// Assembly of G: gather rays from every node's support to the diffuse ends of their chains.
#include "directions.h"
#include "receiver_points.h"
#include "transport.h"

#include <string.h>

#define LANES RSV_SUPPORT_POINTS
#define ROWS_PER_BLOCK 64
/// Blocks that are traced before their rows move to the operator: enough to keep all threads busy to the end.
#define BLOCKS_PER_THREAD 64

/// The receiver points of one node and what holds for the node as a whole.
typedef struct receiver {
    rsv_receiver_points points;
    const rsv_bsdf *bsdf;
    rsv_medium medium;
    bool tints; ///< even what comes from plain surfaces: through a coat or a medium
} receiver;

/// One side of a triangle as the end of a ray, in eight bytes: what process_hits needs of it.
typedef struct ray_target {
    uint32_t face;
    uint16_t side; ///< cells along an edge of the face's grid
    uint8_t kind;
} ray_target;

enum { TARGET_BLACK, TARGET_LAMBERT, TARGET_CHAIN, TARGET_SKY };

/// What the rays of one row found.
typedef struct row_scratch {
    uint32_t *column; ///< [rays] RSV_NONE = nothing
    uint32_t tinted_count;
    uint32_t *tinted_column; ///< [rays]
    rsv_rgb *tinted_weight;
    rsv_escape_row escapes;
    rsv_rgb emission;
    uint64_t rays;
} row_scratch;

/// Rows on their way to the operator.
typedef struct row_block {
    uint32_t *column, *tinted_column;
    rsv_rgb *tinted_weight;
    size_t count, tinted_count;
    size_t column_capacity, tinted_column_capacity, tinted_weight_capacity;
    rsv_escape_list escapes;
} row_block;

typedef struct assembly {
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    const rsv_elements *elements;
    const uint16_t *valid_points;
    ray_target *target; ///< [2 * triangle_count] front and back of each triangle
    rsv_directions directions;
    rsv_transport *transport;
    uint32_t seed;
    row_scratch *scratch; ///< [threads]
    row_block *block;     ///< [wave_size]
    size_t block_count, wave_size;
    size_t entries, tinted_entries; ///< in the operator
} assembly;

static void set_up_receiver(const assembly *a, uint32_t node, receiver *r)
{
    rsv_receiver_points *p = &r->points;
    rsv_receiver_points_set_up(a->elements, node, a->seed, p);
    uint32_t face = a->elements->node_face[node];
    uint32_t material = a->scene->view->triangle_material[a->elements->face_triangle[face]];
    // one of the points speaks for the medium of all
    uint32_t k = a->valid_points[node] ? (uint32_t)__builtin_ctz(a->valid_points[node]) : 0;
    r->bsdf = &a->scene->bsdf[material];
    r->medium =
        rsv_medium_above(&a->scene->media, v3(p->origin_x[k], p->origin_y[k], p->origin_z[k]),
            v3(p->geometric_x[k], p->geometric_y[k], p->geometric_z[k]));
    r->tints = r->bsdf->coated || rsv_medium_absorbs(&r->medium, a->scene->bsdf);
}

/// Light of gathered sources counts however it arrives; that of the others is the business of
/// next-event estimation and light shooting.
static bool counts_by_gathering(const void *user, uint32_t triangle, uint32_t events)
{
    (void)events;
    const rsv_lights *lights = user;
    uint32_t emitter = lights->triangle_emitter[triangle];
    return emitter != RSV_NONE && lights->group[lights->emitter[emitter].group].gathered;
}

static void record_end(
    const assembly *a, row_scratch *s, uint32_t ray, const rsv_chain *chain, float random)
{
    uint32_t face = a->elements->face_of[chain->back][chain->triangle];
    if (face == RSV_NONE) return;
    float weight[3];
    uint32_t cell = rsv_elements_locate(a->elements, face, chain->u, chain->v, weight);
    uint32_t node = rsv_elements_pick_node(a->elements, cell, weight, random);
    rsv_rgb w = chain->weight;
    if (fabsf(w.r - 1) + fabsf(w.g - 1) + fabsf(w.b - 1) < 1e-4f) {
        s->column[ray] = node;
        return;
    }
    s->tinted_column[s->tinted_count] = node;
    s->tinted_weight[s->tinted_count++] = w;
}

/// The general case: specular surfaces, coats, emission.
static void follow_chain(const assembly *a, row_scratch *s, uint32_t node, uint32_t ray,
    const receiver *r, float cos_receiver, const rsv_ray_packet *packet, int k)
{
    rsv_random random = rsv_random_from(a->seed ^ 0x51ed270bu, node, ray);
    rsv_vec3 direction = v3(packet->direction_x[k], packet->direction_y[k], packet->direction_z[k]);
    rsv_chain chain = rsv_chain_begin(a->scene, &r->medium, direction, packet->triangle[k],
        packet->u[k], packet->v[k], packet->t_max[k]);
    chain.weight = rgb_mul(chain.weight, rsv_bsdf_entry(r->bsdf, cos_receiver));
    rsv_gather gather = rsv_chain_gather(a->scene, chain, &random, counts_by_gathering, a->lights);
    s->emission = rgb_add(s->emission, gather.emission);
    s->rays += gather.chain.rays;
    if (gather.end == RSV_CHAIN_DIFFUSE)
        record_end(a, s, ray, &gather.chain, rsv_random_float(&random));
    else if (gather.end == RSV_CHAIN_ESCAPED)
        rsv_escape_row_add(&s->escapes, gather.chain.direction, gather.chain.weight, 1);
}

/// Where sixteen rays ended on the grids of their faces, in arithmetic without branches.
typedef struct grid_places {
    _Alignas(64) float side[LANES], u[LANES], v[LANES];
    _Alignas(64) int32_t index[LANES], corner[LANES];
} grid_places;

static void place_on_grids(grid_places *g, uint32_t stream)
{
    for (int k = 0; k < LANES; k++) {
        float x = g->u[k] * g->side[k], y = g->v[k] * g->side[k];
        int32_t side = (int32_t)g->side[k], j = (int32_t)y, i = (int32_t)x;
        j = j > side - 1 ? side - 1 : j;
        i = i > side - 1 - j ? side - 1 - j : i;
        float fx = x - (float)i, fy = y - (float)j;
        int32_t flipped = (fx + fy > 1) & (i + j < side - 1);
        float b0 = flipped ? fx + fy - 1 : 1 - fx - fy, b1 = flipped ? 1 - fx : fx;
        float random = rsv_unit_float(rsv_hash(stream + (uint32_t)k));
        g->index[k] = j * (2 * side - j) + 2 * i + flipped;
        g->corner[k] = (random >= b0) + (random >= b0 + b1);
    }
}

static ray_target hit_target(const assembly *a, const rsv_ray_packet *packet, int k)
{
    uint32_t triangle = packet->triangle[k];
    if (triangle == RSV_NONE)
        return (ray_target){ .kind = packet->t_max[k] > 0 ? TARGET_SKY : TARGET_BLACK };
    bool back = packet->normal_x[k] * packet->direction_x[k] +
                    packet->normal_y[k] * packet->direction_y[k] +
                    packet->normal_z[k] * packet->direction_z[k] >
                0;
    return a->target[2 * (size_t)triangle + back];
}

static void record_sky(
    row_scratch *s, const receiver *r, float cos_receiver, const rsv_ray_packet *packet, int k)
{
    rsv_vec3 direction = v3(packet->direction_x[k], packet->direction_y[k], packet->direction_z[k]);
    rsv_escape_row_add(&s->escapes, direction, rsv_bsdf_entry(r->bsdf, cos_receiver), 0);
}

static void process_hits(const assembly *a, row_scratch *s, uint32_t node, uint32_t first_ray,
    const receiver *r, const float *cos_receiver, const rsv_ray_packet *packet)
{
    const rsv_elements *e = a->elements;
    grid_places g;
    ray_target target[LANES];
    for (int k = 0; k < LANES; k++) {
        target[k] = hit_target(a, packet, k);
        g.side[k] = target[k].side;
        bool used = target[k].kind == TARGET_LAMBERT; // other lanes may hold anything
        g.u[k] = used ? packet->u[k] : 0;
        g.v[k] = used ? packet->v[k] : 0;
    }
    uint32_t stream = rsv_hash2(a->seed, node) + first_ray;
    place_on_grids(&g, stream);
    for (int k = 0; k < LANES; k++) {
        uint32_t ray = first_ray + (uint32_t)k;
        if (target[k].kind == TARGET_BLACK) continue;
        if (target[k].kind == TARGET_SKY) {
            record_sky(s, r, cos_receiver[k], packet, k);
            continue;
        }
        if (target[k].kind == TARGET_CHAIN || r->tints) {
            follow_chain(a, s, node, ray, r, cos_receiver[k], packet, k);
            continue;
        }
        uint32_t slot = e->slot[e->face_slot[target[k].face] + (uint32_t)g.index[k]];
        if (slot & RSV_SLOT_SPLIT) {
            float weight[3], random = rsv_unit_float(rsv_hash(stream + (uint32_t)k));
            uint32_t cell =
                rsv_elements_locate(e, target[k].face, packet->u[k], packet->v[k], weight);
            s->column[ray] = rsv_elements_pick_node(e, cell, weight, random);
        } else {
            s->column[ray] = e->cell_node[slot][g.corner[k]];
        }
    }
}

static void trace_row(const assembly *a, uint32_t node, row_scratch *s)
{
    receiver r;
    set_up_receiver(a, node, &r);
    uint32_t rays = a->directions.count;
    memset(s->column, 0xff, rays * sizeof *s->column);
    s->tinted_count = 0;
    s->escapes.count = s->escapes.tinted_count = 0;
    s->emission = rgb_gray(0);
    size_t set = rsv_directions_of(&a->directions, a->seed, node);
    rsv_ray_packet packet = { 0 };
    memset(packet.mask, 0xff, sizeof packet.mask);
    for (uint32_t first = 0; first < rays; first += LANES) {
        const float *z = a->directions.z + set + first;
        rsv_receiver_points_aim(&r.points, a->valid_points[node], a->directions.x + set + first,
            a->directions.y + set + first, z, &packet);
        rsv_tracer_closest_packet(a->scene->tracer, &packet, false);
        process_hits(a, s, node, first, &r, z, &packet);
    }
    s->rays += rays;
}

static rsv_status reserve_row(rsv_context *context, row_block *block, size_t count, size_t tinted)
{
    rsv_status status;
    RSV_TRY(rsv_grow(context, (void **)&block->column, &block->column_capacity,
        block->count + count, sizeof *block->column));
    RSV_TRY(rsv_grow(context, (void **)&block->tinted_column, &block->tinted_column_capacity,
        block->tinted_count + tinted, sizeof *block->tinted_column));
    RSV_TRY(rsv_grow(context, (void **)&block->tinted_weight, &block->tinted_weight_capacity,
        block->tinted_count + tinted, sizeof *block->tinted_weight));
cleanup:
    return status;
}

static rsv_status store_row(assembly *a, uint32_t node, const row_scratch *s, row_block *block)
{
    rsv_transport *t = a->transport;
    uint32_t rays = a->directions.count;
    rsv_status status = reserve_row(t->context, block, rays, s->tinted_count);
    if (status != RSV_OK) return status;
    size_t first = block->count;
    for (uint32_t ray = 0; ray < rays; ray++)
        if (s->column[ray] != RSV_NONE) block->column[block->count++] = s->column[ray];
    for (uint32_t k = 0; k < s->tinted_count; k++) {
        block->tinted_column[block->tinted_count] = s->tinted_column[k];
        block->tinted_weight[block->tinted_count++] = s->tinted_weight[k];
    }
    t->row_begin[node + 1] = block->count - first; // summed up in the end
    t->tinted_begin[node + 1] = s->tinted_count;
    int points = __builtin_popcount(a->valid_points[node]);
    t->scale[node] = (float)LANES / ((float)rays * (float)points);
    t->gathered[node] = rgb_scale(s->emission, RSV_PI * t->scale[node]);
    if (!a->scene->view->environment) return RSV_OK; // nobody will ask where rays escaped to
    return rsv_escapes_store(t->context, &t->escapes, node, &s->escapes, &block->escapes);
}

static rsv_status create_scratch(rsv_context *context, uint32_t rays, row_scratch *s)
{
    s->column = rsv_alloc(context, rays, sizeof *s->column);
    s->tinted_column = rsv_alloc(context, rays, sizeof *s->tinted_column);
    s->tinted_weight = rsv_alloc(context, rays, sizeof *s->tinted_weight);
    bool complete = s->column && s->tinted_column && s->tinted_weight;
    return complete ? rsv_escape_row_create(context, rays, &s->escapes) : RSV_ERROR_MEMORY;
}

static void destroy_scratch(rsv_context *context, row_scratch *s)
{
    rsv_free(context, s->column);
    rsv_free(context, s->tinted_column);
    rsv_free(context, s->tinted_weight);
    rsv_escape_row_destroy(context, &s->escapes);
}

static rsv_status trace_block(assembly *a, size_t index, row_scratch *scratch, row_block *block)
{
    size_t begin = index * ROWS_PER_BLOCK, end = begin + ROWS_PER_BLOCK;
    if (end > a->elements->node_count) end = a->elements->node_count;
    for (size_t node = begin; node < end; node++) {
        if (a->valid_points[node] == 0) continue; // hanging or buried
        trace_row(a, (uint32_t)node, scratch);
        rsv_status status = store_row(a, (uint32_t)node, scratch, block);
        if (status != RSV_OK) return status;
    }
    return RSV_OK;
}

static rsv_status trace_wave(assembly *a, size_t first)
{
    rsv_context *context = a->transport->context;
    size_t end = first + a->wave_size < a->block_count ? first + a->wave_size : a->block_count;
    rsv_status result = RSV_OK;
    size_t done = first;
#pragma omp parallel for schedule(dynamic, 1) num_threads(rsv_threads(context))
    for (size_t index = first; index < end; index++) {
        rsv_status status = RSV_OK;
        if (!rsv_cancelled(context))
            status =
                trace_block(a, index, &a->scratch[rsv_thread_index()], &a->block[index - first]);
        size_t finished;
#pragma omp atomic capture
        finished = ++done;
        if (rsv_thread_index() == 0)
            rsv_progress(context, "assemble", (double)finished / (double)a->block_count);
        if (status != RSV_OK) {
#pragma omp critical
            result = status;
        }
    }
    return result;
}

/// Moves the rows of a block behind those of all blocks before.
static rsv_status append_block(assembly *a, row_block *block)
{
    rsv_transport *t = a->transport;
    if (block->count)
        memcpy(t->column + a->entries, block->column, block->count * sizeof *t->column);
    if (block->tinted_count) {
        memcpy(t->tinted_column + a->tinted_entries, block->tinted_column,
            block->tinted_count * sizeof *t->tinted_column);
        memcpy(t->tinted_weight + a->tinted_entries, block->tinted_weight,
            block->tinted_count * sizeof *t->tinted_weight);
    }
    a->entries += block->count;
    a->tinted_entries += block->tinted_count;
    block->count = block->tinted_count = 0;
    return rsv_escapes_append(t->context, &t->escapes, &block->escapes);
}

static void sum_up_rows(rsv_transport *t)
{
    for (size_t row = 0; row < t->row_count; row++) {
        t->row_begin[row + 1] += t->row_begin[row];
        t->tinted_begin[row + 1] += t->tinted_begin[row];
    }
    rsv_escapes_finish(&t->escapes, t->row_count);
}

static rsv_status trace_all(assembly *a)
{
    rsv_context *context = a->transport->context;
    rsv_status status = RSV_OK;
    for (size_t first = 0; first < a->block_count; first += a->wave_size) {
        RSV_TRY(trace_wave(a, first));
        RSV_TRY(rsv_cancelled(context) ? rsv_progress(context, "assemble", 1) : RSV_OK);
        for (size_t k = 0; k < a->wave_size; k++)
            RSV_TRY(append_block(a, &a->block[k]));
    }
    sum_up_rows(a->transport);
    for (int thread = 0; thread < rsv_threads(context); thread++)
        a->transport->rays += a->scratch[thread].rays;
    RSV_TRY(rsv_progress(context, "assemble", 1));
cleanup:
    if (status == RSV_ERROR_MEMORY)
        return rsv_fail(status, "out of memory assembling the operator");
    return status;
}

/// Room for rows of `rays` entries each; what they do not fill is never touched.
static rsv_status create_empty(const rsv_elements *elements, const uint16_t *valid_points,
    uint32_t rays, rsv_transport **transport)
{
    rsv_context *context = elements->context;
    size_t rows = elements->node_count, most = 0;
    rsv_transport *t = *transport = rsv_alloc(context, 1, sizeof *t);
    if (!t) return RSV_ERROR_MEMORY;
    for (size_t row = 0; row < rows; row++)
        most += valid_points[row] ? rays : 0;
    t->context = context;
    t->row_count = rows;
    t->row_begin = rsv_alloc(context, rows + 1, sizeof *t->row_begin);
    t->column = rsv_reserve(context, most, sizeof *t->column);
    t->tinted_begin = rsv_alloc(context, rows + 1, sizeof *t->tinted_begin);
    t->tinted_column = rsv_reserve(context, most, sizeof *t->tinted_column);
    t->tinted_weight = rsv_reserve(context, most, sizeof *t->tinted_weight);
    t->scale = rsv_alloc(context, rows, sizeof *t->scale);
    t->gathered = rsv_alloc(context, rows, sizeof *t->gathered);
    bool complete = t->row_begin && t->column && t->tinted_begin && t->tinted_column &&
                    t->tinted_weight && t->scale && t->gathered;
    return complete ? rsv_escapes_create(context, rows, &t->escapes) : RSV_ERROR_MEMORY;
}

static rsv_status create_workers(assembly *a)
{
    rsv_context *context = a->elements->context;
    size_t threads = (size_t)rsv_threads(context);
    rsv_status status = RSV_OK;
    a->wave_size = BLOCKS_PER_THREAD * threads;
    a->block = rsv_alloc(context, a->wave_size, sizeof *a->block);
    a->scratch = rsv_alloc(context, threads, sizeof *a->scratch);
    if (!a->block || !a->scratch) return RSV_ERROR_MEMORY;
    for (size_t thread = 0; thread < threads && status == RSV_OK; thread++)
        status = create_scratch(context, a->directions.count, &a->scratch[thread]);
    return status;
}

static void destroy_workers(assembly *a)
{
    rsv_context *context = a->elements->context;
    for (int thread = 0; a->scratch && thread < rsv_threads(context); thread++)
        destroy_scratch(context, &a->scratch[thread]);
    for (size_t k = 0; a->block && k < a->wave_size; k++) {
        rsv_free(context, a->block[k].column);
        rsv_free(context, a->block[k].tinted_column);
        rsv_free(context, a->block[k].tinted_weight);
        rsv_escape_list_destroy(context, &a->block[k].escapes);
    }
    rsv_free(context, a->block);
    rsv_free(context, a->scratch);
}

static rsv_status create_targets(assembly *a)
{
    const rsv_scene_view *view = a->scene->view;
    const rsv_elements *e = a->elements;
    a->target = rsv_alloc(e->context, 2 * view->triangle_count, sizeof *a->target);
    if (!a->target) return RSV_ERROR_MEMORY;
    for (size_t side = 0; side < 2 * view->triangle_count; side++) {
        const rsv_bsdf *bsdf = &a->scene->bsdf[view->triangle_material[side / 2]];
        uint32_t face = e->face_of[side & 1][side / 2];
        bool back = side & 1, opaque_back = back && !bsdf->double_sided &&
                                            bsdf->transmission == 0 && bsdf->opacity == 1;
        bool plain = bsdf->lambert && bsdf->opacity == 1 && face != RSV_NONE &&
                     (!bsdf->emissive || !counts_by_gathering(a->lights, (uint32_t)(side / 2), 0));
        a->target[side].kind = opaque_back ? TARGET_BLACK : plain ? TARGET_LAMBERT : TARGET_CHAIN;
        if (face == RSV_NONE) continue;
        a->target[side].face = face;
        a->target[side].side = (uint16_t)(1u << e->face_level[face]);
    }
    return RSV_OK;
}

rsv_status rsv_transport_create(const rsv_transport_scene *scene, const rsv_lights *lights,
    const rsv_elements *elements, const uint16_t *valid_points, uint32_t rays, uint32_t seed,
    rsv_transport **transport)
{
    rsv_context *context = elements->context;
    rsv_status status;
    assembly a = { .scene = scene,
        .lights = lights,
        .elements = elements,
        .valid_points = valid_points,
        .seed = seed,
        .block_count = (elements->node_count + ROWS_PER_BLOCK - 1) / ROWS_PER_BLOCK };
    RSV_TRY(rsv_directions_create(context, rays, seed, &a.directions));
    RSV_TRY(create_targets(&a));
    RSV_TRY(create_empty(elements, valid_points, rays, &a.transport));
    RSV_TRY(create_workers(&a));
    RSV_TRY(trace_all(&a));
    *transport = a.transport;
    a.transport = NULL;
cleanup:
    rsv_transport_destroy(a.transport);
    destroy_workers(&a);
    rsv_free(context, a.target);
    rsv_directions_destroy(&a.directions);
    return status;
}
