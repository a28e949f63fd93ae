/// The state of the view: camera, mode and light. Commands change it; nothing here draws or solves.
#ifndef CLI_VIEW_STATE_H
#define CLI_VIEW_STATE_H

#include "view_command.h"

#include "resolvent/relight.h"

typedef enum cli_view_mode {
    CLI_VIEW_OPERATOR,
    CLI_VIEW_FINAL,
    CLI_VIEW_OCCLUSION,
    CLI_VIEW_OCCLUSION_SCREEN,
    CLI_VIEW_ERROR, ///< heat map of the certificate
    CLI_VIEW_MODE_COUNT
} cli_view_mode;

/// "operator", "final", ...
extern const char *const cli_view_mode_names[];

typedef enum cli_view_kind {
    CLI_VIEW_LIGHT,
    CLI_VIEW_ENVIRONMENT,
    CLI_VIEW_MATERIAL,
    CLI_VIEW_OBJECT ///< that moves; the last but for lights that were added
} cli_view_kind;

/// Something whose light or colour can be changed.
typedef struct cli_view_item {
    cli_view_kind kind;
    const char
        *name; ///< borrowed from the scene; of a node, where lights share a name of their own
    const char *alias; ///< the other one of the light's and its node's; NULL = there is none
    rsv_rgb color;     ///< factors of a light, base colour of a material
    float scale;       ///< of a light
    rsv_vec3 offset;   ///< of a light, from `home`
    rsv_vec3 home;
    rsv_rgb glow; ///< a light's own colour, the largest component 1
    bool movable;
} cli_view_item;

enum { CLI_VIEW_MOST_ADDED = 16, CLI_VIEW_NAME_LENGTH = 64 };

typedef struct cli_view_state {
    const rsv_scene_view *scene;
    float aspect; ///< of one eye's picture
    rsv_vec3 pivot;
    float reach; ///< metres from the pivot to the farthest corner of the scene

    rsv_camera camera;
    cli_view_item *item; ///< [item_count] lights first
    size_t item_count;
    float env_rotation;
    size_t selected;     ///< item_count = none
    bool grabbed;        ///< the item selected follows the mouse
    bool points;         ///< lux are read at `pointer`
    float pointer[2];    ///< x to the right, y down, from 0 to 1
    cli_view_item *home; ///< [item_count] as they began
    float home_rotation;
    cli_view_item *taken; ///< [item_count] as the light last took them
    float taken_rotation;
    size_t added_count; ///< lights that were added: the last items
    char added_name[CLI_VIEW_MOST_ADDED][CLI_VIEW_NAME_LENGTH];

    cli_view_mode mode;
    uint32_t layer, layer_count; ///< RSV_NONE = all
    float exposure;              ///< stops
    float own_exposure;          ///< stops that it begins with: the scene's
    bool soft;
    bool stereo, hud, help, markers;
    float separation; ///< of the eyes, metres

    size_t object;           ///< the item that moves; SIZE_MAX = none
    float object_turn;       ///< degrees
    uint32_t light_changes;  ///< counts everything that changes the light
    uint32_t object_changes; ///< and the object's place
    bool plays;              ///< the scene's animation
    bool sought;             ///< `time` was set: the light is to follow there
    double time, length;     ///< s into the animation; that it lasts, 0 = not known yet
    float speed;             ///< seconds of the animation in a second
    bool quit;
    char screenshot[CLI_VIEW_TEXT_LENGTH]; ///< files wanted; "" = none
    char panorama[CLI_VIEW_TEXT_LENGTH];
} cli_view_state;

/// @param relighter NULL = nothing can be changed yet
/// @param layer_count of the solution: emission and its orders @param body a moving object; NULL = none
/// @param state to be freed by cli_view_state_free even after an error
bool cli_view_state_begin(const rsv_relighter *relighter, const rsv_scene *scene,
    uint32_t layer_count, const rsv_scene *body, cli_view_state *state);
/// Takes over from an earlier state of the same scene where one looks from, and how, and where the object is.
void cli_view_state_continue(cli_view_state *state, const cli_view_state *earlier);
/// Sets the exposure that the scene starts with; changes by the user are kept.
void cli_view_expose(cli_view_state *state, float stops);
void cli_view_state_free(cli_view_state *state);

/// Carries out a command. @param problem out: why not, with room for CLI_VIEW_TEXT_LENGTH bytes; nothing has changed
/// then
bool cli_view_apply(cli_view_state *state, const cli_view_command *command, char *problem);

/// One of the lights that were added, for the relighter.
rsv_punctual_light cli_view_added_light(const cli_view_state *state, size_t index);

/// Storage for the arrays that cli_view_relighting returns.
typedef struct cli_view_changes {
    rsv_light_scale *light;    ///< [item_count]
    rsv_albedo_change *albedo; ///< [item_count]
    rsv_light_move *move;      ///< [item_count]
} cli_view_changes;

/// All changes since the start.
rsv_relight_desc cli_view_relighting(const cli_view_state *state, const cli_view_changes *room);

/// To be called when the light has taken the changes of cli_view_relighting.
void cli_view_note_taken(cli_view_state *state);

/// To be called when the light has refused them: resets lights and colours to the last accepted ones.
void cli_view_take_back(cli_view_state *state);

/// The item called so ("light.NAME", "albedo.MATERIAL", "environment"); item_count = none.
size_t cli_view_find_item(const cli_view_state *state, const char *name);

/// The same words for an item. @param text [CLI_VIEW_TEXT_LENGTH]
void cli_view_item_name(const cli_view_item *item, char *text);

/// Where a light is seen in the picture of the camera. @return metres in front of it, 0 or less = not seen
float cli_view_place(const cli_view_state *state, const cli_view_item *item, float place[2]);

#endif
