/// Kernels. A kernel is a plain inline function in a header that is valid C17 and CUDA. This file makes it run on the
/// device or, on the emulated device, in a loop on the host.
///
/// 1. One call per item:
///
///        typedef struct rsv_scale_args { const float *x; float factor; float *y; } rsv_scale_args;
///        RSV_INLINE void rsv_scale_item(const rsv_scale_args *a, uint32_t i) { a->y[i] = a->factor * a->x[i]; }
///        RSV_KERNEL(scale, rsv_scale_args, rsv_scale_item)
///
///    Host code can then call `rsv_launch_scale(gpu, &args, count)`. Items run in any order and in parallel. The emulated device
///    runs the last one first, so that tests detect dependences on the order.
///
/// 2. One sum per item, by RSV_LANES lanes: a warp on the device. `lane` is called for each of them, `add` combines
/// their values
///    in pairs, always the same ones, and `store` gets the sum:
///
///        RSV_INLINE double rsv_dot_lane(const rsv_dot_args *a, uint32_t chunk, uint32_t lane);
///        RSV_INLINE double rsv_dot_add(double a, double b);
///        RSV_INLINE void rsv_dot_store(const rsv_dot_args *a, uint32_t chunk, double sum);
///        RSV_KERNEL_SUM(dot, rsv_dot_args, double, rsv_dot_lane, rsv_dot_add, rsv_dot_store)
///
///    Both devices form the same sums in the same order: results are equal to the last bit, as long as both compilers avoid
///    contractions (as instructed) and library functions.
///
/// 3. Either kind in two forms, for surfaces that vary and surfaces that do not: `body` or `lane` gets this as its last
/// argument,
///    a constant of each form. If it is false, all texture lookups are compiled out, which frees registers. The launch selects
///    the form by `args->varied`:
///
///        RSV_INLINE void rsv_look_item(const rsv_look_args *a, uint32_t i, bool varied);
///        RSV_KERNEL_VARIED(look, rsv_look_args, rsv_look_item)
///
/// Pointers in `args` are device addresses. The structure itself is copied when the launch is queued: at most
/// RSV_ARGS_BYTES. Headers with kernels are named `*_kernels.h`. They are included three times: by host code, which
/// sees prototypes of the launches, and by `kernels_cuda.cu` and `kernels_emulated.c`, which define RSV_KERNELS_HERE
/// and get the launches themselves.
#ifndef RSV_LAUNCH_H
#define RSV_LAUNCH_H

#include "../core/vec.h"
#include "gpu.h"

#define RSV_LANES 32
#define RSV_ARGS_BYTES 1024

/// Independent iterations whose loads should be in flight together.
#if defined(__CUDACC__)
#define RSV_UNROLL _Pragma("unroll 4")
#else
#define RSV_UNROLL
#endif

#if defined(__cplusplus)
#define RSV_LAUNCH(name, args)                                                                     \
    extern "C" void rsv_launch_##name(rsv_gpu *gpu, const args *a, size_t count)
#else
#define RSV_LAUNCH(name, args) void rsv_launch_##name(rsv_gpu *gpu, const args *a, size_t count)
#endif

#if !defined(RSV_KERNELS_HERE)

#define RSV_KERNEL(name, args, body) RSV_LAUNCH(name, args);
#define RSV_KERNEL_SUM(name, args, value, lane, add, store) RSV_LAUNCH(name, args);

#elif defined(__CUDACC__)
#include "launch_cuda.h"
#else
#include "launch_emulated.h"
#endif

#if !defined(RSV_KERNELS_HERE)
#define RSV_CHOOSE_FORM(name, args)                                                                \
    RSV_INLINE void rsv_launch_##name(rsv_gpu *gpu, const args *a, size_t count)                   \
    {                                                                                              \
        if (a->varied)                                                                             \
            rsv_launch_##name##_varied(gpu, a, count);                                             \
        else                                                                                       \
            rsv_launch_##name##_alike(gpu, a, count);                                              \
    }
#else
#define RSV_CHOOSE_FORM(name, args)
#endif

#define RSV_KERNEL_FORM(name, form, args, body, varied)                                            \
    RSV_INLINE void body##_##form(const args *a, uint32_t item) { body(a, item, varied); }         \
    RSV_KERNEL(name##_##form, args, body##_##form)

#define RSV_KERNEL_VARIED(name, args, body)                                                        \
    RSV_KERNEL_FORM(name, alike, args, body, false)                                                \
    RSV_KERNEL_FORM(name, varied, args, body, true)                                                \
    RSV_CHOOSE_FORM(name, args)

#define RSV_KERNEL_SUM_FORM(name, form, args, value, lane, add, store, varied)                     \
    RSV_INLINE value lane##_##form(const args *a, uint32_t item, uint32_t own)                     \
    {                                                                                              \
        return lane(a, item, own, varied);                                                         \
    }                                                                                              \
    RSV_KERNEL_SUM(name##_##form, args, value, lane##_##form, add, store)

#define RSV_KERNEL_SUM_VARIED(name, args, value, lane, add, store)                                 \
    RSV_KERNEL_SUM_FORM(name, alike, args, value, lane, add, store, false)                         \
    RSV_KERNEL_SUM_FORM(name, varied, args, value, lane, add, store, true)                         \
    RSV_CHOOSE_FORM(name, args)

#endif
