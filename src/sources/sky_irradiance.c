/// Irradiance of every normal from the sky, once and for all.
#include "../core/core.h"
#include "../core/octahedral.h"
#include "../core/parallel.h"
#include "sky.h"

#define NODES RSV_SKY_IRRADIANCE_NODES
#define PATCH_SIDE 64 ///< octahedral patches of the sky, about 2.8 degrees wide

#define PATCHES (PATCH_SIDE * PATCH_SIDE)
#define LANES 8 ///< sums side by side, so that the compiler may use vectors

/// int L w dw over each patch, a vector per channel: exact for normals that see all of the patch.
typedef struct patch_fluxes {
    float vector[3][3][PATCHES]; ///< by channel and coordinate
} patch_fluxes;

static void add_patch(void *user, rsv_vec3 direction, double solid_angle, rsv_rgb radiance)
{
    patch_fluxes *flux = user;
    uint32_t patch = rsv_octahedral_bin(direction, PATCH_SIDE);
    const float d[3] = { direction.x, direction.y, direction.z };
    const float l[3] = { radiance.r, radiance.g, radiance.b };
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++)
            flux->vector[c][k][patch] += (float)solid_angle * l[c] * d[k];
}

/// Sanitizers would find nothing in loops of constant length, and would keep the compiler from using vectors.
__attribute__((no_sanitize("address", "undefined"))) static float sum_channel(
    const float vector[3][PATCHES], rsv_vec3 n)
{
    float lane[LANES] = { 0 };
    for (size_t p = 0; p < PATCHES; p += LANES) {
        for (size_t k = 0; k < LANES; k++) {
            float e = vector[0][p + k] * n.x + vector[1][p + k] * n.y + vector[2][p + k] * n.z;
            lane[k] += e > 0 ? e : 0;
        }
    }
    float sum = 0;
    for (int k = 0; k < LANES; k++)
        sum += lane[k];
    return sum;
}

typedef struct node_job {
    const patch_fluxes *flux;
    rsv_rgb *node;
} node_job;

static void sum_nodes(void *data, rsv_span span)
{
    const node_job *job = data;
    const patch_fluxes *flux = job->flux;
    for (size_t n = span.begin; n < span.end; n++) {
        float x = (float)(n % NODES) / RSV_SKY_IRRADIANCE_SIDE;
        float y = (float)(n / NODES) / RSV_SKY_IRRADIANCE_SIDE;
        rsv_vec3 normal = rsv_octahedral_to_direction(x, y);
        job->node[n] = rgb(sum_channel(flux->vector[0], normal),
            sum_channel(flux->vector[1], normal), sum_channel(flux->vector[2], normal));
    }
}

rsv_status rsv_sky_irradiance_create(
    rsv_context *context, const rsv_sky *sky, rsv_sky_irradiance *irradiance)
{
    irradiance->node = NULL;
    if (!sky->pixel) return RSV_OK;
    patch_fluxes *flux = rsv_alloc(context, 1, sizeof *flux);
    irradiance->node = rsv_alloc(context, NODES * NODES, sizeof *irradiance->node);
    if (!flux || !irradiance->node) {
        rsv_free(context, flux);
        return RSV_ERROR_MEMORY;
    }
    rsv_sky_visit(sky, add_patch, flux);
    node_job job = { flux, irradiance->node };
    rsv_parallel_for(context, NODES * NODES, 64, sum_nodes, &job);
    rsv_free(context, flux);
    return RSV_OK;
}

void rsv_sky_irradiance_destroy(rsv_context *context, rsv_sky_irradiance *irradiance)
{
    rsv_free(context, irradiance->node);
    irradiance->node = NULL;
}
