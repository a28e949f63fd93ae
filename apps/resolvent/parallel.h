/// Loops of the program itself. Those of the library run on threads of the library.
#ifndef CLI_PARALLEL_H
#define CLI_PARALLEL_H

#include <stddef.h>
#include <stdint.h>

/// Calls `body(job, begin, end)` for spans of at most `grain` indices that cover 0 <= i < count once, on at most
/// `threads` threads at a time; returns when all are done.
void cli_parallel_for(uint32_t threads, size_t count, size_t grain,
    void (*body)(void *job, size_t begin, size_t end), void *job);

#endif
