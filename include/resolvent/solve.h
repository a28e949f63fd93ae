/// @file solve.h
/// Solves the light of a scene: the light-transport operator, and the solution of E = E0 + G K E.
#ifndef RESOLVENT_SOLVE_H
#define RESOLVENT_SOLVE_H

#include "resolvent/operator.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum rsv_quality { RSV_QUALITY_DRAFT, RSV_QUALITY_MEDIUM, RSV_QUALITY_HIGH } rsv_quality;

/// Methods to solve E = E0 + G K E. docs/theory.md describes them.
typedef enum rsv_solver {
    RSV_SOLVER_AUTO,    ///< chosen by spectral radius and size
    RSV_SOLVER_NEUMANN, ///< one bounce after another
    RSV_SOLVER_GAUSS_SEIDEL,
    RSV_SOLVER_SOUTHWELL, ///< shooting: progressive radiosity; not with translucent materials
    RSV_SOLVER_CHEBYSHEV,
    RSV_SOLVER_BICGSTAB,
    RSV_SOLVER_GMRES,
    RSV_SOLVER_TWO_GRID,
    RSV_SOLVER_PETSC ///< KSP of PETSc, with its own options; requires a context with a team, possibly of one process
} rsv_solver;

/// Names in the order of rsv_solver ("auto", "neumann", "gauss-seidel", ...), NULL-terminated.
RSV_API const char *const *rsv_solver_names(void);
/// Name of a solver; NULL if out of range.
RSV_API const char *rsv_solver_name(rsv_solver solver);

/// Options of a solve. Start from rsv_default_solve_desc().
typedef struct rsv_solve_desc {
    size_t size;             ///< sizeof this structure; rsv_default_solve_desc() sets it
    uint32_t element_target; ///< number of coarse elements to aim for; finer meshes keep their own
    uint32_t rays_per_element; ///< gather rays of one row of G; a power of two, 64..4096
    /// Minimum number of rays of all rows together. If there are few rows, each gets up to 8 times `rays_per_element`
    /// to reach it. Ignored with `max_bytes`. 0 (default) = no minimum.
    uint64_t row_rays;
    uint32_t refinements; ///< number of pilot solutions, which show where to split coarse elements
    /// Fraction (up to 1) of the usual number of elements where surfaces meet or intersect; 0 (default) = all of them.
    float contact_share;
    /// Shadow rays per element and next-event estimate; a power of two, 16..65536
    uint32_t light_samples;
    uint32_t photon_count; ///< light paths traced for caustics, if the scene has any
    uint32_t
        direct_levels; ///< how often elements are subdivided below the coarse level where direct light varies quickly
    bool direct_level;   ///< false = leave direct light to the renderer (mode `final`)
    rsv_solver solver;   ///< for the orders that are not kept separately
    uint32_t max_orders; ///< maximum number of applications of the operator
    float tolerance;     ///< stop when the truncation bound is below this fraction of mean E
    /// Index of a camera: refine the surfaces that it sees, directly or through reflected light, by their importance
    /// (the adjoint solution). RSV_NONE (default) = refine all surfaces equally.
    uint32_t goal_camera;
    /// Sensors instead of a camera: refine what affects their mean reading (rsv_probe_irradiance). Copied.
    const rsv_probe *goal_points;
    size_t goal_point_count; ///< 0 (default) = none
    uint32_t seed;
    /// Maximum number of elements of the operator, including hanging ones. Elements are made larger to keep it.
    /// 0 = no limit
    size_t max_elements;
    /// Memory limit of the whole process, kept by larger elements and fewer rays where possible. 0 = no limit
    size_t max_bytes;
    /// Part of `max_bytes` to leave free for results, such as a picture or lightmap; default 0
    size_t reserved_bytes;
    /// Existing folder in which rows of G are saved as they are traced, so that an interrupted run can continue. A
    /// finished solution saves what the next solve after an edit can reuse (`earlier`). A folder is for one scene
    /// (rsv_scene_fingerprint) and one version of the library. Borrowed. NULL (default) = none.
    const char *checkpoint;
    /// Checkpoint folder of the scene before an edit (objects moved, added or removed, materials changed). What is
    /// still valid is reused. The solution equals that of a solve from scratch, within its sampling error. Requires
    /// `checkpoint`. Borrowed. NULL (default) = none. update.h does the same in memory.
    const char *earlier;
} rsv_solve_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_solve_desc().
RSV_API void rsv_solve_desc_init(rsv_solve_desc *desc, size_t size, rsv_quality quality);
static inline rsv_solve_desc rsv_default_solve_desc(rsv_quality quality)
{
    rsv_solve_desc desc;
    rsv_solve_desc_init(&desc, sizeof desc, quality);
    return desc;
}

typedef enum rsv_stop_reason {
    RSV_STOP_CONVERGED,
    RSV_STOP_MAX_ORDERS,
    RSV_STOP_NO_LIGHT,
    RSV_STOP_STAGNATED, ///< the residual stopped falling
    RSV_STOP_DIVERGED,  ///< the residual grew
    RSV_STOP_BREAKDOWN  ///< the solver would have divided by zero
} rsv_stop_reason;

/// Result and accuracy of a solve. Times are in seconds.
typedef struct rsv_solve_report {
    rsv_stop_reason stop_reason;
    size_t elements;        ///< coarse elements: unknowns of the linear system
    size_t direct_elements; ///< elements of the direct and caustic levels
    size_t
        rows; ///< coarse elements with a row of their own; the values of the others are interpolated
    uint32_t rays_per_row; ///< may be lower to keep a budget, and higher because of `row_rays`
    size_t entries;        ///< stored entries of G
    size_t bytes;          ///< of the elements of all levels, including one field, and of G and K
    uint64_t rays;         ///< traced during assembly
    uint64_t row_rays;     ///< of these, rays of rows of G
    /// Of these, rays that were reused from before the edit, and not traced
    uint64_t kept_row_rays;
    double spared_seconds;   ///< approximate time that reuse saved
    uint32_t iterations;     ///< applications of G K
    rsv_solver solver;       ///< the solver that was used, never RSV_SOLVER_AUTO
    char solver_reason[192]; ///< why it was chosen, in a sentence
    double norm_inf;         ///< ||G K||_inf, largest row sum over rows and channels
    double spectral_radius;  ///< leading eigenvalue of G K, converged to about 1e-4
    uint32_t
        neumann_terms; ///< orders that the Neumann series would need, predicted from the spectral radius
    double residual_inf; ///< ||E0 + G K E - E||_inf, W/m2, accumulated in double precision
    /// residual_inf / (1 - norm_inf), W/m2: bound for the linear system, before the final gather sharpens what rows
    /// blur
    double truncation_bound;
    double mean_irradiance; ///< area-weighted mean of E, luminance
    double time_bvh, time_assemble, time_solve;
    /// CPU seconds on the critical path of assembly and solve: those of the calling thread or, with several processes,
    /// of the slowest process between synchronisations. Other work on the machine does not affect them.
    double critical_assemble, critical_solve;
} rsv_solve_report;

/// The light of a scene: a solution on the elements of an operator, which the light keeps alive. Constant and
/// thread-safe until it is relit. One operator can have any number of lights.
typedef struct rsv_light rsv_light;

/// Builds the operator and solves. RSV_ERROR_SCENE if the scene is closed and lossless (norm 1: the solution is
/// unbounded). The scene must outlive the light.
RSV_API rsv_status rsv_light_create(
    const rsv_scene *scene, const rsv_solve_desc *desc, rsv_light **light);
RSV_API void rsv_light_destroy(rsv_light *light);

/// A copy on the same operator, which can be relit independently (relight.h). It takes memory for fields but not for
/// rows, and traces no rays. The two may be destroyed in any order.
RSV_API rsv_status rsv_light_copy(const rsv_light *light, rsv_light **copy);

/// Borrowed. Retain it to keep it longer than the light.
RSV_API rsv_operator *rsv_light_operator(const rsv_light *light);

/// E0 and E on the elements of the operator, [element_count]; valid until the light changes.
RSV_API const rsv_rgb *rsv_light_source_field(const rsv_light *light);
RSV_API const rsv_rgb *rsv_light_irradiance_field(const rsv_light *light);

RSV_API const rsv_solve_report *rsv_light_report(const rsv_light *light);

/// The scene that the light belongs to: the one it was created from or, after relighting, a copy with the same
/// surfaces.
RSV_API const rsv_scene *rsv_light_scene(const rsv_light *light);

/// Number of Neumann orders that are kept: order 0 is E0 (direct), order n is (G K)^n E0.
RSV_API uint32_t rsv_light_order_count(const rsv_light *light);

/// Solved irradiance (W/m2, light that enters the diffuse lobe) at a point of a triangle.
/// @param u, v barycentric weights of corners 1 and 2 of the triangle: not negative, with a sum of at most 1
/// @param order one Neumann order; RSV_NONE = the sum of all
/// @param back_side for the back of a double-sided surface
RSV_API rsv_rgb rsv_light_irradiance(
    const rsv_light *light, uint32_t triangle, float u, float v, bool back_side, uint32_t order);

/// A point of a triangle of the scene.
typedef struct rsv_triangle_point {
    uint32_t triangle;
    float u, v;     ///< barycentric weights of corners 1 and 2 of the triangle
    bool back_side; ///< the back of a double-sided surface
} rsv_triangle_point;

/// Solved irradiance at many points, in parallel, and several times as fast as one by one. RSV_ERROR_ARGUMENT for
/// triangles that do not exist and for u or v that are not finite.
/// @param points [count]
/// @param irradiance out, [count] W/m2; 0 on surfaces without a diffuse lobe
RSV_API rsv_status rsv_light_irradiance_points(const rsv_light *light,
    const rsv_triangle_point *points, size_t count, uint32_t order, rsv_rgb *irradiance);

/// The eigenvalues of G K with the largest magnitude, for all colour channels together. Computed by SLEPc, with its own
/// options; requires a context with a team, possibly of one process.
/// @param count in: number wanted, out: number found
/// @param value out, [2 x count]: real and imaginary parts
RSV_API rsv_status rsv_leading_eigenvalues(const rsv_light *light, size_t *count, double *value);

#ifdef __cplusplus
}
#endif

#endif
