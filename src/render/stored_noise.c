#include "stored_noise.h"

#include "../core/parallel.h"
#include "../elements/curvature.h"

/// Added to local levels, so that these become constant and deviations are absolute.
#define FLOOR 1e12f
/// Largest spectral radius that is believed: more would make any reading worthless.
#define MOST_RADIUS 0.99

/// Squared departures of a field.
typedef struct departures {
    const rsv_elements *elements;
    rsv_rgb *square; ///< [node_count] around each node, r: sum, g: how many
    float *largest;  ///< [cell_count] of each cell's own edges; NULL = not needed
} departures;

static void note(void *user, uint32_t cell, uint32_t other, float bend)
{
    const departures *d = user;
    const uint32_t around[2] = { cell, other };
    float departure = bend * FLOOR;
    for (int side = 0; side < 2; side++)
        for (int k = 0; k < 3; k++) {
            rsv_rgb *square = &d->square[d->elements->cell_node[around[side]][k]];
            square->r += departure * departure;
            square->g += 1;
        }
    for (int side = 0; d->largest && side < 2; side++) {
        float *largest = &d->largest[around[side]];
        *largest = f_max(*largest, departure * departure);
    }
}

/// Adds the variances of a field's nodes to `variance`. @param largest see departures
static rsv_status add_variance(
    const rsv_elements *e, const rsv_rgb *field, rsv_rgb *square, rsv_rgb *variance, float *largest)
{
    departures d = { e, square, largest };
    for (size_t n = 0; n < e->node_count; n++)
        square[n] = rgb_gray(0);
    // an edge without any departure counts too: no node is then more certain than it looks
    const rsv_curvature_field curvature = { field, NULL, -1, FLOOR, NULL };
    rsv_status status = rsv_find_curved_edges(e, &curvature, RSV_CURVED_EDGES, note, &d);
    for (size_t n = 0; n < e->node_count; n++)
        if (square[n].g > 0) variance[n].r += square[n].r / (4 * square[n].g);
    return status;
}

static rsv_status find_stored(const rsv_light_view *s, rsv_stored_noise *noise)
{
    const rsv_elements *e = s->elements;
    size_t nodes = e->node_count;
    rsv_status status = RSV_ERROR_MEMORY;
    double area = 0;
    rsv_rgb *field = rsv_alloc(s->context, nodes, sizeof *field);
    rsv_rgb *square = rsv_alloc(s->context, nodes, sizeof *square);
    rsv_rgb *coarse = rsv_alloc(s->context, nodes, sizeof *coarse);
    noise->stored = rsv_alloc(s->context, nodes, sizeof *noise->stored);
    if (!field || !square || !coarse || !noise->stored) goto cleanup;
    for (size_t n = 0; n < nodes; n++)
        field[n] = rgb_add(s->indirect[n], s->gathered[n]);
    RSV_TRY(add_variance(e, field, square, noise->stored, NULL));
    RSV_TRY(add_variance(e, s->irradiance, square, coarse, NULL));
    for (size_t n = 0; n < rsv_elements_surface_nodes(e); n++) {
        noise->coarse += e->node_area[n] * coarse[n].r;
        noise->light += (double)(e->node_area[n] * rgb_luminance(field[n]));
        area += e->node_area[n];
        noise->nodes += e->node_area[n] > 0;
    }
    if (area > 0) noise->coarse /= area, noise->light /= area;
cleanup:
    rsv_free(s->context, field);
    rsv_free(s->context, square);
    rsv_free(s->context, coarse);
    return status;
}

/// Variance of a field of its own. @param variance out
static rsv_status find_variance(
    const rsv_elements *e, const rsv_rgb *field, rsv_field_noise *variance)
{
    rsv_status status = RSV_ERROR_MEMORY;
    rsv_rgb *square = rsv_alloc(e->context, e->node_count, sizeof *square);
    variance->node = rsv_alloc(e->context, e->node_count, sizeof *variance->node);
    variance->cell = rsv_alloc(e->context, e->cell_count, sizeof *variance->cell);
    if (square && variance->node && variance->cell)
        status = add_variance(e, field, square, variance->node, variance->cell);
    for (size_t c = 0; status == RSV_OK && c < e->cell_count; c++)
        variance->cell[c] /= 8;
    rsv_free(e->context, square);
    return status;
}

static void free_variance(rsv_context *context, rsv_field_noise *variance)
{
    rsv_free(context, variance->node);
    rsv_free(context, variance->cell);
}

/// At the edge of a shadow only the cells that it crosses are wrong, and nodes average over many more. Where noise is
/// all there is, the largest of three squares is twice their mean, and the larger of the two estimates up to half too
/// large.
static double variance_at(
    const rsv_elements *e, const rsv_field_noise *variance, uint32_t face, float u, float v)
{
    float weight[3];
    uint32_t cell = rsv_elements_locate(e, face, u, v, weight);
    double around = (double)rsv_elements_interpolate(e, variance->node, face, u, v).r;
    return fmax(around, (double)variance->cell[cell]);
}

/// The elements that hold direct light.
static const rsv_elements *lit_elements(const rsv_light_view *s)
{
    return s->fine.direct ? s->fine.elements : s->elements;
}

/// Number of photons that a node of the coarse elements has caught, from its noise: in the mean of squares, hat
/// functions count each by half.
static double photons_of(double variance, double light)
{
    return variance > 0 ? 0.5 * light * light / variance : INFINITY;
}

typedef struct coarse_noise {
    const rsv_light_view *solution;
    const rsv_rgb *coarse; ///< variance of photons on the coarse elements
    rsv_rgb *variance;     ///< of photons on the fine ones: in and out
} coarse_noise;

/// Nodes with few photons are blended towards the coarse elements (rsv_photon_map_shrink), whose noise is only visible
/// on those.
static void add_coarse_noise(void *user, rsv_span span)
{
    const coarse_noise *job = user;
    const rsv_light_view *s = job->solution;
    const rsv_elements *e = s->caustics.elements;
    const rsv_rgb *coarse = job->coarse;
    rsv_rgb *variance = job->variance;
    for (size_t n = span.begin; n < span.end; n++) {
        uint32_t face;
        float u, v, weight[3];
        rsv_elements_place_node(e, (uint32_t)n, &face, &u, &v);
        uint32_t cell = rsv_elements_locate(s->elements, face, u, v, weight);
        const uint32_t *node = s->elements->cell_node[cell];
        double noise = 0, light = 0, area = 0;
        for (int k = 0; k < 3; k++) {
            double w = (double)weight[k];
            noise += w * (double)coarse[node[k]].r;
            light += w * (double)rgb_luminance(s->caustics.coarse_caustic[node[k]]);
            area += w * s->elements->node_area[node[k]];
        }
        double photons = area > 0 ? photons_of(noise, light) * e->node_area[n] / area : INFINITY;
        double drawn = isfinite(photons) ? RSV_PHOTON_PRIOR / (photons + RSV_PHOTON_PRIOR) : 0;
        variance[n].r += (float)(drawn * drawn * noise);
    }
}

static rsv_status find_caustic(const rsv_light_view *s, rsv_stored_noise *noise)
{
    rsv_field_noise coarse = { 0 };
    rsv_status status = find_variance(s->caustics.elements, s->caustics.caustic, &noise->caustic);
    if (status == RSV_OK && s->caustics.coarse_caustic)
        status = find_variance(s->elements, s->caustics.coarse_caustic, &coarse);
    coarse_noise job = { s, coarse.node, noise->caustic.node };
    if (status == RSV_OK && coarse.node)
        rsv_parallel_for(s->context, s->caustics.elements->node_count, 0, add_coarse_noise, &job);
    free_variance(s->context, &coarse);
    return status;
}

rsv_status rsv_stored_noise_create(const rsv_light_view *s, bool direct, rsv_stored_noise *noise)
{
    rsv_status status;
    double radius = fmin(fmax(s->report.spectral_radius, 0), MOST_RADIUS);
    *noise = (rsv_stored_noise){ .solution = s, .reflected = radius / (1 - radius) };
    RSV_TRY(find_stored(s, noise));
    if (s->caustics.caustic) RSV_TRY(find_caustic(s, noise));
    if (direct)
        RSV_TRY(find_variance(
            lit_elements(s), s->fine.direct ? s->fine.direct : s->source, &noise->direct));
cleanup:
    if (status != RSV_OK) rsv_stored_noise_destroy(noise);
    return status;
}

void rsv_stored_noise_destroy(rsv_stored_noise *noise)
{
    if (!noise->solution) return;
    rsv_free(noise->solution->context, noise->stored);
    free_variance(noise->solution->context, &noise->caustic);
    free_variance(noise->solution->context, &noise->direct);
    *noise = (rsv_stored_noise){ 0 };
}

double rsv_stored_noise_at(
    const rsv_stored_noise *noise, uint32_t face, float u, float v, bool caustic)
{
    const rsv_light_view *s = noise->solution;
    double variance = 0;
    if (noise->caustic.node)
        variance += variance_at(s->caustics.elements, &noise->caustic, face, u, v);
    if (caustic) return variance;
    if (noise->direct.node) variance += variance_at(lit_elements(s), &noise->direct, face, u, v);
    return variance + rsv_elements_interpolate(s->elements, noise->stored, face, u, v).r;
}

/// Contribution of one node to its sums.
typedef struct node_share {
    uint32_t sum;
    float amount; ///< with its sign
} node_share;

static node_share share_of(uint32_t node, float share)
{
    uint32_t hash = rsv_hash(node);
    return (node_share){ hash % RSV_NOISE_SUMS, hash >> 31 ? -share : share };
}

static void add_nodes(float sum[RSV_NOISE_SUMS], const rsv_elements *e, const rsv_rgb *variance,
    uint32_t cell, const float share[3])
{
    for (int k = 0; k < 3; k++) {
        uint32_t node = e->cell_node[cell][k];
        node_share s = share_of(node, share[k]);
        sum[s.sum] += s.amount * sqrtf(variance[node].r);
    }
}

void rsv_shared_noise_add(
    rsv_shared_noise *sums, const rsv_stored_noise *noise, const rsv_stored_lookup *found)
{
    const rsv_light_view *s = noise->solution;
    const rsv_elements *level[2] = { s->elements, s->caustics.elements };
    sums->all += (double)found->share;
    sums->light += (double)(found->share * found->light);
    for (int k = 0; k < (noise->caustic.node ? 2 : 1); k++) {
        float weight[3];
        uint32_t cell = rsv_elements_locate(level[k], found->face, found->u, found->v, weight);
        for (int corner = 0; corner < 3; corner++)
            weight[corner] *= found->share;
        add_nodes(k ? sums->caustic : sums->stored, level[k],
            k ? noise->caustic.node : noise->stored, cell, weight);
    }
}

static double total_square(const float sum[RSV_NOISE_SUMS])
{
    double total = 0;
    for (int k = 0; k < RSV_NOISE_SUMS; k++)
        total += (double)sum[k] * (double)sum[k];
    return total;
}

/// Error of interpolation that is the same all over a scene, relative to the light: deviations of either sign do not
/// show it.
#define COMMON_ERROR 1e-3

/// Light seen over that of the whole scene: a dark room gets this share of the scene's light only, and of its noise.
static double share_of_scene(const rsv_shared_noise *sums, const rsv_stored_noise *noise)
{
    double whole = noise->light * sums->all;
    return sums->light < whole ? sums->light / whole : 1;
}

/// The first reflection uses the nodes it comes from; further ones use all nodes equally.
double rsv_shared_noise_variance(const rsv_shared_noise *sums, const rsv_stored_noise *noise)
{
    double further = noise->reflected * sums->all, share = share_of_scene(sums, noise);
    double common = noise->nodes > 0 ? (2 * sums->all + further) * further / noise->nodes : 0;
    double bias = COMMON_ERROR * sums->light;
    return total_square(sums->stored) + total_square(sums->caustic) +
           share * share * common * noise->coarse + bias * bias;
}
