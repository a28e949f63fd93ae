#include "device.h"

#include "core.h"

#include <dlfcn.h>

rsv_device_desc rsv_default_device_desc(void) { return (rsv_device_desc){ 0 }; }

typedef struct plug_in {
    const char *file, *need;
} plug_in;

static const plug_in plug_ins[] = {
    [RSV_DEVICE_CUDA] = { "libresolvent_cuda.so",
        "which is in the package resolvent-cuda, and built where nvcc of CUDA 12 or newer is found "
        "(docs/gpu.md)" },
    [RSV_DEVICE_EMULATED] = { "libresolvent_emulated.so", "which is built along with the tests" },
};

rsv_status rsv_device_open(const rsv_device_desc *desc, rsv_device **device)
{
    char message[RSV_DEVICE_MESSAGE_BYTES] = "";
    const plug_in *p = &plug_ins[desc->kind];
    void *library = dlopen(p->file, RTLD_NOW | RTLD_LOCAL);
    if (!library)
        return rsv_fail(RSV_ERROR_UNSUPPORTED, "device: it needs the plug-in %s, %s: %s", p->file,
            p->need, dlerror());
    rsv_device_opener open = (rsv_device_opener)dlsym(library, RSV_DEVICE_OPEN);
    if (!open)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "device: %s belongs to another version of this program; install it again", p->file);
    rsv_status status = open(rsv_version(), desc, device, message);
    return status == RSV_OK ? RSV_OK : rsv_fail(status, "device: %s", message);
}

void rsv_device_close(rsv_device *device)
{
    if (device) device->table->close(device);
}

const rsv_device_info *rsv_device_get_info(const rsv_device *device) { return &device->info; }
