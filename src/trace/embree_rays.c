/// Rays through the hierarchies of embree.c.
#include "../scene/twins.h"
#include "embree_internal.h"
#include "near.h"
#include "packet_settle.h"

#include <string.h>

// A packet is handed to Embree as it stands, so its layout must be Embree's.
_Static_assert(sizeof(rsv_ray_packet) >= sizeof(struct RTCRayHit16), "packet is too small");
_Static_assert(offsetof(rsv_ray_packet, direction_x) == offsetof(struct RTCRay16, dir_x), "layout");
_Static_assert(offsetof(rsv_ray_packet, t_max) == offsetof(struct RTCRay16, tfar), "layout");
_Static_assert(offsetof(rsv_ray_packet, normal_x) == offsetof(struct RTCRayHit16, hit), "layout");
_Static_assert(offsetof(rsv_ray_packet, triangle) ==
                   offsetof(struct RTCRayHit16, hit) + offsetof(struct RTCHit16, primID),
    "layout");
_Static_assert(offsetof(struct RTCHit, u) == 12 && offsetof(struct RTCHit, primID) == 20, "layout");

static struct RTCRay to_rtc(const rsv_ray *ray)
{
    return (struct RTCRay){ .org_x = ray->origin.x,
        .org_y = ray->origin.y,
        .org_z = ray->origin.z,
        .dir_x = ray->direction.x,
        .dir_y = ray->direction.y,
        .dir_z = ray->direction.z,
        .tfar = ray->t_max,
        .mask = UINT32_MAX };
}

// Embree 4 dropped the context argument's type, version 3 has no arguments type.
#if RTC_VERSION_MAJOR >= 4
#define DECLARE_QUERY(coherent)                                                                    \
    struct RTCIntersectArguments query;                                                            \
    rtcInitIntersectArguments(&query);                                                             \
    query.flags = (coherent) ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT
#define DECLARE_SHADOW_QUERY(coherent)                                                             \
    struct RTCOccludedArguments query;                                                             \
    rtcInitOccludedArguments(&query);                                                              \
    query.flags = (coherent) ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT
#define INTERSECT(width, valid, rays) rtcIntersect##width(valid, tracer->bvh, rays, &query)
#define OCCLUDED(width, valid, rays) rtcOccluded##width(valid, tracer->bvh, rays, &query)
#define INTERSECT_ONE(ray) rtcIntersect1(tracer->bvh, ray, &query)
#define OCCLUDED_ONE(ray) rtcOccluded1(tracer->bvh, ray, &query)
#else
#define DECLARE_QUERY(coherent)                                                                    \
    struct RTCIntersectContext query;                                                              \
    rtcInitIntersectContext(&query);                                                               \
    query.flags =                                                                                  \
        (coherent) ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT
#define DECLARE_SHADOW_QUERY DECLARE_QUERY
#define INTERSECT(width, valid, rays) rtcIntersect##width(valid, tracer->bvh, &query, rays)
#define OCCLUDED(width, valid, rays) rtcOccluded##width(valid, tracer->bvh, &query, rays)
#define INTERSECT_ONE(ray) rtcIntersect1(tracer->bvh, &query, ray)
#define OCCLUDED_ONE(ray) rtcOccluded1(tracer->bvh, &query, ray)
#endif

bool rsv_tracer_closest(const rsv_tracer *tracer, const rsv_ray *ray, rsv_hit *hit)
{
    struct RTCRayHit query_ray = { .ray = to_rtc(ray),
        .hit = { .primID = RTC_INVALID_GEOMETRY_ID, .geomID = RTC_INVALID_GEOMETRY_ID } };
    DECLARE_QUERY(false);
    INTERSECT_ONE(&query_ray);
    uint32_t triangle = triangle_of(tracer, query_ray.hit.geomID, query_ray.hit.primID);
    *hit = (rsv_hit){ triangle, query_ray.ray.tfar, query_ray.hit.u, query_ray.hit.v };
    if (query_ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    if (tracer->head.twins) rsv_twins_settle(tracer->head.twins, ray->direction, hit);
    return true;
}

bool rsv_tracer_occluded(const rsv_tracer *tracer, const rsv_ray *ray)
{
    struct RTCRay query_ray = to_rtc(ray);
    DECLARE_SHADOW_QUERY(false);
    OCCLUDED_ONE(&query_ray);
    return query_ray.tfar < 0;
}

typedef struct near_visit {
    const rsv_tracer *tracer;
    rsv_near_visitor visit;
    void *user;
} near_visit;

static bool visit_primitive(struct RTCPointQueryFunctionArguments *arguments)
{
    const near_visit *v = arguments->userPtr;
    float before = arguments->query->radius;
    v->visit(v->user, triangle_of(v->tracer, arguments->geomID, arguments->primID),
        &arguments->query->radius);
    return arguments->query->radius < before;
}

void rsv_tracer_visit_near(
    const rsv_tracer *tracer, rsv_vec3 point, float radius, rsv_near_visitor visit, void *user)
{
    struct RTCPointQuery query = { .x = point.x, .y = point.y, .z = point.z, .radius = radius };
    struct RTCPointQueryContext context;
    near_visit v = { tracer, visit, user };
    rtcInitPointQueryContext(&context);
    rtcPointQuery(tracer->bvh, &query, &context, visit_primitive, &v);
}

// Narrower packets for processors without 16 lanes: the same arrays, `width` lanes at a time.
#define COPY_LANES(width, to, from) memcpy(to, from, (width) * sizeof(float))

#define DEFINE_NARROW(width)                                                                       \
    static void load_rays_##width(struct RTCRay##width *to, const rsv_ray_packet *from, int lane)  \
    {                                                                                              \
        COPY_LANES(width, to->org_x, from->origin_x + lane);                                       \
        COPY_LANES(width, to->org_y, from->origin_y + lane);                                       \
        COPY_LANES(width, to->org_z, from->origin_z + lane);                                       \
        COPY_LANES(width, to->tnear, from->t_min + lane);                                          \
        COPY_LANES(width, to->dir_x, from->direction_x + lane);                                    \
        COPY_LANES(width, to->dir_y, from->direction_y + lane);                                    \
        COPY_LANES(width, to->dir_z, from->direction_z + lane);                                    \
        COPY_LANES(width, to->time, from->time + lane);                                            \
        COPY_LANES(width, to->tfar, from->t_max + lane);                                           \
        COPY_LANES(width, to->mask, from->mask + lane);                                            \
        COPY_LANES(width, to->id, from->id + lane);                                                \
        COPY_LANES(width, to->flags, from->flags + lane);                                          \
    }                                                                                              \
    static void closest_##width(const rsv_tracer *tracer, rsv_ray_packet *packet, bool coherent)   \
    {                                                                                              \
        DECLARE_QUERY(coherent);                                                                   \
        for (int lane = 0; lane < 16; lane += (width)) {                                           \
            struct RTCRayHit##width rays;                                                          \
            _Alignas(64) int valid[width];                                                         \
            load_rays_##width(&rays.ray, packet, lane);                                            \
            for (int i = 0; i < (width); i++) {                                                    \
                valid[i] = -1;                                                                     \
                rays.hit.primID[i] = rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;                 \
            }                                                                                      \
            INTERSECT(width, valid, &rays);                                                        \
            COPY_LANES(width, packet->t_max + lane, rays.ray.tfar);                                \
            COPY_LANES(width, packet->normal_x + lane, rays.hit.Ng_x);                             \
            COPY_LANES(width, packet->normal_y + lane, rays.hit.Ng_y);                             \
            COPY_LANES(width, packet->normal_z + lane, rays.hit.Ng_z);                             \
            COPY_LANES(width, packet->u + lane, rays.hit.u);                                       \
            COPY_LANES(width, packet->v + lane, rays.hit.v);                                       \
            COPY_LANES(width, packet->triangle + lane, rays.hit.primID);                           \
            COPY_LANES(width, packet->geometry + lane, rays.hit.geomID);                           \
        }                                                                                          \
    }                                                                                              \
    static void occluded_##width(const rsv_tracer *tracer, rsv_ray_packet *packet, bool coherent)  \
    {                                                                                              \
        DECLARE_SHADOW_QUERY(coherent);                                                            \
        for (int lane = 0; lane < 16; lane += (width)) {                                           \
            struct RTCRay##width rays;                                                             \
            _Alignas(64) int valid[width];                                                         \
            load_rays_##width(&rays, packet, lane);                                                \
            for (int i = 0; i < (width); i++)                                                      \
                valid[i] = -1;                                                                     \
            OCCLUDED(width, valid, &rays);                                                         \
            COPY_LANES(width, packet->t_max + lane, rays.tfar);                                    \
        }                                                                                          \
    }

DEFINE_NARROW(8)
DEFINE_NARROW(4)

static const _Alignas(
    64) int all_lanes[16] = { -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1 };

/// Converts the indices of triangles that were set apart to those of the scene.
static void name_apart(const rsv_tracer *tracer, rsv_ray_packet *packet)
{
    for (int k = 0; k < 16; k++)
        packet->triangle[k] = triangle_of(tracer, packet->geometry[k], packet->triangle[k]);
}

void rsv_tracer_closest_packet(const rsv_tracer *tracer, rsv_ray_packet *packet, bool coherent)
{
    if (tracer->native_width == 8) {
        closest_8(tracer, packet, coherent);
    } else if (tracer->native_width == 4) {
        closest_4(tracer, packet, coherent);
    } else {
        memset(packet->triangle, 0xff, sizeof packet->triangle);
        memset(packet->geometry, 0xff, sizeof packet->geometry);
        DECLARE_QUERY(coherent);
        INTERSECT(16, all_lanes, (struct RTCRayHit16 *)packet);
    }
    if (tracer->apart) name_apart(tracer, packet);
    if (tracer->head.twins) rsv_packet_settle(tracer->head.twins, packet);
}

void rsv_tracer_occluded_packet(const rsv_tracer *tracer, rsv_ray_packet *packet, bool coherent)
{
    if (tracer->native_width == 8) {
        occluded_8(tracer, packet, coherent);
    } else if (tracer->native_width == 4) {
        occluded_4(tracer, packet, coherent);
    } else {
        DECLARE_SHADOW_QUERY(coherent);
        OCCLUDED(16, all_lanes, (struct RTCRay16 *)packet);
    }
}
