/// Objects that several others hold: a count of the holders, 1 on creation, and the last one to let go frees the
/// object.
#ifndef RSV_REFERENCES_H
#define RSV_REFERENCES_H

#include <stdbool.h>
#include <stdint.h>

/// One more holder. Thread-safe. (The count is a plain number, as CUDA's compiler reads structs that hold one.)
static inline void rsv_references_add(uint32_t *count)
{
    __atomic_fetch_add(count, 1, __ATOMIC_SEQ_CST);
}

/// One holder fewer. Thread-safe. @return whether that was the last one
static inline bool rsv_references_drop(uint32_t *count)
{
    return __atomic_fetch_sub(count, 1, __ATOMIC_SEQ_CST) == 1;
}

#endif
