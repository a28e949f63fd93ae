/// The environment of every command: a context that reports progress and warnings, stops on Ctrl-C, and
/// opens scenes by file or name.
#ifndef CLI_SESSION_H
#define CLI_SESSION_H

#include "fog_option.h"
#include "options.h"
#include "progress.h"

#include "resolvent/animation.h"
#include "resolvent/io.h"
#include "resolvent/opfile.h"

#include <math.h>
#include <stdatomic.h>

/// Messages printed so far: each is printed once per command, however often its cause occurs.
typedef struct cli_messages {
    char **text; ///< [count], owned
    size_t count;
} cli_messages;

/// A moment of an animated scene.
typedef struct cli_moment {
    float time;       ///< s; NAN = none: as nodes and weights stand
    const char *clip; ///< NULL = the first
} cli_moment;

#define CLI_AT_REST ((cli_moment){ .time = NAN })

/// How scene files are interpreted: --light-units, --two-sided, --emit and --variant.
typedef struct cli_reading {
    int light_units; ///< rsv_light_units
    bool two_sided;
    int emit;            ///< 1 = from both sides
    const char *variant; ///< NULL = the default
    cli_list luminaires; ///< NAME=FILE
} cli_reading;

typedef struct cli_session {
    rsv_context *context;
    cli_progress progress;
    cli_messages warnings, notes;
    const char *mesh;         ///< file of --mesh, the body of a built-in scene; NULL = none
    cli_moment moment;        ///< that scenes are opened at
    rsv_animation *animation; ///< that scenes came from; NULL = none
    cli_reading reading;
    rsv_load_luminaire luminaire[CLI_LIST_CAPACITY]; ///< of the reading; names are owned
    size_t luminaire_count;
    bool keep_document;        ///< scenes keep the glTF file they come from
    const char *checkpoint;    ///< folder that an interrupted run leaves rows in; NULL = none
    double started;            ///< cli_seconds()
    atomic_ullong allocations; ///< of the context so far
    double time_load;          ///< seconds spent in cli_open_scene
    size_t max_bytes;          ///< of --max-memory; 0 = none was given
    bool opens_scene;          ///< a scene is being opened: it may take max_bytes
    atomic_llong opened_bytes; ///< allocated since then, minus what was freed
    atomic_bool is_too_large;  ///< it needed more than max_bytes
    /// Takes progress in place of the bar, from any thread, and says whether to go on; NULL = none
    bool (*watch)(void *user, const char *phase, double fraction);
    void *watch_user;
    atomic_flag speaking; ///< a thread adds to the messages
} cli_session;

/// The option --mesh for a command's table; its value goes to the session once that has begun.
#define CLI_MESH_OPTION(path)                                                                      \
    {                                                                                              \
        .name = "--mesh", .kind = CLI_TEXT, .value = (path)                                        \
    }
#define CLI_MESH_HELP                                                                              \
    "  --mesh FILE        another body for cornell-glass, -marble, -plaster, -showcase or character\n"

// clang-format off
/// The options that fill a cli_reading, for a command's table; it goes to the session once that has begun.
#define CLI_READING_OPTIONS(reading)                                                               \
    { .name = "--light-units", .kind = CLI_CHOICE, .value = &(reading)->light_units,               \
      .choices = cli_light_unit_names },                                                           \
    { .name = "--two-sided", .kind = CLI_FLAG, .value = &(reading)->two_sided },                   \
    { .name = "--emit", .kind = CLI_CHOICE, .value = &(reading)->emit, .choices = cli_emit_names }, \
    { .name = "--variant", .kind = CLI_TEXT, .value = &(reading)->variant },                       \
    { .name = "--luminaire", .kind = CLI_LIST, .value = &(reading)->luminaires }
// clang-format on

/// Their lines in a command's help.
#define CLI_READING_HELP                                                                                     \
    "  --light-units U    units of the file's lights: watt (W/sr, W/m2), photometric (candela and lux,\n"    \
    "                     divided by 683 lm/W), or auto (default): by the exporting program\n"               \
    "  --two-sided        treat single-sided materials of the file as double-sided\n"                        \
    "  --emit SIDES       sides that emissive materials emit from: file (default, as in the file) or both\n" \
    "  --variant NAME     use this material variant of a glTF file\n"                                        \
    "  --luminaire NAME=FILE  replace the light NAME, or add to the node or object NAME, a measured\n"       \
    "                     luminaire (.ies, .ldt); * matches any text\n"

extern const char *const cli_light_unit_names[], *const cli_emit_names[];

/// The option that says how to read a file and was given; NULL = none.
const char *cli_reading_given(const cli_reading *reading);

/// @param session must stay where it is until cli_session_end
/// @param threads 0 = one per CPU core
bool cli_session_begin(cli_session *session, uint32_t threads);
void cli_session_end(cli_session *session);

/// Closes the animation. Do so before the scene whose document it plays is destroyed.
void cli_close_animation(cli_session *session);

/// Builds the built-in scene `name` around the session's mesh.
rsv_status cli_build_scene(cli_session *session, const char *name, rsv_scene **scene);

/// The surroundings given by --env, --env-intensity and --env-rotate, and the fog.
typedef struct cli_environment {
    const char *path; ///< NULL = none
    float intensity;  ///< factor
    float rotation;   ///< degrees
    cli_fog fog;
} cli_environment;

#define CLI_DEFAULT_ENVIRONMENT ((cli_environment){ .intensity = 1 })

// clang-format off
/// The options that fill a cli_environment, for a command's table.
#define CLI_ENVIRONMENT_OPTIONS(environment)                                                       \
    { .name = "--env", .kind = CLI_TEXT, .value = &(environment)->path },                          \
    { .name = "--env-intensity", .kind = CLI_REAL, .value = &(environment)->intensity,             \
      .max = 1e9 },                                                                                \
    { .name = "--env-rotate", .kind = CLI_REAL, .value = &(environment)->rotation,                 \
      .min = -1e4, .max = 1e4 }
// clang-format on

/// Their lines in a command's help.
#define CLI_ENVIRONMENT_HELP                                                                              \
    "  --env FILE         environment: a latitude-longitude picture (.hdr, .exr), or white (radiance 1\n" \
    "                     from everywhere), or sky (a clear sky with its own sun)\n"                      \
    "  --env-intensity S  multiply the environment by S (default 1)\n"                                    \
    "  --env-rotate DEG   rotate the environment, counter-clockwise seen from above (default 0)\n"

// clang-format off
/// The options that fill its fog.
#define CLI_FOG_OPTIONS(environment)                                                               \
    { .name = "--fog", .kind = CLI_TEXT, .value = &(environment)->fog.medium },                    \
    { .name = "--volume", .kind = CLI_TEXT, .value = &(environment)->fog.volume,                   \
      .goes_with = "--fog" }
/// For commands that have mode `reference`, or only describe the scene.
#define CLI_FOG_HEIGHT_OPTION(environment)                                                         \
    { .name = "--fog-height", .kind = CLI_TEXT, .value = &(environment)->fog.height,               \
      .goes_with = "--fog" }
// clang-format on

#define CLI_FOG_HELP                                                                                   \
    "  --fog E[,A[,G]]    fill the air with fog: extinction E per metre, albedo A (default 1), mean\n" \
    "                     cosine G of the scattering angle (default 0); E and A may be R:G:B\n"        \
    "  --volume FILE.vdb  multiply the extinction by the densities of a grid of this OpenVDB file\n"
#define CLI_FOG_HEIGHT_HELP                                                                         \
    "  --fog-height H[,Y] mode reference: above the height Y (default 0), fog thins to 1/e every\n" \
    "                     H metres\n"

/// Loads the file `name` or, if there is no such file, builds the built-in scene of that name.
/// Prints an error and returns NULL on failure.
/// @param environment the surroundings; NULL = none
rsv_scene *cli_open_scene(
    cli_session *session, const char *name, const cli_environment *environment);

/// How the session reads files.
rsv_load_desc cli_describe_load(const cli_session *session);

/// Whether the user has asked to stop.
bool cli_interrupted(void);

/// Prints why a call of the library failed (or that the work was cancelled); returns the exit status.
int cli_report_failure(cli_session *session, rsv_status status);

/// Threads that a context of `threads` threads runs: `threads`, or one per CPU core if 0.
uint32_t cli_thread_count(uint32_t threads);

/// Prints "error: ..." on standard error.
void cli_error(const char *format, ...) RSV_PRINTF(1, 2);

/// Prints "note: ..." on standard error, unless it was said before.
void cli_note(cli_session *session, const char *message);

/// Prints "warning: ..." on standard error and keeps it for the statistics, unless it was said before.
void cli_warn(cli_session *session, const char *message);

#endif
