/// @file resolvent_rt.h
/// Relighting of solved light at run time, for engines: this header, one source file, nothing else.
///
/// C99, freestanding: no allocation, no input or output, no library, not even the C library. The caller owns all
/// arrays. The source compiles to scalar code, or to 128-bit SIMD on x86-64, Arm and WebAssembly. Both give the same
/// bits if the compiler may not contract multiplications and additions (-ffp-contract=off).
///
/// There are two ways to get from lights to irradiance E (W/m2 arriving on a surface, linear RGB):
///
/// - **Basis.** Light is linear: E = sum of scale[l] * B[l], where B[l] is the irradiance by light l alone, at any
///   receivers: vertices, texels of a lightmap, probes. It is cheap (rsv_rt_relight), and exact for other
///   intensities and colours of the lights that were baked.
/// - **Operator.** E = E0 + G K E for any direct light E0 that the engine supplies, from lights that were not baked.
///   rsv_rt_solver_update continues from the light of the previous frame within a budget of work. So bounced light
///   follows within a few frames, at a cost that the engine chooses.
///
/// The radiance of a diffuse surface is albedo * E / pi. docs/runtime.md shows how to use this header;
/// docs/operator-files.md and docs/bake-reference.md describe the files that hold the arrays.
#ifndef RESOLVENT_RT_H
#define RESOLVENT_RT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Result of a function that can fail.
typedef enum rsv_rt_status {
    RSV_RT_OK = 0,
    RSV_RT_LIGHT_COUNT, ///< the number of scales is not the number of lights in the basis
    RSV_RT_RANGE,       ///< the range of receivers goes beyond the last one
    RSV_RT_ROWS,        ///< row starts decrease, or go beyond the entries
    RSV_RT_INDEX,       ///< an index goes beyond the last element
    RSV_RT_NUMBER,      ///< a number is not finite
    RSV_RT_GRID,        ///< a grid of probes has no probes or no extent
    RSV_RT_ORDER,  ///< hanging elements come before their parents, form a cycle, or occur twice
    RSV_RT_ENERGY, ///< elements pass on far more light than reaches them, or a negative share of it
    RSV_RT_NO_PROBE ///< there is no valid probe around the position
} rsv_rt_status;

/// A short English sentence for a status.
const char *rsv_rt_status_text(rsv_rt_status status);

// ---- basis ----------------------------------------------------------------------------------------

/// Irradiance by each light alone, at the strength that it was baked with.
typedef struct rsv_rt_basis {
    uint32_t light_count;
    uint32_t receiver_count;
    uint32_t value_count; ///< RGB values per receiver: 1 irradiance, RSV_RT_SH_COUNT of probes
    const float *value;   ///< [light_count][receiver_count][value_count][3]
} rsv_rt_basis;

/// out = sum of scale[l] * value[l] for receivers [first, first + count). Ranges are independent: spread them over
/// threads or frames.
/// @param scale [scale_count][3], one for each light; 1 = as baked
/// @param out [receiver_count][value_count][3], the whole array: only the range is written
/// @return RSV_RT_LIGHT_COUNT, RSV_RT_RANGE
rsv_rt_status rsv_rt_relight(const rsv_rt_basis *basis, const float *scale, uint32_t scale_count,
    uint32_t first, uint32_t count, float *out);

/// Scales for surroundings that were baked at `turns` angles, evenly spread over a full turn. An angle in between is
/// interpolated linearly from its two neighbours, so light is exact at the baked angles and changes evenly in between.
/// @param turn fraction of a full turn beyond the first angle, counter-clockwise from above; any number
/// @param color [3] strength of the surroundings, 1 = as baked
/// @param scale out, [turns][3]
void rsv_rt_turn(float turn, const float color[3], uint32_t turns, float *scale);

// ---- operator -------------------------------------------------------------------------------------

/// G and K by rows, as operator files hold them. Row i of G has the weight scale[i] in each of its columns.
typedef struct rsv_rt_operator {
    uint32_t element_count;
    const uint64_t *row_start; ///< [element_count + 1] into column
    const uint32_t *column;    ///< [row_start[element_count]]
    const float *scale;        ///< [element_count] 0 = nothing arrives, or the element hangs
    const uint64_t
        *tinted_row_start; ///< [element_count + 1] entries with a colour; NULL = there are none
    const uint32_t *tinted_column;
    const float *tinted_weight;     ///< [.][3], times scale
    const float *albedo;            ///< [element_count][3] K: exitance over irradiance
    uint32_t hanging_count;         ///< elements that are weighted means of others
    const uint32_t *hanging_node;   ///< [hanging_count] parents before children
    const uint32_t *hanging_parent; ///< [hanging_count][4]
    const float *hanging_weight;    ///< [hanging_count][4]
} rsv_rt_operator;

/// Checks sizes, indices, numbers and the order of hanging elements. Call it once after loading, if the file may be
/// damaged.
/// @param entries, tinted_entries lengths of `column` and `tinted_column`
/// @param scratch [element_count]
/// @return RSV_RT_ROWS, RSV_RT_INDEX, RSV_RT_NUMBER, RSV_RT_ORDER, RSV_RT_ENERGY
rsv_rt_status rsv_rt_operator_check(
    const rsv_rt_operator *transport, uint64_t entries, uint64_t tinted_entries, uint8_t *scratch);

/// State of the solver. Treat all but `change` and `sweeps` as private.
typedef struct rsv_rt_solver {
    const rsv_rt_operator *transport;
    float *irradiance; ///< [element_count][3]
    float *exitance;   ///< [element_count][4]
    float *bounced;    ///< [element_count][3], or NULL
    uint32_t next;     ///< element to be visited next
    float largest;     ///< largest change in the present sweep
    float
        change; ///< largest change of irradiance within the last whole sweep, W/m2; FLT_MAX = some was not finite
    uint32_t sweeps; ///< whole sweeps since rsv_rt_solver_begin
} rsv_rt_solver;

/// Starts from the given `irradiance`: zeros, or any earlier light. Values that are not finite become 0.
/// @param irradiance [element_count][3]; in and out, valid at any time
/// @param exitance [element_count][4]; scratch, aligned to 16 bytes
void rsv_rt_solver_begin(
    rsv_rt_solver *solver, const rsv_rt_operator *transport, float *irradiance, float *exitance);

/// Also keeps G K E alone, the irradiance without direct light, for engines that draw direct light sharper than
/// elements can. Goes right after rsv_rt_solver_begin.
/// @param bounced [element_count][3]; set to 0, valid at any time
void rsv_rt_solver_keep_bounced(rsv_rt_solver *solver, float *bounced);

/// Visits elements one after the other and sets each to E0 + G K E (Gauss-Seidel), continuing where the last call
/// ended. `direct` may change at any time: the light follows. Stop once solver->change is small enough for you. The
/// remaining error is then below change * a / (1 - a), where a is the largest share of its light that any element
/// passes on. Where `direct` is not finite, an element keeps its light.
/// @param direct [element_count][3] E0
/// @param operations most entries of the operator to read; a row is never split
/// @return operations used
uint64_t rsv_rt_solver_update(rsv_rt_solver *solver, const float *direct, uint64_t operations);

/// The same with a clock of yours: continues until `go_on`, called after every `operations`, returns 0, or until a
/// whole sweep changed nothing by more than `tolerance`.
/// @return whether the light has settled
int rsv_rt_solver_update_while(rsv_rt_solver *solver, const float *direct, float tolerance,
    uint64_t operations, int (*go_on)(void *user), void *user);

/// Receivers anywhere between elements: each is a weighted mean of three elements.
typedef struct rsv_rt_receivers {
    uint32_t count;
    const uint32_t *element; ///< [count][3]
    const float *weight;     ///< [count][3]
} rsv_rt_receivers;

rsv_rt_status rsv_rt_receivers_check(const rsv_rt_receivers *receivers, uint32_t element_count);

/// Interpolates a field of the elements at receivers [first, first + count).
/// @param field [element_count][3] @param out [receivers->count][3], the range is written at its place
rsv_rt_status rsv_rt_receive(const rsv_rt_receivers *receivers, const float *field, uint32_t first,
    uint32_t count, float *out);

// ---- probes ---------------------------------------------------------------------------------------

#define RSV_RT_SH_COUNT 9 ///< coefficients of spherical harmonics of order 2

/// A regular grid of probes, x fastest, then y, then z.
typedef struct rsv_rt_probe_grid {
    uint32_t size[3];
    float origin[3];      ///< of the first probe, metres
    float spacing[3];     ///< metres, positive
    const uint8_t *valid; ///< [probes] 0 = inside something; NULL = all are valid
} rsv_rt_probe_grid;

/// Coefficients at a position: the valid probes around it, weighted trilinearly; outside the grid, those at its border.
/// @return RSV_RT_NO_PROBE if none is valid; `sh` is then 0, and an engine should keep the object's previous light.
/// RSV_RT_GRID
/// @param probe [probes][RSV_RT_SH_COUNT][3] radiance, such as rsv_rt_relight makes
/// @param sh [RSV_RT_SH_COUNT][3]
rsv_rt_status rsv_rt_probe_at(
    const rsv_rt_probe_grid *grid, const float *probe, const float position[3], float *sh);

/// Irradiance of a surface with a unit normal under that radiance (Ramamoorthi and Hanrahan 2001), not below 0.
void rsv_rt_sh_irradiance(const float *sh, const float normal[3], float irradiance[3]);

#ifdef __cplusplus
}
#endif

#endif
