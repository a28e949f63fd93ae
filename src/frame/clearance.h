/// Distances within which specular paths that leave a curved surface certainly hit nothing.
///
/// A ray that leaves a finely divided surface starts among its neighbours' boxes, all of which the ray tracer enters.
/// This is a third of the cost of specular paths through glass spheres. But the surroundings of a triangle rise above
/// its plane by at most some angle, and steeper rays miss them.
#ifndef RSV_CLEARANCE_H
#define RSV_CLEARANCE_H

#include "../core/vec.h"
#include "resolvent/trace.h"

struct rsv_specular_media;

/// No point of the scene within `reach` of a triangle's points lies in a direction from them whose cosine to the
/// triangle's normal is more than that of its side.
typedef struct rsv_clearance {
    float reach;     ///< metres
    float cosine[2]; ///< front and back
} rsv_clearance;

/// Those of the triangles from the first to the last smooth one.
typedef struct rsv_clearances {
    rsv_context *context;
    const rsv_tracer *tracer;
    rsv_clearance *of; ///< [count + 1] the last: nothing is known
    uint32_t first, count;
    bool holds; ///< nothing has been set apart to move
} rsv_clearances;

/// @param wanted false = clearances are not needed
rsv_status rsv_clearances_create(rsv_context *context, const struct rsv_specular_media *media,
    bool wanted, rsv_clearances *clearances);
void rsv_clearances_destroy(rsv_clearances *clearances);

/// Forgets all if the scene's triangles may have moved.
void rsv_clearances_refresh(rsv_clearances *clearances, const rsv_tracer *tracer);

RSV_INLINE const rsv_clearance *rsv_clearance_of(const rsv_clearances *c, uint32_t triangle)
{
    uint32_t k = triangle - c->first;
    return &c->of[k < c->count ? k : c->count];
}

/// Minimum distance of a ray's hit. @param cosine between its direction and the triangle's normal on that side
RSV_INLINE float rsv_clear_distance(const rsv_clearance *c, bool back, float cosine)
{
    return cosine > c->cosine[back] ? c->reach : 0;
}

#endif
