/// Private services every room uses: errors, memory, log, progress, threads.
#ifndef RSV_CORE_H
#define RSV_CORE_H

#include "resolvent/core.h"

#include <assert.h>

/// A condition only our own bug can break.
#define RSV_ASSERT(condition) assert(condition)

/// Runs `call`; on failure stores its status in `status` and jumps to `cleanup`.
#define RSV_TRY(call)                                                                              \
    do {                                                                                           \
        status = (call);                                                                           \
        if (status != RSV_OK) goto cleanup;                                                        \
    } while (0)

/// Sets the calling thread's error message.
/// @return true
bool rsv_note_error(const char *format, ...) RSV_PRINTF(1, 2);

static inline rsv_status rsv_failed(rsv_status status, bool noted)
{
    (void)noted;
    return status;
}

/// Sets the calling thread's error message (printf format). The value of the macro is `status`. A function defined
/// elsewhere would hide from compilers and analysers that the status of a failure is not RSV_OK.
#define rsv_fail(status, ...) rsv_failed(status, rsv_note_error(__VA_ARGS__))

void rsv_log(const rsv_context *context, rsv_log_level level, const char *format, ...)
    RSV_PRINTF(3, 4);

/// Zeroed array of `count` elements of `size` bytes, aligned to 64; never NULL for count 0. Overflow
/// and exhaustion set the error message and return NULL. Thread-safe.
void *rsv_alloc(rsv_context *context, size_t count, size_t size);
/// Like rsv_alloc, but not zeroed. Pages that are never written take no memory, so generous upper bounds cost
/// nothing.
void *rsv_reserve(rsv_context *context, size_t count, size_t size);
void rsv_free(rsv_context *context, void *memory);

/// Grows `*array` (capacity in elements at `*capacity`) to hold at least `needed` elements, keeping
/// its content.
rsv_status rsv_grow(
    rsv_context *context, void **array, size_t *capacity, size_t needed, size_t size);

/// Memory of the machine or container, bytes; INFINITY if unknown.
double rsv_machine_memory(void);

/// A copy of `text` (NULL counts as ""); NULL on exhaustion.
char *rsv_copy_string(rsv_context *context, const char *text);

/// How many errors the calling thread has noted.
unsigned rsv_error_count(void);

/// Workers that share a loop (parallel.h).
int rsv_threads(const rsv_context *context);

/// The descriptor that the context was created with.
const rsv_context_desc *rsv_context_settings(const rsv_context *context);

/// True after a request to stop, or after a deadline. Cheap enough to poll in parallel loops.
bool rsv_cancelled(const rsv_context *context);

/// Work is cancelled from `seconds` on, as rsv_seconds counts them, until another deadline is set; INFINITY = there is
/// none.
void rsv_set_deadline(rsv_context *context, double seconds);

/// Whether it was not a deadline that cancelled.
bool rsv_was_asked_to_stop(const rsv_context *context);

/// Names the part that the work has come to, such as "pilot" 2: phases are reported as "pilot 2: assemble" from now on.
/// Parts have no parts of their own. @param name NULL = none @param number from 1 on; 0 = there is only one
void rsv_progress_part(rsv_context *context, const char *name, uint32_t number);

/// Reports progress from the thread that entered the library, and turns a cancellation into
/// RSV_ERROR_CANCELLED.
rsv_status rsv_progress(rsv_context *context, const char *phase_of_part, double fraction);

/// Seconds on a monotonic clock.
double rsv_seconds(void);

/// Seconds of a processor that the calling thread has had.
double rsv_thread_seconds(void);

#endif
