/// Values of nodes that hang, as means of nodes that do not: specular paths of parents are resolved.
#ifndef RSV_PARENTS_H
#define RSV_PARENTS_H

#include "../elements/elements.h"

typedef struct rsv_parents {
    uint32_t *begin; ///< [node_count + 1] into `node` and `weight`; free nodes have none
    uint32_t *node;  ///< free
    float *weight;
} rsv_parents;

rsv_status rsv_parents_create(const rsv_elements *elements, rsv_parents *parents);
void rsv_parents_destroy(rsv_context *context, rsv_parents *parents);

#endif
