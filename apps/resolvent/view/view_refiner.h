/// Better and better light of a scene, made by a thread of its own while frames go on.
#ifndef CLI_VIEW_REFINER_H
#define CLI_VIEW_REFINER_H

#include "../session.h"
#include "view_frames.h"

/// A light, all that is needed to show it and, if it has a relighter, to change it.
typedef struct cli_lit {
    const char *name; ///< of its quality
    rsv_light *light;
    rsv_relighter *relighter; ///< NULL = none yet
    cli_view_frames *frames;
    bool follows; ///< it has followed moving surfaces, and so has no relighter
} cli_lit;

void cli_free_lit(cli_lit *lit);

typedef struct cli_refiner_desc {
    cli_session *session; ///< whose progress the refiner takes over
    const rsv_scene *scene;
    rsv_light *light;      ///< already solved, to be prepared only; taken over. NULL = none
    rsv_solve_desc solve;  ///< of the final light
    rsv_quality quality;   ///< of the final light
    const rsv_scene *body; ///< as in cli_view_frames_create, as is budget_ms
    double budget_ms;
    uint32_t width, height; ///< of the window
    bool keeps_pace;        ///< cli_view_frames_keep_pace
} cli_refiner_desc;

typedef struct cli_refiner cli_refiner;

/// Computes a coarse light, then draft, and so on up to the quality wanted; last comes a copy of that with its
/// relighter.
/// @return NULL if there is no memory or no thread
cli_refiner *cli_refiner_start(const cli_refiner_desc *desc);

/// Stops the computation, and waits for its thread to end.
void cli_refiner_stop(cli_refiner *refiner);

/// Takes the best light finished since the last call; the caller owns it. @return whether there is one
bool cli_refiner_take(cli_refiner *refiner, cli_lit *lit);

/// Describes the present work: "medium: assemble 43 %"; "" = none. @param text [CLI_VIEW_TEXT_LENGTH]
void cli_refiner_say(cli_refiner *refiner, char *text);

/// Whether nothing more is being made.
bool cli_refiner_is_done(cli_refiner *refiner);

/// How it ended, or RSV_OK. @param message out: why, with room for CLI_VIEW_TEXT_LENGTH bytes; once
rsv_status cli_refiner_failure(cli_refiner *refiner, char *message);

#endif
