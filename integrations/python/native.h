/// What the bindings add to the library: callbacks that reach Python, rarely enough to cost nothing.
#ifndef RSV_PYTHON_NATIVE_H
#define RSV_PYTHON_NATIVE_H

#include <resolvent/resolvent.h>

#include <stdatomic.h>
#include <time.h>

/// Progress is told so often, and signals are looked at.
#define RSV_PY_NANOSECONDS 20000000

/// What the callbacks of a context get.
typedef struct rsv_py_user {
    void *handle;              ///< the context's, in Python
    _Atomic(long long) silent; ///< nanoseconds until which nothing is told
} rsv_py_user;

/// These are Python's.
static bool rsv_py_progress(void *handle, const char *phase, double fraction);
static void rsv_py_log(void *handle, rsv_log_level level, const char *message);

static bool rsv_py_tell_progress(void *user, const char *phase, double fraction)
{
    rsv_py_user *u = user;
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    long long now = 1000000000LL * time.tv_sec + time.tv_nsec;
    if (now < atomic_load_explicit(&u->silent, memory_order_relaxed)) return true;
    atomic_store_explicit(&u->silent, now + RSV_PY_NANOSECONDS, memory_order_relaxed);
    return rsv_py_progress(u->handle, phase, fraction);
}

static void rsv_py_tell_log(void *user, rsv_log_level level, const char *message)
{
    rsv_py_log(((rsv_py_user *)user)->handle, level, message);
}

/// @param user lives as long as the context
static rsv_status rsv_py_context_create(
    int thread_count, void *handle, rsv_py_user *user, rsv_context **context)
{
    rsv_context_desc desc = rsv_default_context_desc();
    user->handle = handle;
    desc.thread_count = thread_count;
    desc.log = rsv_py_tell_log;
    desc.progress = rsv_py_tell_progress;
    desc.user = user;
    return rsv_context_create(&desc, context);
}

/// Whether this CPU has the instructions that the library was compiled to.
static bool rsv_py_runs_here(void)
{
#if defined(RSV_PY_AVX2)
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
           __builtin_cpu_supports("bmi2");
#else
    return true;
#endif
}

#endif
