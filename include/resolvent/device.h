/// @file device.h
/// Applies and solves the operator on a GPU.
///
/// Open a device once and pass it to a context (rsv_context_desc.device). Supported parts then run on the device, and
/// the others on the CPU. Results are the same up to rounding. The device code is a plug-in that is loaded on demand,
/// so the library itself does not depend on CUDA.
#ifndef RESOLVENT_DEVICE_H
#define RESOLVENT_DEVICE_H

#include "resolvent/core.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum rsv_device_kind {
    RSV_DEVICE_CUDA,    ///< the first NVIDIA GPU that the driver lists (CUDA_VISIBLE_DEVICES)
    RSV_DEVICE_EMULATED ///< the same code on the CPU; slow, for tests
} rsv_device_kind;

/// Options of a device. Start from rsv_default_device_desc().
typedef struct rsv_device_desc {
    size_t size; ///< sizeof this structure; rsv_default_device_desc() sets it
    rsv_device_kind kind;
    /// true = the CPU takes over, with a warning, if the device has too little memory or fails. false = this is an
    /// error.
    bool optional;
    /// true = also trace the rays of rows, the shadow rays of direct light and the photons of caustics on the device.
    /// They are the same rays, and end where they do on the CPU, except within rounding of an edge.
    bool rows;
    size_t max_bytes;    ///< limit of device memory; 0 = all free memory
    uint64_t fail_after; ///< emulated: the device fails after so many launches; 0 = never
    uint32_t capability; ///< emulated: the major compute capability to report; 0 = no device
} rsv_device_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_device_desc().
RSV_API void rsv_device_desc_init(rsv_device_desc *desc, size_t size);
static inline rsv_device_desc rsv_default_device_desc(void)
{
    rsv_device_desc desc;
    rsv_device_desc_init(&desc, sizeof desc);
    return desc;
}

typedef struct rsv_device_info {
    char name[128];      ///< "NVIDIA H200"
    char capability[16]; ///< "9.0"
    char driver[32];     ///< newest CUDA version that the driver supports
    char runtime[32];    ///< CUDA version that the plug-in was built with
    size_t memory_bytes; ///< in total
    uint32_t processors; ///< streaming multiprocessors
    size_t cache_bytes;  ///< L2 cache
} rsv_device_info;

typedef struct rsv_device rsv_device;

/// @return RSV_ERROR_UNSUPPORTED if the plug-in is not installed, or there is no driver or no device that is new enough
RSV_API rsv_status rsv_device_open(const rsv_device_desc *desc, rsv_device **device);
/// Close it after its contexts are destroyed. @param device NULL is allowed
RSV_API void rsv_device_close(rsv_device *device);
RSV_API const rsv_device_info *rsv_device_get_info(const rsv_device *device);

// ---- relighting by factors -----------------------------------------------------------------------

/// The contribution of each light to receivers (vertices, texels of a lightmap, elements), in device memory. Light is
/// linear: E = sum of scale[l] x value[l] (as in rsv_rt_relight on the CPU).
typedef struct rsv_device_basis rsv_device_basis;

/// @param value [light_count][receiver_count][3], copied
/// @return RSV_ERROR_MEMORY if it does not fit into device memory
RSV_API rsv_status rsv_device_basis_create(rsv_device *device, uint32_t light_count,
    size_t receiver_count, const float *value, rsv_device_basis **basis);
/// Destroy it before its device is closed. @param basis NULL is allowed
RSV_API void rsv_device_basis_destroy(rsv_device_basis *basis);

/// Irradiance of all receivers under other strengths of the lights; done when the call returns.
/// @param scale [light_count] 1 = as given at creation
/// @param irradiance out, [receiver_count]; NULL = it stays on the device
RSV_API rsv_status rsv_device_basis_relight(
    rsv_device_basis *basis, const rsv_rgb *scale, rsv_rgb *irradiance);

/// Where on the device the irradiance lies, for other code that runs there: [receiver_count].
RSV_API const rsv_rgb *rsv_device_basis_address(const rsv_device_basis *basis);

#ifdef __cplusplus
}
#endif

#endif
