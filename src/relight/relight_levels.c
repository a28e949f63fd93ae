/// Levels of direct light and caustics that are refined for sources that moved, and given back once these are at home.
#include "relight_responses.h"

#include <string.h>

static rsv_status copy_field(
    const rsv_relighter *r, const rsv_rgb *from, size_t count, rsv_rgb **copy)
{
    if (!from) return RSV_OK;
    *copy = rsv_alloc(r->context, count, sizeof **copy);
    if (!*copy) return RSV_ERROR_MEMORY;
    memcpy(*copy, from, count * sizeof **copy);
    return RSV_OK;
}

static size_t node_count(const rsv_elements *level) { return level ? level->node_count : 0; }

rsv_status rsv_relighter_keep_levels(rsv_relighter *r)
{
    rsv_status status = RSV_OK;
    if (!r->began || r->refined) return RSV_OK;
    size_t fine = node_count(r->s->fine.elements), caustic = node_count(r->s->caustics.elements);
    for (size_t k = 0; k < r->basis->source_count; k++) {
        const rsv_light_part *home = r->away[k] ? &r->home_part[k] : &r->basis->part[k];
        rsv_light_part_free(r->context, &r->began_part[k]);
        r->began_part[k] = (rsv_light_part){ 0 };
        RSV_TRY(copy_field(r, home->fine, fine, &r->began_part[k].fine));
        RSV_TRY(copy_field(r, home->caustic, caustic, &r->began_part[k].caustic));
    }
cleanup:
    return status;
}

void rsv_relighter_forget_levels(rsv_relighter *r)
{
    rsv_receiver_blocks_destroy(r->fine);
    rsv_free(r->context, r->valid);
    r->fine = NULL;
    r->valid = NULL;
    rsv_relight_responses_forget(r);
}

static void free_levels(const rsv_relighter *r, rsv_light_part *part)
{
    rsv_free(r->context, part->fine);
    rsv_free(r->context, part->caustic);
    part->fine = part->caustic = NULL;
}

void rsv_relighter_return_levels(rsv_relighter *r)
{
    rsv_relighter_forget_levels(r);
    for (size_t k = 0; k < r->basis->source_count; k++) {
        rsv_light_part *home = r->away[k] ? &r->home_part[k] : &r->basis->part[k];
        free_levels(r, &r->basis->part[k]);
        free_levels(r, home);
        home->fine = r->began_part[k].fine;
        home->caustic = r->began_part[k].caustic;
        r->began_part[k] = (rsv_light_part){ 0 };
        r->stale[k] = r->away[k];
    }
    r->refined = false;
    r->replacements++;
}
