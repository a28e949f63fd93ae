/// Exposure of 8-bit pictures: that of --exposure, else chosen automatically for scenes from files. Built-in scenes are
/// lit for an exposure of 0.
#ifndef CLI_EXPOSURE_H
#define CLI_EXPOSURE_H

#include "options.h"
#include "subject.h"

#include "resolvent/image.h"
#include "resolvent/render.h"

#include <math.h>

/// Stands for an option that was not given.
#define CLI_AUTO_EXPOSURE NAN

/// The option --exposure for a command's table. @param stops float *, CLI_AUTO_EXPOSURE before
#define CLI_EXPOSURE_OPTION(stops)                                                                 \
    {                                                                                              \
        .name = "--exposure", .kind = CLI_REAL, .value = (stops), .min = -64, .max = 64            \
    }

#define CLI_EXPOSURE_HELP                                                                          \
    "  --exposure STOPS   brighten .png by 2^STOPS (default: automatic for files, and printed; 0 for\n"\
    "                     built-in scenes)\n"

/// Whether the exposure is automatic: none was given, and the scene is neither built-in nor a solution of a built-in
/// one.
/// @param name of the scene or operator file
bool cli_exposes(cli_session *session, const char *name, float asked);

/// Determines the exposure of a picture, and prints it. @param wanted whether it is automatic; otherwise `asked`, or 0
float cli_expose(cli_session *session, bool wanted, float asked, const rsv_image *image);

/// The same for a solved scene, from a small picture in mode operator. @param stops out; 0 unless `wanted` or asked for
rsv_status cli_expose_light(
    cli_session *session, bool wanted, const rsv_light *light, uint32_t camera, float *stops);

/// Whether a .png is among the outputs.
bool cli_writes_png(const cli_list *outputs);

#endif
