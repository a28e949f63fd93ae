#include "alias_table.h"

rsv_status rsv_alias_table_fill(
    rsv_context *context, const double *weight, size_t count, rsv_alias_entry *table)
{
    double sum = 0;
    for (size_t k = 0; k < count; k++)
        sum += weight[k];
    // those below the mean from the front, those above from the back
    uint32_t *stack = rsv_alloc(context, count, sizeof *stack);
    double *left = rsv_alloc(context, count, sizeof *left);
    size_t small = 0, large = count;
    bool complete = stack && left;
    for (size_t k = 0; complete && k < count; k++) {
        left[k] = sum > 0 ? weight[k] * (double)count / sum : 1;
        table[k] = (rsv_alias_entry){ 1, (uint32_t)k };
        if (left[k] < 1)
            stack[small++] = (uint32_t)k;
        else
            stack[--large] = (uint32_t)k;
    }
    while (complete && small > 0 && large < count) {
        uint32_t under = stack[--small], over = stack[large];
        table[under] = (rsv_alias_entry){ (float)left[under], over };
        left[over] -= 1 - left[under];
        if (left[over] >= 1) continue;
        large++;
        stack[small++] = over;
    }
    rsv_free(context, stack);
    rsv_free(context, left);
    return complete ? RSV_OK : RSV_ERROR_MEMORY;
}
