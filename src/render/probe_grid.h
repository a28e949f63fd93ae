/// A grid of probes over a scene, each with the radiance around it in spherical harmonics of order 2: light for objects
/// that are not part of the operator. Probes are lit one by one, on demand.
///
/// Radiance is fitted to irradiance readings for 32 normals: those of McLaren's cubature of degree 9 (1963), vertices
/// of an icosahedron and a dodecahedron. Irradiance is radiance with scaled harmonics (Ramamoorthi and Hanrahan 2001).
/// Those of degree 3 are absent from it, and those of degree 4 nearly, so the fit is a projection.
#ifndef RSV_PROBE_GRID_H
#define RSV_PROBE_GRID_H

#include "probe_gather.h"

#define RSV_PROBE_HARMONICS 9
/// A probe that sees backs of double-sided surfaces nearly all around. Its light decides whether it is inside
/// something.
#define RSV_PROBE_ENCLOSED 2

typedef struct rsv_probe_grid {
    const rsv_light_view *solution;
    rsv_probe_job job; ///< for the readings of its probes
    uint32_t size[3];
    rsv_vec3 origin, spacing; ///< of the first probe; between neighbours
    size_t count;
    rsv_rgb (*coefficient)[RSV_PROBE_HARMONICS]; ///< [count] W/(sr m2)
    uint8_t *valid; ///< [count] 0 = inside something; 1; RSV_PROBE_ENCLOSED
    uint8_t *lit;   ///< [count]
} rsv_probe_grid;

/// Places probes at the centres of equal cells that fill the scene's bounds, and finds those inside objects. None is
/// lit yet.
/// @param spacing metres; 0 = a sixteenth of the scene's longest side @param samples rays per normal
/// @param sources whether probes include the light that next-event estimation finds
rsv_status rsv_probe_grid_create(const rsv_light_view *solution, float spacing, uint32_t samples,
    bool sources, rsv_probe_grid *grid);
void rsv_probe_grid_destroy(rsv_probe_grid *grid);

/// Lights a valid probe that is not lit yet.
void rsv_probe_grid_light(rsv_probe_grid *grid, size_t probe);
/// Judges enclosed probes, once all are lit: those in the dark are inside something, and not valid.
void rsv_probe_grid_judge(rsv_probe_grid *grid);
/// Clears all probes, after the light has changed.
void rsv_probe_grid_darken(rsv_probe_grid *grid);

/// The probes around a point, x fastest, and their weights. Beyond the grid its border goes on.
void rsv_probe_grid_around(
    const rsv_probe_grid *grid, rsv_vec3 point, size_t probe[8], float weight[8]);

/// Irradiance at a free point, W/m2: of the probes around it that are valid and that it sees, so that nothing leaks
/// through walls. Where there is none such, light is gathered there and then. Those around it must be lit.
rsv_rgb rsv_probe_grid_irradiance(const rsv_probe_grid *grid, rsv_vec3 point, rsv_vec3 normal);

#endif
