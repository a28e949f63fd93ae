#include "light_sum.h"

#include <stdlib.h>

rsv_status rsv_light_sum_create(rsv_context *context, size_t points, rsv_light_sum *sum)
{
    *sum = (rsv_light_sum){ 0 };
    bool made = true;
    for (int l = 0; l < RSV_LIGHT_LEVELS; l++) {
        sum->term[l] = rsv_reserve(context, 3 * points, sizeof *sum->term[l]);
        made = made && sum->term[l];
    }
    return made ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_light_sum_destroy(rsv_context *context, rsv_light_sum *sum)
{
    for (int l = 0; l < RSV_LIGHT_LEVELS; l++)
        rsv_free(context, sum->term[l]);
}

static void list_levels(const rsv_light_view *s, const rsv_elements *level[RSV_LIGHT_LEVELS])
{
    level[0] = s->elements;
    level[1] = s->fine.direct && s->caustics.caustic ? s->caustics.elements : NULL;
    level[2] = s->fine.direct ? s->fine.elements : NULL;
}

void rsv_light_sum_add(rsv_light_sum *sum, const rsv_light_view *light,
    const rsv_triangle_point *point, rsv_rgb weight)
{
    const rsv_elements *level[RSV_LIGHT_LEVELS];
    uint32_t face = light->elements->face_of[point->back_side][point->triangle];
    if (face == RSV_NONE) return;
    list_levels(light, level);
    for (int l = 0; l < RSV_LIGHT_LEVELS; l++) {
        float w[3];
        if (!level[l]) continue;
        const uint32_t *node =
            level[l]->cell_node[rsv_elements_locate(level[l], face, point->u, point->v, w)];
        for (int k = 0; k < 3; k++)
            sum->term[l][sum->added + (size_t)k] =
                (rsv_light_sum_term){ node[k], rgb_scale(weight, w[k]) };
    }
    sum->added += 3;
}

static int compare_nodes(const void *a, const void *b)
{
    uint32_t x = ((const rsv_light_sum_term *)a)->node, y = ((const rsv_light_sum_term *)b)->node;
    return (x > y) - (x < y);
}

void rsv_light_sum_close(rsv_light_sum *sum, const rsv_light_view *light)
{
    const rsv_elements *level[RSV_LIGHT_LEVELS];
    list_levels(light, level);
    for (int l = 0; l < RSV_LIGHT_LEVELS; l++) {
        rsv_light_sum_term *term = sum->term[l];
        size_t kept = 0;
        sum->count[l] = 0;
        if (!level[l] || !sum->added) continue;
        qsort(term, sum->added, sizeof *term, compare_nodes);
        for (size_t k = 1; k < sum->added; k++)
            if (term[k].node == term[kept].node)
                term[kept].weight = rgb_add(term[kept].weight, term[k].weight);
            else
                term[++kept] = term[k];
        sum->count[l] = kept + 1;
    }
}

static rsv_rgb add_field(const rsv_light_sum *sum, int level, const rsv_rgb *field)
{
    rsv_rgb all = rgb_gray(0);
    for (size_t k = 0; k < sum->count[level]; k++) {
        const rsv_light_sum_term *term = &sum->term[level][k];
        all = rgb_add(all, rgb_mul(term->weight, field[term->node]));
    }
    return all;
}

rsv_rgb rsv_light_sum_of(const rsv_light_sum *sum, const rsv_light_view *s)
{
    rsv_rgb all = add_field(sum, 0, s->indirect);
    if (!s->fine.direct) return rgb_add(all, add_field(sum, 0, s->source));
    all = rgb_add(all, add_field(sum, 0, s->gathered));
    if (s->caustics.caustic) all = rgb_add(all, add_field(sum, 1, s->caustics.caustic));
    return rgb_add(all, add_field(sum, 2, s->fine.direct));
}
