/// @file solve.h
/// Solves the light of a scene: the light-transport operator, and the solution of E = E0 + G K E.
#ifndef RESOLVENT_SOLVE_H
#define RESOLVENT_SOLVE_H

#include "resolvent/operator.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum rsv_quality { RSV_QUALITY_DRAFT, RSV_QUALITY_MEDIUM, RSV_QUALITY_HIGH } rsv_quality;

/// How E = E0 + G K E is solved. docs/theory.md says what each of them does.
typedef enum rsv_solver {
    RSV_SOLVER_AUTO,    ///< the cheapest one, by the spectral radius and the size
    RSV_SOLVER_NEUMANN, ///< bounce after bounce
    RSV_SOLVER_GAUSS_SEIDEL,
    RSV_SOLVER_SOUTHWELL, ///< shooting: progressive radiosity; not with translucent materials
    RSV_SOLVER_CHEBYSHEV,
    RSV_SOLVER_BICGSTAB,
    RSV_SOLVER_GMRES,
    RSV_SOLVER_TWO_GRID,
    RSV_SOLVER_PETSC ///< KSP of PETSc, by its own options; in a context with a team, be it of one process (team.h)
} rsv_solver;

/// "auto", "neumann", "gauss-seidel", ... in the order of rsv_solver, and then NULL.
RSV_API const char *const *rsv_solver_names(void);
/// One of them; NULL beyond the last.
RSV_API const char *rsv_solver_name(rsv_solver solver);

/// Start from rsv_default_solve_desc().
typedef struct rsv_solve_desc {
    size_t size; ///< of this structure; rsv_default_solve_desc() sets it
    uint32_t
        element_target; ///< wanted number of coarse elements; meshes finer than that keep theirs
    uint32_t rays_per_element; ///< gather rays of one row of G; a power of two, 64..4096
    /// Rays of all rows together at least: rows that are few, which cost little, get up to 8 times as many as
    /// `rays_per_element`, where no `max_bytes` counts them; 0 (default) = any number will do.
    uint64_t row_rays;
    uint32_t refinements; ///< pilot solutions that show where coarse elements must be split
    /// Part of the usual elements that are spent where surfaces meet or cut through each other, to 1; 0 (default) = all.
    float contact_share;
    uint32_t
        light_samples; ///< shadow rays per element and next-event estimate; a power of two, 16 to 65536
    uint32_t photon_count;  ///< light paths shot for caustics, where the scene has any
    uint32_t direct_levels; ///< subdivisions of the direct level below the coarse one where direct
                            ///< light changes quickly
    bool direct_level;      ///< false = leave direct light to the renderer (mode `final`)
    rsv_solver solver;      ///< of the orders beyond those that are kept one by one
    uint32_t max_orders;    ///< applications of the operator at most
    float tolerance;        ///< stop when the truncation bound is below this share of mean E
    /// Index of a camera whose picture is all that matters: elements are spent on what it sees and on what lights
    /// that, by importance (the adjoint solution). RSV_NONE (default) = all surfaces matter alike.
    uint32_t goal_camera;
    /// Instead of a camera: sensors whose mean reading, as rsv_probe_irradiance gives it, is all that matters. Copied.
    const rsv_probe *goal_points;
    size_t goal_point_count; ///< 0 (default) = none
    uint32_t seed;
    size_t
        max_elements; ///< of the operator at most, hanging ones included: they are larger then; 0 = no limit
    size_t
        max_bytes; ///< of memory for the whole process, as far as the solution can keep it by larger
                   ///< elements and fewer rays; 0 = no limit
    size_t
        reserved_bytes; ///< of these for what is made of the solution: a picture, a lightmap (default 0)
    /// Folder that keeps rows of G while they are traced, so that a run that is killed goes on where it was, and what a
    /// finished solution knows, for the next one after an edit; for one scene
    /// (rsv_scene_fingerprint) and one version of the library. It must exist; borrowed. NULL (default) = none.
    const char *checkpoint;
    /// Such a folder of the scene before it was edited (objects moved, added or removed, materials changed): what its
    /// solution knew and still holds is not found again. The solution is that of a run without, within its sampling error.
    /// Requires `checkpoint`; borrowed. NULL (default) = none. update.h does the same in memory.
    const char *earlier;
} rsv_solve_desc;

/// Defaults, for a descriptor of `size` bytes: what rsv_default_solve_desc() is made of.
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
    RSV_STOP_DIVERGED,  ///< it grew
    RSV_STOP_BREAKDOWN  ///< the solver had to divide by nothing
} rsv_stop_reason;

/// What happened, and how good the answer is. Times in seconds.
typedef struct rsv_solve_report {
    rsv_stop_reason stop_reason;
    size_t elements;        ///< coarse elements: unknowns of the linear system
    size_t direct_elements; ///< elements of the direct and caustic levels
    size_t rows;            ///< coarse elements with a row of their own: the others follow or hang
    uint32_t rays_per_row;  ///< fewer than wanted to keep a budget, more by `row_rays`
    size_t entries;         ///< stored entries of G
    size_t bytes;           ///< of the elements of all levels, with one field each, and of G and K
    uint64_t rays;          ///< traced during assembly
    uint64_t row_rays;      ///< of these, those of rows of G
    uint64_t
        kept_row_rays; ///< of these, known from before the scene was edited, and not traced at all
    double spared_seconds;   ///< by that, about
    uint32_t iterations;     ///< applications of G K
    rsv_solver solver;       ///< that was used, not RSV_SOLVER_AUTO
    char solver_reason[192]; ///< why, in a sentence
    double norm_inf;         ///< ||G K||_inf, largest row sum over rows and channels
    double spectral_radius;  ///< of G K: its leading eigenvalue, converged to about 1e-4
    uint32_t
        neumann_terms;   ///< orders that the Neumann series takes, as the spectral radius predicts
    double residual_inf; ///< ||E0 + G K E - E||_inf, W/m2, accumulated in double
    double
        truncation_bound; ///< residual_inf / (1 - norm_inf), W/m2: of the system, before what rows blur is sharpened
    double mean_irradiance; ///< area-weighted mean of E, luminance
    double time_bvh, time_assemble, time_solve;
    /// CPU seconds that assembly and solve take on their critical path: of the calling thread; with several
    /// processes, of the slowest from meeting to meeting. Other work on the machine does not lengthen them.
    double critical_assemble, critical_solve;
} rsv_solve_report;

/// The light of a scene, solved on the elements of its operator, which it keeps alive. Constant until it is relit;
/// thread-safe. As many of one operator as are wanted live side by side.
typedef struct rsv_light rsv_light;

/// Builds and solves. RSV_ERROR_SCENE if the scene is closed and lossless (norm 1: no bounded answer).
/// The scene must outlive the solution.
RSV_API rsv_status rsv_light_create(
    const rsv_scene *scene, const rsv_solve_desc *desc, rsv_light **light);
RSV_API void rsv_light_destroy(rsv_light *light);

/// Another light of the same operator, the same at first, that can be changed by itself (relight.h). Costs memory for
/// fields, not for rows, and no rays. Either may be destroyed first.
RSV_API rsv_status rsv_light_copy(const rsv_light *light, rsv_light **copy);

/// Borrowed: retain it to keep it longer than the light.
RSV_API rsv_operator *rsv_light_operator(const rsv_light *light);

/// E0 and E on the elements of the operator, [element_count]; valid until the light changes.
RSV_API const rsv_rgb *rsv_light_source_field(const rsv_light *light);
RSV_API const rsv_rgb *rsv_light_irradiance_field(const rsv_light *light);

RSV_API const rsv_solve_report *rsv_light_report(const rsv_light *light);

/// The scene as the light has it: the one that it was made of or, once it was relit, one of its own with the same surfaces.
RSV_API const rsv_scene *rsv_light_scene(const rsv_light *light);

/// Number of Neumann orders kept: order 0 is E0 (direct), order n is (G K)^n E0.
RSV_API uint32_t rsv_light_order_count(const rsv_light *light);

/// Solved irradiance (W/m2, light that enters the diffuse lobe) at a point of a triangle.
/// @param u, v barycentric weights of the triangle's corners 1 and 2: from 0 on, with a sum of at most 1
/// @param order one Neumann order, or RSV_NONE = their sum
/// @param back_side the back of a double-sided surface
RSV_API rsv_rgb rsv_light_irradiance(
    const rsv_light *light, uint32_t triangle, float u, float v, bool back_side, uint32_t order);

/// A point of a triangle of the scene.
typedef struct rsv_triangle_point {
    uint32_t triangle;
    float u, v;     ///< barycentric weights of the triangle's corners 1 and 2
    bool back_side; ///< the back of a double-sided surface
} rsv_triangle_point;

/// The same for many points at once, several times as fast: in parallel, and with less waiting for memory.
/// RSV_ERROR_ARGUMENT for triangles that the scene does not have and u or v that are not finite.
/// @param points [count] @param irradiance out, [count] W/m2; 0 where nothing reflects diffusely
RSV_API rsv_status rsv_light_irradiance_points(const rsv_light *light,
    const rsv_triangle_point *points, size_t count, uint32_t order, rsv_rgb *irradiance);

/// The eigenvalues of G K that are largest by magnitude, those of all colour channels together, by SLEPc and its options.
/// In a context with a team, be it of one process.
/// @param count wanted in, found out @param value out, [2 x count]: real and imaginary parts
RSV_API rsv_status rsv_leading_eigenvalues(const rsv_light *light, size_t *count, double *value);

#ifdef __cplusplus
}
#endif

#endif
