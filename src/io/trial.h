/// Work on hostile input by code that others wrote, tried where it can do no harm.
#ifndef RSV_TRIAL_H
#define RSV_TRIAL_H

#include "resolvent/core.h"

#define RSV_TRIAL_MESSAGE_BYTES 400

/// Does `work` in a copy of this process first, with bounds to its time and memory that grow with the input: RSV_OK if
/// it succeeds there, so that it may be done here. Where `work` fails with a message, that becomes the error's; where it
/// crashes, hangs or runs out of memory, the error says so. Nothing of what it makes survives.
/// @param work fills `message` [RSV_TRIAL_MESSAGE_BYTES] if it answers false; must not depend on other threads
/// @param bytes of the input
rsv_status rsv_trial(bool (*work)(void *user, char *message), void *user, size_t bytes);

#endif
