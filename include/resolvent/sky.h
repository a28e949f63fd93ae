/// @file sky.h
/// Daylight outdoors: position of the sun, luminance of the sky, weather files.
///
/// Directions are unit vectors from the ground to the sky, in a frame with x east, y up and -z north. Azimuths count
/// clockwise from north as seen from above. Luminances are in cd/m2, illuminances in lux.
#ifndef RESOLVENT_SKY_H
#define RESOLVENT_SKY_H

#include "resolvent/core.h"

#ifdef __cplusplus
extern "C" {
#endif

// ---- the sun --------------------------------------------------------------------------------------

#define RSV_SUN_RADIUS 0.004651 ///< angular radius of the sun's disk, radians

/// A place on Earth.
typedef struct rsv_site {
    double latitude;  ///< degrees, north positive
    double longitude; ///< degrees, east positive
    double time_zone; ///< hours ahead of UTC of the clock that times refer to
    double elevation; ///< metres above sea level
} rsv_site;

/// A date and time of the site's clock, standard time.
typedef struct rsv_moment {
    int year, month, day; ///< Gregorian calendar; month and day from 1
    double hour;          ///< 0 to 24
} rsv_moment;

typedef struct rsv_solar_position {
    double elevation; ///< radians above the horizon, of the centre of the disk, without refraction
    double azimuth;   ///< radians, clockwise from north, 0 to 2 pi
    double distance;  ///< astronomical units
    rsv_vec3 direction;
} rsv_solar_position;

/// Position of the sun as seen from a site, with parallax and without refraction. Within 0.001 degrees of NREL's Solar
/// Position Algorithm (Reda and Andreas 2008) from 1950 to 2050; for other years, variations of Earth's rotation add up
/// to 0.01 degrees a century.
RSV_API rsv_solar_position rsv_sun_position(const rsv_site *site, const rsv_moment *moment);

/// Days since 1 January 2000; negative before.
RSV_API long rsv_day_number(int year, int month, int day);
RSV_API bool rsv_is_leap_year(int year);
/// 1 to 366.
RSV_API int rsv_day_of_year(int year, int month, int day);

// ---- luminance of the sky -------------------------------------------------------------------------

#define RSV_CIE_SKY_TYPES 15
/// The traditional overcast sky (Moon and Spencer 1942), type 16 of the standard.
#define RSV_CIE_TRADITIONAL_OVERCAST 16

/// Relative luminance of a sky, at the zenith angle Z and the angle G from the sun, clamped to 0:
/// (1 + a exp(b / cos Z)) (1 + c (exp(d G) + f) + e cos^2 G).
typedef struct rsv_sky_shape {
    double a, b, c, d, e, f;
    rsv_vec3 sun;
    bool linear; ///< use (1 + 2 cos Z) / 3 instead
} rsv_sky_shape;

/// The CIE standard general sky (ISO 15469:2004, CIE S 011:2003).
/// @param type 1 overcast, graded steeply ... 12 clear ... 15 white-blue, turbid; or RSV_CIE_TRADITIONAL_OVERCAST
RSV_API rsv_sky_shape rsv_cie_sky(int type, rsv_vec3 sun);

RSV_API double rsv_sky_shape_at(const rsv_sky_shape *shape, rsv_vec3 direction);

/// Measurements of a weather station.
typedef struct rsv_irradiance_record {
    double direct_normal;      ///< W/m2
    double diffuse_horizontal; ///< W/m2
    double dew_point;          ///< degrees Celsius; NAN = unknown, 11 is used
    int day_of_year;
} rsv_irradiance_record;

/// The all-weather sky of Perez, Seals and Michalsky (1993), with luminous efficacies of Perez et al. (1990).
typedef struct rsv_perez_sky {
    rsv_sky_shape shape;
    double clearness, brightness; ///< epsilon and Delta of the model
    double diffuse_illuminance;   ///< lux on the ground, from the sky alone
    double direct_illuminance;    ///< lux from the sun, on a plane that faces it
} rsv_perez_sky;

/// @param sun its direction; moved to the horizon if it is below, and to 3 degrees from the zenith if it is closer
RSV_API rsv_perez_sky rsv_perez_sky_of(const rsv_irradiance_record *record, rsv_vec3 sun);

/// The same from measured illuminances: finds the corresponding irradiances.
/// @param diffuse, direct lux, on the ground and on a plane that faces the sun
RSV_API rsv_perez_sky rsv_perez_sky_of_illuminance(
    double diffuse, double direct, const rsv_irradiance_record *record, rsv_vec3 sun);

// ---- patches --------------------------------------------------------------------------------------

/// Patches of the sky: the 145 of Tregenza (1987), each divided into `subdivision` squared as by Reinhart. Patch 0 is
/// the ground, everything below the horizon. Then follow rows from the horizon upwards, each from north clockwise. The
/// last patch is the zenith.
typedef struct rsv_sky_patches {
    uint32_t subdivision; ///< MF, 1 to RSV_SKY_MOST_SUBDIVISIONS
    uint32_t count;       ///< 144 MF^2 + 2
} rsv_sky_patches;

#define RSV_SKY_MOST_SUBDIVISIONS 16

/// @param subdivision is clamped to 1..RSV_SKY_MOST_SUBDIVISIONS
RSV_API rsv_sky_patches rsv_sky_patches_of(uint32_t subdivision);
RSV_API uint32_t rsv_sky_patch_at(const rsv_sky_patches *patches, rsv_vec3 direction);
/// Direction of the centre of a patch; straight down for the ground.
RSV_API rsv_vec3 rsv_sky_patch_direction(const rsv_sky_patches *patches, uint32_t patch);
/// Solid angle of a patch, steradians.
RSV_API double rsv_sky_patch_solid_angle(const rsv_sky_patches *patches, uint32_t patch);

/// Luminances of all patches: those of the shape at the patches' centres, scaled so that the sky gives an illuminance
/// of `illuminance` on the ground. The ground's luminance is not changed. A shape that is not positive anywhere gives a
/// uniform sky.
/// @param luminance out, [patches->count]

RSV_API void rsv_sky_patch_luminances(const rsv_sky_patches *patches, const rsv_sky_shape *shape,
    double illuminance, float *luminance);

// ---- weather --------------------------------------------------------------------------------------

/// One interval of a weather file.
typedef struct rsv_weather_hour {
    rsv_moment moment; ///< middle of the interval
    double hours;      ///< its length
    rsv_irradiance_record record;
    /// Lux, if the file holds illuminances instead of irradiances (WEA, unit 2); otherwise NAN
    double direct_illuminance, diffuse_illuminance;
    bool filled; ///< irradiances were missing, and are those of the nearest day
} rsv_weather_hour;

/// A weather file. Intervals are in the order of the file.
typedef struct rsv_weather {
    char name[128]; ///< of the place
    rsv_site site;
    rsv_weather_hour *hour; ///< [count]
    size_t count;
    size_t filled;  ///< number of intervals with the irradiances of another day
    size_t missing; ///< hours of the year that are not in the file
    bool leap;      ///< includes 29 February
} rsv_weather;

/// Reads EnergyPlus weather (.epw) or Daysim's .wea, detected by content. Missing irradiances are computed from the
/// global irradiance if that is known, and otherwise taken from the nearest day that has some at that hour.
/// RSV_ERROR_IO; RSV_ERROR_FORMAT, with line and column.
/// @param weather out; free it with rsv_weather_free, even after an error
RSV_API rsv_status rsv_weather_read(rsv_context *context, const char *path, rsv_weather *weather);
RSV_API void rsv_weather_free(rsv_context *context, rsv_weather *weather);

/// The sky of an interval. @param sun out: position of the sun at its middle; may be NULL
RSV_API rsv_perez_sky rsv_weather_sky(
    const rsv_weather *weather, size_t hour, rsv_solar_position *sun);

#ifdef __cplusplus
}
#endif

#endif
