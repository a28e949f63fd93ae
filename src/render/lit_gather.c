#include "lit_gather.h"

#include "../sources/partition.h"
#include "../specular/fog_flight.h"
#include "camera_step.h"

/// A specular path on its way.
typedef struct traveller {
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    bool shot;
    rsv_random *random;
    rsv_specular_path path;
    rsv_rough_departure departure; ///< how it left the surface before
    rsv_rgb found;
    rsv_vec3 place; ///< in the fog, where that ends it
} traveller;

static void add(traveller *t, rsv_rgb radiance) { t->found = rgb_add(t->found, radiance); }

static bool counts(const traveller *t)
{
    return rsv_gathering_counts(t->lights, t->path.triangle, t->path.turns, t->shot);
}

static void add_emission(traveller *t, const rsv_bsdf *bsdf)
{
    const rsv_specular_path *path = &t->path;
    if (!bsdf->emissive || (path->back && !bsdf->double_sided) || !counts(t)) return;
    float weight = rsv_rough_emission_weight(t->scene, t->lights, path, &t->departure);
    rsv_rgb emission = rgb_scale(bsdf->emission, weight * bsdf->opacity);
    add(t, rgb_mul(rsv_specular_throughput(t->scene, path, &path->medium), emission));
}

static void add_sky(traveller *t)
{
    rsv_vec3 direction = t->path.direction;
    rsv_rgb sky = t->path.turns ? rsv_rough_sky(t->lights, direction, &t->departure)
                                : rsv_gathering_sky(t->lights, direction, 0, t->shot);
    add(t, rgb_mul(rsv_specular_throughput(t->scene, &t->path, &t->path.medium), sky));
}

/// Aims at sources. @param chance of coming to aim at them from here
static void add_aimed(traveller *t, const rsv_rough_surface *surface, float chance)
{
    float u[3];
    for (int k = 0; k < 3; k++)
        u[k] = rsv_random_float(t->random);
    add(t, rgb_scale(rsv_rough_light(surface, t->lights, t->shot, u), 1 / chance));
}

/// Draws what happens at the surface, and aims at sources where that is not the diffuse lobe.
static rsv_bsdf_event draw(traveller *t, const rsv_rough_surface *s)
{
    float opacity = s->bsdf->opacity;
    // what was aimed at was so past blended surfaces, too
    if (opacity < 1 && rsv_random_float(t->random) >= opacity)
        return rsv_event(RSV_LOBE_PASS, t->path.direction, rgb_gray(1));
    t->departure = (rsv_rough_departure){ .shot = t->shot };
    float u[3];
    for (int k = 0; k < 3; k++)
        u[k] = rsv_random_float(t->random);
    rsv_bsdf_event event = rsv_bsdf_draw_event(s->bsdf, s->wo, s->normal, s->front, u);
    if (event.lobe == RSV_LOBE_DIFFUSE || !s->bsdf->rough) return event;
    float specular = rsv_bsdf_specular_chance(s->bsdf, s->wo, s->normal, s->front);
    if (specular * opacity > 0) add_aimed(t, s, specular * opacity);
    if (event.lobe != RSV_LOBE_NONE && event.pdf_solid_angle > 0) {
        t->departure = rsv_rough_depart(s, event.direction, 0);
        t->departure.shot = t->shot;
    }
    return event;
}

/// Moves on by an event. @return false if the specular path ends, as `end` then says
static bool move_on(traveller *t, const rsv_bsdf_event *event, rsv_specular_end *end)
{
    *end = RSV_SPECULAR_ABSORBED;
    if (event->lobe == RSV_LOBE_NONE || t->path.events >= RSV_SPECULAR_MAX_EVENTS) return false;
    if (event->lobe == RSV_LOBE_DIFFUSE) {
        t->path.weight = rgb_mul(t->path.weight, event->weight);
        if (rsv_specular_survives(&t->path.weight, t->random)) *end = RSV_SPECULAR_DIFFUSE;
        return false;
    }
    rsv_specular_move move = rsv_specular_follow(t->scene, &t->path, event, event->weight);
    if (move == RSV_SPECULAR_MOVED) return rsv_specular_survives(&t->path.weight, t->random);
    if (move == RSV_SPECULAR_LEFT_SCENE) {
        *end = RSV_SPECULAR_SCATTERED;
        if (rsv_specular_lands(t->scene, &t->path, true, t->random, &t->place)) return false;
        add_sky(t);
        *end = RSV_SPECULAR_ESCAPED;
    }
    return false;
}

rsv_gather rsv_gather_lit(const rsv_transport_scene *scene, const rsv_lights *lights, bool shot,
    rsv_specular_path path, rsv_random *random)
{
    traveller t = { scene, lights, shot, random, path, { .shot = shot }, rgb_gray(0), v3(0, 0, 0) };
    rsv_gather gather = { .end = RSV_SPECULAR_ABSORBED };
    rsv_bsdf_event event;
    do {
        rsv_rough_surface surface;
        if (rsv_specular_lands(scene, &t.path, false, random, &t.place)) {
            gather.end = RSV_SPECULAR_SCATTERED;
            break;
        }
        rsv_rough_meet(scene, &t.path, &surface);
        add_emission(&t, surface.bsdf);
        event = draw(&t, &surface);
    } while (move_on(&t, &event, &gather.end));
    gather.path = t.path;
    gather.path.weight = rsv_specular_throughput(scene, &t.path, &t.path.medium);
    gather.emission = t.found;
    gather.place = t.place;
    return gather;
}
