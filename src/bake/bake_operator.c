#include "bake_operator.h"

#include "../core/parallel.h"
#include "../opfile/exchange.h"
#include "bake_basis.h"

#include <string.h>

rsv_status rsv_bake_check_operator(const rsv_light_view *s, const rsv_bake_desc *desc)
{
    if (!desc->operator_file || !s->subsurface) return RSV_OK;
    return rsv_fail(RSV_ERROR_UNSUPPORTED,
        "bake: an operator for run time cannot hold translucent materials; leave it out, or bake a "
        "basis, which holds their light too");
}

/// Where receivers lie.
typedef struct receiver_places {
    const rsv_elements *elements;
    const rsv_bake_receiver *receiver; ///< [count]
    uint32_t (*element)[3];            ///< [count] out
    float (*weight)[3];                ///< [count] out
} receiver_places;

/// Elements and weights of a place; nothing where no light is kept.
static void locate(
    const rsv_elements *e, const rsv_bake_receiver *r, uint32_t element[3], float weight[3])
{
    uint32_t face = r->triangle == RSV_NONE ? RSV_NONE : e->face_of[r->back][r->triangle];
    if (face == RSV_NONE) {
        memset(element, 0, 3 * sizeof *element);
        memset(weight, 0, 3 * sizeof *weight);
        return;
    }
    uint32_t cell = rsv_elements_locate(e, face, r->u, r->v, weight);
    memcpy(element, e->cell_node[cell], 3 * sizeof *element);
}

static void locate_span(void *job, rsv_span span)
{
    const receiver_places *p = job;
    for (size_t n = span.begin; n < span.end; n++)
        locate(p->elements, &p->receiver[n], p->element[n], p->weight[n]);
}

rsv_status rsv_bake_write_operator(const rsv_light_view *s, const char *kind,
    const rsv_bake_receiver *receiver, size_t count, const char *output)
{
    rsv_status status;
    char path[RSV_PATH_BYTES];
    uint32_t(*element)[3] = rsv_alloc(s->context, count, sizeof *element);
    float(*weight)[3] = rsv_alloc(s->context, count, sizeof *weight);
    RSV_TRY(element && weight ? RSV_OK : RSV_ERROR_MEMORY);
    receiver_places places = { s->elements, receiver, element, weight };
    rsv_parallel_for(s->context, count, 0, locate_span, &places);
    const char *slash = strrchr(output, '/');
    rsv_bake_name_beside(output, "operator", path);
    const rsv_file_receivers receivers = { kind, count, element, weight };
    RSV_TRY(rsv_light_save_receivers(s->light, slash ? slash + 1 : output, &receivers, path));
cleanup:
    rsv_free(s->context, element);
    rsv_free(s->context, weight);
    return status;
}
