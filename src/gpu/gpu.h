/// Devices for the plug-in's host code: one queue, memory, recordings. Plain C; launch.h describes kernels.
///
/// Two libraries are built from the same sources. In one, the device is `gpu_cuda.cu`, and kernels run on it. In the
/// other, it is `gpu_emulated.c`, made of host memory and loops. That one runs every line of the plug-in except the
/// launches, under any sanitizer, with memory limits and failures chosen by a test.
///
/// Work is queued and executed in order. Only rsv_gpu_wait needs its result checked: the first failure is stored,
/// everything after it does nothing, and rsv_gpu_wait reports it.
#ifndef RSV_GPU_H
#define RSV_GPU_H

#include "../core/device.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Data of an open device for plug-in code. The type of a back end starts with it.
typedef struct rsv_gpu {
    rsv_device device; ///< the library's view of it
    rsv_status status; ///< of the first failure
    char message[RSV_DEVICE_MESSAGE_BYTES];
} rsv_gpu;

/// Opens the device of this back end. @param message of a failure, [RSV_DEVICE_MESSAGE_BYTES]
rsv_status rsv_gpu_create(const rsv_device_desc *desc, rsv_gpu **gpu, char *message);
void rsv_gpu_destroy(rsv_gpu *gpu);

/// The oldest major compute capability that will do: launches want grid constants and shuffles as kernels use them.
#define RSV_GPU_OLDEST 7

/// Whether a device with complete info is new enough. @param message out: what is wrong if it is not
rsv_status rsv_gpu_check_capability(const rsv_device_info *info, int major, char *message);

/// Message of a device with too little memory: what needs how many MiB, and which device has how many.
#define RSV_GPU_TOO_SMALL                                                                          \
    "%s would take %.0f MiB, and %s has %.0f MiB free; use a lower quality, or compute on the "    \
    "CPU"

/// Notes a failure, unless there was one.
void rsv_gpu_fail(rsv_gpu *gpu, rsv_status status, const char *format, ...) RSV_PRINTF(3, 4);

/// Zeroed host memory of a task; free it with free(). @return NULL, with a message, if out of memory
void *rsv_gpu_new(size_t bytes, char *message);

/// Waits until all work is done. A failure that leaves the device intact, such as too little memory, is reported once
/// and then cleared, because a smaller task may succeed. @param message of the first failure,
/// [RSV_DEVICE_MESSAGE_BYTES]; unchanged if there is none
rsv_status rsv_gpu_wait(rsv_gpu *gpu, char *message);

/// Reports and clears the first failure like rsv_gpu_wait, without waiting; for back ends.
rsv_status rsv_gpu_report(rsv_gpu *gpu, char *message);

// ---- memory --------------------------------------------------------------------------------------

/// One allocation for all arrays of a task, so that a card with too little memory fails before the work starts. A
/// layout is a function that places a task's arrays in a block:
///
///     static void lay_out(void *task, rsv_gpu_block *block)
///     {
///         sums *s = task;
///         s->value = rsv_gpu_place(block, s->count, sizeof *s->value);
///         s->total = rsv_gpu_place(block, 1, sizeof *s->total);
///     }
///     ...
///     rsv_gpu_lay_out(gpu, &s->block, lay_out, s, "the sums");
typedef struct rsv_gpu_block {
    char *base; ///< on the device; NULL = being measured
    size_t bytes, placed;
} rsv_gpu_block;

typedef void (*rsv_gpu_layout)(void *task, rsv_gpu_block *block);

/// Measures, allocates and places. @param what needs the memory: for the message
void rsv_gpu_lay_out(
    rsv_gpu *gpu, rsv_gpu_block *block, rsv_gpu_layout layout, void *task, const char *what);

/// @return the array's address on the device, aligned to 256 bytes; NULL while measuring
void *rsv_gpu_place(rsv_gpu_block *block, size_t count, size_t size);

/// Allocates the measured size, uninitialised. @param what needs the memory: for the message
void rsv_gpu_reserve(rsv_gpu *gpu, rsv_gpu_block *block, const char *what);
/// Waits for the queue and frees.
void rsv_gpu_release(rsv_gpu *gpu, rsv_gpu_block *block);

/// Host memory must stay as it is until the queue has been waited for.
void rsv_gpu_upload(rsv_gpu *gpu, void *device, const void *host, size_t bytes);

/// An array of the host and where it goes.
typedef struct rsv_gpu_array {
    const void *to, *from;
    size_t count, size;
} rsv_gpu_array;

void rsv_gpu_upload_all(rsv_gpu *gpu, const rsv_gpu_array *array, size_t count);

/// Waits for the queue: `host` is complete when the call returns.
void rsv_gpu_download(rsv_gpu *gpu, void *host, const void *device, size_t bytes);
void rsv_gpu_copy(rsv_gpu *gpu, void *to, const void *from, size_t bytes);
/// All bytes 0.
void rsv_gpu_clear(rsv_gpu *gpu, void *device, size_t bytes);

// ---- recordings ----------------------------------------------------------------------------------

/// A sequence of launches, copies on the device and clears that is queued as one (a CUDA graph): launches take
/// microseconds each, which a solver's small kernels would spend waiting.
typedef struct rsv_gpu_recording rsv_gpu_recording;

/// From here on, work is recorded instead of executed.
void rsv_gpu_record(rsv_gpu *gpu);
/// @return NULL after a failure, with which rsv_gpu_replay does nothing
rsv_gpu_recording *rsv_gpu_recorded(rsv_gpu *gpu);
void rsv_gpu_replay(rsv_gpu *gpu, rsv_gpu_recording *recording);
void rsv_gpu_forget(rsv_gpu_recording *recording);

// ---- time ----------------------------------------------------------------------------------------

enum { RSV_GPU_MARKS = 2 };
/// Notes when the queue gets here. @param mark 0 or 1
void rsv_gpu_mark(rsv_gpu *gpu, uint32_t mark);
/// Seconds from mark 0 to mark 1, measured by the device; waits for both.
double rsv_gpu_marked_seconds(rsv_gpu *gpu);

#ifdef __cplusplus
}
#endif

#endif
