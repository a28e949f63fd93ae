/// @file device.h
/// Where the operator is applied and solved: on the processor, or on a GPU.
///
/// A device is opened once and given to a context (rsv_context_desc.device); what the library knows to do there is then
/// done there, the rest as before, with the same answers up to rounding. How that works is the business of a plug-in
/// that is loaded when it is wanted: the library itself needs no CUDA.
#ifndef RESOLVENT_DEVICE_H
#define RESOLVENT_DEVICE_H

#include "resolvent/core.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum rsv_device_kind {
    RSV_DEVICE_CUDA,    ///< the first NVIDIA GPU that the driver shows (CUDA_VISIBLE_DEVICES)
    RSV_DEVICE_EMULATED ///< the same code on the processor, slowly: for tests
} rsv_device_kind;

/// Start from rsv_default_device_desc().
typedef struct rsv_device_desc {
    rsv_device_kind kind;
    /// Whether work that the device cannot do, because its memory is too small or because it fails, is done by the
    /// processor with a warning. Otherwise it ends with an error.
    bool optional;
    size_t max_bytes;    ///< of the device's memory; 0 = all that is free
    uint64_t fail_after; ///< emulated: the device is lost after so many launches; 0 = never
} rsv_device_desc;

RSV_API rsv_device_desc rsv_default_device_desc(void);

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

#ifdef __cplusplus
}
#endif

#endif
