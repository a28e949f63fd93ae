/// Commands of the view, as text. Scripts, keys and the mouse all use them.
///
///     orbit 15 -5        select "light.desk lamp"        mode occlusion
#ifndef CLI_VIEW_COMMAND_H
#define CLI_VIEW_COMMAND_H

#include <stdbool.h>
#include <stddef.h>

typedef enum cli_view_verb {
    CLI_VIEW_ADD,
    CLI_VIEW_ALBEDO,
    CLI_VIEW_BRIGHTEN,
    CLI_VIEW_CAMERA,
    CLI_VIEW_CHOOSE,
    CLI_VIEW_COLOR,
    CLI_VIEW_DELETE,
    CLI_VIEW_DOLLY,
    CLI_VIEW_DRAG,
    CLI_VIEW_DUPLICATE,
    CLI_VIEW_ENV_ROTATE,
    CLI_VIEW_EXPOSE,
    CLI_VIEW_EXPOSURE,
    CLI_VIEW_FLY,
    CLI_VIEW_GRASP,
    CLI_VIEW_HAUL,
    CLI_VIEW_HIDE,
    CLI_VIEW_INTENSITY,
    CLI_VIEW_LAYER,
    CLI_VIEW_LOOK,
    CLI_VIEW_MODE,
    CLI_VIEW_MOVE,
    CLI_VIEW_NUDGE,
    CLI_VIEW_ORBIT,
    CLI_VIEW_PAINT,
    CLI_VIEW_PANORAMA,
    CLI_VIEW_PAUSE,
    CLI_VIEW_PICK,
    CLI_VIEW_PLACE,
    CLI_VIEW_PLAY,
    CLI_VIEW_POINT,
    CLI_VIEW_QUIT,
    CLI_VIEW_RELEASE,
    CLI_VIEW_RESET,
    CLI_VIEW_RESIZE,
    CLI_VIEW_SAVE,
    CLI_VIEW_SCREENSHOT,
    CLI_VIEW_SCRUB,
    CLI_VIEW_SELECT,
    CLI_VIEW_SEPARATION,
    CLI_VIEW_SHIFT,
    CLI_VIEW_SHOW,
    CLI_VIEW_SPEED,
    CLI_VIEW_SPIN,
    CLI_VIEW_STEP,
    CLI_VIEW_SURFACE,
    CLI_VIEW_TINT,
    CLI_VIEW_TONE,
    CLI_VIEW_TURN,
    CLI_VIEW_UNDO
} cli_view_verb;

enum { CLI_VIEW_TEXT_LENGTH = 256 };

typedef struct cli_view_command {
    cli_view_verb verb;
    float number[4];
    double exact[4]; ///< the same: places of a scene's file may have more digits than a float
    char text[CLI_VIEW_TEXT_LENGTH];
} cli_view_command;

/// Reads one command. @param problem out: why not, with room for CLI_VIEW_TEXT_LENGTH bytes
bool cli_read_view_command(const char *line, cli_view_command *command, char *problem);

/// Whether the command has to do with sources and materials, or takes a picture: it means nothing before the light is
/// there.
bool cli_view_needs_light(cli_view_verb verb);

/// Whether the command is for objects of the scene (view_editor.h).
bool cli_view_edits(cli_view_verb verb);

#endif
