/// An NVIDIA GPU.
#define RSV_KERNELS_HERE
#include "launch.h"

#include <stdio.h>
#include <stdlib.h>

struct rsv_gpu_recording {
    cudaGraphExec_t graph;
};

namespace
{

struct cuda_gpu {
    rsv_gpu gpu;
    cudaStream_t stream;
    cudaEvent_t mark[RSV_GPU_MARKS];
    size_t bytes_used; ///< of all blocks
};

cuda_gpu *cuda_of(rsv_gpu *gpu) { return (cuda_gpu *)gpu; }

/// Records the error of a call. @return whether it succeeded
bool check(rsv_gpu *gpu, cudaError_t error, const char *doing)
{
    if (error == cudaSuccess) return true;
    cudaGetLastError(); // it sticks to the next launch otherwise
    rsv_status status = error == cudaErrorMemoryAllocation ? RSV_ERROR_MEMORY : RSV_ERROR_DEVICE;
    rsv_gpu_fail(gpu, status, "%s fails while %s: %s", gpu->device.info.name, doing,
        cudaGetErrorString(error));
    return false;
}

__global__ void any_kernel() {}

/// Whether the plug-in has code that the device can run, or make its own.
rsv_status look_for_code(const rsv_device_info *info, char *message)
{
    cudaFuncAttributes attributes;
    cudaError_t error = cudaFuncGetAttributes(&attributes, any_kernel);
    if (error == cudaSuccess) return RSV_OK;
    cudaGetLastError();
    snprintf(message, RSV_DEVICE_MESSAGE_BYTES,
        "the plug-in was not built for %s of compute capability %s: %s; build it again with "
        "CMAKE_CUDA_ARCHITECTURES",
        info->name, info->capability, cudaGetErrorString(error));
    return RSV_ERROR_UNSUPPORTED;
}

void print_version(char *text, size_t bytes, int version)
{
    snprintf(text, bytes, "%d.%d", version / 1000, version % 1000 / 10);
}

/// Finds the device and its name.
rsv_status look(rsv_device_info *info, char *message)
{
    int count = 0, driver = 0, runtime = 0;
    cudaDeviceProp properties;
    cudaDriverGetVersion(&driver);
    cudaRuntimeGetVersion(&runtime);
    cudaError_t error = cudaGetDeviceCount(&count);
    if (driver == 0) {
        snprintf(message, RSV_DEVICE_MESSAGE_BYTES,
            "there is no NVIDIA driver; install it, or compute on the CPU");
        return RSV_ERROR_UNSUPPORTED;
    }
    if (error == cudaSuccess && count > 0) error = cudaGetDeviceProperties(&properties, 0);
    if (error != cudaSuccess || count == 0) {
        snprintf(message, RSV_DEVICE_MESSAGE_BYTES,
            "the driver, for CUDA %d.%d at most, shows no device to CUDA %d.%d: %s", driver / 1000,
            driver % 1000 / 10, runtime / 1000, runtime % 1000 / 10,
            cudaGetErrorString(error == cudaSuccess ? cudaErrorNoDevice : error));
        return RSV_ERROR_UNSUPPORTED;
    }
    snprintf(info->name, sizeof info->name, "%s", properties.name);
    snprintf(
        info->capability, sizeof info->capability, "%d.%d", properties.major, properties.minor);
    print_version(info->driver, sizeof info->driver, driver);
    print_version(info->runtime, sizeof info->runtime, runtime);
    info->memory_bytes = properties.totalGlobalMem;
    info->processors = (uint32_t)properties.multiProcessorCount;
    info->cache_bytes = (size_t)properties.l2CacheSize;
    return rsv_gpu_check_capability(info, properties.major, message);
}

} // namespace

rsv_status rsv_gpu_create(const rsv_device_desc *desc, rsv_gpu **gpu, char *message)
{
    cuda_gpu *c = (cuda_gpu *)calloc(1, sizeof *c);
    if (!c) {
        snprintf(message, RSV_DEVICE_MESSAGE_BYTES, "out of memory");
        return RSV_ERROR_MEMORY;
    }
    rsv_device_info *info = &c->gpu.device.info;
    rsv_status status = look(info, message);
    if (desc->max_bytes && desc->max_bytes < info->memory_bytes)
        info->memory_bytes = desc->max_bytes;
    if (status == RSV_OK) status = look_for_code(info, message);
    if (status == RSV_OK) {
        rsv_gpu *g = &c->gpu;
        check(g, cudaSetDevice(0), "being opened");
        check(g, cudaStreamCreateWithFlags(&c->stream, cudaStreamNonBlocking), "being opened");
        for (cudaEvent_t &mark : c->mark)
            check(g, cudaEventCreate(&mark), "being opened");
        status = rsv_gpu_wait(g, message);
    }
    if (status == RSV_OK)
        *gpu = &c->gpu;
    else
        rsv_gpu_destroy(&c->gpu);
    return status;
}

void rsv_gpu_destroy(rsv_gpu *gpu)
{
    cuda_gpu *c = cuda_of(gpu);
    for (cudaEvent_t mark : c->mark)
        if (mark) cudaEventDestroy(mark);
    if (c->stream) cudaStreamDestroy(c->stream);
    cudaGetLastError(); // a device that is lost fails all of these
    free(c);
}

rsv_status rsv_gpu_wait(rsv_gpu *gpu, char *message)
{
    cuda_gpu *c = cuda_of(gpu);
    if (c->stream && gpu->status != RSV_ERROR_DEVICE)
        check(gpu, cudaStreamSynchronize(c->stream), "working");
    return rsv_gpu_report(gpu, message);
}

// ---- memory --------------------------------------------------------------------------------------

void rsv_gpu_reserve(rsv_gpu *gpu, rsv_gpu_block *block, const char *what)
{
    size_t left = 0, all = 0, used = cuda_of(gpu)->bytes_used;
    size_t most = gpu->device.desc.max_bytes;
    void *memory = nullptr;
    if (gpu->status != RSV_OK) return;
    block->placed = 0;
    if (!check(gpu, cudaMemGetInfo(&left, &all), "asked for memory")) return;
    if (most && left > most - used) left = most - used;
    if (block->bytes > left ||
        cudaMalloc(&memory, block->bytes ? block->bytes : 1) != cudaSuccess) {
        cudaGetLastError(); // as above
        rsv_gpu_fail(gpu, RSV_ERROR_MEMORY, RSV_GPU_TOO_SMALL, what, (double)block->bytes / 0x1p20,
            gpu->device.info.name, (double)left / 0x1p20);
        return;
    }
    block->base = (char *)memory;
    cuda_of(gpu)->bytes_used += block->bytes;
}

void rsv_gpu_release(rsv_gpu *gpu, rsv_gpu_block *block)
{
    cudaStreamSynchronize(cuda_of(gpu)->stream);
    if (block->base) cuda_of(gpu)->bytes_used -= block->bytes;
    cudaFree(block->base);
    cudaGetLastError(); // as above
    *block = rsv_gpu_block{};
}

void rsv_gpu_upload(rsv_gpu *gpu, void *device, const void *host, size_t bytes)
{
    cudaStream_t stream;
    if (!rsv_gpu_begins(gpu, bytes, &stream)) return;
    check(gpu, cudaMemcpyAsync(device, host, bytes, cudaMemcpyHostToDevice, stream), "copying");
}

void rsv_gpu_download(rsv_gpu *gpu, void *host, const void *device, size_t bytes)
{
    cudaStream_t stream;
    if (!rsv_gpu_begins(gpu, bytes, &stream)) return;
    check(gpu, cudaMemcpyAsync(host, device, bytes, cudaMemcpyDeviceToHost, stream), "copying");
    check(gpu, cudaStreamSynchronize(stream), "working");
}

void rsv_gpu_copy(rsv_gpu *gpu, void *to, const void *from, size_t bytes)
{
    cudaStream_t stream;
    if (!rsv_gpu_begins(gpu, bytes, &stream)) return;
    check(gpu, cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToDevice, stream), "copying");
}

void rsv_gpu_clear(rsv_gpu *gpu, void *device, size_t bytes)
{
    cudaStream_t stream;
    if (!rsv_gpu_begins(gpu, bytes, &stream)) return;
    check(gpu, cudaMemsetAsync(device, 0, bytes, stream), "clearing memory");
}

// ---- launches and recordings ---------------------------------------------------------------------

bool rsv_gpu_begins(rsv_gpu *gpu, size_t count, cudaStream_t *stream)
{
    *stream = cuda_of(gpu)->stream;
    return gpu->status == RSV_OK && count > 0;
}

void rsv_gpu_launched(rsv_gpu *gpu, const char *name) { check(gpu, cudaGetLastError(), name); }

void rsv_gpu_record(rsv_gpu *gpu)
{
    cudaStream_t stream;
    if (!rsv_gpu_begins(gpu, 1, &stream)) return;
    // relaxed: a kernel whose code is loaded by its first launch may well be launched here
    check(gpu, cudaStreamBeginCapture(stream, cudaStreamCaptureModeRelaxed), "recording");
}

rsv_gpu_recording *rsv_gpu_recorded(rsv_gpu *gpu)
{
    cudaGraph_t graph = nullptr;
    rsv_gpu_recording *made = (rsv_gpu_recording *)calloc(1, sizeof *made);
    // a stream that captures is brought out of it even after a failure
    cudaError_t error = cudaStreamEndCapture(cuda_of(gpu)->stream, &graph);
    if (error != cudaSuccess) cudaGetLastError(); // as above
    if (!made) rsv_gpu_fail(gpu, RSV_ERROR_MEMORY, "out of memory");
    if (gpu->status == RSV_OK && check(gpu, error, "recording"))
        check(gpu, cudaGraphInstantiate(&made->graph, graph, 0), "recording");
    if (graph) cudaGraphDestroy(graph);
    if (gpu->status == RSV_OK) return made;
    free(made);
    return nullptr;
}

void rsv_gpu_replay(rsv_gpu *gpu, rsv_gpu_recording *recording)
{
    cudaStream_t stream;
    if (!recording || !rsv_gpu_begins(gpu, 1, &stream)) return;
    check(gpu, cudaGraphLaunch(recording->graph, stream), "replaying");
}

void rsv_gpu_forget(rsv_gpu_recording *recording)
{
    if (recording) cudaGraphExecDestroy(recording->graph);
    free(recording);
}

// ---- time ----------------------------------------------------------------------------------------

void rsv_gpu_mark(rsv_gpu *gpu, uint32_t mark)
{
    cudaStream_t stream;
    if (!rsv_gpu_begins(gpu, 1, &stream)) return;
    check(gpu, cudaEventRecord(cuda_of(gpu)->mark[mark], stream), "timing");
}

double rsv_gpu_marked_seconds(rsv_gpu *gpu)
{
    const cuda_gpu *c = cuda_of(gpu);
    float milliseconds = 0;
    if (gpu->status != RSV_OK) return 0;
    check(gpu, cudaEventSynchronize(c->mark[1]), "working");
    check(gpu, cudaEventElapsedTime(&milliseconds, c->mark[0], c->mark[1]), "timing");
    return 1e-3 * (double)milliseconds;
}
