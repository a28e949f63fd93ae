/// E0 of each light separately: contributions that add up to the total, so that scaling them relights a scene without
/// tracing rays.
///
/// Each source is sampled separately. Then every value of the total is divided in proportion to those estimates. The
/// total therefore stays the same, byte for byte, and where only one source shines, its contribution is exact.
#ifndef RSV_LIGHT_BASIS_H
#define RSV_LIGHT_BASIS_H

#include "../direct/receiver_blocks.h"
#include "../sources/light_subset.h"
#include "resolvent/relight.h"

struct rsv_light;

/// The fields of one source, on their own sets of elements; NULL where the solution has none.
typedef struct rsv_light_part {
    rsv_rgb *direct;         ///< on the coarse elements, next-event estimates
    rsv_rgb *coarse_caustic; ///< the same for caustics
    rsv_rgb *fine;           ///< of the direct level
    rsv_rgb *caustic;        ///< of the caustic level
} rsv_light_part;

#define RSV_LIGHT_FIELDS 4

/// Parts and strengths are those of sources by themselves, unscaled: a source that is switched off is still known.
typedef struct rsv_light_basis {
    rsv_context *context;
    size_t source_count;
    rsv_source *source;     ///< [source_count] names are the scene's
    rsv_light_part *part;   ///< [source_count]
    rsv_rgb *scale;         ///< [source_count] factor by which the part counts
    rsv_rgb *strength;      ///< [source_count] radiance or intensity; of surroundings 1
    bool *gathered;         ///< [source_count] whether rows found it
    bool *stale;            ///< [source_count] whether only few rays found the part
    rsv_rgb gathered_scale; ///< factor of the emission that rows gathered
    rsv_rgb *environment; ///< pixels of surroundings that are scaled; NULL = as the scene has them
} rsv_light_basis;

/// The fields of a part in order, and how long they are; 0 = the solution has none.
rsv_rgb **rsv_light_part_field(rsv_light_part *part, size_t field);
size_t rsv_light_field_length(const struct rsv_light *solution, size_t field);

/// @param basis out; without parts if there are fewer than two sources, or their parts would take more than
/// RSV_MAX_PART_BYTES
rsv_status rsv_light_basis_create(const struct rsv_light *solution, rsv_light_basis **basis);
/// A basis without contributions, to be filled.
rsv_status rsv_light_basis_create_empty(const struct rsv_light *solution, rsv_light_basis **basis);
/// Sampling effort for one source, and `valid`: receiver points of the direct level that are not buried.
typedef struct rsv_light_effort {
    uint32_t coarse_samples, fine_samples; ///< shadow rays per element of either level
    uint32_t photons;
    const uint16_t *valid;
    const rsv_receiver_blocks *coarse,
        *fine; ///< of either level, where a preview will do; NULL = nowhere
    /// Light of all sources on the direct level: nodes get shadow rays by the source's share of it. NULL = all of them
    const rsv_rgb *fine_whole;
} rsv_light_effort;

/// The full effort of the solution's own description. @param valid borrowed
rsv_light_effort rsv_full_light_effort(const struct rsv_light *solution, const uint16_t *valid);

/// @param valid out, freed by the caller; NULL if there is no direct level
rsv_status rsv_find_fine_valid(const struct rsv_light *solution, uint16_t **valid);

/// Samples one of the lights separately. @param part its arrays are created if missing; free it with
/// rsv_light_part_free, even after an error
/// @param rays incremented by the number of rays
rsv_status rsv_light_part_estimate(const struct rsv_light *solution, const rsv_lights *lights,
    const rsv_source *source, const rsv_light_effort *effort, rsv_light_part *part, uint64_t *rays);
void rsv_light_part_free(rsv_context *context, rsv_light_part *part);
void rsv_light_basis_destroy(rsv_light_basis *basis);

/// Whether any source is not as strong as it is by itself.
bool rsv_light_basis_is_scaled(const rsv_light_basis *basis);
/// Whether each part has all its rays. @param basis may be NULL
bool rsv_light_basis_is_known(const rsv_light_basis *basis);

/// @param basis of `from` @param solution a copy of that light, whose sources are named in the copy
rsv_status rsv_light_basis_copy(
    const rsv_light_basis *basis, const struct rsv_light *solution, rsv_light_basis **copy);
/// A basis for a number of sources, without their contributions. @param basis out
rsv_status rsv_light_basis_allocate(
    rsv_context *context, size_t source_count, rsv_light_basis **basis);
/// Takes over names and nodes from a scene.
void rsv_light_basis_name_sources(rsv_light_basis *basis, const rsv_scene_view *scene);

/// The strength of a source in a scene; NULL for surroundings.
const rsv_rgb *rsv_source_strength(const rsv_scene_view *scene, const rsv_source *source);

/// Memory for the parts of all sources at most.
#define RSV_MAX_PART_BYTES ((size_t)2 << 30)

/// Whether the sources of a solution are kept apart: there are several, and their parts fit.
bool rsv_light_keeps_parts(const struct rsv_light *solution, const rsv_light_basis *basis);
/// RSV_ERROR_UNSUPPORTED where parts do not fit.
rsv_status rsv_light_basis_check(const struct rsv_light *solution, const rsv_light_basis *basis);

/// A field of the solution, for all its sources together; the first field includes gathered light and caustics.
rsv_rgb *rsv_light_field(const struct rsv_light *solution, size_t field);

/// Next-event estimates and caustics of a solution, for all sources together. @param total [length of field]
void rsv_light_total(const struct rsv_light *solution, size_t field, rsv_rgb *total);

#endif
