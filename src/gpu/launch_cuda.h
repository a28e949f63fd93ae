/// Launches on the device.
#ifndef RSV_LAUNCH_CUDA_H
#define RSV_LAUNCH_CUDA_H

#include <cuda_runtime.h>

#include <cstring>

enum { RSV_BLOCK_THREADS = 256 };

/// Whether there is something to launch and nothing has failed; the stream to launch it in.
extern "C" bool rsv_gpu_begins(rsv_gpu *gpu, size_t count, cudaStream_t *stream);
/// Notes a launch that failed.
extern "C" void rsv_gpu_launched(rsv_gpu *gpu, const char *name);

template <typename Args, void (*body)(const Args *, uint32_t)>
__global__ void __launch_bounds__(RSV_BLOCK_THREADS)
    rsv_each(const __grid_constant__ Args args, uint32_t count)
{
    uint32_t item = blockIdx.x * RSV_BLOCK_THREADS + threadIdx.x;
    if (item < count) body(&args, item);
}

/// The value of the lane `distance` further on.
template <typename Value> __device__ Value rsv_from_lane(const Value &value, uint32_t distance)
{
    static_assert(sizeof(Value) % 4 == 0, "lanes exchange words");
    uint32_t word[sizeof(Value) / 4];
    memcpy(word, &value, sizeof value);
#pragma unroll
    for (uint32_t k = 0; k < sizeof(Value) / 4; k++)
        word[k] = __shfl_down_sync(0xffffffffu, word[k], distance);
    Value other;
    memcpy(&other, word, sizeof other);
    return other;
}

template <typename Args, typename Value, Value (*lane)(const Args *, uint32_t, uint32_t),
    Value (*add)(Value, Value), void (*store)(const Args *, uint32_t, Value)>
__global__ void __launch_bounds__(RSV_BLOCK_THREADS)
    rsv_each_sum(const __grid_constant__ Args args, uint32_t count)
{
    uint32_t item = blockIdx.x * (RSV_BLOCK_THREADS / RSV_LANES) + threadIdx.x / RSV_LANES;
    uint32_t own = threadIdx.x % RSV_LANES;
    if (item >= count) return; // the whole warp
    Value sum = lane(&args, item, own);
#pragma unroll
    for (uint32_t half = RSV_LANES / 2; half > 0; half /= 2)
        sum = add(sum, rsv_from_lane(sum, half));
    if (own == 0) store(&args, item, sum);
}

/// Number of blocks for a number of threads.
static inline uint32_t rsv_blocks(size_t threads)
{
    return (uint32_t)((threads + RSV_BLOCK_THREADS - 1) / RSV_BLOCK_THREADS);
}

#define RSV_LAUNCH_GRID(name, args, threads, ...)                                                  \
    RSV_LAUNCH(name, args)                                                                         \
    {                                                                                              \
        static_assert(sizeof(args) <= RSV_ARGS_BYTES, "too many arguments");                       \
        cudaStream_t stream;                                                                       \
        if (!rsv_gpu_begins(gpu, count, &stream)) return;                                          \
        __VA_ARGS__<<<rsv_blocks(threads), RSV_BLOCK_THREADS, 0, stream>>>(*a, (uint32_t)count);   \
        rsv_gpu_launched(gpu, #name);                                                              \
    }

#define RSV_KERNEL(name, args, body) RSV_LAUNCH_GRID(name, args, count, rsv_each<args, body>)

#define RSV_KERNEL_SUM(name, args, value, lane, add, store)                                        \
    RSV_LAUNCH_GRID(name, args, count *RSV_LANES, rsv_each_sum<args, value, lane, add, store>)

#endif
