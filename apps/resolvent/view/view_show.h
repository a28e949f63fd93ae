/// What is on show: a sketch of the scene, its first light, better ones, and the change from one to the next.
#ifndef CLI_VIEW_SHOW_H
#define CLI_VIEW_SHOW_H

#include "view_refiner.h"
#include "view_sketch.h"

enum { CLI_SHOW_MOST_EVENTS = 8 };

/// When something was shown first, by cli_seconds().
typedef struct cli_show_event {
    const char *name; ///< "sketch", "coarse", ...
    double when;
    double processor; ///< seconds of the process until then
} cli_show_event;

/// All that a sketch depends on.
typedef struct cli_view_pose {
    rsv_camera camera;
    float exposure;
    bool soft;
    uint32_t width, height;
} cli_view_pose;

typedef struct cli_view_show {
    cli_session *session;
    const rsv_scene *body;
    cli_sketch *sketch;     ///< NULL as soon as it is of no more use
    cli_lit lit;            ///< on show; its frames NULL = the sketch is
    cli_lit before;         ///< what fades out; its frames NULL = the sketch does, or nothing
    uint32_t fade;          ///< frames that the change still takes
    cli_view_pose sketched; ///< how the last sketch was seen
    bool sketch_rests;      ///< it was seen so before
    cli_canvas old;         ///< a picture of `before`, or of the sketch
    cli_refiner *refiner;   ///< NULL = nothing is made
    cli_show_event event[CLI_SHOW_MOST_EVENTS];
    uint32_t event_count;
    char message[CLI_VIEW_TEXT_LENGTH]; ///< why nothing better is coming; "" = nothing to say
    bool failed;
} cli_view_show;

/// Shows a sketch of the scene while its light is made. Says what went wrong. @param desc its session and body too
bool cli_show_begin(cli_view_show *show, const cli_refiner_desc *desc, uint32_t threads);

/// Whether frames are of a light, and not of the sketch alone.
bool cli_show_is_lit(const cli_view_show *show);

/// Whether it is the best one, whose sources and materials can be changed.
bool cli_show_is_complete(const cli_view_show *show);

/// Takes over what has been finished meanwhile: the state goes on with it.
rsv_status cli_show_update(cli_view_show *show, cli_view_state *state);

/// Makes the next frame, as cli_view_frames_next.
rsv_status cli_show_frame(
    cli_view_show *show, cli_view_state *state, cli_canvas *canvas, cli_view_timing *timing);

/// Takes the light to a version of the scene in which surfaces are elsewhere; from then on sources and materials stay as they
/// are. After an error other than RSV_ERROR_UNSUPPORTED nothing can be shown any more.
rsv_status cli_show_follow(cli_view_show *show, cli_view_state *state, const rsv_scene *scene);

/// Whether a further frame would look the same, or hardly any better while the next light is waited for.
bool cli_show_at_rest(const cli_view_show *show);

/// Leaves the processors to what is being made for a share of the time that the last frame took, a larger one while there is no
/// light yet.
void cli_show_yield(const cli_view_show *show, double frame_ms);

void cli_show_end(cli_view_show *show);

#endif
