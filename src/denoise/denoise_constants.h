/// Constants of the filter.
#ifndef RSV_DENOISE_CONSTANTS_H
#define RSV_DENOISE_CONSTANTS_H

/// Pixels on either side that a mean takes in.
#define RADIUS 5
/// Pixels on either side that the light of two places is compared over.
#define PATCH 2
/// Pixels on either side over which variances are averaged.
#define VARIANCE_RADIUS 2
/// Squared differences of light that exceed their variance by so much of it count as 1.
#define LIGHT_TOLERANCE 0.4f
/// Squared difference of normals, and deviation from the plane of a pixel relative to its distance, that count as 1.
#define NORMAL_TOLERANCE 0.01f
#define PLACE_TOLERANCE 0.01f
/// Least albedo that light is divided by.
#define LEAST_ALBEDO 1e-3f
/// Variance that counts as none, relative to the square of the mean.
#define NO_VARIANCE 1e-7f

#endif
