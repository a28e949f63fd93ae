/// With T = G K >= 0 and S = (I - T)^-1, the norm of S for the largest error is M = max S 1. For any x with (I - T) x
/// >= d > 0, S 1 <= x / d. Here x = 1 + T 1 + ... + T^n 1, so d = 1 - max T^(n+1) 1.
///
/// G is symmetric if area is weighted by the transmission of coats. The adjoint of S is therefore (I - K G)^-1 = 1 + K
/// S G, with a norm of at most 1 + max albedo M, and by Schur's test ||S||_2 <= sqrt(M (1 + max albedo M)).
#include "amplification.h"

#include "../solve/transport_map.h"

#define MOST_ORDERS 1000
/// The bound is at most this much above its limit for more orders.
#define REST 0.02
/// Allowance for rounding in sums of floats.
#define ROUNDING 1e-5

static rsv_rgb rgb_most(rsv_rgb a, rsv_rgb b)
{
    return rgb(f_max(a.r, b.r), f_max(a.g, b.g), f_max(a.b, b.b));
}

static rsv_rgb largest(const rsv_rgb *value, size_t count)
{
    rsv_rgb most = rgb_gray(0);
    for (size_t n = 0; n < count; n++)
        most = rgb_most(most, value[n]);
    return most;
}

/// max x / d of one channel.
static double bound_of(double x, double rest)
{
    double d = 1 - rest - ROUNDING;
    return d > 0 ? x / d : (double)INFINITY;
}

/// @param term, image, sum [node_count] scratch
static double largest_answer(
    const rsv_transport_map *map, size_t nodes, rsv_rgb *term, rsv_rgb *image, rsv_rgb *sum)
{
    rsv_rgb rest = rgb_gray(1);
    for (size_t n = 0; n < nodes; n++)
        term[n] = sum[n] = rgb_gray(1);
    rsv_transport_map_mask(map, 1, term);
    for (int order = 0;; order++) {
        map->linear.table->apply(map->linear.data, 3, &term->r, &image->r);
        rest = largest(image, nodes);
        if ((double)rgb_max(rest) < REST || order == MOST_ORDERS) break;
        for (size_t n = 0; n < nodes; n++) {
            term[n] = image[n];
            sum[n] = rgb_add(sum[n], image[n]);
        }
    }
    rsv_rgb x = largest(sum, nodes);
    double r = bound_of((double)x.r, (double)rest.r), g = bound_of((double)x.g, (double)rest.g);
    return fmax(fmax(r, g), bound_of((double)x.b, (double)rest.b));
}

/// Over the materials that receive light.
static double coat_factor(const rsv_light_view *s)
{
    rsv_rgb least = rgb_gray(INFINITY), most = rgb_gray(0);
    for (size_t face = 0; face < s->elements->face_count; face++) {
        uint32_t triangle = s->elements->face_triangle[face];
        const rsv_bsdf *bsdf = &s->bsdf[s->scene.view->triangle_material[triangle]];
        rsv_rgb scale = bsdf->coated ? bsdf->entry_scale : rgb_gray(1);
        most = rgb_most(most, scale);
        least = rgb(f_min(least.r, scale.r), f_min(least.g, scale.g), f_min(least.b, scale.b));
    }
    float ratio = f_max(f_max(most.r / least.r, most.g / least.g), most.b / least.b);
    return ratio >= 1 ? sqrt((double)ratio) : 1;
}

rsv_status rsv_amplification_of(const rsv_light_view *s, double max_albedo, rsv_amplification *a)
{
    rsv_context *context = s->context;
    size_t nodes = s->elements->node_count;
    rsv_transport_map *map = NULL;
    rsv_rgb *term = rsv_alloc(context, nodes, sizeof *term);
    rsv_rgb *image = rsv_alloc(context, nodes, sizeof *image);
    rsv_rgb *sum = rsv_alloc(context, nodes, sizeof *sum);
    rsv_status status = RSV_OK;
    RSV_TRY(term && image && sum ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_operator_map(s->op, 1, &map));
    double m = largest_answer(map, nodes, term, image, sum);
    double by_albedo = max_albedo < 1 ? 1 / (1 - max_albedo) : (double)INFINITY;
    a->factor = fmin(by_albedo, sqrt(m * (1 + max_albedo * m)));
    a->coat_factor = coat_factor(s);
cleanup:
    rsv_transport_map_destroy(map);
    rsv_free(context, term);
    rsv_free(context, image);
    rsv_free(context, sum);
    return status;
}
