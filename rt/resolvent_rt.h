/// @file resolvent_rt.h
/// Solved light in an engine: this header, one source, nothing else.
///
/// C99, freestanding: no allocation, no input or output, no library, not even the C library. All arrays are the caller's.
/// One source makes scalar code and 128-bit SIMD for x86-64, Arm and WebAssembly; both give the same bits as long as the
/// compiler may not contract multiplications and additions (-ffp-contract=off).
///
/// Two routes lead from lights to irradiance E (W/m2 that arrive on a surface, linear RGB):
///
/// - **Basis.** Light is linear: E = sum of scale[l] * B[l], where B[l] is what light l alone does, at any receivers:
///   vertices, texels of a lightmap, probes. Exact for other intensities and colours of the lights that were baked,
///   and cheap: rsv_rt_relight.
/// - **Operator.** E = E0 + G K E for whatever direct light E0 the engine brings, from lights that were not baked.
///   rsv_rt_solver_update goes on from the light of the frame before, within a budget of work, so that bounced light
///   follows within some frames and costs what the engine allows.
///
/// What is drawn of a diffuse surface is albedo * E / pi. docs/runtime.md shows how to use it, docs/operator-files.md
/// and docs/bake.md where the arrays are found in files.
#ifndef RESOLVENT_RT_H
#define RESOLVENT_RT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// What a function that can fail returns.
typedef enum rsv_rt_status {
    RSV_RT_OK = 0,
    RSV_RT_LIGHT_COUNT, ///< as many scales as the basis has lights are needed
    RSV_RT_RANGE,       ///< receivers beyond the last
    RSV_RT_ROWS,        ///< row starts that step back, or beyond the entries
    RSV_RT_INDEX,       ///< an index beyond the last element
    RSV_RT_NUMBER,      ///< a number that is not finite
    RSV_RT_GRID,        ///< a grid of probes without probes or without extent
    RSV_RT_ORDER,       ///< hanging elements before their parents, in circles, or twice
    RSV_RT_ENERGY,  ///< elements that pass on far more light than reaches them, or less than none
    RSV_RT_NO_PROBE ///< a place without a valid probe around it
} rsv_rt_status;

/// A short English sentence for a status.
const char *rsv_rt_status_text(rsv_rt_status status);

// ---- basis ----------------------------------------------------------------------------------------

/// What each light does by itself, at the strength that it was baked with.
typedef struct rsv_rt_basis {
    uint32_t light_count;
    uint32_t receiver_count;
    uint32_t value_count; ///< RGB values per receiver: 1 irradiance, RSV_RT_SH_COUNT of probes
    const float *value;   ///< [light_count][receiver_count][value_count][3]
} rsv_rt_basis;

/// out = sum of scale[l] * value[l] for receivers [first, first + count). Ranges are independent: spread them over
/// threads, or over frames.
/// @param scale [scale_count][3], as many as there are lights; 1 = as baked
/// @param out [receiver_count][value_count][3], all of it: the range is written at its place
rsv_rt_status rsv_rt_relight(const rsv_rt_basis *basis, const float *scale, uint32_t scale_count,
    uint32_t first, uint32_t count, float *out);

/// Scales of surroundings that a basis holds at `turns` angles, evenly spread over a full turn: the two angles next to the
/// wanted one share it, in proportion. So light is as baked at each of them, and changes evenly in between.
/// @param turn share of a full turn beyond the first angle, counter-clockwise from above; any number
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

/// Checks sizes, indices, numbers and the order of hanging elements: once, after loading, if the file is not your own.
/// @param entries, tinted_entries how long `column` and `tinted_column` are
/// @param scratch [element_count]
rsv_rt_status rsv_rt_operator_check(
    const rsv_rt_operator *transport, uint64_t entries, uint64_t tinted_entries, uint8_t *scratch);

/// Light on its way. Treat all but `change` and `sweeps` as private.
typedef struct rsv_rt_solver {
    const rsv_rt_operator *transport;
    float *irradiance; ///< [element_count][3]
    float *exitance;   ///< [element_count][4]
    float *bounced;    ///< [element_count][3], or NULL
    uint32_t next;     ///< element to be visited next
    float largest;     ///< change within the sweep that is under way
    float
        change; ///< largest change of irradiance within the last whole sweep, W/m2; FLT_MAX = some was not finite
    uint32_t sweeps; ///< whole sweeps since rsv_rt_solver_begin
} rsv_rt_solver;

/// Starts from `irradiance` as it is: zeros, or any light of before. What is not finite becomes 0.
/// @param irradiance [element_count][3]; in and out, valid at any time
/// @param exitance [element_count][4]; scratch, aligned to 16 bytes
void rsv_rt_solver_begin(
    rsv_rt_solver *solver, const rsv_rt_operator *transport, float *irradiance, float *exitance);

/// Keeps G K E by itself, too: irradiance without the direct light, which engines draw sharper than elements can hold it.
/// Goes right after rsv_rt_solver_begin.
/// @param bounced [element_count][3]; set to 0, valid at any time
void rsv_rt_solver_keep_bounced(rsv_rt_solver *solver, float *bounced);

/// Visits elements one after the other and sets each to E0 + G K E (Gauss-Seidel), going on where the last call ended.
/// `direct` may change at any time: the light follows. At rest when solver->change is small enough for you; the error left
/// is then below change * a / (1 - a), with a the largest share of its light that any element passes on. Where `direct` is
/// not finite, an element keeps the light that it had.
/// @param direct [element_count][3] E0
/// @param operations entries of the operator to be read at most; a row is never cut in two
/// @return operations used
uint64_t rsv_rt_solver_update(rsv_rt_solver *solver, const float *direct, uint64_t operations);

/// The same under a clock of yours: goes on until `go_on` returns 0, asking after every `operations`, or until a
/// whole sweep changed nothing by more than `tolerance`.
/// @return whether it is at rest
int rsv_rt_solver_update_while(rsv_rt_solver *solver, const float *direct, float tolerance,
    uint64_t operations, int (*go_on)(void *user), void *user);

/// Receivers between elements: each is a weighted mean of three.
typedef struct rsv_rt_receivers {
    uint32_t count;
    const uint32_t *element; ///< [count][3]
    const float *weight;     ///< [count][3]
} rsv_rt_receivers;

rsv_rt_status rsv_rt_receivers_check(const rsv_rt_receivers *receivers, uint32_t element_count);

/// Carries a field of the elements to receivers [first, first + count).
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

/// Coefficients at a point: the valid probes around it, weighted trilinearly; beyond the grid, those of its border.
/// @return RSV_RT_NO_PROBE where none is valid, with `sh` all zero: an engine keeps what the object had before
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
