/// Objects that several others hold: a count of the holders, 1 on creation, and the last one to let go frees the object.
#ifndef RSV_REFERENCES_H
#define RSV_REFERENCES_H

#include <stdatomic.h>
#include <stdbool.h>

/// One more holder. Thread-safe.
static inline void rsv_references_add(atomic_uint *count) { atomic_fetch_add(count, 1); }

/// One holder fewer. Thread-safe. @return whether that was the last one
static inline bool rsv_references_drop(atomic_uint *count)
{
    return atomic_fetch_sub(count, 1) == 1;
}

#endif
