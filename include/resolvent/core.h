/// @file core.h
/// Context, status codes and small value types: the basis of all other headers.
///
/// Units are SI and radiometric: metres, W, W/m2 (irradiance, exitance), W/(sr m2) (radiance), each
/// as linear RGB. Coordinates are glTF's: right-handed, y up. See docs/conventions.md.
#ifndef RESOLVENT_CORE_H
#define RESOLVENT_CORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define RSV_API __attribute__((visibility("default")))
#define RSV_PRINTF(format_index, first_argument)                                                   \
    __attribute__((format(printf, format_index, first_argument)))
#else
#define RSV_API
#define RSV_PRINTF(format_index, first_argument)
#endif

#ifdef __cplusplus
extern "C" {
#endif

/// A point, direction or normal in world space (metres).
typedef struct rsv_vec3 {
    float x, y, z;
} rsv_vec3;

/// A linear RGB triple: radiance, irradiance, albedo, ...
typedef struct rsv_rgb {
    float r, g, b;
} rsv_rgb;

/// What a function that can fail returns. Details: rsv_last_error().
typedef enum rsv_status {
    RSV_OK = 0,
    RSV_ERROR_ARGUMENT,    ///< the caller broke a documented rule
    RSV_ERROR_IO,          ///< a file cannot be opened, read or written
    RSV_ERROR_FORMAT,      ///< a file's content is malformed
    RSV_ERROR_UNSUPPORTED, ///< well-formed, but asks for something this build cannot do
    RSV_ERROR_SCENE,       ///< a scene without a bounded or meaningful answer
    RSV_ERROR_MEMORY,      ///< out of memory
    RSV_ERROR_CANCELLED,   ///< stopped by the progress callback or rsv_context_cancel
    RSV_ERROR_DEVICE       ///< the device (resolvent/device.h) failed in the middle of its work
} rsv_status;

typedef enum rsv_log_level { RSV_LOG_INFO, RSV_LOG_WARNING } rsv_log_level;

/// Owns allocator, log, progress and thread count. Every other object borrows one and must be
/// destroyed before it.
typedef struct rsv_context rsv_context;

// Descriptors, here and in the other headers, hold the options of a function. Each begins with its size, so that later versions
// of the library can add fields. rsv_default_..._desc() sets it; where an initialiser does instead, it is sizeof the descriptor.
// Functions take NULL for defaults, and refuse a descriptor without a size (RSV_ERROR_ARGUMENT). See docs/api.md, Versions.

/// How a context behaves. Start from rsv_default_context_desc().
typedef struct rsv_context_desc {
    size_t size; ///< of this structure; rsv_default_context_desc() sets it
    /// Workers that share a loop; 0 = one per core, or OMP_NUM_THREADS. Results do not depend on it.
    int thread_count;
    /// Runs loops on threads of the program: calls `task(data, i)` once for each i < count, and returns when all have returned.
    /// `count` is thread_count at most. Tasks may run at the same time or one after the other, in any order, on any threads;
    /// none waits for another, and none calls this. NULL = OpenMP's threads. (Embree builds its hierarchies on threads of its
    /// own.)
    void (*parallel)(void *user, size_t count, void (*task)(void *data, size_t index), void *data);
    /// Receives notes and warnings, one line each without a newline; NULL = silent.
    void (*log)(void *user, rsv_log_level level, const char *message);
    /// Called from the calling thread, or one that runs a task of `parallel`, during long work, with `fraction` in [0, 1] within the named
    /// phase: "assemble", or "pilot 2: assemble" where the same is done for several parts of the work.
    /// Return false to cancel. NULL = no progress.
    bool (*progress)(void *user, const char *phase, double fraction);
    /// Allocator: returns `bytes` bytes aligned to 64, or NULL; worker threads call it at the same time.
    /// NULL = the C library's.
    void *(*allocate)(void *user, size_t bytes);
    /// Frees what `allocate` returned, from any thread; set both or neither.
    void (*release)(void *user, void *memory);
    /// Passed to every callback.
    void *user;
    /// Processes that share the work (resolvent/team.h); borrowed. NULL = this one alone.
    struct rsv_team *team;
    /// Where the operator is applied and solved (resolvent/device.h); borrowed. NULL = on the CPU.
    struct rsv_device *device;
    /// An RTCDevice of the Embree that the library is linked to: it builds and traces all hierarchies of this context and of
    /// others that have it, with its own threads and settings; borrowed. NULL = each hierarchy has one of its own. Builds
    /// without Embree refuse it (RSV_ERROR_UNSUPPORTED) when they trace.
    void *embree_device;
} rsv_context_desc;

/// Defaults, for a descriptor of `size` bytes: what rsv_default_context_desc() is made of.
RSV_API void rsv_context_desc_init(rsv_context_desc *desc, size_t size);
static inline rsv_context_desc rsv_default_context_desc(void)
{
    rsv_context_desc desc;
    rsv_context_desc_init(&desc, sizeof desc);
    return desc;
}

/// @param desc NULL = defaults
RSV_API rsv_status rsv_context_create(const rsv_context_desc *desc, rsv_context **context);
RSV_API void rsv_context_destroy(rsv_context *context);

/// Asks running work to stop with RSV_ERROR_CANCELLED. Safe from signal handlers and other threads.
/// Later work of the context is refused likewise until rsv_context_reset_cancel().
RSV_API void rsv_context_cancel(rsv_context *context);

/// Takes a cancellation back, whether it came from rsv_context_cancel() or from the progress callback: work may begin
/// again. Call it while the context does nothing. RSV_ERROR_UNSUPPORTED with a team: its other processes have stopped, too.
RSV_API rsv_status rsv_context_reset_cancel(rsv_context *context);

/// The calling thread's last error: one line that says what, where and what to do. Never NULL.
RSV_API const char *rsv_last_error(void);

/// The version of these headers.
#define RSV_VERSION_MAJOR 0
#define RSV_VERSION_MINOR 1
#define RSV_VERSION_PATCH 0
#define RSV_VERSION_STRING "0.1.0"

/// The library's version, "major.minor.patch": that of the headers it was built from.
RSV_API const char *rsv_version(void);

#ifdef __cplusplus
}
#endif

#endif
