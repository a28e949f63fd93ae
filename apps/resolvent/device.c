#include "device.h"

#include "crew.h"
#include "session.h"

#include <stdio.h>

const char *const cli_device_names[] = { [CLI_DEVICE_CPU] = "cpu",
    [CLI_DEVICE_CUDA] = "cuda",
    [CLI_DEVICE_AUTO] = "auto",
    [CLI_DEVICE_EMULATED] = "emulated",
    NULL };

/// Belongs to the process, as the crew does.
static rsv_device *device;

rsv_device *cli_device(void) { return device; }

bool cli_device_is_emulated(void) { return device && rsv_device_get_info(device)->processors == 1; }

bool cli_device_open(int choice)
{
    rsv_device_desc desc = rsv_default_device_desc();
    if (choice == CLI_DEVICE_CPU) return true;
    desc.kind = choice == CLI_DEVICE_EMULATED ? RSV_DEVICE_EMULATED : RSV_DEVICE_CUDA;
    desc.rows = choice != CLI_DEVICE_EMULATED; // whose single thread would take minutes
    desc.optional = choice == CLI_DEVICE_AUTO;
    if (rsv_device_open(&desc, &device) == RSV_OK) return true;
    if (!desc.optional) {
        cli_error("%s", rsv_last_error());
        return false;
    }
    if (cli_crew_speaks()) fprintf(stderr, "note: %s; computing on the CPU\n", rsv_last_error());
    return true;
}

void cli_device_close(void)
{
    rsv_device_close(device);
    device = NULL;
}
