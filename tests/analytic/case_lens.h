/// What a glass ball makes of a parallel beam, from Snell's and Fresnel's formulas alone.
#ifndef CASE_LENS_H
#define CASE_LENS_H

/// Mean irradiance over a disk divided by that at its centre, on a plane across the axis of a beam that a ball of
/// radius 1 focuses. Light that was reflected inside has folds, next to which averaging over a disk is no small thing.
/// @param ior of the ball @param plane distance of the plane from the ball's centre @param r of the disk's centre from
/// the axis @param radius of the disk
double case_lens_blur(double ior, double plane, double r, double radius);

#endif
