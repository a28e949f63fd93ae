/// Work on hostile input by code that others wrote, done where it can do no harm.
#ifndef RSV_CHILD_PROCESS_H
#define RSV_CHILD_PROCESS_H

#include "resolvent/core.h"

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/// The work to do; must not depend on other threads. @param answer where results are written
/// @return an error as usual, with a message set by rsv_fail
typedef rsv_status (*rsv_child_work)(void *user, FILE *answer);

/// Runs `work` in a child of this process, with limits on time and memory that grow with the input. Nothing it does to
/// memory reaches the caller: only the bytes of its answer, or its error, come back. If it crashes, hangs or runs out
/// of memory, that becomes an error.
/// @param bytes size of the input @param answer, count out: the bytes that the child sent, to be released by
/// rsv_free(context, ...). The child may have corrupted its memory before it sent them: check them
rsv_status rsv_in_child_process(rsv_context *context, rsv_child_work work, void *user, size_t bytes,
    uint8_t **answer, size_t *count);

#endif
