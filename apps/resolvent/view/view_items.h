/// Things that can be selected and changed: lights, surroundings, colours, the moving object. Commands as in
/// cli_view_apply.
#ifndef CLI_VIEW_ITEMS_H
#define CLI_VIEW_ITEMS_H

#include "view_state.h"

/// Finds all of them, as they begin. @param relighter NULL = nothing but the body
void cli_view_list_items(
    cli_view_state *state, const rsv_relighter *relighter, const rsv_scene *body);

bool cli_view_select(cli_view_state *state, const char *name, char *problem);
bool cli_view_set_scale(cli_view_state *state, float scale, char *problem);
bool cli_view_brighten(cli_view_state *state, float stops, char *problem);
bool cli_view_set_color(cli_view_state *state, size_t index, rsv_rgb color, char *problem);
bool cli_view_tint(cli_view_state *state, const float by[3], char *problem);
bool cli_view_move_to(cli_view_state *state, rsv_vec3 offset, char *problem);
bool cli_view_nudge(cli_view_state *state, rsv_vec3 by, char *problem);
/// @param place offset in metres, turn in degrees
bool cli_view_place_object(cli_view_state *state, const float place[4], char *problem);
bool cli_view_set_albedo(cli_view_state *state, const cli_view_command *command, char *problem);
bool cli_view_add_light(cli_view_state *state, const cli_view_command *command, char *problem);

/// Writes a problem with one detail. @return false
bool cli_view_fail(char *problem, const char *format, const char *detail);

/// Within -most .. most.
float cli_view_within(float value, float most);

#endif
