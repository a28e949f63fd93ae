/// Where the sun is: a truncated VSOP87 (Bretagnon and Francou 1988) in the form that Meeus gives (Astronomical
/// Algorithms, 1998, chapters 22, 25 and 40), which NREL's algorithm uses too.
#include "../core/core.h"
#include "resolvent/sky.h"

#include <math.h>

#define DEGREES (M_PI / 180)
#define ASTRONOMICAL_UNIT_RADII                                                                    \
    23455.0 ///< 1 / sin of the sun's parallax at 1 au, 8.794 seconds of arc

/// amplitude cos(phase + rate t), t in millennia since J2000; amplitudes are 1e-8 rad or au.
typedef struct term {
    double amplitude, phase, rate;
} term;

static const term longitude_0[] = { { 175347046, 0, 0 }, { 3341656, 4.6692568, 6283.0758500 },
    { 34894, 4.62610, 12566.15170 }, { 3497, 2.7441, 5753.3849 }, { 3418, 2.8289, 3.5231 },
    { 3136, 3.6277, 77713.7715 }, { 2676, 4.4181, 7860.4194 }, { 2343, 6.1352, 3930.2097 },
    { 1324, 0.7425, 11506.7698 }, { 1273, 2.0371, 529.6910 }, { 1199, 1.1096, 1577.3435 },
    { 990, 5.233, 5884.927 }, { 902, 2.045, 26.298 }, { 857, 3.508, 398.149 },
    { 780, 1.179, 5223.694 }, { 753, 2.533, 5507.553 }, { 505, 4.583, 18849.228 },
    { 492, 4.205, 775.523 }, { 357, 2.920, 0.067 }, { 317, 5.849, 11790.629 },
    { 284, 1.899, 796.298 }, { 271, 0.315, 10977.079 }, { 243, 0.345, 5486.778 },
    { 206, 4.806, 2544.314 }, { 205, 1.869, 5573.143 }, { 202, 2.458, 6069.777 },
    { 156, 0.833, 213.299 }, { 132, 3.411, 2942.463 }, { 126, 1.083, 20.775 },
    { 115, 0.645, 0.980 }, { 103, 0.636, 4694.003 } };
static const term longitude_1[] = { { 628331966747, 0, 0 }, { 206059, 2.678235, 6283.075850 },
    { 4303, 2.6351, 12566.1517 }, { 425, 1.590, 3.523 }, { 119, 5.796, 26.298 },
    { 109, 2.966, 1577.344 } };
static const term longitude_2[] = { { 52919, 0, 0 }, { 8720, 1.0721, 6283.0758 },
    { 309, 0.867, 12566.152 } };
static const term latitude_0[] = { { 280, 3.199, 84334.662 }, { 102, 5.422, 5507.553 },
    { 80, 3.88, 5223.69 } };
static const term distance_0[] = { { 100013989, 0, 0 }, { 1670700, 3.0984635, 6283.0758500 },
    { 13956, 3.05525, 12566.15170 }, { 3084, 5.1985, 77713.7715 }, { 1628, 1.1739, 5753.3849 },
    { 1576, 2.8469, 7860.4194 }, { 925, 5.453, 11506.770 }, { 542, 4.564, 3930.210 },
    { 472, 3.661, 5884.927 }, { 346, 0.964, 5507.553 }, { 329, 5.900, 5223.694 },
    { 307, 0.299, 5573.143 } };
static const term distance_1[] = { { 103019, 1.107490, 6283.075850 }, { 1721, 1.0644, 12566.1517 },
    { 702, 3.142, 0 } };

#define SUM(terms, t) sum_of(terms, sizeof(terms) / sizeof *(terms), t)

static double sum_of(const term *terms, size_t count, double t)
{
    double sum = 0;
    for (size_t k = 0; k < count; k++)
        sum += terms[k].amplitude * cos(terms[k].phase + terms[k].rate * t);
    return 1e-8 * sum;
}

bool rsv_is_leap_year(int year) { return (year % 4 == 0 && year % 100 != 0) || year % 400 == 0; }

int rsv_day_of_year(int year, int month, int day)
{
    static const int before[] = { 0, 31, 59, 90, 120, 151, 181, 212, 243, 273, 304, 334 };
    return before[month - 1] + day + (month > 2 && rsv_is_leap_year(year));
}

/// Floor of the quotient, for years before the first.
static long floor_divide(long a, long b) { return a / b - (a % b < 0); }

long rsv_day_number(int year, int month, int day)
{
    long y = (long)year - 1;
    long days = 365 * y + floor_divide(y, 4) - floor_divide(y, 100) + floor_divide(y, 400);
    return days + rsv_day_of_year(year, month, day) - 730120; // days before the year 2000
}

/// Terrestrial time less universal time, seconds: polynomials of Espenak and Meeus (2006), constant before 1961.
static double clock_lag(double year)
{
    double t = year - 2000;
    if (year < 1961) return 33;
    if (year < 1986) {
        double u = year - 1975;
        return 45.45 + u * (1.067 - u * (1.0 / 260 + u / 718));
    }
    if (year < 2005)
        return 63.86 + t * (0.3345 + t * (-0.060374 + t * (0.0017275 + t * 0.000651814))) +
               0.00002373599 * pow(t, 5);
    return 62.92 + t * (0.32217 + t * 0.005589);
}

/// The sun's apparent right ascension and declination, and the correction from mean to apparent sidereal time. Radians.
typedef struct equatorial {
    double ascension, declination, distance, equation_of_equinoxes;
} equatorial;

/// @param t centuries of terrestrial time since J2000
static equatorial apparent_sun(double t)
{
    double m = t / 10;
    double heliocentric = SUM(longitude_0, m) + m * (SUM(longitude_1, m) + m * SUM(longitude_2, m));
    double distance = SUM(distance_0, m) + m * SUM(distance_1, m);
    double latitude = -SUM(latitude_0, m);
    double node = (125.04452 - 1934.136261 * t) * DEGREES;
    double sun = (280.4665 + 36000.7698 * t) * DEGREES,
           moon = (218.3165 + 481267.8813 * t) * DEGREES;
    double in_longitude =
        -17.20 * sin(node) - 1.32 * sin(2 * sun) - 0.23 * sin(2 * moon) + 0.21 * sin(2 * node);
    double in_obliquity =
        9.20 * cos(node) + 0.57 * cos(2 * sun) + 0.10 * cos(2 * moon) - 0.09 * cos(2 * node);
    double obliquity =
        (84381.448 - t * (46.8150 + t * (0.00059 - t * 0.001813)) + in_obliquity) / 3600 * DEGREES;
    double aberration = -20.4898 / distance;
    double longitude = heliocentric + M_PI + (in_longitude + aberration) / 3600 * DEGREES;
    return (equatorial){ atan2(sin(longitude) * cos(obliquity) - tan(latitude) * sin(obliquity),
                             cos(longitude)),
        asin(sin(latitude) * cos(obliquity) + cos(latitude) * sin(obliquity) * sin(longitude)),
        distance, in_longitude / 3600 * DEGREES * cos(obliquity) };
}

/// Greenwich mean sidereal time, radians. @param days of universal time since J2000
static double sidereal_time(double days)
{
    double t = days / 36525;
    return fmod(280.46061837 + 360.98564736629 * days + t * t * (0.000387933 - t / 38710000), 360) *
           DEGREES;
}

/// From the Earth's centre to a site on its ellipsoid.
static void add_parallax(const rsv_site *site, double hour_angle, equatorial *sun, double *local)
{
    double sine = 1 / (ASTRONOMICAL_UNIT_RADII * sun->distance), phi = site->latitude * DEGREES;
    double u = atan(0.99664719 * tan(phi)), height = site->elevation / 6378140;
    double x = cos(u) + height * cos(phi), y = 0.99664719 * sin(u) + height * sin(phi);
    double cosine = cos(sun->declination);
    double shift = atan2(-x * sine * sin(hour_angle), cosine - x * sine * cos(hour_angle));
    sun->declination =
        atan2((sin(sun->declination) - y * sine) * cos(shift), cosine - x * sine * cos(hour_angle));
    *local = hour_angle - shift;
}

rsv_solar_position rsv_sun_position(const rsv_site *site, const rsv_moment *moment)
{
    double days = (double)rsv_day_number(moment->year, moment->month, moment->day) - 0.5 +
                  (moment->hour - site->time_zone) / 24; // J2000 is noon
    double year = 2000 + days / 365.25;
    equatorial sun = apparent_sun((days + clock_lag(year) / 86400) / 36525);
    double hour_angle =
        sidereal_time(days) + sun.equation_of_equinoxes + site->longitude * DEGREES - sun.ascension;
    add_parallax(site, hour_angle, &sun, &hour_angle);
    double phi = site->latitude * DEGREES;
    double up = sin(phi) * sin(sun.declination) + cos(phi) * cos(sun.declination) * cos(hour_angle);
    double east = -cos(sun.declination) * sin(hour_angle);
    double north =
        cos(phi) * sin(sun.declination) - sin(phi) * cos(sun.declination) * cos(hour_angle);
    double azimuth = atan2(east, north);
    return (rsv_solar_position){ atan2(up, hypot(east, north)),
        azimuth < 0 ? azimuth + 2 * M_PI : azimuth, sun.distance,
        { (float)east, (float)up, (float)-north } };
}
