/// The dipole approximation of subsurface scattering (Jensen, Marschner, Levoy and Hanrahan 2001, "A
/// practical model for subsurface light transport"), for measured coefficients. Plain C, also for device code.
///
/// Lengths and coefficients share any one unit. Fresnel transmittances at entry and exit are not included.
#ifndef RSV_DIPOLE_H
#define RSV_DIPOLE_H

#include "../core/vec.h"

/// A half space of scattering medium.
typedef struct rsv_dipole {
    double albedo;   ///< alpha' = sigma_s' / sigma_t'
    double boundary; ///< A = (1 + Fdr) / (1 - Fdr), of the mismatched refractive index
    double decay;    ///< sigma_tr, effective transport coefficient
    double real;     ///< z_r, depth of the real source: one mean free path
    double image;    ///< z_v, height of its image
} rsv_dipole;

/// Diffuse Fresnel reflectance from inside, the rational fit that the paper uses.
RSV_INLINE double rsv_dipole_fresnel(double eta)
{
    return -1.440 / (eta * eta) + 0.710 / eta + 0.668 + 0.0636 * eta;
}

/// @param fresnel diffuse reflectance of the boundary from inside, below 1
RSV_INLINE rsv_dipole rsv_dipole_from_fresnel(
    double reduced_scattering, double absorption, double fresnel)
{
    rsv_dipole dipole;
    double extinction = reduced_scattering + absorption;
    dipole.albedo = reduced_scattering / extinction;
    dipole.boundary = (1 + fresnel) / (1 - fresnel);
    dipole.decay = sqrt(3 * absorption * extinction);
    dipole.real = 1 / extinction;
    dipole.image = dipole.real * (1 + 4 * dipole.boundary / 3);
    return dipole;
}
RSV_INLINE rsv_dipole rsv_dipole_create(double reduced_scattering, double absorption, double eta)
{
    return rsv_dipole_from_fresnel(reduced_scattering, absorption, rsv_dipole_fresnel(eta));
}

RSV_INLINE double rsv_dipole_source(double depth, double decay, double r)
{
    double distance = sqrt(r * r + depth * depth);
    return depth * (1 + decay * distance) * exp(-decay * distance) /
           (distance * distance * distance);
}

/// Rd(r): exitance per entered flux, 1 / length^2.
RSV_INLINE double rsv_dipole_profile(const rsv_dipole *dipole, double r)
{
    return dipole->albedo / (4 * 3.14159265358979323846) *
           (rsv_dipole_source(dipole->real, dipole->decay, r) +
               rsv_dipole_source(dipole->image, dipole->decay, r));
}

/// Exitance over irradiance of a uniformly lit half space: the integral of Rd over the plane.
RSV_INLINE double rsv_dipole_reflectance(const rsv_dipole *dipole)
{
    return 0.5 * dipole->albedo *
           (exp(-dipole->decay * dipole->real) + exp(-dipole->decay * dipole->image));
}

/// The alpha' at which a half space has the total reflectance `reflectance`: the medium for a given albedo.
/// @param reflectance in [0, 1]
RSV_INLINE double rsv_dipole_albedo(double reflectance, double eta)
{
    double low = 0, high = 1;
    for (int step = 0; step < 60; step++) {
        double middle = 0.5 * (low + high);
        rsv_dipole dipole = rsv_dipole_create(middle, 1 - middle, eta);
        if (rsv_dipole_reflectance(&dipole) < reflectance)
            low = middle;
        else
            high = middle;
    }
    return 0.5 * (low + high);
}

#endif
