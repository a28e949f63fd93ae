/// Every kind of surface, and integrals over the sphere of directions that hold for the narrowest lobe.
#ifndef RSV_TEST_BSDF_CASES_H
#define RSV_TEST_BSDF_CASES_H

#include "bsdf/bsdf.h"

#include <stddef.h>

typedef struct bsdf_case {
    const char *name;
    rsv_material material; ///< white and lossless; its roughness is the test's to choose
    bool both_sides;       ///< also to be seen from inside or behind
} bsdf_case;

/// Ends with a NULL name.
const bsdf_case *bsdf_cases(void);

rsv_bsdf bsdf_of(const bsdf_case *c, float roughness);

/// Coordinates of the unit square for one hemisphere, dense where a lobe peaks: by the half vector, which
/// makes reflection lobes round at any angle, or by the polar distance from the refracted direction.
typedef struct bsdf_chart {
    rsv_vec3 wo, axis, tangent, bitangent;
    float scale,
        stretch; ///< stretch: of brushed surfaces, along the tangent and the inverse across it
    float side;  ///< +1, -1: only directions above or below the surface count
    bool half_vectors; ///< side -1: of light reflected through the surface, as by a thin sheet
} bsdf_chart;

/// [0] above the surface, [1] below. The normal is z. Tangents lie in the plane of wo and the normal. The surfaces of
/// these cases scatter symmetrically about that plane: (u, v) and (u, 1 - v).
void bsdf_charts(const rsv_bsdf *bsdf, rsv_vec3 wo, bool front, bsdf_chart chart[2]);

/// Direction at (u, v) of the unit square. @param jacobian solid angle per unit of (u, v); 0 off side
rsv_vec3 bsdf_chart_direction(const bsdf_chart *chart, float u, float v, double *jacobian);

/// Where `w` lies on the unit square.
void bsdf_chart_locate(const bsdf_chart *chart, rsv_vec3 w, float *u, float *v);

/// Integral over the part of the unit square given, by the midpoint rule.
typedef struct bsdf_integral {
    double response[3], density;
} bsdf_integral;

typedef struct bsdf_patch {
    float u0, u1, v0, v1;
    int steps_u, steps_v;
} bsdf_patch;

bsdf_integral bsdf_integrate(
    const rsv_bsdf *bsdf, rsv_vec3 wo, bool front, const bsdf_chart *chart, bsdf_patch patch);

/// Over both hemispheres: over one half of either, by symmetry. @param steps_v around, even
bsdf_integral bsdf_integrate_all(
    const rsv_bsdf *bsdf, rsv_vec3 wo, bool front, int steps_u, int steps_v);

#endif
