/// @file luminaire.h
/// Measured luminaires: which luminous intensity they send where, from files of IES LM-63 (1986 to 2019) and EULUMDAT.
#ifndef RESOLVENT_LUMINAIRE_H
#define RESOLVENT_LUMINAIRE_H

#include "resolvent/core.h"

#ifdef __cplusplus
extern "C" {
#endif

/// How angles of a file are meant.
typedef enum rsv_photometry_type {
    RSV_PHOTOMETRY_C, ///< vertical: from straight down, 0 to 180 degrees; horizontal: about the vertical axis
    RSV_PHOTOMETRY_B, ///< floodlights: horizontal angles are latitudes, vertical ones turn about the horizontal axis
    RSV_PHOTOMETRY_A ///< headlights: vertical angles are latitudes, horizontal ones turn about the vertical axis
} rsv_photometry_type;

typedef struct rsv_luminaire {
    char name[128];
    rsv_photometry_type type;
    uint32_t vertical_count, horizontal_count;
    float *vertical;   ///< [vertical_count] degrees, ascending
    float *horizontal; ///< [horizontal_count] degrees, ascending; symmetric parts are left out
    float *
        intensity; ///< [horizontal_count][vertical_count] cd; ballast, lamps and multipliers are in it
    double width, length, height; ///< of the opening, m; negative = round, as in the file
    double lamp_lumens;           ///< of all lamps together; 0 = absolute photometry
    double watts;
} rsv_luminaire;

/// Reads either format, told by its content. RSV_ERROR_IO, RSV_ERROR_FORMAT with what is wrong and where.
/// @param luminaire to be freed by rsv_luminaire_free, even after a failure
RSV_API rsv_status rsv_luminaire_read(
    rsv_context *context, const char *path, rsv_luminaire *luminaire);
RSV_API void rsv_luminaire_free(rsv_context *context, rsv_luminaire *luminaire);

/// cd in a direction (unit) of the luminaire's own frame: y up, x where C = 0 points, z where C = 90 does; of types A and B, z is
/// the direction at which both angles are 0. Linear in both angles between what the file states; 0 beyond.
RSV_API double rsv_luminaire_intensity(const rsv_luminaire *luminaire, rsv_vec3 direction);

/// lm: the integral of that over the sphere.
RSV_API double rsv_luminaire_flux(const rsv_luminaire *luminaire);
/// cd
RSV_API double rsv_luminaire_peak(const rsv_luminaire *luminaire);

#ifdef __cplusplus
}
#endif

#endif
