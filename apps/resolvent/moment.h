/// Moments of animated scenes: --time, --clip, --frames and --fps.
#ifndef CLI_MOMENT_H
#define CLI_MOMENT_H

#include "session.h"

// clang-format off
/// The options that fill a cli_moment, for a command's table.
#define CLI_MOMENT_OPTIONS(moment)                                                                 \
    { .name = "--time", .kind = CLI_REAL, .value = &(moment)->time, .min = -1e6, .max = 1e6 },     \
    { .name = "--clip", .kind = CLI_TEXT, .value = &(moment)->clip, .goes_with = "--time" }
// clang-format on

/// Their lines in a command's help.
#define CLI_MOMENT_HELP                                                                                    \
    "  --time S           glTF: pose the scene at S seconds of its animation (default: rest pose)\n"       \
    "  --clip NAME        the animation to play, as listed by `resolvent info SCENE`; all = all at once\n" \
    "                     (default: the first)\n"

/// Frames of an animation: --frames A-B --fps N. Frame 0 is at 0 s.
typedef struct cli_sequence {
    const char *frames; ///< as given; NULL = one picture
    float fps;
    float shutter; ///< part of a frame's time for which the shutter is open; 0 = an instant
    uint32_t first, last;
} cli_sequence;

#define CLI_DEFAULT_SEQUENCE ((cli_sequence){ .fps = 24 })

// clang-format off
#define CLI_SEQUENCE_OPTIONS(sequence)                                                             \
    { .name = "--frames", .kind = CLI_TEXT, .value = &(sequence)->frames },                        \
    { .name = "--fps", .kind = CLI_REAL, .value = &(sequence)->fps, .min = 0.001, .max = 1e6,      \
      .goes_with = "--frames" },                                                                   \
    { .name = "--shutter", .kind = CLI_REAL, .value = &(sequence)->shutter, .min = 0, .max = 1,    \
      .goes_with = "--frames" }
// clang-format on

#define CLI_SHUTTER_HELP                                                                                  \
    "  --shutter S        motion blur: the shutter is open for the part S (0 to 1) of each frame, from\n" \
    "                     its start; the mean of 8 pictures, each of --spp rays per pixel (default 0)\n"

#define CLI_SEQUENCE_HELP                                                                              \
    "  --frames A-B       render these frames of the animation; frame 0 is at 0 s. -o walk-%04d.png\n" \
    "                     numbers the files. Light that does not change is not solved again.\n"        \
    "                     --quality defaults to medium\n"                                              \
    "  --fps N            frames per second (default 24)\n" CLI_SHUTTER_HELP

/// Parses `frames`; prints an error on standard error if it is invalid.
bool cli_read_sequence(const char *command, cli_sequence *sequence);

/// Moments whose pictures make up a frame.
uint32_t cli_moments_of_frame(const cli_sequence *sequence);

/// Seconds. @param moment below cli_moments_of_frame()
float cli_frame_time(const cli_sequence *sequence, uint32_t frame, uint32_t moment);

/// Loads the scene of a file at the session's moment; the file is read only once. Prints an error and returns false on
/// failure.
bool cli_load_moment(cli_session *session, const char *path, rsv_scene **scene);

#endif
