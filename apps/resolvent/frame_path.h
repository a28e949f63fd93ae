/// Names of the pictures of a sequence.
#ifndef CLI_FRAME_PATH_H
#define CLI_FRAME_PATH_H

#include <limits.h>
#include <stdbool.h>
#include <stdint.h>

/// Puts a frame's number where `pattern` has %d or, with zeros in front, %04d.
/// @return false if there is no such place, or more than one, or the name is too long
bool cli_frame_path(const char *pattern, uint32_t frame, char path[PATH_MAX]);

#endif
