/// A picture of a scene before it is solved: its surfaces under a lamp at the camera, and its sources, at the speed of
/// rays.
#ifndef CLI_VIEW_SKETCH_H
#define CLI_VIEW_SKETCH_H

#include "view_canvas.h"
#include "view_state.h"

typedef struct cli_sketch cli_sketch;

/// The scene must outlive it.
rsv_status cli_sketch_create(const rsv_scene *scene, uint32_t threads, cli_sketch **sketch);
void cli_sketch_destroy(cli_sketch *sketch);

/// Draws the view of the state's camera. @param state its aspect is set
void cli_sketch_draw(const cli_sketch *sketch, cli_view_state *state, cli_canvas *canvas);

#endif
