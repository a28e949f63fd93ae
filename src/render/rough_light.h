/// Light sources as rough surfaces on the way of a camera ray reflect them: small lamps, suns and punctual
/// lights are aimed at, large ones met by chance, and the two weighed by the power heuristic.
#ifndef RSV_ROUGH_LIGHT_H
#define RSV_ROUGH_LIGHT_H

#include "../receiver/next_event.h"
#include "../specular/specular_path.h"

/// How a specular path left a rough surface, for its next hit, past blended surfaces.
typedef struct rsv_rough_departure {
    rsv_vec3 point,
        side; ///< of the surface; unit normal on the side that the specular path left to
    float pdf_solid_angle; ///< 0 = not from a rough surface: nothing has been aimed at
    float sky_pdf;         ///< of the aim at the gathered sky
    bool
        shot; ///< emitters that are not gathered, suns and punctual lights are left out: shot_light.h
} rsv_rough_departure;

/// A rough surface on a specular path, for light from sources; its textures are looked up once.
typedef struct rsv_rough_surface {
    const rsv_transport_scene *scene;
    const rsv_specular_path *path;
    const rsv_bsdf *bsdf; ///< of the scene, or `storage`: the structure must not be copied
    rsv_bsdf storage;
    rsv_surface_point point;
    rsv_vec3 wo, normal;
    bool front;
    rsv_vec3 turn[2]; ///< by which the normal changes from side to side of the footprint
    uint32_t
        turns; ///< normals across the footprint that respond to sources aimed at; 0 = the one in its middle
} rsv_rough_surface;

/// The surface as it is seen. @param path borrowed
RSV_SHARED void rsv_rough_see(
    const rsv_transport_scene *scene, const rsv_specular_path *path, rsv_rough_surface *surface);

/// Lifts the point to the curved surface, for lighting (surface/lift.h).
RSV_SHARED void rsv_rough_lift(rsv_rough_surface *surface);

/// Both.
RSV_SHARED void rsv_rough_meet(
    const rsv_transport_scene *scene, const rsv_specular_path *path, rsv_rough_surface *surface);

/// Finds how the normal turns across the footprint of what was seen, if that is much beside the width of the lobes: a
/// highlight on a thin tube is smaller than the footprint, and all of its normals then respond to sources aimed at. The
/// smaller the footprint, the less that blurs.
RSV_SHARED void rsv_rough_find_turns(rsv_rough_surface *surface);

/// Whether the lobes of a rough surface are all so wide that a light path which ends there is likely to reach any eye.
RSV_SHARED bool rsv_rough_is_wide(const rsv_bsdf *bsdf);

/// Response of the rough lobes to light from unit direction `wi`: radiance at the specular path's start per irradiance
/// on a surface that faces it.
RSV_SHARED rsv_rgb rsv_rough_response(const rsv_rough_surface *surface, rsv_vec3 wi);

/// Radiance that the surface scatters towards the camera from sources aimed at.
/// @param shot leaves out those of rsv_rough_departure.shot
/// @param u for the choice of a source and for the place on it, in [0, 1)
RSV_SHARED rsv_rgb rsv_rough_light(
    const rsv_rough_surface *surface, const rsv_lights *lights, bool shot, const float u[3]);

/// Of that, the light of the k-th punctual light (rsv_punctual_at).
RSV_SHARED rsv_rgb rsv_rough_light_from(
    const rsv_rough_surface *surface, const rsv_lights *lights, uint32_t k, const float u[3]);

/// The same as rsv_rough_light, but that `punctual` responds to punctual lights: the surface again, or one with wider
/// lobes at its place. NULL leaves out their light.
RSV_SHARED rsv_rgb rsv_rough_light_by(const rsv_rough_surface *surface,
    const rsv_rough_surface *punctual, const rsv_lights *lights, bool shot, const float u[3]);

/// Widens the lobes of a surface by the variation of its normals across a footprint (Tokuyoshi and Kaplanyan 2019).
/// @param variance of the normals, sum over both directions, radian^2 @return whether that makes a difference
RSV_SHARED bool rsv_rough_widen(rsv_rough_surface *surface, float variance);

/// Draws a direction from all lobes but the diffuse one, with their chance in the weight.
/// @param u for the lobe and for the direction within it, in [0, 1)
RSV_SHARED rsv_bsdf_event rsv_rough_draw(const rsv_rough_surface *surface, const float u[3]);

/// The departure of the specular path along `direction`. @param sky_pdf as in rsv_rough_departure
RSV_SHARED rsv_rough_departure rsv_rough_depart(
    const rsv_rough_surface *surface, rsv_vec3 direction, float sky_pdf);

/// Weight of the emission of the surface that the specular path has come to.
RSV_SHARED float rsv_rough_emission_weight(const rsv_transport_scene *scene,
    const rsv_lights *lights, const rsv_specular_path *path, const rsv_rough_departure *departure);

/// Radiance of the sky for a specular path that has left the scene. The parts that rough surfaces sample are weighted
/// separately; the gathered part counts in full.
RSV_SHARED rsv_rgb rsv_rough_sky(
    const rsv_lights *lights, rsv_vec3 direction, const rsv_rough_departure *departure);

// ---- parts ---------------------------------------------------------------------------------------

/// By what the interpolated normal of a triangle changes in its plane.
typedef struct rsv_normal_change {
    rsv_vec3 edge[2],
        turn[2];        ///< from corner 0 to corners 1 and 2; changes of the normal along these
    float a, b, c;      ///< e0 e0, e0 e1, e1 e1
    float squared_area; ///< of the parallelogram, never 0
} rsv_normal_change;

RSV_INLINE rsv_normal_change rsv_normal_change_of(const rsv_scene_view *view, uint32_t triangle)
{
    const uint32_t *corner = view->triangle[triangle];
    rsv_normal_change n;
    for (int k = 0; k < 2; k++) {
        n.edge[k] = v3_sub(view->position[corner[k + 1]], view->position[corner[0]]);
        n.turn[k] = v3_sub(view->normal[corner[k + 1]], view->normal[corner[0]]);
    }
    n.a = v3_dot(n.edge[0], n.edge[0]);
    n.b = v3_dot(n.edge[0], n.edge[1]);
    n.c = v3_dot(n.edge[1], n.edge[1]);
    n.squared_area = f_max(n.a * n.c - n.b * n.b, 1e-30f);
    return n;
}

/// Response of the rough lobes about a normal; nothing where the normals disagree on wi's side.
RSV_LARGE rsv_bsdf_value rsv_rough_respond_by(
    const rsv_rough_surface *s, rsv_vec3 normal, rsv_vec3 wi)
{
    rsv_bsdf_value value = { rgb_gray(0), 0 };
    float above = v3_dot(normal, wi);
    if (above * v3_dot(above > 0 ? s->point.horizon : s->point.geometric, wi) <= 0) return value;
    value = rsv_bsdf_evaluate(s->bsdf, wi, s->wo, normal, s->front, RSV_LOBES_ROUGH);
    value.response = rgb_scale(value.response, s->bsdf->opacity);
    float chance = rsv_bsdf_specular_chance(s->bsdf, s->wo, normal, s->front);
    if (value.pdf_solid_angle > 0) value.pdf_solid_angle /= chance;
    return value;
}

RSV_INLINE rsv_bsdf_value rsv_rough_respond(const rsv_rough_surface *s, rsv_vec3 wi)
{
    return rsv_rough_respond_by(s, s->normal, wi);
}

RSV_INLINE float rsv_power_heuristic(float own, float other)
{
    float ratio = other / own;
    return 1 / (1 + ratio * ratio);
}

/// A value of rsv_rough_respond, weighed against draws by the lobes. @param pdf of the direction as it was aimed at
RSV_INLINE rsv_response rsv_rough_weighed(const rsv_bsdf_value *value, float pdf)
{
    rsv_response response;
    response.share = value->response;
    response.factor = rsv_power_heuristic(pdf, value->pdf_solid_angle);
    return response;
}

/// The same, as the mean over the normals of the footprint. @param u where they begin, in [0, 1)
RSV_LARGE rsv_response rsv_rough_mean_response(
    const rsv_rough_surface *s, rsv_vec3 wi, float pdf, const float u[2])
{
    rsv_rgb sum = rgb_gray(0);
    float seen = 0;
    for (uint32_t k = 0; k < s->turns; k++) { // evenly over the square (Roberts' sequence)
        float x = (float)k * 0.7548777f + u[0], y = (float)k * 0.5698403f + u[1];
        rsv_vec3 normal = v3_mad(s->normal, x - floorf(x) - 0.5f, s->turn[0]);
        normal = v3_normalize(v3_mad(normal, y - floorf(y) - 0.5f, s->turn[1]));
        if (v3_dot(normal, s->wo) * v3_dot(s->normal, s->wo) <= 0) continue; // not to be seen
        rsv_bsdf_value value = rsv_rough_respond_by(s, normal, wi);
        seen++;
        if (!(value.pdf_solid_angle > 0)) continue;
        rsv_response response = rsv_rough_weighed(&value, pdf);
        sum = rgb_mad(sum, response.factor, response.share);
    }
    rsv_response mean;
    mean.share = rgb_scale(sum, 1 / f_max(seen, 1));
    mean.factor = 1;
    return mean;
}

/// Response to a direction that was aimed at with this density, weighed against draws by the lobes. Punctual lights have an
/// infinite one, as no draw finds them.
RSV_INLINE rsv_response rsv_rough_aimed_response(
    const rsv_rough_surface *s, rsv_vec3 wi, float pdf, const float u[2])
{
    if (s->turns) return rsv_rough_mean_response(s, wi, pdf, u);
    rsv_bsdf_value value = rsv_rough_respond(s, wi);
    rsv_response response = rsv_rough_weighed(&value, pdf);
    if (!(value.pdf_solid_angle > 0)) response.share = rgb_gray(0);
    return response;
}

/// One side of a rough surface as a receiver of light. Must not be copied.
typedef struct rsv_rough_side {
    rsv_receiver receiver; ///< by the normal that the lobes go by
    rsv_medium medium;
    rsv_entrance
        entrance; ///< its weight: radiance at the specular path's start per radiance that arrives
} rsv_rough_side;

RSV_INLINE void rsv_rough_set_side(const rsv_rough_surface *s, bool below, rsv_rough_side *side)
{
    side->receiver.point = s->point;
    side->receiver.point.normal = s->normal;
    side->receiver.origin = rsv_moved_off(s->point.position, s->point.geometric, s->point.extent);
    if (below) side->receiver = rsv_receiver_below(&side->receiver);
    side->medium = below ? rsv_specular_medium_beyond(s->scene, s->path) : s->path->medium;
    side->entrance = rsv_entrance_through(&side->medium, s->scene->bsdf, RSV_COVER_NONE);
    side->entrance.weight = rsv_specular_throughput(s->scene, s->path, &side->medium);
}

#if defined(RSV_DEVICE_CODE)
#include "rough_light_body.h"
#endif

#endif
