/// Skies of tests/validation/cases.json that are given by a formula, as pictures with enough pixels to represent them.
#ifndef CASE_SKY_H
#define CASE_SKY_H

#include "resolvent/resolvent.h"

#include <cjson/cJSON.h>

typedef enum case_sky_kind {
    CASE_SKY_NONE,
    CASE_SKY_CONSTANT,
    CASE_SKY_UPPER,    ///< constant above the horizon, black below
    CASE_SKY_DISC,     ///< constant within an angle of an axis
    CASE_SKY_LOBE,     ///< radiance * max(0, cos)^exponent about an axis
    CASE_SKY_OVERCAST, ///< CIE overcast
    CASE_SKY_GENERAL,  ///< CIE general (ISO 15469), without the sun
    CASE_SKY_HARMONICS ///< nine real spherical harmonics
} case_sky_kind;

/// The cases' zenith is +z.
typedef struct case_sky {
    case_sky_kind kind;
    double radiance;    ///< at the zenith or on the axis
    double ground;      ///< below the horizon of daylight
    double axis[3];     ///< unit: of disc and lobe, towards the sun
    double cos_radius;  ///< disc
    double exponent;    ///< lobe
    double abcde[5];    ///< general
    double harmonic[9]; ///< L00, L1-1, L10, L11, L2-2, L2-1, L20, L21, L22
} case_sky;

/// False if the sky is of a kind that is not known here or negative somewhere.
bool case_sky_read(const cJSON *json, case_sky *sky);

/// Surrounds the scene with the sky, if it is one.
rsv_status case_sky_add(rsv_scene *scene, const case_sky *sky);

#endif
