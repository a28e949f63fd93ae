/// Lights with a place (emitters that next-event estimation samples, point and spot lights) as fog is lit by them:
/// chosen where a path is scattered, or ahead of that, for a whole segment of it.
#ifndef RSV_FOG_LIGHTS_H
#define RSV_FOG_LIGHTS_H

#include "../core/alias_table.h"
#include "punctual_light.h"

/// The first entries are those of rsv_lights.sampled, the others punctual lights behind the distant ones.
typedef struct rsv_fog_lights {
    rsv_context *context;
    const rsv_lights *lights;
    uint32_t emitters, count;
    rsv_alias_entry *table; ///< [count] by power
    float *probability;     ///< [count] of the table
    uint32_t *entry;        ///< [emitter_count] of each emitter; RSV_NONE = it is gathered
} rsv_fog_lights;

/// @param lights borrowed
rsv_status rsv_fog_lights_create(
    rsv_context *context, const rsv_lights *lights, rsv_fog_lights *fog_lights);
void rsv_fog_lights_destroy(rsv_fog_lights *fog_lights);

/// Emitters that are weighed one by one, the tree of the others, and punctual lights or the tree of those.
#define RSV_FOG_CHOICES (RSV_LOCAL_LIGHTS + 1 + RSV_SUMMED_LIGHTS)

/// The lights as seen from one point, with probabilities close to their unshadowed contributions.
typedef struct rsv_fog_choice {
    const rsv_fog_lights *lights;
    rsv_vec3 point;
    uint32_t count;
    float probability[RSV_FOG_CHOICES];
} rsv_fog_choice;

void rsv_fog_lights_at(const rsv_fog_lights *lights, rsv_vec3 point, rsv_fog_choice *choice);
/// The same for emitters only.
void rsv_fog_emitters_at(const rsv_fog_lights *lights, rsv_vec3 point, rsv_fog_choice *choice);

/// One of them. @return its entry; RSV_NONE if none contributes @param probability out
uint32_t rsv_fog_choice_draw(const rsv_fog_choice *choice, float u, float *probability);

/// Probability to draw that entry.
float rsv_fog_choice_probability(const rsv_fog_choice *choice, uint32_t entry);

/// The punctual light of an entry; NULL = it is an emitter.
const rsv_punctual_light *rsv_fog_light_punctual(const rsv_fog_lights *lights, uint32_t entry);

/// Draws a point on the emitter of an entry. False if no part of it faces the point.
/// @param sample out: with the density of the direction only, without that of the entry
bool rsv_fog_sample_emitter(
    const rsv_fog_choice *choice, uint32_t entry, float u1, float u2, rsv_light_sample *sample);

/// Density per solid angle with which that draws a direction; 0 if it cannot.
float rsv_fog_emitter_pdf(
    const rsv_fog_choice *choice, uint32_t emitter, rsv_vec3 direction, float distance);

#endif
