/// Distance between elements: uniform, except where a scene is open.
///
/// Irradiance varies over distances like those to the surfaces from which light arrives. In a closed box of surface S,
/// no point of a wall is farther than sqrt(S) / 4 from the other walls. Ground farther than that from everything that
/// rises above it is *open*. The effect of a body at distance d decreases with 1/d^2 there, and the curvature, which
/// linear interpolation misses, with 1/d^4, so elements may grow with d^2. (Ward, Rubinstein and Clear 1988 space the
/// records of their irradiance cache by such distances.) Ground is also open, however close to a fence, if surfaces
/// fill little of its view: their light and its curvature are proportional to that fraction, so elements may grow with
/// one over its square root. S counts surfaces after this, otherwise the plain around a house would take all elements.
/// Lamps that reflect nothing are ignored: their light is direct, and elements do not depend on their positions.
#ifndef RSV_SPACING_H
#define RSV_SPACING_H

#include "../specular/specular_path.h"
#include "elements.h"

typedef struct rsv_spacing {
    float metres; ///< between nodes
    float reach;  ///< metres: cells farther than that from everything are twice as large at least
    const rsv_transport_scene *scene; ///< NULL = nothing is open
} rsv_spacing;

/// The spacing that puts about `target` nodes on everything that scatters diffusely, of each triangle one side counted.
rsv_spacing rsv_spacing_for(const rsv_transport_scene *scene, uint32_t target);

/// Level of the regular grid whose cells on a triangle are about `metres` long.
int rsv_spacing_level(const rsv_scene_view *scene, uint32_t triangle, float metres);

/// Whether a cell is larger than usual, and lies so far in the open that it may be.
bool rsv_spacing_lets_grow(const rsv_spacing *spacing, const rsv_elements *elements, uint32_t cell);

/// Whether a cell is larger than usual and may not be.
bool rsv_spacing_is_exceeded(
    const rsv_spacing *spacing, const rsv_elements *elements, uint32_t cell);

/// The cells that one side of a triangle is divided into.
typedef struct rsv_face_division {
    int coarsest;  ///< level
    double counts; ///< m2 that count: larger elements count for less
} rsv_face_division;

rsv_face_division rsv_spacing_divide(const rsv_spacing *spacing, uint32_t triangle, bool back);

#endif
