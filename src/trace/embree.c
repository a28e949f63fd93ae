/// The only file that knows Embree. Works with Embree 3.13 and 4.
#include "tracer_update.h"

#include "../core/core_internal.h"
#include "../core/vec.h"
#include "../scene/material_at.h"
#include "near.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <stdio.h>
#include <string.h>

struct rsv_tracer {
    rsv_context *context;
    const rsv_scene *scene;
    RTCDevice device;
    RTCScene bvh;
    int native_width; ///< widest packet the processor traverses natively: 16, 8, 4 or 1
    uint32_t *apart;  ///< [apart_count] triangles of the second geometry; NULL = there is but one
    size_t apart_count;
};

/// Geometries: the scene's triangles under their own numbers, and those set apart.
enum { SCENE_GEOMETRY, APART_GEOMETRY };

// A packet is handed to Embree as it stands, so its layout must be Embree's.
_Static_assert(sizeof(rsv_ray_packet) >= sizeof(struct RTCRayHit16), "packet is too small");
_Static_assert(offsetof(rsv_ray_packet, direction_x) == offsetof(struct RTCRay16, dir_x), "layout");
_Static_assert(offsetof(rsv_ray_packet, t_max) == offsetof(struct RTCRay16, tfar), "layout");
_Static_assert(offsetof(rsv_ray_packet, normal_x) == offsetof(struct RTCRayHit16, hit), "layout");
_Static_assert(offsetof(rsv_ray_packet, triangle) ==
                   offsetof(struct RTCRayHit16, hit) + offsetof(struct RTCHit16, primID),
    "layout");
_Static_assert(offsetof(struct RTCHit, u) == 12 && offsetof(struct RTCHit, primID) == 20, "layout");

static void record_device_error(void *user, enum RTCError code, const char *text)
{
    (void)user;
    rsv_fail(code == RTC_ERROR_OUT_OF_MEMORY ? RSV_ERROR_MEMORY : RSV_ERROR_ARGUMENT,
        "ray tracing: %s", text);
}

static rsv_status check_device(const rsv_tracer *tracer)
{
    enum RTCError code = rtcGetDeviceError(tracer->device);
    if (code == RTC_ERROR_NONE) return RSV_OK;
    if (code == RTC_ERROR_OUT_OF_MEMORY)
        return rsv_fail(RSV_ERROR_MEMORY, "ray tracing: out of memory building the hierarchy");
    return rsv_fail(RSV_ERROR_UNSUPPORTED, "ray tracing: Embree reports error %d", (int)code);
}

static int native_packet_width(RTCDevice device)
{
    if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)) return 16;
    if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED)) return 8;
    if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED)) return 4;
    return 1;
}

/// The scene's number of a triangle.
static uint32_t triangle_of(const rsv_tracer *tracer, uint32_t geometry, uint32_t primitive)
{
    return geometry == APART_GEOMETRY ? tracer->apart[primitive] : primitive;
}

/// Lets rays pass where a surface is cut out. Embree calls it for every hit, in traversal order or not.
static void reject_cut_out(const struct RTCFilterFunctionNArguments *hits)
{
    const rsv_tracer *tracer = hits->geometryUserPtr;
    const rsv_scene_view *scene = rsv_scene_get_view(tracer->scene);
    // RTCHitN is a run of N for each member of RTCHit; Embree's accessors are for C++ alone
    const float *member = (const float *)hits->hit;
    const float *u = member + 3 * hits->N, *v = member + 4 * hits->N;
    const uint32_t *primitive = (const uint32_t *)(member + 5 * hits->N);
    const uint32_t *geometry = primitive + hits->N;
    for (unsigned k = 0; k < hits->N; k++)
        if (hits->valid[k] &&
            rsv_is_cut_out(scene, triangle_of(tracer, geometry[k], primitive[k]), u[k], v[k]))
            hits->valid[k] = 0;
}

/// Scenes without cut-out materials do without the filter and its cost.
static void set_filter(rsv_tracer *tracer, RTCGeometry geometry)
{
    if (!rsv_find_cut_out(rsv_scene_get_view(tracer->scene))) return;
    rtcSetGeometryUserData(geometry, tracer);
    rtcSetGeometryIntersectFilterFunction(geometry, reject_cut_out);
    rtcSetGeometryOccludedFilterFunction(geometry, reject_cut_out);
}

static rsv_status build(rsv_tracer *tracer)
{
    const rsv_scene_view *view = rsv_scene_get_view(tracer->scene);
    RTCGeometry geometry = rtcNewGeometry(tracer->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    // Copied, not shared: Embree reads 4 bytes past the end of a shared vertex buffer.
    void *vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
        sizeof(rsv_vec3), view->vertex_count);
    void *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
        3 * sizeof(uint32_t), view->triangle_count);
    if (vertices && indices) {
        memcpy(vertices, view->position, view->vertex_count * sizeof(rsv_vec3));
        memcpy(indices, view->triangle, view->triangle_count * sizeof *view->triangle);
        set_filter(tracer, geometry);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(tracer->bvh, geometry, SCENE_GEOMETRY);
        rtcSetSceneFlags(tracer->bvh, RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(tracer->bvh,
            view->triangle_count > 2000000 ? RTC_BUILD_QUALITY_MEDIUM : RTC_BUILD_QUALITY_HIGH);
        rtcCommitScene(tracer->bvh);
    }
    rtcReleaseGeometry(geometry);
    return check_device(tracer);
}

rsv_status rsv_tracer_create(const rsv_scene *scene, rsv_tracer **result)
{
    rsv_status status = RSV_OK;
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_tracer *tracer = rsv_alloc(context, 1, sizeof *tracer);
    if (!tracer) return RSV_ERROR_MEMORY;
    tracer->context = context;
    tracer->scene = scene;
    char settings[64];
    snprintf(settings, sizeof settings, "threads=%d,set_affinity=0", rsv_threads(context));
    tracer->device = rtcNewDevice(settings);
    if (!tracer->device) {
        status = rsv_fail(RSV_ERROR_UNSUPPORTED, "ray tracing: Embree finds no usable processor");
        goto cleanup;
    }
    rtcSetDeviceErrorFunction(tracer->device, record_device_error, NULL);
    tracer->native_width = native_packet_width(tracer->device);
    tracer->bvh = rtcNewScene(tracer->device);
    RSV_TRY(check_device(tracer));
    RSV_TRY(build(tracer));
    *result = tracer;
    return RSV_OK;
cleanup:
    rsv_tracer_destroy(tracer);
    return status;
}

// ---- triangles that move ---------------------------------------------------------------------------

/// Lists the triangles of these materials.
static rsv_status list_apart(rsv_tracer *tracer, const bool *moves)
{
    const rsv_scene_view *view = rsv_scene_get_view(tracer->scene);
    tracer->apart = rsv_alloc(tracer->context, view->triangle_count, sizeof *tracer->apart);
    if (!tracer->apart) return RSV_ERROR_MEMORY;
    tracer->apart_count = 0;
    for (uint32_t t = 0; t < view->triangle_count; t++)
        if (moves[view->triangle_material[t]]) tracer->apart[tracer->apart_count++] = t;
    return RSV_OK;
}

/// What was set apart has no extent in the first geometry: no ray meets it there, and the others keep their numbers.
static void collapse_apart(const rsv_tracer *tracer)
{
    RTCGeometry geometry = rtcGetGeometry(tracer->bvh, SCENE_GEOMETRY);
    uint32_t(*index)[3] = rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_INDEX, 0);
    for (size_t k = 0; k < tracer->apart_count; k++) {
        uint32_t *corner = index[tracer->apart[k]];
        corner[1] = corner[2] = corner[0];
    }
    rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0);
    rtcCommitGeometry(geometry);
}

/// @param vertices [3 apart_count]
static void place_apart(const rsv_tracer *tracer, rsv_vec3 *vertices)
{
    const rsv_scene_view *view = rsv_scene_get_view(tracer->scene);
    for (size_t k = 0; k < 3 * tracer->apart_count; k++)
        vertices[k] = view->position[view->triangle[tracer->apart[k / 3]][k % 3]];
}

static void attach_apart(rsv_tracer *tracer)
{
    RTCGeometry geometry = rtcNewGeometry(tracer->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void *vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
        sizeof(rsv_vec3), 3 * tracer->apart_count);
    uint32_t *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0,
        RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), tracer->apart_count);
    if (vertices && indices) {
        for (size_t k = 0; k < 3 * tracer->apart_count; k++)
            indices[k] = (uint32_t)k;
        place_apart(tracer, vertices);
        set_filter(tracer, geometry);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(tracer->bvh, geometry, APART_GEOMETRY);
    }
    rtcReleaseGeometry(geometry);
}

rsv_status rsv_tracer_set_apart(rsv_tracer *tracer, const bool *moves)
{
    if (tracer->apart) return RSV_OK;
    rsv_status status = list_apart(tracer, moves);
    if (status != RSV_OK) return status;
    collapse_apart(tracer);
    attach_apart(tracer);
    // a hierarchy for each geometry and one above them, each as good as the whole was, but for the splitting of triangles
    rtcSetSceneFlags(tracer->bvh, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC);
    rtcSetSceneBuildQuality(tracer->bvh, RTC_BUILD_QUALITY_LOW);
    rtcCommitScene(tracer->bvh);
    return check_device(tracer);
}

bool rsv_tracer_is_apart(const rsv_tracer *tracer) { return tracer->apart != NULL; }

rsv_status rsv_tracer_update(rsv_tracer *tracer)
{
    RTCGeometry geometry = rtcGetGeometry(tracer->bvh, APART_GEOMETRY);
    void *vertices =
        geometry ? rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0) : NULL;
    if (!vertices) return rsv_fail(RSV_ERROR_MEMORY, "ray tracing: out of memory for what moves");
    place_apart(tracer, vertices);
    rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometry);
    rtcCommitScene(tracer->bvh);
    return check_device(tracer);
}

void rsv_tracer_destroy(rsv_tracer *tracer)
{
    if (!tracer) return;
    if (tracer->bvh) rtcReleaseScene(tracer->bvh);
    if (tracer->device) rtcReleaseDevice(tracer->device);
    rsv_free(tracer->context, tracer->apart);
    rsv_free(tracer->context, tracer);
}

const rsv_scene *rsv_tracer_scene(const rsv_tracer *tracer) { return tracer->scene; }

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
    return query_ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
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

/// Gives what was set apart its numbers in the scene.
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
