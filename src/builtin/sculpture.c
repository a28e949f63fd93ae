#include "sculpture.h"

// ---- knot -----------------------------------------------------------------------------------------

#define BALLS 160

/// Multiplies z = (cos, sin) by a fixed turn.
static void turn(float z[2], const float by[2])
{
    float real = z[0] * by[0] - z[1] * by[1];
    z[1] = z[0] * by[1] + z[1] * by[0];
    z[0] = real;
}

/// Sum of compact balls along a (2, 3) torus knot; where the sum reaches 1.4 lies the surface.
static float knot(rsv_vec3 p)
{
    // cosine and sine of one ball's step, of twice the way and of three times the way
    static const float step[2] = { 0.99922904f, 0.039259816f };
    float twice_step[2] = { step[0], step[1] }, thrice_step[2] = { step[0], step[1] };
    turn(twice_step, step);
    turn(thrice_step, twice_step);
    float twice[2] = { 1, 0 }, thrice[2] = { 1, 0 }, sum = 0;
    for (int i = 0; i < BALLS; i++) {
        float ring = 1 + 0.42f * thrice[0];
        rsv_vec3 d = v3(p.x - ring * twice[1], p.y - ring * twice[0], p.z - 0.48f * thrice[1]);
        float reach = 0.44f + 0.065f * thrice[0] - 0.101f * thrice[1];
        float share = 1 - v3_dot(d, d) / (reach * reach);
        if (share > 0) sum += share * share * share;
        turn(twice, twice_step);
        turn(thrice, thrice_step);
    }
    return 1.4f - sum;
}

rsv_sculpture rsv_sculpture_knot(void)
{
    return (rsv_sculpture){ knot, { -1.9f, -1.9f, -1.0f }, { 1.9f, 1.9f, 1.0f } };
}

// ---- bust -----------------------------------------------------------------------------------------

/// Union of two distances, rounded over a width of about `k` (a polynomial minimum).
static float join(float a, float b, float k)
{
    float h = f_max(k - fabsf(a - b), 0) / k;
    return f_min(a, b) - 0.25f * h * h * k;
}

static float carve(float body, float tool, float k) { return -join(-body, tool, k); }

/// Distance to an ellipsoid, exact in first order near it.
static float ellipsoid(rsv_vec3 p, rsv_vec3 centre, rsv_vec3 radius)
{
    rsv_vec3 d = v3_sub(p, centre);
    rsv_vec3 q = v3(d.x / radius.x, d.y / radius.y, d.z / radius.z);
    float steepness = v3_length(v3(q.x / radius.x, q.y / radius.y, q.z / radius.z));
    float length = v3_length(q);
    return steepness > 0 ? length * (length - 1) / steepness : -radius.x;
}

static float ball(rsv_vec3 p, rsv_vec3 centre, float radius)
{
    return v3_length(v3_sub(p, centre)) - radius;
}

static float rod(rsv_vec3 p, rsv_vec3 a, rsv_vec3 b, float radius)
{
    rsv_vec3 axis = v3_sub(b, a);
    float t = v3_dot(v3_sub(p, a), axis) / v3_dot(axis, axis);
    return ball(p, v3_mad(a, f_min(f_max(t, 0), 1), axis), radius);
}

/// @param p mirrored to x >= 0
static float face(rsv_vec3 p)
{
    float d = ellipsoid(p, v3(0, 0.25f, -0.06f), v3(0.37f, 0.44f, 0.46f));
    d = join(d, ellipsoid(p, v3(0, -0.06f, 0.1f), v3(0.28f, 0.43f, 0.32f)), 0.12f);
    d = join(d, ball(p, v3(0, -0.37f, 0.29f), 0.09f), 0.14f);
    d = join(d, rod(p, v3(0, 0.2f, 0.385f), v3(0.17f, 0.2f, 0.33f), 0.05f), 0.09f);
    d = carve(d, ball(p, v3(0.15f, 0.1f, 0.47f), 0.1f), 0.1f);
    d = join(d, ball(p, v3(0.14f, 0.095f, 0.315f), 0.068f), 0.02f);
    d = join(d, rod(p, v3(0, 0.16f, 0.405f), v3(0, -0.05f, 0.5f), 0.035f), 0.07f);
    d = join(d, ball(p, v3(0.045f, -0.065f, 0.445f), 0.035f), 0.05f);
    d = join(d, rod(p, v3(0, -0.195f, 0.415f), v3(0.075f, -0.205f, 0.375f), 0.022f), 0.03f);
    d = join(d, rod(p, v3(0, -0.245f, 0.405f), v3(0.06f, -0.24f, 0.375f), 0.026f), 0.03f);
    return join(d, ellipsoid(p, v3(0.375f, 0.05f, -0.03f), v3(0.045f, 0.13f, 0.085f)), 0.05f);
}

static float bust(rsv_vec3 p)
{
    p.x = fabsf(p.x);
    float d = face(p);
    d = join(d, rod(p, v3(0, -0.25f, -0.06f), v3(0, -0.8f, -0.1f), 0.18f), 0.12f);
    float shoulders = ellipsoid(p, v3(0, -1.05f, -0.1f), v3(0.82f, 0.32f, 0.36f));
    d = join(d, shoulders, 0.25f);
    return carve(d, p.y + 1.15f, 0.06f);
}

rsv_sculpture rsv_sculpture_bust(void)
{
    return (rsv_sculpture){ bust, { -0.95f, -1.25f, -0.65f }, { 0.95f, 0.8f, 0.65f } };
}
