#include "core.h"
#include "descriptor.h"
#include "device.h"
#include "team.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#if defined(__linux__)
#include <sys/mman.h>
#endif
#if defined(_OPENMP)
#include <omp.h>
#endif

#define PART_BYTES 24

struct rsv_context {
    rsv_context_desc desc;
    int thread_count;
    atomic_bool cancelled;
    bool has_deadline;
    double deadline;          ///< as rsv_seconds counts
    rsv_status team_status;   ///< the failure of another process
    rsv_status device_status; ///< why the device failed
    bool device_lost;
    char part[PART_BYTES]; ///< "pilot 2: ", or nothing
    char device_message[RSV_DEVICE_MESSAGE_BYTES];
};

static _Thread_local char last_error[1024] = "no error";
static _Thread_local unsigned error_count;

/// Requests huge pages for large arrays, so that touching them for the first time causes a few page faults instead of
/// thousands. If the C library puts an array into its heap (below 32 MB) instead of a mapping, the request outlives the
/// array: later allocations there get huge pages too, and neighbours use the rest of these. Revoking the request would
/// cost two system calls per array and split the heap into more ranges.
static void ask_for_huge_pages(void *memory, size_t bytes)
{
#if defined(MADV_HUGEPAGE)
    const size_t page = (size_t)1 << 21;
    uintptr_t begin = ((uintptr_t)memory + page - 1) / page * page;
    uintptr_t end = ((uintptr_t)memory + bytes) / page * page;
    if (memory && end > begin)
        madvise((void *)begin, end - begin, MADV_HUGEPAGE); // a wish: refusing it is fine
#else
    (void)memory;
    (void)bytes;
#endif
}

static void *default_allocate(void *user, size_t bytes)
{
    (void)user;
    void *memory = aligned_alloc(64, bytes);
    ask_for_huge_pages(memory, bytes);
    return memory;
}

static void default_release(void *user, void *memory)
{
    (void)user;
    free(memory);
}

void rsv_context_desc_init(rsv_context_desc *desc, size_t size)
{
    const rsv_context_desc defaults = { .size = sizeof defaults };
    rsv_desc_fill(desc, size, &defaults);
}

rsv_status rsv_context_create(const rsv_context_desc *desc, rsv_context **context)
{
    rsv_context_desc settings = rsv_default_context_desc();
    rsv_status status = RSV_READ_DESC(rsv_context_desc, &settings, desc);
    if (status != RSV_OK) return status;
    if ((settings.allocate == NULL) != (settings.release == NULL))
        return rsv_fail(RSV_ERROR_ARGUMENT, "context: set both allocate and release, or neither");
    if (settings.thread_count < 0 || settings.thread_count > 1024)
        return rsv_fail(RSV_ERROR_ARGUMENT, "context: thread_count %d is not in 0..1024",
            settings.thread_count);
    if (!settings.allocate) {
        settings.allocate = default_allocate;
        settings.release = default_release;
    }
    rsv_context *created = settings.allocate(settings.user, (sizeof *created + 63) / 64 * 64);
    if (!created) return rsv_fail(RSV_ERROR_MEMORY, "out of memory creating a context");
    memset(created, 0, sizeof *created);
    created->desc = settings;
    created->thread_count = settings.thread_count;
#if defined(_OPENMP)
    if (created->thread_count == 0) created->thread_count = omp_get_max_threads();
#else
    created->thread_count = 1;
#endif
    *context = created;
    return RSV_OK;
}

void rsv_context_destroy(rsv_context *context)
{
    if (context) context->desc.release(context->desc.user, context);
}

void rsv_context_cancel(rsv_context *context)
{
    atomic_store_explicit(&context->cancelled, true, memory_order_relaxed);
}

rsv_status rsv_context_reset_cancel(rsv_context *context)
{
    if (rsv_team_of(context))
        return rsv_fail(RSV_ERROR_UNSUPPORTED, "a cancelled team cannot continue; create another");
    atomic_store_explicit(&context->cancelled, false, memory_order_relaxed);
    return RSV_OK;
}

const char *rsv_last_error(void) { return last_error; }

unsigned rsv_error_count(void) { return error_count; }

const char *rsv_version(void) { return RSV_VERSION_STRING; }

bool rsv_note_error(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(last_error, sizeof last_error, format, arguments);
    va_end(arguments);
    error_count++;
    for (char *c = last_error; *c; c++) // one line, whatever names a file brought in
        if ((unsigned char)*c < 0x20) *c = ' ';
    return true;
}

void rsv_log(const rsv_context *context, rsv_log_level level, const char *format, ...)
{
    if (!context->desc.log) return;
    char message[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    for (char *c = message; *c; c++)
        if ((unsigned char)*c < 0x20) *c = ' ';
    context->desc.log(context->desc.user, level, message);
}

void *rsv_reserve(rsv_context *context, size_t count, size_t size)
{
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes) || bytes > SIZE_MAX - 127) {
        rsv_fail(
            RSV_ERROR_MEMORY, "out of memory: %zu x %zu bytes cannot be addressed", count, size);
        return NULL;
    }
    bytes = (bytes / 64 + 1) * 64;
    void *memory = context->desc.allocate(context->desc.user, bytes);
    if (!memory) rsv_fail(RSV_ERROR_MEMORY, "out of memory: cannot allocate %zu bytes", bytes);
    return memory;
}

void *rsv_alloc(rsv_context *context, size_t count, size_t size)
{
    void *memory = rsv_reserve(context, count, size);
    if (memory) memset(memory, 0, (count * size / 64 + 1) * 64);
    return memory;
}

void rsv_free(rsv_context *context, void *memory)
{
    if (memory) context->desc.release(context->desc.user, memory);
}

rsv_status rsv_grow(
    rsv_context *context, void **array, size_t *capacity, size_t needed, size_t size)
{
    if (needed <= *capacity) return RSV_OK;
    size_t grown = *capacity + *capacity / 2 > needed ? *capacity + *capacity / 2 : needed;
    if (grown < 16) grown = 16;
    void *moved = rsv_alloc(context, grown, size);
    if (!moved) return RSV_ERROR_MEMORY;
    if (*array) memcpy(moved, *array, *capacity * size);
    rsv_free(context, *array);
    *array = moved;
    *capacity = grown;
    return RSV_OK;
}

char *rsv_copy_string(rsv_context *context, const char *text)
{
    size_t length = text ? strlen(text) : 0;
    char *copy = rsv_alloc(context, length + 1, 1);
    if (copy && length) memcpy(copy, text, length); // NOLINT: its end is a zero already
    return copy;
}

int rsv_threads(const rsv_context *context) { return context->thread_count; }

const rsv_context_desc *rsv_context_settings(const rsv_context *context) { return &context->desc; }

rsv_team *rsv_context_team(const rsv_context *context) { return context->desc.team; }

rsv_team *rsv_team_of(const rsv_context *context)
{
    rsv_team *team = context->desc.team;
    return team && team->size > 1 ? team : NULL;
}

rsv_team_place rsv_team_place_of(const rsv_context *context)
{
    const rsv_team *team = rsv_team_of(context);
    return team ? (rsv_team_place){ team->rank, team->size } : (rsv_team_place){ 0, 1 };
}

rsv_status rsv_team_meet(rsv_context *context, rsv_status status)
{
    rsv_team *team = rsv_team_of(context);
    if (!team) return status; // a single process may continue after a failure
    if (context->team_status != RSV_OK) return context->team_status;
    status = rsv_team_agree(team, status, NULL);
    if (status == RSV_OK) return status;
    context->team_status = status;
    rsv_context_cancel(context);
    return status;
}

void rsv_team_alarm(rsv_context *context)
{
    if (rsv_team_of(context)) rsv_context_cancel(context); // a single process may continue after a failure
}

rsv_device *rsv_context_device(const rsv_context *context)
{
    return context->device_lost ? NULL : context->desc.device;
}

rsv_status rsv_device_failed(rsv_context *context, rsv_status status, const char *message)
{
    context->device_lost = context->device_lost || status == RSV_ERROR_DEVICE;
    if (context->desc.device->desc.optional) {
        rsv_log(context, RSV_LOG_WARNING, "device: %s; the CPU is used instead", message);
        return RSV_OK;
    }
    context->device_status = status;
    snprintf(context->device_message, sizeof context->device_message, "%s", message);
    return rsv_fail(status, "device: %s", message);
}

bool rsv_was_asked_to_stop(const rsv_context *context)
{
    return atomic_load_explicit(&context->cancelled, memory_order_relaxed);
}

bool rsv_cancelled(const rsv_context *context)
{
    return rsv_was_asked_to_stop(context) ||
           (context->has_deadline && rsv_seconds() > context->deadline);
}

void rsv_set_deadline(rsv_context *context, double seconds)
{
    context->has_deadline = isfinite(seconds);
    context->deadline = seconds;
}

void rsv_progress_part(rsv_context *context, const char *name, uint32_t number)
{
    if (!name)
        context->part[0] = '\0';
    else if (number == 0)
        snprintf(context->part, sizeof context->part, "%s: ", name);
    else
        snprintf(context->part, sizeof context->part, "%s %u: ", name, number);
}

rsv_status rsv_progress(rsv_context *context, const char *phase_of_part, double fraction)
{
    char phase[2 * PART_BYTES];
    snprintf(phase, sizeof phase, "%s%s", context->part, phase_of_part);
    rsv_team *team = rsv_team_of(context);
    if (team) fraction = team->table->progress(team, phase, fraction);
    if (team && team->table->alarm(team, rsv_cancelled(context))) rsv_context_cancel(context);
    if (context->desc.progress && !context->desc.progress(context->desc.user, phase, fraction))
        rsv_context_cancel(context);
    if (context->team_status != RSV_OK) return context->team_status;
    if (context->device_status != RSV_OK)
        return rsv_fail(context->device_status, "device: %s", context->device_message);
    return rsv_cancelled(context) ? rsv_fail(RSV_ERROR_CANCELLED, "cancelled during '%s'", phase)
                                  : RSV_OK;
}

static double read_clock(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double rsv_seconds(void) { return read_clock(CLOCK_MONOTONIC); }

double rsv_thread_seconds(void) { return read_clock(CLOCK_THREAD_CPUTIME_ID); }
