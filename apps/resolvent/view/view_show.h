/// What the view displays: a sketch of the scene, its first light, better ones, and the fade from one to the next.
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

/// Everything that a sketch depends on.
typedef struct cli_view_pose {
    rsv_camera camera;
    float exposure;
    bool soft;
    uint32_t width, height;
} cli_view_pose;

typedef struct cli_view_show {
    cli_session *session;
    const rsv_scene *body;
    bool keeps_pace;        ///< cli_view_frames_keep_pace
    cli_sketch *sketch;     ///< NULL once it is no longer needed
    cli_lit lit;            ///< displayed; frames NULL = the sketch is
    cli_lit before;         ///< fading out; frames NULL = the sketch is, or nothing
    uint32_t fade;          ///< frames until the fade ends
    cli_view_pose sketched; ///< pose of the last sketch
    bool sketch_rests;      ///< the pose has not changed since
    cli_canvas old;         ///< a picture of `before`, or the sketch
    cli_refiner *refiner;   ///< NULL = no light is being computed
    cli_show_event event[CLI_SHOW_MOST_EVENTS];
    uint32_t event_count;
    char message[CLI_VIEW_TEXT_LENGTH]; ///< why no better light will come; "" = nothing to say
    bool failed;
} cli_view_show;

/// Shows a sketch of the scene while its light is computed. Prints errors. @param desc its session and body outlive the
/// show
bool cli_show_begin(cli_view_show *show, const cli_refiner_desc *desc, uint32_t threads);

/// Whether a solved light is displayed, not only the sketch.
bool cli_show_is_lit(const cli_view_show *show);

/// Whether it is the final light, whose sources and materials can be changed.
bool cli_show_is_complete(const cli_view_show *show);

/// Switches to the best light finished meanwhile, which gets the state's changes.
rsv_status cli_show_update(cli_view_show *show, cli_view_state *state);

/// Makes the next frame, as cli_view_frames_next.
rsv_status cli_show_frame(
    cli_view_show *show, cli_view_state *state, cli_canvas *canvas, cli_view_timing *timing);

/// Takes the light to a version of the scene in which surfaces have moved. From then on sources and materials cannot be
/// changed. After an error other than RSV_ERROR_UNSUPPORTED nothing can be displayed any more.
/// @param most_triangles of moving surfaces whose own light is computed again; 0 = all
rsv_status cli_show_follow(
    cli_view_show *show, cli_view_state *state, const rsv_scene *scene, size_t most_triangles);

/// Shows the light of another scene instead, whose sources and materials cannot be changed.
/// @param light taken over, even after an error: nothing can be displayed any more then
rsv_status cli_show_replace(cli_view_show *show, cli_view_state *state, rsv_light *light);

/// Whether another frame would look the same, or hardly any better until the next light is ready.
bool cli_show_at_rest(const cli_view_show *show);

/// Sleeps for a share of the last frame's time, so that the light gets the processors; longer while there is no light
/// yet.
void cli_show_yield(const cli_view_show *show, double frame_ms);

void cli_show_end(cli_view_show *show);

#endif
