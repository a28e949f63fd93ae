/// Light that changes over time: the file format of `resolvent relight --script`.
///
///     # frame  value at that frame; interpolated linearly in between
///     0        env-rotate=0    light.sun=1           "light.desk lamp=0"
///     120                      light.sun=1,1,0.7,0.4
///     239      env-rotate=180  light.sun=0           "light.desk lamp=1" albedo.wall=0.2,0.3,0.8
#ifndef CLI_LIGHT_SCRIPT_H
#define CLI_LIGHT_SCRIPT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "resolvent/scene.h"

enum { CLI_MAX_TRACKS = 64, CLI_MAX_FRAME = 1000000 };

typedef enum cli_track_kind {
    CLI_TRACK_LIGHT,     ///< light.NAME=SCALE, =R,G,B or =SCALE,R,G,B: three factors
    CLI_TRACK_ALBEDO,    ///< albedo.MATERIAL=R,G,B
    CLI_TRACK_MOVE,      ///< move.NAME=X,Y,Z
    CLI_TRACK_AIM,       ///< aim.NAME=X,Y,Z
    CLI_TRACK_PLACE,     ///< place.object=X,Y,Z
    CLI_TRACK_INTENSITY, ///< env-intensity=S
    CLI_TRACK_ROTATION   ///< env-rotate=DEG
} cli_track_kind;

typedef struct cli_key {
    uint32_t frame;
    float value[3];
} cli_key;

/// The keys of one property.
typedef struct cli_track {
    cli_track_kind kind;
    char *name; ///< of the light or material
    cli_key *key;
    size_t key_count; ///< frames increase
} cli_track;

typedef struct cli_light_script {
    cli_track track[CLI_MAX_TRACKS];
    size_t track_count;
    uint32_t first, last; ///< frames
} cli_light_script;

/// Prints on standard error which line is wrong, and why. @param script to be freed even after an error
bool cli_read_light_script(const char *path, cli_light_script *script);
void cli_free_light_script(cli_light_script *script);

/// Linear between keys, constant before the first and after the last.
void cli_track_at(const cli_track *track, uint32_t frame, float value[3]);

/// The three factors of a light, from one number, R, G, B, or a factor and R, G, B. @return false for other counts
bool cli_light_scale(const float *number, size_t count, rsv_rgb *scale);

/// Cuts "NAME=1,2,..." into name and at most four numbers. @return how many; 0 = it is nothing of the kind
size_t cli_cut_change(char *text, float number[4]);

#endif
