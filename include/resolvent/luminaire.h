/// @file luminaire.h
/// Measured luminaires: their luminous intensity by direction, from IES LM-63 (1986 to 2019) and EULUMDAT files.
#ifndef RESOLVENT_LUMINAIRE_H
#define RESOLVENT_LUMINAIRE_H

#include "resolvent/core.h"

#ifdef __cplusplus
extern "C" {
#endif

#define RSV_LUMEN_PER_WATT                                                                         \
    683 ///< luminous efficacy that turns lm, cd and lux into W, W/sr and W/m2

/// Meaning of a file's angles.
typedef enum rsv_photometry_type {
    RSV_PHOTOMETRY_C, ///< vertical: from straight down, 0 to 180 degrees; horizontal: about the vertical axis
    RSV_PHOTOMETRY_B, ///< floodlights: horizontal angles are latitudes, vertical ones are about the horizontal axis
    RSV_PHOTOMETRY_A ///< headlights: vertical angles are latitudes, horizontal ones are about the vertical axis
} rsv_photometry_type;

typedef struct rsv_luminaire {
    char name[128];
    rsv_photometry_type type;
    uint32_t vertical_count, horizontal_count;
    float *vertical;   ///< [vertical_count] degrees, ascending
    float *horizontal; ///< [horizontal_count] degrees, ascending; symmetric parts are omitted
    float *
        intensity; ///< [horizontal_count][vertical_count] cd, with ballast, lamps and multipliers applied
    /// Size of the opening, m, as in LM-63: length along C = 0; negative = round
    double width, length, height;
    double lamp_lumens; ///< of all lamps together; 0 = absolute photometry
    double watts;
} rsv_luminaire;

/// Reads a file of either format, detected by content. RSV_ERROR_IO; RSV_ERROR_FORMAT, with what is wrong and where.
/// @param luminaire out; free it with rsv_luminaire_free, even after an error
RSV_API rsv_status rsv_luminaire_read(
    rsv_context *context, const char *path, rsv_luminaire *luminaire);
RSV_API void rsv_luminaire_free(rsv_context *context, rsv_luminaire *luminaire);

/// Reads the contents of a file. @param name for messages @param text [bytes]
RSV_API rsv_status rsv_luminaire_parse(rsv_context *context, const char *name, const char *text,
    size_t bytes, rsv_luminaire *luminaire);

/// @param to out; free it with rsv_luminaire_free, even after an error
RSV_API rsv_status rsv_luminaire_copy(
    rsv_context *context, const rsv_luminaire *from, rsv_luminaire *to);
/// RSV_ERROR_FORMAT for invalid data: angles that do not ascend, intensities that are negative or not finite.
RSV_API rsv_status rsv_luminaire_check(const rsv_luminaire *luminaire);
/// Prints an LM-63-2002 file with absolute photometry. @param text out; free it with the context's allocator
RSV_API rsv_status rsv_luminaire_print(
    rsv_context *context, const rsv_luminaire *luminaire, char **text);

/// Luminous intensity in a direction, cd. The direction is a unit vector in the luminaire's frame, that of glTF's
/// EXT_lights_ies: -z is its axis (down, for a hanging luminaire), x the direction of C = 0, and y that of C = 90,
/// which is counter-clockwise from above. For types A and B, -z is the direction in which both angles are 0, y is up,
/// and horizontal angles increase towards x. Linear in both angles between the values of the file, and 0 beyond them.
RSV_API double rsv_luminaire_intensity(const rsv_luminaire *luminaire, rsv_vec3 direction);

/// Luminous flux, lm: the integral of the intensity over the sphere.
RSV_API double rsv_luminaire_flux(const rsv_luminaire *luminaire);
/// Highest intensity, cd.
RSV_API double rsv_luminaire_peak(const rsv_luminaire *luminaire);
/// Largest angle from its axis at which it emits light, degrees; 180 for types A and B.
RSV_API double rsv_luminaire_cutoff(const rsv_luminaire *luminaire);
/// Size of the luminous opening along x, y and z of the luminaire's frame, m. All 0 = a point. Negative x and y = an
/// ellipse with these diameters, otherwise a rectangle or box.
RSV_API rsv_vec3 rsv_luminaire_opening(const rsv_luminaire *luminaire);

#ifdef __cplusplus
}
#endif

#endif
