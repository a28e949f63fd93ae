/// @file operator.h
/// The light-transport operator G K of a scene: for each pair of elements, the fraction of the light arriving at one that
/// arrives at the other next. It is computed once and then constant, while lights (solve.h) are created and destroyed.
///
/// Fields are [element_count] RGB values, in W/m2 if they are irradiances. All of these functions are thread-safe.
#ifndef RESOLVENT_OPERATOR_H
#define RESOLVENT_OPERATOR_H

#include "resolvent/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A virtual receiver: casts no shadow. A point on a surface is taken to be on the side its normal
/// points to.
typedef struct rsv_probe {
    rsv_vec3 position;
    rsv_vec3 normal; ///< normalised by the callee
} rsv_probe;

/// Counted: whoever retains one releases it, and each light of it keeps it alive.
typedef struct rsv_operator rsv_operator;

RSV_API rsv_operator *rsv_operator_retain(rsv_operator *transport);
RSV_API void rsv_operator_release(rsv_operator *transport); ///< NULL is allowed

/// Unknowns of the linear system: values at the nodes of elements on the scene's own triangles.
RSV_API size_t rsv_operator_element_count(const rsv_operator *transport);

/// image = G K field: the irradiance that follows from an irradiance after one reflection.
RSV_API rsv_status rsv_operator_apply(
    const rsv_operator *transport, const rsv_rgb *field, rsv_rgb *image);

/// image = (G K)* field, the adjoint of rsv_operator_apply: importance one reflection earlier.
RSV_API rsv_status rsv_operator_apply_transpose(
    const rsv_operator *transport, const rsv_rgb *field, rsv_rgb *image);

/// residual = source + G K field - field, with sums in double.
RSV_API rsv_status rsv_operator_residual(
    const rsv_operator *transport, const rsv_rgb *source, const rsv_rgb *field, rsv_rgb *residual);

/// ||G K||_inf: the largest row sum over elements and channels. Below 1 the series of reflections converges.
RSV_API rsv_status rsv_operator_norm(const rsv_operator *transport, double *norm_inf);

/// Elements around a point and their weights: a field's value there is the weighted sum of theirs.
typedef struct rsv_element_weights {
    uint32_t element[3];
    float weight[3];
} rsv_element_weights;

/// What a point of a triangle looks up. @param u, v barycentric weights of the triangle's corners 1 and 2
/// @return false where that side of the triangle has no elements: it does not reflect diffusely
RSV_API bool rsv_operator_locate(const rsv_operator *transport, uint32_t triangle, float u, float v,
    bool back_side, rsv_element_weights *around);

/// The same for points in space, each at the nearest place of the surfaces that its normal looks at, where mode lookup of
/// rsv_probe_irradiance reads, too.
/// @param probes [count], less rsv_scene_view.origin
/// @param around out, [count]; weights are 0 where the surface does not reflect diffusely
RSV_API rsv_status rsv_operator_locate_probes(const rsv_operator *transport,
    const rsv_probe *probes, size_t count, rsv_element_weights *around);

/// An element: the function that is 1 at its node, falls to 0 at the nodes around, and is linear in between. In fog, a part of
/// the air whose irradiance is a quarter of its fluence.
typedef struct rsv_element {
    rsv_vec3 position, normal; ///< of the node, less rsv_scene_view.origin; the normal is 0 in fog
    rsv_rgb albedo;            ///< exitance over (diffused) irradiance, 0..1
    float area; ///< integral of the function, m2, in fog 4 x volume x extinction; 0 = it hangs
    uint32_t triangle; ///< one of those around the node, of the scene; UINT32_MAX in fog
    bool back_side;    ///< of it
} rsv_element;

/// @param element out, [element_count]
RSV_API rsv_status rsv_operator_elements(const rsv_operator *transport, rsv_element *element);

/// What G K is made of, with A = diag(albedo):
///
///     G K = C G A           where nothing is translucent, for fields that C leaves as they are
///     G K = C G A C S M C   in general
///
/// C G A C S M C is what rsv_operator_apply computes.
typedef enum rsv_operator_factor {
    RSV_FACTOR_INTERPOLATION, ///< C [N x N]: values of hanging elements are means of others; all else stays as it is
    RSV_FACTOR_PROPAGATION, ///< G [N x N]: irradiance by exitance
    RSV_FACTOR_SUBSURFACE, ///< S [N x (N + clusters)]: diffused irradiance by irradiance; the unit matrix where nothing is translucent
    RSV_FACTOR_CLUSTERS ///< M [(N + clusters) x N]: irradiance, and below it its means over clusters of translucent cells
} rsv_operator_factor;

/// A sparse matrix by rows: the entries of row i are those from row_start[i] up to row_start[i + 1]. A column that occurs twice
/// in a row counts twice.
typedef struct rsv_sparse_matrix {
    rsv_context *context; ///< whose memory it takes
    size_t row_count, column_count;
    size_t *row_start; ///< [row_count + 1]
    uint32_t *column;  ///< [row_start[row_count]]
    float *weight;     ///< likewise
} rsv_sparse_matrix;

/// One of these matrices for one colour channel, 0 to 2.
/// @param matrix out, a copy; to be destroyed before the context
RSV_API rsv_status rsv_operator_matrix(const rsv_operator *transport, rsv_operator_factor factor,
    uint32_t channel, rsv_sparse_matrix **matrix);
RSV_API void rsv_sparse_matrix_destroy(rsv_sparse_matrix *matrix); ///< NULL is allowed

#ifdef __cplusplus
}
#endif

#endif
