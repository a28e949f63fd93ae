/// How a glass ball focuses a parallel beam, computed from Snell's and Fresnel's formulas only.
#ifndef CASE_LENS_H
#define CASE_LENS_H

/// Mean irradiance over a disk divided by that at its centre, on a plane perpendicular to the axis of a beam that a
/// ball of radius 1 focuses. Light reflected inside the ball forms caustic folds, near which averaging over a disk
/// matters.
/// @param ior of the ball @param plane distance of the plane from the ball's centre @param r of the disk's centre from
/// the axis @param radius of the disk
double case_lens_blur(double ior, double plane, double r, double radius);

#endif
