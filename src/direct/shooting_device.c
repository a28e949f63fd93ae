#include "shooting_device.h"

#include "../core/team.h"
#include "../trace/hierarchy.h"
#include "direct_constants.h"

static bool can_do(const rsv_device_shooting_desc *deal)
{
    rsv_context *context = deal->lights->context;
    const rsv_device *device = rsv_context_device(context);
    return device && device->desc.rows && !deal->shooting.scene->view->fog &&
           rsv_team_place_of(context).size == 1 && deal->map_count <= RSV_DEVICE_MAPS;
}

static rsv_status shoot(const rsv_device_shooting_table *table, rsv_device_shooting *shooting,
    const rsv_device_shooting_desc *deal, uint32_t total, char *message)
{
    rsv_status status = RSV_OK;
    double done = 0;
    for (size_t s = 0; s < deal->source_count; s++) {
        double share = deal->source[s].share;
        uint32_t count = rsv_photons_of_source(&deal->source[s], total);
        for (uint32_t first = 0; first < count && status == RSV_OK; first += PHOTONS_AT_A_TIME) {
            uint32_t left = count - first,
                     photons = left < PHOTONS_AT_A_TIME ? left : PHOTONS_AT_A_TIME;
            status = table->shoot(shooting, (uint32_t)s, first, photons, count, message);
            if (status != RSV_OK) return status;
            RSV_TRY(rsv_progress(deal->lights->context, "caustics",
                fmin(done + share * (first + photons) / count, 1)));
        }
        done += share;
    }
cleanup:
    return status;
}

rsv_status rsv_photons_by_device(
    const rsv_device_shooting_desc *deal, uint32_t count, uint64_t *rays, bool *done)
{
    rsv_status status = RSV_OK;
    char message[RSV_DEVICE_MESSAGE_BYTES] = "";
    rsv_context *context = deal->lights->context;
    rsv_device_shooting_desc desc = *deal;
    rsv_device_shooting *shooting = NULL;
    const rsv_device_shooting_table *table = NULL;
    *done = false;
    if (!can_do(deal)) return RSV_OK;
    table = rsv_context_device(context)->table->shooting;
    RSV_TRY(rsv_tracer_hierarchy(deal->shooting.scene->tracer, &desc.bvh));
    status = table->create(rsv_context_device(context), &desc, &shooting, message);
    if (status == RSV_OK) status = shoot(table, shooting, deal, count, message);
    if (status == RSV_OK) status = table->collect(shooting, deal->map, rays, message);
    *done = status == RSV_OK;
    // a job that is called off is no failure of the device
    if (status != RSV_OK && message[0]) status = rsv_device_failed(context, status, message);
cleanup:
    if (shooting) table->destroy(shooting);
    return status;
}
