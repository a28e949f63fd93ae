/// Where the program computes: the device that --device chooses, which belongs to the process.
#ifndef CLI_DEVICE_H
#define CLI_DEVICE_H

#include "resolvent/device.h"

typedef enum cli_device_choice {
    CLI_DEVICE_CPU,
    CLI_DEVICE_CUDA,
    CLI_DEVICE_AUTO,
    CLI_DEVICE_EMULATED
} cli_device_choice;

extern const char *const cli_device_names[];

/// The option --device for a command's table, and its lines in the command's help.
#define CLI_DEVICE_OPTION(choice)                                                                  \
    {                                                                                              \
        .name = "--device", .kind = CLI_CHOICE, .value = (choice), .choices = cli_device_names     \
    }
#define CLI_DEVICE_HELP                                                                            \
    "  --device D         cpu (default); cuda: an NVIDIA GPU, where supported (docs/gpu.md); auto:\n"\
    "                     the GPU if there is a suitable one; emulated: the GPU code on the CPU\n"

/// Opens the device for the sessions that follow. @return false after a message
bool cli_device_open(int choice);
/// NULL = the processor
rsv_device *cli_device(void);
bool cli_device_is_emulated(void);
void cli_device_close(void);

#endif
