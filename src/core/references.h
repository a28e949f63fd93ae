/// Objects that several others hold: a count of the holders, 1 on creation, and the last one to let go frees the object.
#ifndef RSV_REFERENCES_H
#define RSV_REFERENCES_H

#include <stdbool.h>
#include <stdint.h>

/// One more holder. Thread-safe.
static inline void rsv_references_add(uint32_t *count)
{
#pragma omp atomic update seq_cst
    ++*count;
}

/// One holder fewer. Thread-safe. @return whether that was the last one
static inline bool rsv_references_drop(uint32_t *count)
{
    uint32_t left;
#pragma omp atomic capture seq_cst
    left = --*count;
    return left == 0;
}

#endif
