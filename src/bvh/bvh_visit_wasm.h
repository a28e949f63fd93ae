/// The children of a node against a ray, four at a time by the instructions of WebAssembly; the same bits as rsv_bvh_visit's loop.
#ifndef RSV_BVH_VISIT_WASM_H
#define RSV_BVH_VISIT_WASM_H

#include "bvh.h"

#include <wasm_simd128.h>

/// When a ray enters and leaves boxes; [2] children 0 to 3, and 4 to 7.
typedef struct rsv_bvh_spans {
    v128_t enter[2], leave[2];
} rsv_bvh_spans;

/// Narrows spans to the slabs of an axis: plane q is passed at q * step + start, by `slack` earlier or later.
static inline void rsv_bvh_pass_slabs(rsv_bvh_spans *spans, const uint32_t low[2],
    const uint32_t high[2], float step, float start, float slack)
{
    v128_t low8 = wasm_u16x8_extend_low_u8x16(wasm_v128_load64_zero(low));
    v128_t high8 = wasm_u16x8_extend_low_u8x16(wasm_v128_load64_zero(high));
    v128_t low4[2] = { wasm_u32x4_extend_low_u16x8(low8), wasm_u32x4_extend_high_u16x8(low8) };
    v128_t high4[2] = { wasm_u32x4_extend_low_u16x8(high8), wasm_u32x4_extend_high_u16x8(high8) };
    v128_t steps = wasm_f32x4_splat(step), starts = wasm_f32x4_splat(start),
           slacks = wasm_f32x4_splat(slack);
    for (int h = 0; h < 2; h++) {
        v128_t a = wasm_f32x4_add(wasm_f32x4_mul(wasm_f32x4_convert_i32x4(low4[h]), steps), starts);
        v128_t b =
            wasm_f32x4_add(wasm_f32x4_mul(wasm_f32x4_convert_i32x4(high4[h]), steps), starts);
        // pmin(y, x) is x < y ? x : y, as f_min(x, y)
        v128_t first = wasm_f32x4_sub(wasm_f32x4_pmin(b, a), slacks);
        v128_t last = wasm_f32x4_add(wasm_f32x4_pmax(b, a), slacks);
        spans->enter[h] = wasm_f32x4_pmax(spans->enter[h], first);
        spans->leave[h] = wasm_f32x4_pmin(spans->leave[h], last);
    }
}

/// A bit for each child whose span is not empty.
static inline uint32_t rsv_bvh_met(const rsv_bvh_spans *spans)
{
    return (uint32_t)wasm_i32x4_bitmask(wasm_f32x4_le(spans->enter[0], spans->leave[0])) |
           (uint32_t)wasm_i32x4_bitmask(wasm_f32x4_le(spans->enter[1], spans->leave[1])) << 4;
}

#endif
