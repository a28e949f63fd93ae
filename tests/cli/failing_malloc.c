/// A malloc, to be preloaded before the C library's, whose call number RSV_FAIL fails. If RSV_FAIL is "count", it
/// prints the number of calls at the end instead.
#define _GNU_SOURCE
#include <errno.h>
#include <malloc.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void *__libc_malloc(size_t bytes);
void *__libc_calloc(size_t count, size_t bytes);
void *__libc_realloc(void *memory, size_t bytes);
void *__libc_memalign(size_t alignment, size_t bytes);

static atomic_long calls;
static long failing = -1;
static bool counts;

__attribute__((constructor)) static void begin(void)
{
    const char *wish = getenv("RSV_FAIL");
    counts = wish && strcmp(wish, "count") == 0;
    if (wish && !counts) failing = atol(wish);
    atomic_store(&calls, 0);
}

__attribute__((destructor)) static void end(void)
{
    if (counts) fprintf(stderr, "calls: %ld\n", atomic_load(&calls));
}

static bool fails(void)
{
    bool now = atomic_fetch_add(&calls, 1) == failing;
    if (now) errno = ENOMEM;
    return now;
}

void *malloc(size_t bytes) { return fails() ? NULL : __libc_malloc(bytes); }
void *calloc(size_t count, size_t bytes) { return fails() ? NULL : __libc_calloc(count, bytes); }
void *realloc(void *memory, size_t bytes) { return fails() ? NULL : __libc_realloc(memory, bytes); }

void *memalign(size_t alignment, size_t bytes)
{
    return fails() ? NULL : __libc_memalign(alignment, bytes);
}

void *aligned_alloc(size_t alignment, size_t bytes) { return memalign(alignment, bytes); }

int posix_memalign(void **memory, size_t alignment, size_t bytes)
{
    void *made = memalign(alignment, bytes);
    if (!made) return ENOMEM;
    *memory = made;
    return 0;
}
