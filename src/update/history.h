/// Results of an earlier solve of the scene, before an edit. Every stage of the next solve looks them up by key, and
/// repeats only what the edit may have changed.
///
/// They are stored in one blob: how cells were split, and which of their corners are open; the receiver points, direct
/// light and indirect light of each node; the positions of triangles. Places have the same keys in every version of a
/// scene (element_keys.h). Results are valid until something comes near them or into their light:
/// - open corners and buried points, unless a box around a change reaches the cells (the inside of a changed body is in its
///   box);
/// - splits of coarse elements, unless they are close to a change relative to its size;
/// - direct light, if sources have not changed, and no straight line from the cells to a source meets such a box.
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

/// Stored direct light of a free node.
typedef struct rsv_history_light {
    rsv_rgb direct;  ///< irradiance by next-event estimation, W/m2
    float deviation; ///< of its luminance, W/m2; fine level
    uint32_t valid;  ///< receiver points that are not buried, bit by bit
} rsv_history_light;

/// Stored data of a free node of the coarse level.
typedef struct rsv_history_node {
    rsv_history_light light;
    rsv_rgb source;   ///< E0, including gathered light and caustics, W/m2
    rsv_rgb indirect; ///< all other irradiance, W/m2
    uint32_t draw;    ///< number by which receiver points were drawn
} rsv_history_node;

typedef struct rsv_history rsv_history;

/// @param settings key of everything else that determines how a scene is solved; other settings have another history
/// @param store must outlive it
/// @param history out: NULL if the store has no valid one for these settings
rsv_status rsv_history_open(const rsv_transport_scene *scene, const rsv_lights *lights,
    rsv_store *store, uint64_t settings, rsv_history **history);
void rsv_history_close(rsv_history *history);

/// The spacing of the coarse elements then, if that is like the one now: cells keep their places. Else the one now.
rsv_spacing rsv_history_spacing(const rsv_history *history, rsv_spacing now);

/// Whether a cell was split that can be split again.
bool rsv_history_was_split(const rsv_history *history, rsv_history_level level,
    const rsv_elements *elements, uint32_t cell);
/// Halvings of the radius of clusters on a face (elements.h), and the level of its grid. @return false if it is not
/// known
bool rsv_history_find_face(const rsv_history *history, const rsv_elements *elements, uint32_t face,
    uint8_t *halvings, uint8_t *level);
/// @return false if it is not known, or may be another now
bool rsv_history_openness(
    const rsv_history *history, const rsv_elements *elements, uint32_t cell, uint8_t *openness);
/// @return NULL if the node did not exist, or something is next to it now
const rsv_history_light *rsv_history_find_light(const rsv_history *history, rsv_history_level level,
    const rsv_elements *elements, uint32_t node, uint64_t node_key);
/// The same of the coarse level.
const rsv_history_node *rsv_history_find_node(
    const rsv_history *history, const rsv_elements *elements, uint32_t node, uint64_t node_key);

/// The known results, for elements.
const rsv_known_cells *rsv_history_known_cells(const rsv_history *history);

/// Boxes around everything that is new.
const rsv_scene_change *rsv_history_added(const rsv_history *history);

/// Boxes around everything that is new or gone.
const rsv_scene_change *rsv_history_change(const rsv_history *history);

/// The same for two histories with the same contents, never 0.
uint64_t rsv_history_identity(const rsv_history *history);

/// Whether sources have changed.
bool rsv_history_sources_changed(const rsv_history *history);

/// Whether the node existed, on any level, with the same surroundings: no new wall divides it.
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

/// Cells whose light may have changed. @param light_changed out: [cell_count], freed by the caller
rsv_status rsv_history_find_light_changed(
    const rsv_history *history, const rsv_elements *elements, uint8_t **light_changed);

/// A level of a solution, to be stored.
typedef struct rsv_history_fields {
    const rsv_elements *elements;              ///< NULL = there is no such level
    const rsv_rgb *direct, *source, *indirect; ///< [node_count]; NULL = 0
    const float *deviation;                    ///< of that irradiance
    const uint16_t *valid_points;              ///< [node_count]
} rsv_history_fields;

/// A warning where that fails: a solution is complete without it.
void rsv_history_write(const rsv_transport_scene *scene, const rsv_lights *lights, rsv_store *store,
    uint64_t settings, const rsv_spacing *spacing,
    const rsv_history_fields level[RSV_HISTORY_LEVELS]);

#endif
