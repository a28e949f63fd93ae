/// Edits the objects of the scene in the view: they are moved, turned, scaled, hidden, repeated and deleted, and their
/// materials changed. The light follows.
///
/// Edits start from the scene as it was opened. What moves is followed (rsv_light_follow); where objects come or go, or
/// materials change, the scene is solved again, reusing what the edit did not change (rsv_operator_update).
#ifndef CLI_VIEW_EDITOR_H
#define CLI_VIEW_EDITOR_H

#include "view_show.h"

#include "resolvent/edit.h"
#include "resolvent/trace.h"
#include "resolvent/update.h"

/// An object of the edited scene.
typedef struct cli_edited_object {
    uint32_t source;  ///< object of the original scene
    float matrix[16]; ///< column-major, from where that is
    bool hidden;
} cli_edited_object;

/// All objects and materials: what undo goes back to.
typedef struct cli_edition {
    cli_edited_object *object; ///< [object_count]
    size_t object_count;
    rsv_material_edit *material; ///< [material_count] that were changed
    size_t material_count;
    size_t selected; ///< object; SIZE_MAX = none
} cli_edition;

typedef struct cli_view_editor {
    const rsv_scene *original; ///< NULL = there is nothing to edit
    rsv_solve_desc solve;
    cli_edition now;
    cli_edition *past; ///< [past_count] for undo, the last one the newest
    size_t past_count;
    bool hauls;                      ///< the last command dragged the object
    bool changed;                    ///< the light does not show `now` yet
    bool played;                     ///< the scene is an animation's: nothing can be edited
    char save[CLI_VIEW_TEXT_LENGTH]; ///< .glb file wanted; "" = none

    cli_edition built;       ///< that `parts` was made for; without objects = for the original
    rsv_scene *parts;        ///< what is shown, where it was at first; NULL = the original
    rsv_scene *lit;          ///< that the light was created for; NULL = the original
    rsv_scene *version;      ///< what the light shows; NULL = the same as `lit`
    rsv_update_store *store; ///< NULL = nothing was solved again yet
    rsv_tracer *tracer;      ///< of what is shown; NULL = not needed yet
    uint32_t quiet_frames;
    bool settled;
} cli_view_editor;

/// @param original borrowed; outlives the editor
void cli_view_editor_begin(
    cli_view_editor *editor, const rsv_scene *original, const rsv_solve_desc *solve);
/// After the light.
void cli_view_editor_end(cli_view_editor *editor);

/// Carries out a command for objects. @param problem as in cli_view_apply
bool cli_view_editor_apply(cli_view_editor *editor, const cli_view_state *state,
    const cli_view_command *command, char *problem);

/// Takes the light to the scene as edited, and finishes it once edits rest. An edit that cannot be carried out is
/// undone.
/// @param problem out: why not @param lag_ms out: how long that took; 0 = nothing was to be done
/// @return false after an error
bool cli_view_edit(cli_view_editor *editor, cli_view_show *show, cli_view_state *state,
    double *lag_ms, char *problem);

/// The selected object, for the panel. @param text [CLI_VIEW_TEXT_LENGTH]; "" = none
void cli_view_editor_say(const cli_view_editor *editor, char *text);

#endif
