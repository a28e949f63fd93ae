/// The frames of an animation, lit by one light that follows what moves. `render` and `relight` share it.
#ifndef CLI_SEQUENCE_H
#define CLI_SEQUENCE_H

#include "moment.h"

#include "resolvent/image.h"
#include "resolvent/update.h"

#include <cJSON.h>

/// What the updates of all frames reused and computed.
void cli_add_update(rsv_update_report *sum, const rsv_update_report *update);
void cli_write_updates(cJSON *stats, const rsv_update_report *sum);

/// Takes a light to the next frame.
/// @param finished divide shadows as a solve does: for pictures of the light alone
/// @param sum this update is added
rsv_status cli_follow_frame(
    rsv_light *light, const rsv_scene *scene, bool finished, rsv_update_report *sum);

/// Adds the picture of one of a frame's moments to their mean. @param image taken over @param mean NULL at first
void cli_add_moment(const cli_sequence *sequence, rsv_image *image, rsv_image **mean);

/// Runs the frames in their order, and shows progress. @return false as soon as one fails
bool cli_run_frames(cli_session *session, const cli_sequence *sequence,
    bool (*run)(void *user, uint32_t frame), void *user);

#endif
