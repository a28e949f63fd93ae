/// @file operator.h
/// The light-transport operator G K of a scene: for each pair of elements, the fraction of the light arriving at one
/// that arrives at the other next. It is computed once and then constant, while lights (solve.h) are created and
/// destroyed.
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

/// residual = source + G K field - field, with sums in double precision.
RSV_API rsv_status rsv_operator_residual(
    const rsv_operator *transport, const rsv_rgb *source, const rsv_rgb *field, rsv_rgb *residual);

/// ||G K||_inf: the largest row sum over elements and channels. The series of reflections converges if it is below 1.
RSV_API rsv_status rsv_operator_norm(const rsv_operator *transport, double *norm_inf);

/// Elements around a point, and their weights: the value of a field there is the weighted sum of theirs.
typedef struct rsv_element_weights {
    uint32_t element[3];
    float weight[3];
} rsv_element_weights;

/// Elements and weights for a point of a triangle. @param u, v barycentric weights of corners 1 and 2 of the triangle
/// @return false if that side of the triangle has no elements, because it does not reflect diffusely
RSV_API bool rsv_operator_locate(const rsv_operator *transport, uint32_t triangle, float u, float v,
    bool back_side, rsv_element_weights *around);

/// Elements and weights for points in space, each at the nearest surface point on the side that its normal points to,
/// as in mode lookup of rsv_probe_irradiance.
/// @param probes [count], relative to rsv_scene_view.origin
/// @param around out, [count]; weights are 0 on surfaces that do not reflect diffusely
RSV_API rsv_status rsv_operator_locate_probes(const rsv_operator *transport,
    const rsv_probe *probes, size_t count, rsv_element_weights *around);

/// An element: the function that is 1 at its node, 0 at the nodes around it, and linear in between. In fog: a part of
/// the air, whose irradiance is a quarter of its fluence.
typedef struct rsv_element {
    rsv_vec3 position,
        normal;     ///< of the node, relative to rsv_scene_view.origin; the normal is 0 in fog
    rsv_rgb albedo; ///< exitance / (diffused) irradiance, 0..1
    float
        area; ///< integral of the function, m2; in fog 4 x volume x extinction; 0 = a hanging element
    uint32_t triangle; ///< a triangle of the scene at the node; UINT32_MAX in fog
    bool back_side;    ///< of that triangle
} rsv_element;

/// @param element out, [element_count]
RSV_API rsv_status rsv_operator_elements(const rsv_operator *transport, rsv_element *element);

/// The factors of G K, with A = diag(albedo):
///
///     G K = C G A           without translucent materials, for fields that C does not change
///     G K = C G A C S M C   in general
///
/// rsv_operator_apply computes C G A C S M C.
typedef enum rsv_operator_factor {
    /// C [N x N]: replaces the values of hanging elements by means of others, and keeps all others
    RSV_FACTOR_INTERPOLATION,
    RSV_FACTOR_PROPAGATION, ///< G [N x N]: irradiance from exitance
    /// S [N x (N + clusters)]: diffused irradiance from irradiance; the identity without translucent materials
    RSV_FACTOR_SUBSURFACE,
    /// M [(N + clusters) x N]: irradiance, followed by its means over clusters of translucent cells
    RSV_FACTOR_CLUSTERS
} rsv_operator_factor;

/// A sparse matrix by rows. Row i has the entries row_start[i] to row_start[i + 1] - 1. If a column occurs twice in a
/// row, the weights add up.
typedef struct rsv_sparse_matrix {
    rsv_context *context; ///< owner of the memory
    size_t row_count, column_count;
    size_t *row_start; ///< [row_count + 1]
    uint32_t *column;  ///< [row_start[row_count]]
    float *weight;     ///< the same length
} rsv_sparse_matrix;

/// A copy of one of the factors, for one colour channel (0 to 2).
/// @param matrix out; destroy it before the context
RSV_API rsv_status rsv_operator_matrix(const rsv_operator *transport, rsv_operator_factor factor,
    uint32_t channel, rsv_sparse_matrix **matrix);
RSV_API void rsv_sparse_matrix_destroy(rsv_sparse_matrix *matrix); ///< NULL is allowed

#ifdef __cplusplus
}
#endif

#endif
