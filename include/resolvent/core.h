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

/// Result of a function that can fail. rsv_last_error() gives details.
typedef enum rsv_status {
    RSV_OK = 0,
    RSV_ERROR_ARGUMENT,    ///< the caller broke a documented rule
    RSV_ERROR_IO,          ///< a file cannot be opened, read or written
    RSV_ERROR_FORMAT,      ///< a file's content is malformed
    RSV_ERROR_UNSUPPORTED, ///< valid, but this build or function does not support it
    RSV_ERROR_SCENE,       ///< the scene has no bounded or meaningful solution
    RSV_ERROR_MEMORY,      ///< out of memory
    RSV_ERROR_CANCELLED,   ///< stopped by the progress callback or rsv_context_cancel
    RSV_ERROR_DEVICE       ///< the device (resolvent/device.h) failed
} rsv_status;

typedef enum rsv_log_level { RSV_LOG_INFO, RSV_LOG_WARNING } rsv_log_level;

/// Owns allocator, log, progress and thread count. Every other object belongs to a context and must be destroyed before
/// it.
typedef struct rsv_context rsv_context;

// Descriptors, here and in the other headers, hold the options of a function. Each begins with its size, so that later
// versions of the library can add fields. rsv_default_..._desc() sets it; in an initialiser, set it to sizeof the
// descriptor. Functions use defaults for NULL, and reject a descriptor without a size (RSV_ERROR_ARGUMENT). See
// docs/api.md, Versions.

/// How a context behaves. Start from rsv_default_context_desc().
typedef struct rsv_context_desc {
    size_t size; ///< sizeof this structure; rsv_default_context_desc() sets it
    /// Threads per loop; 0 = one per core, or OMP_NUM_THREADS. Results do not depend on it.
    int thread_count;
    /// Runs loops on threads of the program. It must call `task(data, i)` once for each i < count, and return when all
    /// calls have returned. `count` is at most thread_count. Tasks may run in any order, on any threads, in parallel or
    /// one after the other. They do not wait for each other, and do not call `parallel`. NULL = OpenMP's threads.
    /// Embree builds its hierarchies on its own threads.
    void (*parallel)(void *user, size_t count, void (*task)(void *data, size_t index), void *data);
    /// Receives notes and warnings, one line each without a newline; NULL = silent.
    void (*log)(void *user, rsv_log_level level, const char *message);
    /// Reports progress of long work: `fraction` in [0, 1] of a phase, such as "assemble" or "pilot 2: assemble".
    /// Called from the calling thread, or from a thread that runs a task of `parallel`. Return false to cancel. NULL =
    /// no progress.
    bool (*progress)(void *user, const char *phase, double fraction);
    /// Allocator: returns `bytes` bytes aligned to 64, or NULL. Worker threads may call it at the same time.
    /// NULL = the C library's.
    void *(*allocate)(void *user, size_t bytes);
    /// Frees memory from `allocate`, from any thread. Set both or neither.
    void (*release)(void *user, void *memory);
    /// Passed to every callback.
    void *user;
    /// Processes that share the work (resolvent/team.h); borrowed. NULL = only this one.
    struct rsv_team *team;
    /// Device that applies and solves the operator (resolvent/device.h); borrowed. NULL = the CPU.
    struct rsv_device *device;
    /// An RTCDevice of the Embree that the library is linked to; borrowed. All contexts with this device build and
    /// trace their hierarchies with it, using its threads and settings. NULL = each hierarchy has its own device.
    /// Builds without Embree do not support it: tracing fails (RSV_ERROR_UNSUPPORTED).
    void *embree_device;
} rsv_context_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_context_desc().
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

/// Stops running work with RSV_ERROR_CANCELLED. Safe from signal handlers and other threads.
/// Later work of the context fails in the same way until rsv_context_reset_cancel().
RSV_API void rsv_context_cancel(rsv_context *context);

/// Undoes a cancellation by rsv_context_cancel() or by the progress callback, so that work can start again. Call it
/// only while the context does no work. RSV_ERROR_UNSUPPORTED with a team, because its other processes have stopped
/// too.
RSV_API rsv_status rsv_context_reset_cancel(rsv_context *context);

/// The calling thread's last error, in one line: what is wrong, where, and what to do. Never NULL.
RSV_API const char *rsv_last_error(void);

/// The version of these headers.
#define RSV_VERSION_MAJOR 0
#define RSV_VERSION_MINOR 1
#define RSV_VERSION_PATCH 0
#define RSV_VERSION_STRING "0.1.0"

/// The version of the library, "major.minor.patch".
RSV_API const char *rsv_version(void);

#ifdef __cplusplus
}
#endif

#endif
