/// A device emulated with host memory and loops.
#define RSV_KERNELS_HERE
#include "launch.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/// Something that was queued while a recording was made.
typedef struct step {
    void (*run)(const void *args, uint32_t item); ///< NULL = a copy, or a clear if `from` is NULL
    union {
        char args[RSV_ARGS_BYTES];
        struct {
            void *to;
            const void *from;
            size_t bytes;
        } move;
    };
    size_t count;
} step;

struct rsv_gpu_recording {
    step *step;
    size_t count, capacity;
};

typedef struct emulated {
    rsv_gpu gpu;
    size_t bytes_left;
    uint64_t launches;
    rsv_gpu_recording *recording; ///< in progress; NULL = work is executed at once
    double mark[RSV_GPU_MARKS];
} emulated;

static emulated *emulated_of(rsv_gpu *gpu) { return (emulated *)gpu; }

static rsv_status claim_capability(rsv_device_info *info, uint32_t major, char *message)
{
    if (major == 0) return RSV_OK;
    snprintf(info->capability, sizeof info->capability, "%u.0", major);
    return rsv_gpu_check_capability(info, (int)major, message);
}

rsv_status rsv_gpu_create(const rsv_device_desc *desc, rsv_gpu **gpu, char *message)
{
    emulated *e = rsv_gpu_new(sizeof *e, message);
    if (!e) return RSV_ERROR_MEMORY;
    e->bytes_left = desc->max_bytes ? desc->max_bytes : SIZE_MAX;
    e->gpu.device.info = (rsv_device_info){ .name = "emulated device",
        .capability = "none",
        .driver = "none",
        .runtime = "none",
        .memory_bytes = e->bytes_left,
        .processors = 1 };
    rsv_status status = claim_capability(&e->gpu.device.info, desc->capability, message);
    if (status == RSV_OK)
        *gpu = &e->gpu;
    else
        rsv_gpu_destroy(&e->gpu);
    return status;
}

void rsv_gpu_destroy(rsv_gpu *gpu) { free(gpu); }

rsv_status rsv_gpu_wait(rsv_gpu *gpu, char *message) { return rsv_gpu_report(gpu, message); }

// ---- memory --------------------------------------------------------------------------------------

void rsv_gpu_reserve(rsv_gpu *gpu, rsv_gpu_block *block, const char *what)
{
    emulated *e = emulated_of(gpu);
    if (gpu->status != RSV_OK) return;
    size_t bytes = block->bytes;
    block->placed = 0;
    if (bytes <= e->bytes_left) block->base = aligned_alloc(256, bytes ? bytes : 256);
    if (!block->base) {
        rsv_gpu_fail(gpu, RSV_ERROR_MEMORY, RSV_GPU_TOO_SMALL, what, (double)bytes / 0x1p20,
            gpu->device.info.name, (double)e->bytes_left / 0x1p20);
        return;
    }
    memset(block->base, 0xff, bytes); // NaN, so that reading uninitialised memory shows
    e->bytes_left -= bytes;
}

void rsv_gpu_release(rsv_gpu *gpu, rsv_gpu_block *block)
{
    if (block->base) emulated_of(gpu)->bytes_left += block->bytes;
    free(block->base);
    *block = (rsv_gpu_block){ 0 };
}

static step *note(rsv_gpu_recording *r)
{
    if (r->count == r->capacity) {
        size_t capacity = r->capacity ? 2 * r->capacity : 64;
        step *grown = realloc(r->step, capacity * sizeof *grown);
        if (!grown) return NULL;
        r->step = grown;
        r->capacity = capacity;
    }
    return &r->step[r->count++];
}

static void move(void *to, const void *from, size_t bytes)
{
    if (bytes == 0) return;
    if (from)
        memmove(to, from, bytes);
    else
        memset(to, 0, bytes);
}

static void move_or_note(rsv_gpu *gpu, void *to, const void *from, size_t bytes)
{
    rsv_gpu_recording *recording = emulated_of(gpu)->recording;
    if (gpu->status != RSV_OK) return;
    if (!recording) {
        move(to, from, bytes);
        return;
    }
    step *s = note(recording);
    if (s)
        *s = (step){ .move = { to, from, bytes } };
    else
        rsv_gpu_fail(gpu, RSV_ERROR_MEMORY, "out of memory");
}

void rsv_gpu_upload(rsv_gpu *gpu, void *device, const void *host, size_t bytes)
{
    if (gpu->status == RSV_OK) move(device, host, bytes);
}

void rsv_gpu_download(rsv_gpu *gpu, void *host, const void *device, size_t bytes)
{
    if (gpu->status == RSV_OK) move(host, device, bytes);
}

void rsv_gpu_copy(rsv_gpu *gpu, void *to, const void *from, size_t bytes)
{
    move_or_note(gpu, to, from, bytes);
}

void rsv_gpu_clear(rsv_gpu *gpu, void *device, size_t bytes)
{
    move_or_note(gpu, device, NULL, bytes);
}

// ---- launches and recordings ---------------------------------------------------------------------

static void run_items(
    emulated *e, void (*run)(const void *args, uint32_t item), const void *args, size_t count)
{
    uint64_t most = e->gpu.device.desc.fail_after;
    if (most && ++e->launches > most) {
        rsv_gpu_fail(&e->gpu, RSV_ERROR_DEVICE, "%s is lost", e->gpu.device.info.name);
        return;
    }
    for (size_t item = count; item-- > 0;)
        run(args, (uint32_t)item);
}

void rsv_gpu_run(rsv_gpu *gpu, void (*run)(const void *args, uint32_t item), const void *args,
    size_t args_bytes, size_t count)
{
    emulated *e = emulated_of(gpu);
    if (gpu->status != RSV_OK || count == 0) return;
    if (!e->recording) {
        run_items(e, run, args, count);
        return;
    }
    step *s = note(e->recording);
    if (!s) {
        rsv_gpu_fail(gpu, RSV_ERROR_MEMORY, "out of memory");
        return;
    }
    s->run = run;
    s->count = count;
    memcpy(s->args, args, args_bytes);
}

void rsv_gpu_record(rsv_gpu *gpu)
{
    if (gpu->status != RSV_OK) return;
    emulated_of(gpu)->recording = calloc(1, sizeof(rsv_gpu_recording));
    if (!emulated_of(gpu)->recording) rsv_gpu_fail(gpu, RSV_ERROR_MEMORY, "out of memory");
}

rsv_gpu_recording *rsv_gpu_recorded(rsv_gpu *gpu)
{
    rsv_gpu_recording *made = emulated_of(gpu)->recording;
    emulated_of(gpu)->recording = NULL;
    return made;
}

void rsv_gpu_replay(rsv_gpu *gpu, rsv_gpu_recording *recording)
{
    for (size_t k = 0; recording && k < recording->count && gpu->status == RSV_OK; k++) {
        const step *s = &recording->step[k];
        if (s->run)
            run_items(emulated_of(gpu), s->run, s->args, s->count);
        else
            move(s->move.to, s->move.from, s->move.bytes);
    }
}

void rsv_gpu_forget(rsv_gpu_recording *recording)
{
    if (recording) free(recording->step);
    free(recording);
}

// ---- time ----------------------------------------------------------------------------------------

void rsv_gpu_mark(rsv_gpu *gpu, uint32_t mark)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    emulated_of(gpu)->mark[mark] = (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double rsv_gpu_marked_seconds(rsv_gpu *gpu)
{
    const double *mark = emulated_of(gpu)->mark;
    return mark[1] - mark[0];
}
