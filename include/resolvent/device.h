/// @file device.h
/// Where the operator is applied and solved: on the CPU or on a GPU.
///
/// Open a device once and give it to a context (rsv_context_desc.device). The supported parts then run on the device, the
/// others on the CPU, with the same results up to rounding. The device code is in a plug-in that is loaded on demand, so
/// the library itself does not depend on CUDA.
#ifndef RESOLVENT_DEVICE_H
#define RESOLVENT_DEVICE_H

#include "resolvent/core.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum rsv_device_kind {
    RSV_DEVICE_CUDA,    ///< the first NVIDIA GPU that the driver shows (CUDA_VISIBLE_DEVICES)
    RSV_DEVICE_EMULATED ///< the same code on the CPU, slowly: for tests
} rsv_device_kind;

/// Start from rsv_default_device_desc().
typedef struct rsv_device_desc {
    size_t size; ///< of this structure; rsv_default_device_desc() sets it
    rsv_device_kind kind;
    /// Whether work that the device cannot do, because its memory is too small or because it fails, is done by the
    /// CPU with a warning. Otherwise it ends with an error.
    bool optional;
    /// Whether the rays of the operator's rows, the shadow rays of direct light and the photons of caustics are traced there,
    /// too: the same rays, which end where those of the CPU do, except within rounding of an edge.
    bool rows;
    size_t max_bytes;    ///< of the device's memory; 0 = all that is free
    uint64_t fail_after; ///< emulated: the device is lost after so many launches; 0 = never
    uint32_t
        capability; ///< emulated: the major compute capability it claims to have; 0 = none at all
} rsv_device_desc;

/// Defaults, for a descriptor of `size` bytes: what rsv_default_device_desc() is made of.
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
    char driver[32];     ///< the newest CUDA that the driver knows
    char runtime[32];    ///< the CUDA that the plug-in was built with
    size_t memory_bytes; ///< all of it
    uint32_t processors; ///< streaming multiprocessors
    size_t cache_bytes;  ///< of the second level
} rsv_device_info;

typedef struct rsv_device rsv_device;

/// @return RSV_ERROR_UNSUPPORTED if the plug-in is not installed, if there is no driver, no device, or too old a one
RSV_API rsv_status rsv_device_open(const rsv_device_desc *desc, rsv_device **device);
/// After the contexts that have it. @param device NULL is allowed
RSV_API void rsv_device_close(rsv_device *device);
RSV_API const rsv_device_info *rsv_device_get_info(const rsv_device *device);

// ---- relighting by factors -----------------------------------------------------------------------

/// What each light does by itself, at any receivers, resident on a device: vertices, texels of a lightmap, elements.
/// Light is linear: E = sum of scale[l] x value[l] (as rsv_rt_relight does on the CPU).
typedef struct rsv_device_basis rsv_device_basis;

/// @param value [light_count][receiver_count][3], copied
/// @return RSV_ERROR_MEMORY if the device is too small for it
RSV_API rsv_status rsv_device_basis_create(rsv_device *device, uint32_t light_count,
    size_t receiver_count, const float *value, rsv_device_basis **basis);
/// Before its device is closed. @param basis NULL is allowed
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
