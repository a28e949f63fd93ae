/// Work on hostile input by code that others wrote, done where it can do no harm.
#ifndef RSV_CHILD_PROCESS_H
#define RSV_CHILD_PROCESS_H

#include "resolvent/core.h"

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/// What is done; must not depend on other threads. @param answer where results go
/// @return as usual, with a message of rsv_fail
typedef rsv_status (*rsv_child_work)(void *user, FILE *answer);

/// Does `work` in a child of this process, with bounds to its time and memory that grow with the input. Nothing of what it
/// does to memory reaches the caller: all that comes back is the bytes of its answer, or its error. Where it crashes, hangs
/// or runs out of memory, the error says so.
/// @param bytes of the input @param answer, count out: to be released by rsv_free(context, ...); bytes that the child sent,
/// which may have gone astray before: check them
rsv_status rsv_in_child_process(rsv_context *context, rsv_child_work work, void *user, size_t bytes,
    uint8_t **answer, size_t *count);

#endif
