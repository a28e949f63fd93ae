#include "specular_media.h"

#include "../core/core.h"
#include "packet_kernels.h"

#include <string.h>

enum { NO_BODY = RSV_MEDIA_BODIES, BODY_LEFT_OUT };

// ---- the list -----------------------------------------------------------------------------------

/// Whether rsv_bsdf_evaluate_branches is rsv_set_ideal_branches everywhere, and the surface shows nothing else.
static bool is_smooth(const rsv_transport_scene *scene, uint32_t material)
{
    const rsv_bsdf *b = &scene->bsdf[material];
    bool ideal = !b->lambert && !b->rough && b->alpha == 0 && b->diffuse == 0 && !b->layered &&
                 b->film.share == 0;
    bool covers = b->opacity >= 1 && (b->double_sided || b->transmission > 0);
    return ideal && covers && !b->emissive && !b->unlit && !scene->view->material_varies[material];
}

static bool same_medium(const rsv_medium *a, const rsv_medium *b)
{
    if (a->depth != b->depth) return false;
    for (uint32_t k = 0; k < a->depth; k++)
        if (a->body[k] != b->body[k]) return false;
    return true;
}

_Static_assert(RSV_MEDIA + RSV_MAX_EYES <= RSV_MEDIUM_UNLISTED, "a number for each eye");

static void set_medium(rsv_specular_media *m, uint32_t k, const rsv_medium *medium)
{
    m->medium[k] = *medium;
    m->ior[k] = rsv_medium_ior(medium, m->scene->bsdf);
    m->absorbs[k] = rsv_medium_absorbs(medium, m->scene->bsdf);
}

static uint8_t find(const rsv_specular_media *m, const rsv_medium *medium)
{
    uint32_t k = 0;
    while (k < m->count && !same_medium(&m->medium[k], medium))
        k++;
    return (uint8_t)(k < m->count ? k : RSV_MEDIUM_UNLISTED);
}

/// Its number, which it is given if there is room.
static uint8_t list(rsv_specular_media *m, const rsv_medium *medium)
{
    uint8_t found = find(m, medium);
    if (found != RSV_MEDIUM_UNLISTED || m->count == RSV_MEDIA) return found;
    set_medium(m, m->count, medium);
    return (uint8_t)m->count++;
}

static void list_neighbours(rsv_specular_media *m, uint32_t from, uint32_t body, uint32_t material)
{
    rsv_medium inside = m->medium[from], front = inside, back = inside;
    rsv_medium_arrive_inside(&inside, material);
    rsv_medium_cross(&front, material, false);
    rsv_medium_cross(&back, material, true);
    m->inside[body][from] = list(m, &inside);
    m->cross[0][body][from] = list(m, &front);
    m->cross[1][body][from] = list(m, &back);
}

/// Lists the media that the bodies make, those of few bodies first. @param bodies [count] their materials
static void list_media(rsv_specular_media *m, const uint32_t *bodies, uint32_t count)
{
    const rsv_medium outside = { { 0 }, 0 };
    memset(m->inside, RSV_MEDIUM_UNLISTED, sizeof m->inside);
    memset(m->cross, RSV_MEDIUM_UNLISTED, sizeof m->cross);
    list(m, &outside);
    for (uint32_t from = 0; from < m->count; from++)
        for (uint32_t k = 0; k < count; k++)
            list_neighbours(m, from, k, bodies[k]);
    for (uint32_t from = 0; from < RSV_MEDIUM_UNLISTED; from++)
        m->inside[NO_BODY][from] = m->cross[0][NO_BODY][from] = m->cross[1][NO_BODY][from] =
            (uint8_t)from;
}

rsv_status rsv_specular_media_create(
    rsv_context *context, const rsv_transport_scene *scene, rsv_specular_media *m)
{
    uint32_t bodies[RSV_MEDIA_BODIES], count = 0;
    size_t materials = scene->view->material_count;
    m->context = context;
    m->scene = scene;
    m->material = rsv_alloc(context, materials, sizeof *m->material);
    if (!m->material) return RSV_ERROR_MEMORY;
    for (uint32_t k = 0; k < materials; k++) {
        bool solid = scene->bsdf[k].solid;
        uint32_t body = !solid ? NO_BODY : count < RSV_MEDIA_BODIES ? count : BODY_LEFT_OUT;
        m->material[k] = (rsv_material_traits){ (uint8_t)body, is_smooth(scene, k) };
        if (body < NO_BODY) bodies[count++] = k;
    }
    list_media(m, bodies, count);
    return RSV_OK;
}

void rsv_specular_media_refresh(rsv_specular_media *m)
{
    for (uint32_t k = 0; k < m->scene->view->material_count; k++)
        m->material[k].smooth = is_smooth(m->scene, k);
    for (uint32_t k = 0; k < m->count; k++)
        set_medium(m, k, &m->medium[k]);
}

void rsv_specular_media_destroy(rsv_specular_media *m)
{
    if (m->context) rsv_free(m->context, m->material);
}

uint8_t rsv_specular_media_of_eye(rsv_specular_media *m, uint32_t eye, const rsv_medium *medium)
{
    uint8_t found = find(m, medium);
    if (found != RSV_MEDIUM_UNLISTED) return found;
    set_medium(m, RSV_MEDIA + eye, medium);
    return (uint8_t)(RSV_MEDIA + eye);
}

// ---- arrival ------------------------------------------------------------------------------------

static void dim(const rsv_specular_media *m, uint32_t lane, float distance, rsv_specular_lanes *c)
{
    rsv_rgb left = rsv_medium_transmittance(&m->medium[c->medium[lane]], m->scene->bsdf, distance);
    rsv_set_lane_color(c->weight, lane, rgb_mul(rsv_lane_color(c->weight, lane), left));
}

/// At a surface that is not in the table. @return whether the medium is listed
static bool arrive(
    const rsv_specular_media *m, uint32_t material, uint32_t k, rsv_specular_lanes *c)
{
    uint8_t body = m->material[material].body;
    int medium = c->back[k] ? m->inside[body][c->medium[k]] : c->medium[k];
    if (medium == RSV_MEDIUM_UNLISTED) return false;
    if (body != NO_BODY) {
        if (!c->settled[k]) c->start_ior[k] = m->ior[medium];
        c->settled[k] = 1;
    }
    c->material[k] = material;
    c->medium[k] = medium;
    return true;
}

/// rsv_specular_throughput
static void set_throughput(const rsv_specular_media *m, rsv_specular_lanes *c)
{
    float ior[RSV_LANES];
    for (uint32_t k = 0; k < RSV_LANES; k++)
        ior[k] = m->ior[c->medium[k]];
    for (uint32_t k = 0; k < RSV_LANES; k++) {
        float ratio = c->start_ior[k] / ior[k];
        rsv_rgb weight = rsv_lane_color(c->weight, k);
        rsv_set_lane_color(c->throughput, k, rgb_scale(weight, ratio * ratio));
    }
}

uint32_t rsv_specular_media_arrive(
    const rsv_specular_media *m, const rsv_arrival *a, uint32_t lanes, float spread)
{
    const rsv_ray_packet *p = a->rays;
    rsv_specular_lanes *c = a->paths;
    uint32_t unlisted = 0;
    for (uint32_t k = 0; k < RSV_LANES; k++)
        c->back[k] = rsv_packet_meets_back(p, k);
    for (uint32_t left = lanes & a->left; left; left &= left - 1) {
        uint32_t k = (uint32_t)__builtin_ctz(left);
        uint32_t material = (uint32_t)a->places->cell[k] - 1;
        if (material >= m->scene->view->material_count) // the cell of a glossy surface
            material = m->scene->view->triangle_material[p->triangle[k]];
        if (!arrive(m, material, k, c))
            unlisted |= 1u << k;
        else
            c->width[k] += spread * p->t_max[k];
    }
    for (uint32_t in = lanes & ~unlisted; in; in &= in - 1) {
        uint32_t k = (uint32_t)__builtin_ctz(in);
        if (m->absorbs[c->medium[k]]) dim(m, k, p->t_max[k], c);
    }
    set_throughput(m, c);
    return unlisted;
}
