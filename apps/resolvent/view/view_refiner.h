/// Better and better light of a scene, made by a thread of its own while frames go on.
#ifndef CLI_VIEW_REFINER_H
#define CLI_VIEW_REFINER_H

#include "../session.h"
#include "view_frames.h"

/// A light, and all that is needed to show it and, where there is a relighter, to change it.
typedef struct cli_lit {
    const char *name; ///< of its quality
    rsv_light *light;
    rsv_relighter *relighter; ///< NULL = none yet
    cli_view_frames *frames;
    bool follows; ///< it has followed what moves: there is no relighter any more
} cli_lit;

void cli_free_lit(cli_lit *lit);

typedef struct cli_refiner_desc {
    cli_session *session; ///< whose progress the refiner takes over
    const rsv_scene *scene;
    rsv_light *light;     ///< solved already: it is made ready to be shown; taken over. NULL = none
    rsv_solve_desc solve; ///< of the best light
    rsv_quality quality;  ///< of that
    const rsv_scene *body; ///< as in cli_view_frames_create, as is budget_ms
    double budget_ms;
    uint32_t width, height; ///< of the window
    bool keeps_pace;        ///< cli_view_frames_keep_pace
} cli_refiner_desc;

typedef struct cli_refiner cli_refiner;

/// Starts with a coarse light, draft next, and so on up to the quality wanted, and ends with a copy of that and its relighter.
/// @return NULL where there is no memory or no thread
cli_refiner *cli_refiner_start(const cli_refiner_desc *desc);

/// Stops whatever is being made, and waits for its end.
void cli_refiner_stop(cli_refiner *refiner);

/// The best light that was finished since the last call, which is the caller's from then on. @return whether there is one
bool cli_refiner_take(cli_refiner *refiner, cli_lit *lit);

/// What is being made: "medium: assemble 43 %"; "" = nothing. @param text [CLI_VIEW_TEXT_LENGTH]
void cli_refiner_say(cli_refiner *refiner, char *text);

/// Whether nothing more is being made.
bool cli_refiner_is_done(cli_refiner *refiner);

/// How it ended, or RSV_OK. @param message out: why, with room for CLI_VIEW_TEXT_LENGTH bytes; once
rsv_status cli_refiner_failure(cli_refiner *refiner, char *message);

#endif
