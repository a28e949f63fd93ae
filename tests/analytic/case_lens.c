#include "case_lens.h"

#include "core/vec.h"

#include <math.h>

#define BEAM_RAYS 200000
#define REFLECTIONS 8
/// Radius of a disk that is small enough to represent a point, and wide enough for many rays. It does not touch the
/// folds.
#define POINT_RADIUS 0.01

/// @param cosine of incidence @param ior of the far side, relative; no total reflection
static double reflectance(double cosine, double ior)
{
    double far_cosine = sqrt(1 - (1 - cosine * cosine) / (ior * ior));
    double s = (cosine - ior * far_cosine) / (cosine + ior * far_cosine);
    double p = (ior * cosine - far_cosine) / (ior * cosine + far_cosine);
    return 0.5 * (s * s + p * p);
}

/// Share of the circle of radius rho around the axis that lies in a disk.
static double share_in_disk(double rho, double r, double radius)
{
    if (fabs(rho - r) >= radius) return 0;
    double cosine = (rho * rho + r * r - radius * radius) / (2 * rho * r);
    return acos(fmax(-1, fmin(1, cosine))) / (double)RSV_PI;
}

/// Power that a thin ring of the beam brings to a disk, for unit power in the ring. Seen from the centre, a ray meets
/// the ball at the polar angle pi - incidence and, after every chord, pi - 2 refraction further round.
static double ring_to_disk(double ior, double plane, double height, double r, double radius)
{
    double incidence = asin(height), refraction = asin(height / ior);
    double reflected = reflectance(cos(incidence), ior), power = 1 - reflected, sum = 0;
    double polar = (double)RSV_PI - incidence;
    for (int k = 0; k <= REFLECTIONS; k++, power *= reflected) {
        polar -= (double)RSV_PI - 2 * refraction;
        double direction = polar - incidence, way = (plane - cos(polar)) / cos(direction);
        if (cos(direction) < 1e-9 || way < 0) continue;
        double rho = fabs(sin(polar) + way * sin(direction));
        sum += power * (1 - reflected) * share_in_disk(rho, r, radius);
    }
    return sum;
}

static double disk_mean(double ior, double plane, double r, double radius)
{
    double sum = 0;
    for (int k = 0; k < BEAM_RAYS; k++)
        sum += ring_to_disk(ior, plane, sqrt((k + 0.5) / BEAM_RAYS), r, radius);
    return sum / (radius * radius);
}

double case_lens_blur(double ior, double plane, double r, double radius)
{
    return disk_mean(ior, plane, r, radius) / disk_mean(ior, plane, r, POINT_RADIUS);
}
