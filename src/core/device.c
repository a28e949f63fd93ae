#include "device.h"
#include "descriptor.h"

#include "core.h"

#include <dlfcn.h>

void rsv_device_desc_init(rsv_device_desc *desc, size_t size)
{
    const rsv_device_desc defaults = { .size = sizeof defaults };
    rsv_desc_fill(desc, size, &defaults);
}

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
    rsv_device_desc settings = rsv_default_device_desc();
    rsv_status status = RSV_READ_DESC(rsv_device_desc, &settings, desc);
    if (status != RSV_OK) return status;
    if ((unsigned)settings.kind >= sizeof plug_ins / sizeof *plug_ins)
        return rsv_fail(RSV_ERROR_ARGUMENT, "device: there is no kind %d", (int)settings.kind);
    const plug_in *p = &plug_ins[settings.kind];
    void *library = dlopen(p->file, RTLD_NOW | RTLD_LOCAL);
    if (!library)
        return rsv_fail(RSV_ERROR_UNSUPPORTED, "device: it needs the plug-in %s, %s: %s", p->file,
            p->need, dlerror());
    rsv_device_opener open = (rsv_device_opener)dlsym(library, RSV_DEVICE_OPEN);
    if (!open)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "device: %s belongs to another version of this program; install it again", p->file);
    status = open(rsv_version(), &settings, device, message);
    return status == RSV_OK ? RSV_OK : rsv_fail(status, "device: %s", message);
}

void rsv_device_close(rsv_device *device)
{
    if (device) device->table->close(device);
}

const rsv_device_info *rsv_device_get_info(const rsv_device *device) { return &device->info; }
