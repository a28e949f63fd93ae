/// Plays a scene's animation in the view. The light follows what moves, and lags behind it by the time that takes.
#ifndef CLI_VIEW_PLAYER_H
#define CLI_VIEW_PLAYER_H

#include "view_show.h"
#include "view_turns.h"

typedef struct cli_view_player {
    cli_session *session;
    const char *path, *clip_name; ///< of the scene's file; NULL = the first clip
    double step;                  ///< s from frame to frame; 0 = as the clock says
    rsv_animation *animation;     ///< the session's, borrowed; NULL = not looked at yet
    uint32_t clip;
    cli_turns turns;       ///< of objects, within the budget
    rsv_scene *scene;      ///< that the light has followed to; NULL = none yet
    rsv_scene *wanted;     ///< that `scene` is on the way to; NULL = it is there
    double followed;       ///< s into the animation that this is at
    double clock;          ///< cli_seconds() of the last frame
    uint32_t quiet_frames; ///< at the same moment
    bool settled;          ///< the light rests there
} cli_view_player;

/// Whether a file may hold an animation.
bool cli_view_is_playable(const char *path);

/// Advances time and light while the animation plays or after its time was set.
/// @param state its animation's length is set once that is known @param problem out: the error, in a buffer of
/// CLI_VIEW_TEXT_LENGTH bytes; the animation then stops
/// @param lag_ms out: how far the displayed light is behind; 0 = not at all
/// @return false after an error
bool cli_view_play(cli_view_player *player, cli_view_show *show, cli_view_state *state,
    double *lag_ms, char *problem);

void cli_view_player_end(cli_view_player *player);

#endif
