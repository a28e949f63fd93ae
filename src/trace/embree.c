/// Hierarchies of Embree. Only this file and embree_rays.c use it; both work with Embree 3.13 and 4.
#include "tracer_update.h"

#include "../core/core.h"
#include "../core/vec.h"
#include "../scene/material_at.h"
#include "../scene/scene.h"
#include "embree_internal.h"

#include <stdio.h>
#include <string.h>

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

/// Lets rays pass where a surface is cut out. Embree calls it for every hit, in traversal order or not.
static void reject_cut_out(const struct RTCFilterFunctionNArguments *hits)
{
    const rsv_tracer *tracer = hits->geometryUserPtr;
    const rsv_scene_view *scene = rsv_scene_get_view(tracer->head.scene);
    // RTCHitN has an array of N for each member of RTCHit; Embree's accessors are only for C++
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
    if (!rsv_find_cut_out(rsv_scene_get_view(tracer->head.scene))) return;
    rtcSetGeometryUserData(geometry, tracer);
    rtcSetGeometryIntersectFilterFunction(geometry, reject_cut_out);
    rtcSetGeometryOccludedFilterFunction(geometry, reject_cut_out);
}

static rsv_status build(rsv_tracer *tracer)
{
    const rsv_scene_view *view = rsv_scene_get_view(tracer->head.scene);
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

/// The program's device, or a new one.
static rsv_status open_device(const rsv_context *context, rsv_tracer *tracer)
{
    tracer->device = rsv_context_settings(context)->embree_device;
    if (tracer->device) {
        rtcRetainDevice(tracer->device);
        rtcGetDeviceError(tracer->device); // clears errors that the program caused before
        return RSV_OK;
    }
    char settings[64];
    snprintf(settings, sizeof settings, "threads=%d,set_affinity=0", rsv_threads(context));
    tracer->device = rtcNewDevice(settings);
    if (!tracer->device)
        return rsv_fail(RSV_ERROR_UNSUPPORTED, "ray tracing: Embree finds no usable CPU");
    rtcSetDeviceErrorFunction(tracer->device, record_device_error, NULL);
    return RSV_OK;
}

rsv_status rsv_tracer_create(const rsv_scene *scene, rsv_tracer **result)
{
    rsv_status status = RSV_OK;
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_tracer *tracer = NULL;
    RSV_TRY(rsv_scene_require_committed(scene));
    tracer = rsv_alloc(context, 1, sizeof *tracer);
    RSV_TRY(tracer ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_tracer_head_begin(scene, &tracer->head));
    RSV_TRY(open_device(context, tracer));
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
    const rsv_scene_view *view = rsv_scene_get_view(tracer->head.scene);
    tracer->apart = rsv_alloc(tracer->head.context, view->triangle_count, sizeof *tracer->apart);
    if (!tracer->apart) return RSV_ERROR_MEMORY;
    tracer->apart_count = 0;
    for (uint32_t t = 0; t < view->triangle_count; t++)
        if (moves[view->triangle_material[t]]) tracer->apart[tracer->apart_count++] = t;
    return RSV_OK;
}

/// In the first geometry, triangles that were set apart get indices beyond the last vertex, so that Embree ignores them
/// and the others keep their numbers. Degenerate triangles would do too, but if many are in one point, Embree's builder
/// cannot divide them, and aborts.
static void drop_apart(const rsv_tracer *tracer)
{
    RTCGeometry geometry = rtcGetGeometry(tracer->bvh, SCENE_GEOMETRY);
    uint32_t(*index)[3] = rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_INDEX, 0);
    for (size_t k = 0; k < tracer->apart_count; k++) {
        uint32_t *corner = index[tracer->apart[k]];
        corner[0] = corner[1] = corner[2] = UINT32_MAX;
    }
    rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0);
    rtcCommitGeometry(geometry);
}

/// @param vertices [3 apart_count]
static void place_apart(const rsv_tracer *tracer, rsv_vec3 *vertices)
{
    const rsv_scene_view *view = rsv_scene_get_view(tracer->head.scene);
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

/// Builds the two geometries of the listed triangles.
static rsv_status build_apart(rsv_tracer *tracer)
{
    if (tracer->apart_attached) rtcDetachGeometry(tracer->bvh, APART_GEOMETRY);
    tracer->apart_attached = true;
    drop_apart(tracer);
    attach_apart(tracer);
    // one hierarchy for each geometry and one above them, each as good as a single one, except for the splitting of
    // triangles
    rtcSetSceneFlags(tracer->bvh, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC);
    rtcSetSceneBuildQuality(tracer->bvh, RTC_BUILD_QUALITY_LOW);
    rtcCommitScene(tracer->bvh);
    return check_device(tracer);
}

rsv_status rsv_tracer_set_apart(rsv_tracer *tracer, const bool *moves)
{
    if (tracer->apart) return RSV_OK;
    rsv_status status = list_apart(tracer, moves);
    return status == RSV_OK ? build_apart(tracer) : status;
}

/// Whether any of these triangles is still among the others. @param apart [triangle_count] out: those that are not
static bool any_to_set_apart(const rsv_tracer *tracer, const uint8_t *moves, uint8_t *apart)
{
    size_t triangles = rsv_scene_get_view(tracer->head.scene)->triangle_count;
    for (size_t k = 0; k < tracer->apart_count; k++)
        apart[tracer->apart[k]] = 1;
    for (size_t t = 0; t < triangles; t++)
        if (moves[t] && !apart[t]) return true;
    return false;
}

rsv_status rsv_tracer_set_triangles_apart(rsv_tracer *tracer, const uint8_t *moves)
{
    size_t triangles = rsv_scene_get_view(tracer->head.scene)->triangle_count;
    rsv_status status = RSV_OK;
    uint8_t *apart = rsv_alloc(tracer->head.context, triangles, 1);
    RSV_TRY(apart ? RSV_OK : RSV_ERROR_MEMORY);
    if (!any_to_set_apart(tracer, moves, apart)) goto cleanup;
    if (!tracer->apart)
        tracer->apart = rsv_alloc(tracer->head.context, triangles, sizeof *tracer->apart);
    RSV_TRY(tracer->apart ? RSV_OK : RSV_ERROR_MEMORY);
    for (uint32_t t = 0; t < triangles; t++)
        if (moves[t] && !apart[t]) tracer->apart[tracer->apart_count++] = t;
    RSV_TRY(build_apart(tracer));
cleanup:
    rsv_free(tracer->head.context, apart);
    return status;
}

bool rsv_tracer_is_apart(const rsv_tracer *tracer) { return tracer->apart != NULL; }

rsv_status rsv_tracer_update(rsv_tracer *tracer)
{
    if (!tracer->apart_attached) return RSV_OK; // nothing moves yet
    RTCGeometry geometry = rtcGetGeometry(tracer->bvh, APART_GEOMETRY);
    void *vertices =
        geometry ? rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0) : NULL;
    if (!vertices)
        return rsv_fail(RSV_ERROR_MEMORY, "ray tracing: out of memory for moving surfaces");
    rsv_bvh_destroy(&tracer->head.hierarchy->bvh);
    place_apart(tracer, vertices);
    rsv_tracer_head_find_twins(&tracer->head);
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
    rsv_free(tracer->head.context, tracer->apart);
    rsv_tracer_head_end(&tracer->head);
    rsv_free(tracer->head.context, tracer);
}

const rsv_scene *rsv_tracer_scene(const rsv_tracer *tracer) { return tracer->head.scene; }
