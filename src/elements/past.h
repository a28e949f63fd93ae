/// What an earlier solve of the scene knew, before an edit: every stage of the next solve asks it by key and does again
/// only what the edit may have changed.
///
/// A file in the folder of the rows, mapped into memory: how cells were split and which of their corners are open; of each
/// node its receiver points, direct light and indirect light; where the triangles were. Places have the same keys in every
/// version of a scene (element_keys.h). What is known holds until something comes near it or into its light:
/// - corners and buried points, unless a box around what changed reaches the cells (what lies inside a changed body lies
///   inside its box);
/// - splits of coarse elements, unless they lie near a change as seen from its size;
/// - direct light, if sources are what they were, and if no straight line from the cells to a source meets such a box.
#ifndef RSV_PAST_H
#define RSV_PAST_H

#include "../chain/chain_walk.h"
#include "../light/light.h"
#include "elements.h"
#include "scene_change.h"
#include "spacing.h"

typedef enum rsv_past_level { RSV_PAST_COARSE, RSV_PAST_FINE, RSV_PAST_LEVELS } rsv_past_level;

/// What was known of the direct light of a free node.
typedef struct rsv_past_light {
    rsv_rgb direct;  ///< irradiance by next-event estimation, W/m2
    float deviation; ///< of its luminance, W/m2; fine level
    uint32_t valid;  ///< receiver points that are not buried, bit by bit
} rsv_past_light;

/// What was known of a free node of the coarse level.
typedef struct rsv_past_node {
    rsv_past_light light;
    rsv_rgb source;   ///< E0, what was gathered and caustics included, W/m2
    rsv_rgb indirect; ///< irradiance by all else, W/m2
    uint32_t draw;    ///< number by which receiver points were drawn
} rsv_past_node;

typedef struct rsv_past rsv_past;

/// @param settings key of all else that decides how a scene is solved: another one is another past
/// @param past out: NULL if the folder holds none that is sound, for these settings
rsv_status rsv_past_open(const rsv_transport_scene *scene, const rsv_lights *lights,
    const char *folder, uint64_t settings, rsv_past **past);
void rsv_past_close(rsv_past *past);

/// The spacing of the coarse elements then, if that is like the one now: cells keep their places. Else the one now.
rsv_spacing rsv_past_spacing(const rsv_past *past, rsv_spacing now);

/// Whether a cell was split that can be split again.
bool rsv_past_was_cell_split(
    const rsv_past *past, rsv_past_level level, const rsv_elements *elements, uint32_t cell);
/// Halvings of the radius of clusters on a face (elements.h), and the level of its grid. @return false if it is not known
bool rsv_past_find_face(const rsv_past *past, const rsv_elements *elements, uint32_t face,
    uint8_t *halvings, uint8_t *level);
/// @return false if it is not known, or may be another now
bool rsv_past_openness(
    const rsv_past *past, const rsv_elements *elements, uint32_t cell, uint8_t *openness);
/// @return NULL if the node was not there, or something has come to lie beside it
const rsv_past_light *rsv_past_find_light(const rsv_past *past, rsv_past_level level,
    const rsv_elements *elements, uint32_t node, uint64_t node_key);
/// The same of the coarse level.
const rsv_past_node *rsv_past_find_node(
    const rsv_past *past, const rsv_elements *elements, uint32_t node, uint64_t node_key);

/// Boxes around all that is new, and all that is gone.
const rsv_scene_change *rsv_past_change(const rsv_past *past);

/// The same for two that know the same, never 0.
uint64_t rsv_past_identity(const rsv_past *past);

/// Whether sources are not what they were.
bool rsv_past_has_other_sources(const rsv_past *past);

/// Whether the node was there, on any level, and what lies around it is what it was: no wall divides it that did not.
bool rsv_past_knows_around(
    const rsv_past *past, const rsv_elements *elements, uint32_t node, uint64_t node_key);

/// Whether a face or a cell lies near the change: no farther from a changed body than that is large.
bool rsv_past_is_face_near(const rsv_past *past, const rsv_elements *elements, uint32_t face);
bool rsv_past_is_near(const rsv_past *past, const rsv_elements *elements, uint32_t cell);
/// The same of any cell around a node.
bool rsv_past_is_node_near(const rsv_past *past, const rsv_elements *elements, uint32_t node);
/// Whether the light that reaches a cell straight from the sources may be another now.
bool rsv_past_is_lit_anew(const rsv_past *past, const rsv_elements *elements, uint32_t cell);

/// The same of any cell whose light a node receives, those of its followers included.
/// @param cell_lit_anew [cell_count] of the cells
bool rsv_past_is_node_lit_anew(
    const rsv_elements *elements, uint32_t node, const uint8_t *cell_lit_anew);
/// The cells for which that holds. @param lit_anew out: [cell_count], to be freed
rsv_status rsv_past_find_lit_anew(
    const rsv_past *past, const rsv_elements *elements, uint8_t **lit_anew);

/// A level of a solution, to be remembered.
typedef struct rsv_past_fields {
    const rsv_elements *elements;              ///< NULL = there is no such level
    const rsv_rgb *direct, *source, *indirect; ///< [node_count]; NULL = 0
    const float *deviation;                    ///< likewise
    const uint16_t *valid_points;              ///< [node_count]
} rsv_past_fields;

/// Writes it beside its place and moves it there; a warning where that fails: a solution is complete without it.
void rsv_past_write(const rsv_transport_scene *scene, const rsv_lights *lights, const char *folder,
    uint64_t settings, const rsv_spacing *spacing, const rsv_past_fields level[RSV_PAST_LEVELS]);

#endif
