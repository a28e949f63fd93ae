#include "fresnel.h"

float rsv_fresnel_conductor(float cos_i, float eta, float k)
{
    // Born and Wolf, Principles of Optics, 14.2: the complex refracted cosine in real numbers
    double cos2 = (double)cos_i * cos_i, sin2 = 1 - cos2;
    double difference = (double)eta * eta - (double)k * k - sin2;
    double modulus = hypot(difference, 2.0 * eta * k);
    double real_part = sqrt(0.5 * fmax(modulus + difference, 0));
    double cross = 2 * real_part * cos_i;
    double perpendicular = (modulus + cos2 - cross) / (modulus + cos2 + cross);
    double parallel = perpendicular * (cos2 * modulus + sin2 * sin2 - cross * sin2) /
                      (cos2 * modulus + sin2 * sin2 + cross * sin2);
    return (float)(0.5 * (perpendicular + parallel));
}

double rsv_fresnel_dielectric_mean(double eta)
{
    double step = eta - 1;
    if (step < 1e-4) return step / 3; // leading term; Walsh's terms cancel like 1 / step
    // Walsh 1926; see also Duntley 1942. Differences of powers are factored to keep their digits.
    double n2 = eta * eta, n4 = n2 * n2;
    double minus = step * (eta + 1), plus = n2 + 1; // n^2 - 1, n^2 + 1
    double n4_minus = minus * plus;
    return 0.5 + step * (3 * eta + 1) / (6 * (eta + 1) * (eta + 1)) +
           n2 * minus * minus / (plus * plus * plus) * log(step / (eta + 1)) -
           2 * n2 * eta * (n2 + 2 * eta - 1) / (plus * n4_minus) +
           8 * n4 * (n4 + 1) / (plus * n4_minus * n4_minus) * log1p(step);
}
