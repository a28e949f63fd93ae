/// What an earlier solve of the scene knew, before an edit: every stage of the next solve asks it by key and does again
/// only what the edit may have changed.
///
/// A blob beside those of the rows: how cells were split and which of their corners are open; of each
/// node its receiver points, direct light and indirect light; where the triangles were. Places have the same keys in every
/// version of a scene (element_keys.h). What is known holds until something comes near it or into its light:
/// - corners and buried points, unless a box around what changed reaches the cells (what lies inside a changed body lies
///   inside its box);
/// - splits of coarse elements, unless they lie near a change as seen from its size;
/// - direct light, if sources are what they were, and if no straight line from the cells to a source meets such a box.
#ifndef RSV_HISTORY_H
#define RSV_HISTORY_H

#include "../elements/elements.h"
#include "../elements/known_cells.h"
#include "../elements/spacing.h"
#include "../sources/lights.h"
#include "../specular/specular_walk.h"
#include "scene_change.h"
#include "store.h"

typedef enum rsv_history_level {
    RSV_HISTORY_COARSE,
    RSV_HISTORY_FINE,
    RSV_HISTORY_LEVELS
} rsv_history_level;

/// What was known of the direct light of a free node.
typedef struct rsv_history_light {
    rsv_rgb direct;  ///< irradiance by next-event estimation, W/m2
    float deviation; ///< of its luminance, W/m2; fine level
    uint32_t valid;  ///< receiver points that are not buried, bit by bit
} rsv_history_light;

/// What was known of a free node of the coarse level.
typedef struct rsv_history_node {
    rsv_history_light light;
    rsv_rgb source;   ///< E0, what was gathered and caustics included, W/m2
    rsv_rgb indirect; ///< irradiance by all else, W/m2
    uint32_t draw;    ///< number by which receiver points were drawn
} rsv_history_node;

typedef struct rsv_history rsv_history;

/// @param settings key of all else that decides how a scene is solved: another one has another history
/// @param store that outlives it
/// @param history out: NULL if the store holds none that is sound, for these settings
rsv_status rsv_history_open(const rsv_transport_scene *scene, const rsv_lights *lights,
    rsv_store *store, uint64_t settings, rsv_history **history);
void rsv_history_close(rsv_history *history);

/// The spacing of the coarse elements then, if that is like the one now: cells keep their places. Else the one now.
rsv_spacing rsv_history_spacing(const rsv_history *history, rsv_spacing now);

/// Whether a cell was split that can be split again.
bool rsv_history_was_split(const rsv_history *history, rsv_history_level level,
    const rsv_elements *elements, uint32_t cell);
/// Halvings of the radius of clusters on a face (elements.h), and the level of its grid. @return false if it is not known
bool rsv_history_find_face(const rsv_history *history, const rsv_elements *elements, uint32_t face,
    uint8_t *halvings, uint8_t *level);
/// @return false if it is not known, or may be another now
bool rsv_history_openness(
    const rsv_history *history, const rsv_elements *elements, uint32_t cell, uint8_t *openness);
/// @return NULL if the node was not there, or something has come to lie beside it
const rsv_history_light *rsv_history_find_light(const rsv_history *history, rsv_history_level level,
    const rsv_elements *elements, uint32_t node, uint64_t node_key);
/// The same of the coarse level.
const rsv_history_node *rsv_history_find_node(
    const rsv_history *history, const rsv_elements *elements, uint32_t node, uint64_t node_key);

/// What elements ask of it.
const rsv_known_cells *rsv_history_known_cells(const rsv_history *history);

/// Boxes around all that is new.
const rsv_scene_change *rsv_history_added(const rsv_history *history);

/// Boxes around all that is new, and all that is gone.
const rsv_scene_change *rsv_history_change(const rsv_history *history);

/// The same for two that know the same, never 0.
uint64_t rsv_history_identity(const rsv_history *history);

/// Whether sources are not what they were.
bool rsv_history_sources_changed(const rsv_history *history);

/// Whether the node was there, on any level, and what lies around it is what it was: no wall divides it that did not.
bool rsv_history_knows_around(
    const rsv_history *history, const rsv_elements *elements, uint32_t node, uint64_t node_key);

/// Whether a face or a cell lies near the change: no farther from a changed body than that is large.
bool rsv_history_is_face_near(
    const rsv_history *history, const rsv_elements *elements, uint32_t face);
bool rsv_history_is_near(const rsv_history *history, const rsv_elements *elements, uint32_t cell);
/// The same of any cell around a node.
bool rsv_history_is_node_near(
    const rsv_history *history, const rsv_elements *elements, uint32_t node);
/// Whether the light that reaches a cell straight from the sources may be another now.
bool rsv_history_is_light_changed(
    const rsv_history *history, const rsv_elements *elements, uint32_t cell);

/// The cells for which that holds. @param light_changed out: [cell_count], to be freed
rsv_status rsv_history_find_light_changed(
    const rsv_history *history, const rsv_elements *elements, uint8_t **light_changed);

/// A level of a solution, to be kept.
typedef struct rsv_history_fields {
    const rsv_elements *elements;              ///< NULL = there is no such level
    const rsv_rgb *direct, *source, *indirect; ///< [node_count]; NULL = 0
    const float *deviation;                    ///< likewise
    const uint16_t *valid_points;              ///< [node_count]
} rsv_history_fields;

/// A warning where that fails: a solution is complete without it.
void rsv_history_write(const rsv_transport_scene *scene, const rsv_lights *lights, rsv_store *store,
    uint64_t settings, const rsv_spacing *spacing,
    const rsv_history_fields level[RSV_HISTORY_LEVELS]);

#endif
