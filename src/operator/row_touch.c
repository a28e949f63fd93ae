#include "row_touch.h"

#include <string.h>

#define LANES RSV_SUPPORT_POINTS
#define ANYTHING 4.0f ///< radians: more than two directions can differ by

// ---- where a row is -------------------------------------------------------------------------------

/// Square of the distance between two axes of frames, lane by lane from the first.
static float distance_of(const float *x, const float *y, const float *z, int k)
{
    float dx = x[k] - x[0], dy = y[k] - y[0], dz = z[k] - z[0];
    return dx * dx + dy * dy + dz * dz;
}

rsv_row_place rsv_row_place_of(const rsv_receiver_points *p)
{
    rsv_vec3 low = v3(INFINITY, INFINITY, INFINITY), high = v3_neg(low);
    float apart = 0;
    for (int k = 0; k < LANES; k++) {
        rsv_vec3 at = v3(p->origin_x[k], p->origin_y[k], p->origin_z[k]);
        low = v3_min(low, at);
        high = v3_max(high, at);
        apart = f_max(apart, distance_of(p->tangent_x, p->tangent_y, p->tangent_z, k) +
                                 distance_of(p->bitangent_x, p->bitangent_y, p->bitangent_z, k) +
                                 distance_of(p->normal_x, p->normal_y, p->normal_z, k));
    }
    float chord = sqrtf(apart);
    return (rsv_row_place){ .centre = v3_scale(v3_add(low, high), 0.5f),
        .radius = 0.5f * v3_length(v3_sub(high, low)),
        .tangent = v3(p->tangent_x[0], p->tangent_y[0], p->tangent_z[0]),
        .normal = v3(p->normal_x[0], p->normal_y[0], p->normal_z[0]),
        .spread = p->lifted || chord > 1 ? ANYTHING : 2 * asinf(0.5f * chord) + 1e-3f };
}

// ---- cones ----------------------------------------------------------------------------------------

static void fill_cone(const rsv_row_cones *c, size_t cone, const rsv_directions *d)
{
    rsv_vec3 sum = v3(0, 0, 0);
    size_t first = cone * LANES;
    float least = 1;
    for (size_t k = first; k < first + LANES; k++)
        sum = v3_add(sum, v3(d->x[k], d->y[k], d->z[k]));
    rsv_vec3 axis = v3_normalize(sum);
    for (size_t k = first; k < first + LANES; k++)
        least = f_min(least, v3_dot(axis, v3(d->x[k], d->y[k], d->z[k])));
    c->x[cone] = axis.x, c->y[cone] = axis.y, c->z[cone] = axis.z;
    c->angle[cone] = acosf(f_max(least, -1)) + 1e-3f;
}

rsv_status rsv_row_cones_create(rsv_context *context, const rsv_directions *d, rsv_row_cones *c)
{
    size_t count = (size_t)RSV_DIRECTION_SETS * (d->count / LANES);
    *c = (rsv_row_cones){ .context = context, .packets = d->count / LANES };
    c->x = rsv_alloc(context, count, sizeof *c->x);
    c->y = rsv_alloc(context, count, sizeof *c->y);
    c->z = rsv_alloc(context, count, sizeof *c->z);
    c->angle = rsv_alloc(context, count, sizeof *c->angle);
    if (!c->x || !c->y || !c->z || !c->angle) {
        rsv_row_cones_destroy(c);
        return RSV_ERROR_MEMORY;
    }
    for (size_t cone = 0; cone < count; cone++)
        fill_cone(c, cone, d);
    return RSV_OK;
}

void rsv_row_cones_destroy(rsv_row_cones *c)
{
    if (!c->context) return;
    rsv_free(c->context, c->x);
    rsv_free(c->context, c->y);
    rsv_free(c->context, c->z);
    rsv_free(c->context, c->angle);
    *c = (rsv_row_cones){ .context = NULL };
}

/// Marks the packets whose cones come within an angle of a direction. @param towards unit, in the frame of the row
static bool mark_around(
    const rsv_row_cones *c, size_t set, rsv_vec3 towards, float angle, uint64_t *packet)
{
    bool any = false;
    for (uint32_t k = 0; k < c->packets; k++) {
        float cos =
            c->x[set + k] * towards.x + c->y[set + k] * towards.y + c->z[set + k] * towards.z;
        // cos falls by the angle: cos(x) >= 1 - x^2 / 2
        float wide = angle + c->angle[set + k];
        bool meets = cos >= 1 - 0.5f * wide * wide;
        packet[k / 64] |= (uint64_t)meets << (k % 64);
        any = any || meets;
    }
    return any;
}

static bool mark_all(const rsv_row_cones *c, uint64_t *packet)
{
    for (uint32_t k = 0; k < c->packets; k++)
        packet[k / 64] |= (uint64_t)1 << (k % 64);
    return true;
}

bool rsv_row_cones_meet(const rsv_row_cones *c, size_t set, const rsv_row_place *place,
    const rsv_scene_change *change, uint64_t *packet)
{
    bool any = false;
    memset(packet, 0, (c->packets + 63) / 64 * sizeof *packet);
    for (uint32_t box = 0; box < change->count; box++) {
        rsv_vec3 low = change->low[box], high = change->high[box];
        rsv_vec3 to = v3_sub(v3_scale(v3_add(low, high), 0.5f), place->centre);
        float radius = 0.5f * v3_length(v3_sub(high, low)) + place->radius;
        float distance = v3_length(to);
        if (distance <= radius * 1.01f || place->spread >= ANYTHING) return mark_all(c, packet);
        rsv_vec3 local = v3(v3_dot(to, place->tangent),
            v3_dot(to, v3_cross(place->normal, place->tangent)), v3_dot(to, place->normal));
        float angle = asinf(radius / distance) + place->spread;
        any |= mark_around(c, set, v3_scale(local, 1 / distance), angle, packet);
    }
    return any;
}
