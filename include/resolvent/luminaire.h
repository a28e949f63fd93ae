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
    double width, length,
        height;         ///< of the opening, m, as in LM-63: length along C = 0; negative = round
    double lamp_lumens; ///< of all lamps together; 0 = absolute photometry
    double watts;
} rsv_luminaire;

/// Reads either format, told by its content. RSV_ERROR_IO, RSV_ERROR_FORMAT with what is wrong and where.
/// @param luminaire to be freed by rsv_luminaire_free, even after a failure
RSV_API rsv_status rsv_luminaire_read(
    rsv_context *context, const char *path, rsv_luminaire *luminaire);
RSV_API void rsv_luminaire_free(rsv_context *context, rsv_luminaire *luminaire);

/// The same of a file's content. @param name of it, for messages @param text [bytes]
RSV_API rsv_status rsv_luminaire_parse(rsv_context *context, const char *name, const char *text,
    size_t bytes, rsv_luminaire *luminaire);

/// @param to to be freed by rsv_luminaire_free, even after a failure
RSV_API rsv_status rsv_luminaire_copy(
    rsv_context *context, const rsv_luminaire *from, rsv_luminaire *to);
/// RSV_ERROR_FORMAT for what no file could hold: angles that do not ascend, intensities that are negative or not finite.
RSV_API rsv_status rsv_luminaire_check(const rsv_luminaire *luminaire);
/// As a file of LM-63-2002 in absolute photometry. @param text out: to be freed by the context's allocator
RSV_API rsv_status rsv_luminaire_print(
    rsv_context *context, const rsv_luminaire *luminaire, char **text);

/// cd in a direction (unit) of the luminaire's own frame, that of glTF's EXT_lights_ies: it points along -z (down, if it hangs),
/// x is where C = 0 points and y where C = 90 does: counter-clockwise, seen from above. Of types A and B, -z is the direction at
/// which both angles are 0, y is up, and horizontal angles count towards x. Linear in both angles between what the file states;
/// 0 beyond.
RSV_API double rsv_luminaire_intensity(const rsv_luminaire *luminaire, rsv_vec3 direction);

/// lm: the integral of that over the sphere.
RSV_API double rsv_luminaire_flux(const rsv_luminaire *luminaire);
/// cd
RSV_API double rsv_luminaire_peak(const rsv_luminaire *luminaire);
/// Degrees off its axis beyond which it sends no light; 180 of types A and B.
RSV_API double rsv_luminaire_cutoff(const rsv_luminaire *luminaire);
/// Extent of the luminous opening along x, y and z of that frame, m; all 0 = a point. x and y negative = an ellipse of these
/// diameters, else a rectangle or box.
RSV_API rsv_vec3 rsv_luminaire_opening(const rsv_luminaire *luminaire);

#ifdef __cplusplus
}
#endif

#endif
