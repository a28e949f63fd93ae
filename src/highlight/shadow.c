/// The share of highlights that arrives, from a few shadow rays.
///
/// A ray draws a source by how much it gives, and there a direction: of a few that are uniform under a lobe's transformed cosine
/// or on it, one by what the lobe makes of its light (resampling, Talbot et al. 2005). So it stands for the light that
/// closed forms know, and the visibility found is right in the mean with one ray.
#include "highlights_internal.h"
#include "lobe_polygon.h"

#include "../sources/local_lights.h"
#include "../sources/punctual_light.h"
#include "../surface/lift.h"

#define CANDIDATES 4

/// Random numbers of a ray, one after the other.
typedef struct numbers {
    uint32_t seed, next;
} numbers;

static float draw(numbers *n) { return rsv_unit_float(rsv_hash3(n->seed, n->next++, 0x51ed27u)); }

/// A shadow ray in the making.
typedef struct shadow_ray {
    rsv_vec3 direction;
    float distance;
    uint32_t emitter; ///< RSV_NONE = none
    const rsv_punctual_light *light;
    float weight; ///< of the candidate
} shadow_ray;

/// A lobe by its albedo. @param probability out
static const rsv_highlight_lobe *draw_lobe(
    const rsv_highlight_lobes *l, float u, float *probability)
{
    float total = 0;
    uint32_t last = 0;
    for (uint32_t k = 0; k < l->count; k++)
        total += rgb_luminance(l->lobe[k].albedo);
    u *= total;
    for (uint32_t k = 0; k < l->count; k++) {
        float own = rgb_luminance(l->lobe[k].albedo);
        if (!(own > 0)) continue;
        last = k;
        if (u < own) break;
        u -= own;
    }
    *probability = total > 0 ? rgb_luminance(l->lobe[last].albedo) / total : 0;
    return &l->lobe[last];
}

/// A lamp of a group by its rough light. @return its probability; 0 = none
static float draw_lamp(const rsv_highlights *h, const rsv_highlight_lobes *l, uint32_t group,
    numbers *n, const rsv_lamp **lamp)
{
    uint32_t node = h->lamps.root[group];
    float probability = 1, detail, u = draw(n);
    if (node == RSV_NONE) return 0;
    while (h->lamps.node[node].right) {
        uint32_t right = h->lamps.node[node].right;
        float a = rsv_lamp_urge(h, l, node + 1, &detail), b = rsv_lamp_urge(h, l, right, &detail);
        if (!(a + b > 0)) return 0;
        float share = a / (a + b);
        bool left = u < share;
        u = left ? u / share : (u - share) / (1 - share);
        probability *= left ? share : 1 - share;
        node = left ? node + 1 : right;
    }
    *lamp = &h->lamps.lamp[h->lamps.node[node].lamp];
    return probability;
}

/// A direction uniform over a polygon on the unit sphere. @return solid angle of the polygon; 0 = too small to be divided
static float draw_direction(const rsv_lobe_polygon *p, float u, float v, rsv_vec3 *direction)
{
    rsv_spherical_triangle triangle[RSV_LOBE_CORNERS];
    double total = 0;
    for (uint32_t i = 0; i + 2 < p->count; i++) {
        rsv_double3 corner[3] = { d3_from(p->corner[0]), d3_from(p->corner[i + 1]),
            d3_from(p->corner[i + 2]) };
        triangle[i] = rsv_spherical_triangle_from(corner);
        total += triangle[i].solid_angle;
    }
    if (!(total > 1e-9)) return 0;
    double place = u * total;
    uint32_t k = 0;
    while (k + 3 < p->count && place >= triangle[k].solid_angle)
        place -= triangle[k++].solid_angle;
    double within = triangle[k].solid_angle > 0 ? place / triangle[k].solid_angle : 0.5;
    *direction = d3_to_float(rsv_spherical_triangle_sample(&triangle[k], fmin(within, 1), v));
    return (float)total;
}

/// From the place under a lobe to a candidate. @param density per solid angle under the plain cosine
static void weigh(const rsv_highlight_lobes *l, const rsv_highlight_lobe *lobe, rsv_vec3 v,
    float density, float luminance, shadow_ray *ray)
{
    rsv_vec3 local = rsv_lobe_direction(&lobe->shape, v);
    float stretch = RSV_PI * rsv_lobe_density(&lobe->shape, local) / f_max(v.z, 1e-6f);
    if (rsv_lobe_is_below(lobe->kind)) local.z = -local.z;
    ray->direction = v3_normalize(rsv_from_lobe_frame(l, local));
    rsv_rgb response = rsv_lobe_response(l, lobe->kind, ray->direction);
    float weight = rgb_luminance(response) * luminance / (density * stretch);
    ray->weight = isfinite(weight) ? weight : 0;
}

static float distance_to(const rsv_lamp *lamp, rsv_vec3 point, rsv_vec3 direction)
{
    float height = v3_dot(lamp->normal, v3_sub(lamp->corner[0], point));
    return height / v3_dot(lamp->normal, direction);
}

static void towards_lamp(const rsv_highlights *h, const rsv_highlight_lobes *l, uint32_t group,
    numbers *n, shadow_ray *ray)
{
    const rsv_lamp *lamp;
    float chance, probability = draw_lamp(h, l, group, n, &lamp);
    const rsv_highlight_lobe *lobe = draw_lobe(l, draw(n), &chance);
    float u = draw(n), v = draw(n);
    if (!(probability > 0) || !(chance > 0)) return;
    if (!rsv_emitter_faces(&h->lights->emitter[lamp->emitter], l->point.position)) return;
    rsv_local_polygon local;
    rsv_lobe_polygon polygon;
    rsv_vec3 place = v3(0, 0, 1);
    rsv_local_polygon_of(
        l, lamp->corner, lamp->count, rsv_lobe_is_below(lobe->kind) ? -1 : 1, &local);
    if (local.count < 3) return;
    rsv_lobe_polygon_of(&lobe->shape, &local, &polygon);
    float solid_angle = draw_direction(&polygon, u, v, &place);
    if (!(solid_angle > 0)) { // a lamp so small that any place will do
        place = polygon.corner[(uint32_t)(u * (float)polygon.count)];
        solid_angle = 1e-9f;
    }
    weigh(l, lobe, place, probability * chance / solid_angle, rgb_luminance(lamp->radiance), ray);
    ray->emitter = lamp->emitter;
    ray->distance = distance_to(lamp, l->point.position, ray->direction);
    if (!(ray->distance > 0) || !(ray->distance < INFINITY)) ray->weight = 0;
}

static void towards_sky(
    const rsv_highlights *h, const rsv_highlight_lobes *l, numbers *n, shadow_ray *ray)
{
    float chance;
    const rsv_highlight_lobe *lobe = draw_lobe(l, draw(n), &chance);
    float u = draw(n), v = draw(n);
    rsv_vec3 place = rsv_square_to_cosine_hemisphere(u, v);
    if (!(chance > 0)) return;
    weigh(l, lobe, place, chance * place.z / RSV_PI, 1, ray);
    if (v3_dot(l->point.horizon, ray->direction) * v3_dot(l->point.normal, ray->direction) <= 0)
        ray->weight = 0;
    ray->weight *= rgb_luminance(rsv_sky_map_mean(&h->sky, ray->direction, 0));
}

/// A direction to a source. @return false: none that gives light
static bool aim(const rsv_highlights *h, const rsv_highlight_lobes *l, uint32_t source, numbers *n,
    shadow_ray *ray)
{
    rsv_highlight_source s = rsv_highlights_source(h, source);
    rsv_rgb irradiance;
    *ray = (shadow_ray){ .distance = INFINITY, .emitter = RSV_NONE };
    if (s.kind == RSV_HIGHLIGHT_SUN) {
        float u = draw(n), v = draw(n);
        ray->direction = rsv_sun_sample(&h->lights->environment->sun[s.index], u, v);
        return true;
    }
    if (s.kind == RSV_HIGHLIGHT_PUNCTUAL) {
        ray->light = &h->lights->scene->light[s.index];
        return rsv_punctual_irradiance(
            ray->light, l->point.position, &ray->direction, &ray->distance, &irradiance);
    }
    float total = 0, u = draw(n);
    for (int k = 0; k < CANDIDATES; k++) {
        shadow_ray other = { .distance = INFINITY, .emitter = RSV_NONE };
        if (s.kind == RSV_HIGHLIGHT_GROUP)
            towards_lamp(h, l, s.index, n, &other);
        else
            towards_sky(h, l, n, &other);
        if (!(other.weight > 0)) continue;
        total += other.weight;
        float share = other.weight / total;
        if (u < share) {
            *ray = other;
            u /= share;
        } else {
            u = (u - share) / (1 - share);
        }
    }
    return total > 0;
}

static rsv_vec3 leaving_point(const rsv_surface_point *p, rsv_vec3 normal, rsv_vec3 direction)
{
    if (v3_dot(normal, direction) < 0)
        return rsv_moved_off(p->position, v3_neg(p->geometric), p->extent);
    return rsv_lifted_origin(p, rsv_moved_off(p->position, p->geometric, p->extent), direction);
}

/// Share that arrives along a ray.
static float trace(const rsv_highlights *h, const rsv_tracer *tracer, const rsv_highlight_lobes *l,
    const rsv_surface_point *surface, const shadow_ray *r)
{
    rsv_vec3 origin = leaving_point(surface, l->point.normal, r->direction);
    rsv_ray ray;
    if (r->light) {
        rsv_punctual_sample to = { r->light, r->direction, r->distance, { 0, 0, 0 } };
        ray = rsv_punctual_ray(&to, origin);
    } else {
        rsv_light_sample to = {
            .direction = r->direction, .distance = r->distance, .emitter = r->emitter
        };
        ray = rsv_shadow_ray(h->lights, &to, surface->position, origin);
    }
    return rsv_tracer_passed(tracer, &ray);
}

/// Sources that rays go to, by their luminance.
typedef struct shadow_sums {
    rsv_rgb known, open; ///< light whose share is known, light that is asked for
    rsv_rgb asked, arrived;
    float cumulative[RSV_HIGHLIGHT_LIGHTS]; ///< of what is asked for
} shadow_sums;

static float divide_or(float a, float b, float otherwise) { return b > 0 ? a / b : otherwise; }

/// Sorts the light into what is known and what is asked for. What stands for several sources goes with the others.
static shadow_sums sort_light(const rsv_highlight_light *light, uint32_t count, const float *known)
{
    shadow_sums s = { 0 };
    float total = 0;
    for (uint32_t i = 0; i < count; i++) {
        bool is_known = known && known[i] >= 0;
        if (is_known)
            s.known = rgb_mad(s.known, known[i], light[i].radiance);
        else
            s.open = rgb_add(s.open, light[i].radiance);
        if (!is_known && light[i].source != RSV_NONE) total += rgb_luminance(light[i].radiance);
        s.cumulative[i] = total;
    }
    return s;
}

static uint32_t draw_source(const shadow_sums *s, uint32_t count, float u, float *probability)
{
    float total = s->cumulative[count - 1], place = u * total;
    uint32_t i = 0;
    while (i + 1 < count && place >= s->cumulative[i])
        i++;
    while (i > 0 && !(s->cumulative[i] > s->cumulative[i - 1]))
        i--;
    *probability = (s->cumulative[i] - (i > 0 ? s->cumulative[i - 1] : 0)) / total;
    return i;
}

rsv_rgb rsv_highlight_shadowed(const rsv_highlights *h, const rsv_tracer *tracer,
    const rsv_highlight_lobes *l, const rsv_surface_point *surface,
    const rsv_highlight_light *light, uint32_t count, const float *known, uint32_t rays,
    uint32_t seed)
{
    if (count == 0) return rgb_gray(0);
    shadow_sums s = sort_light(light, count, known);
    if (!(s.cumulative[count - 1] > 0)) return rgb_add(s.known, s.open);
    rays = rays < RSV_HIGHLIGHT_RAYS ? rays : RSV_HIGHLIGHT_RAYS;
    for (uint32_t k = 0; k < rays; k++) {
        numbers n = { rsv_hash2(seed, k), 0 };
        // one shift for all rays: each source gets its share of them
        float shift = rsv_unit_float(rsv_hash(seed)), probability;
        uint32_t i = draw_source(&s, count, ((float)k + shift) / (float)rays, &probability);
        shadow_ray ray;
        rsv_rgb weighed = rgb_scale(light[i].radiance, 1 / probability);
        if (!aim(h, l, light[i].source, &n, &ray)) continue;
        s.asked = rgb_add(s.asked, weighed);
        s.arrived = rgb_mad(s.arrived, trace(h, tracer, l, surface, &ray), weighed);
    }
    rsv_rgb share = rgb(divide_or(s.arrived.r, s.asked.r, 1), divide_or(s.arrived.g, s.asked.g, 1),
        divide_or(s.arrived.b, s.asked.b, 1));
    return rgb_add(s.known, rgb_mul(s.open, share));
}
