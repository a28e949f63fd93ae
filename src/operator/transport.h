/// The propagation operator G on elements: the fraction of the exitance of each element that arrives at each other one,
/// along any specular path.
///
/// Row i contains the ends of its gather rays. Rays are cosine-distributed, so all have the same weight. An end without
/// colour is only an element index, with the weight 1 / (rays of the row). Ends of specular paths through coloured
/// glass or metal also have an RGB factor. Without coats and tints, row sums are at most 1, because a ray ends once:
/// energy is conserved by construction. With them, this holds on average over the rays, and a row can exceed 1 by its
/// sampling noise. Rows of receivers in another medium than their ends also have the factor (index of the start / index
/// of the end)^2, which can be above 1: the conserved quantity is L / n^2.
#ifndef RSV_TRANSPORT_H
#define RSV_TRANSPORT_H

#include "../elements/elements.h"
#include "../sources/lights.h"
#include "../specular/escapes.h"
#include "../specular/specular_path.h"
#include "division.h"

typedef struct rsv_transport rsv_transport;

/// The entries of one row, borrowed from its storage.
typedef struct rsv_transport_row {
    const uint32_t *column;        ///< [count] ends of weight 1
    const uint32_t *tinted_column; ///< [tinted_count]
    const rsv_rgb *tinted_weight;  ///< [tinted_count]
    size_t count, tinted_count;
} rsv_transport_row;

/// Storage of rows: as traced (rows_stored.c), or any other that offers these functions. Products ignore rows of other
/// processes.
typedef struct rsv_transport_table {
    /// Frees everything except the fields of rsv_transport.
    void (*destroy)(rsv_transport *transport);
    /// Borrowed data is valid until the next call by the same thread.
    rsv_transport_row (*row)(const rsv_transport *transport, size_t row);
    /// As rsv_transport_gather and rsv_transport_residual; rsv_gather_by_rows and rsv_residual_by_rows will do.
    void (*gather)(const rsv_transport *transport, size_t fields, const rsv_rgb *exitance,
        size_t begin, size_t end, rsv_rgb *irradiance);
    void (*residual)(const rsv_transport *transport, size_t fields, const rsv_rgb *exitance,
        const rsv_rgb *source, const rsv_rgb *irradiance, rsv_rgb *residual);
    /// Brings the rows of all processes here; called where there are others.
    rsv_status (*complete)(rsv_transport *transport);
    size_t (*entries)(const rsv_transport *transport); ///< of the rows that are here
    size_t (*bytes)(const rsv_transport *transport);   ///< that they take
} rsv_transport_table;

/// Data of rows that does not depend on their storage.
struct rsv_transport {
    const rsv_transport_table *table;
    rsv_context *context;
    size_t row_count;
    float *scale;        ///< [row_count] 1 / rays of the row that count; 0 = hanging or buried
    rsv_rgb *gathered;   ///< [row_count] irradiance emitted by sources that are found by gathering
    rsv_escapes escapes; ///< of the rays that left the scene
    uint64_t rays;
    uint64_t kept_rays;    ///< of these, known from an earlier version of the scene
    size_t kept_rows;      ///< rows of which none was traced
    double spared_seconds; ///< by that, about
    /// Division of the rows among processes: other processes' rows are empty here, except `scale` and `gathered`. NULL
    /// = all rows are here
    rsv_division *division;
};

/// For plug-ins too, which call no functions of the library.
RSV_INLINE rsv_transport_row rsv_transport_row_at(const rsv_transport *transport, size_t row)
{
    return transport->table->row(transport, row);
}

/// Input for tracing rows; borrowed.
typedef struct rsv_transport_desc {
    const rsv_transport_scene *scene; ///< with data from an earlier version (update)
    const rsv_lights *lights;         ///< select the emitters that rows gather
    const rsv_elements *elements;
    const uint16_t *
        valid_points; ///< [node_count] from rsv_find_buried with RSV_SUPPORT_POINTS points and the seed
    uint32_t rays; ///< per row, a power of two >= 16
    uint32_t seed;
} rsv_transport_desc;

/// Traces the rows of all free nodes that are not buried; in a team, those of this process's part. Products with fields
/// come out whole in all of them all the same.
rsv_status rsv_transport_create(const rsv_transport_desc *desc, rsv_transport **transport);

/// Cost of rays in the ray tracer alone.
typedef struct rsv_ray_cost {
    uint64_t rays;
    double packet_seconds, single_seconds; ///< in packets and one by one, divided by the threads
} rsv_ray_cost;

/// Traces the first-hit rays of all rows without using the results: the minimum cost of rsv_transport_create.
rsv_status rsv_transport_trace_only(const rsv_transport_desc *desc, rsv_ray_cost *cost);

void rsv_transport_destroy(rsv_transport *transport);

/// irradiance = G exitance, both [row_count]; rows of hanging and buried nodes come out 0.
void rsv_transport_apply(
    const rsv_transport *transport, const rsv_rgb *exitance, rsv_rgb *irradiance);

/// Irradiance from an environment with the given radiance in each bin (rsv_escape_radiance): the environment's part of
/// E0, without the sampled part.
/// @param irradiance [row_count]; 0 for hanging and buried nodes
void rsv_transport_environment(
    const rsv_transport *transport, const rsv_rgb *bin_radiance, rsv_rgb *irradiance);

/// Estimated standard deviation of the luminance of each row of G exitance, from the spread of its rays.
/// @param bin_radiance of the surroundings, whose light counts too
/// @param deviation [row_count]; 0 for rows that come out 0
void rsv_transport_deviation(const rsv_transport *transport, const rsv_rgb *exitance,
    const rsv_rgb *bin_radiance, float *deviation);

/// Gives all processes the rows of all others, for algorithms that need columns or rows in turn.
rsv_status rsv_transport_complete(rsv_transport *transport);

/// Of the rows that are here.
size_t rsv_transport_entries(const rsv_transport *transport);

/// Memory that all of it takes.
size_t rsv_transport_bytes(const rsv_transport *transport);

#endif
