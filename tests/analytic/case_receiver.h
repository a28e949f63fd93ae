/// Receivers of light from points of light by way of mirrors and glass. Mode lookup reads the light where it is stored,
/// so there the virtual receivers of a case get a black plate to lie on.
#ifndef CASE_RECEIVER_H
#define CASE_RECEIVER_H

#include "case_scene.h"

enum { CASE_RECEIVER_POINTS = 256 };

/// Whether the scene has both points of light and something specular.
bool case_receiver_needed(const case_scene *scene);

/// Of the plate.
double case_receiver_area(const case_scene *scene);

/// Makes the plate large enough for a receiver of that radius. All receivers of a case lie in one plane,
/// z = const, in front of mirrors that stand on it.
void case_receiver_cover(case_scene *scene, rsv_vec3 point, rsv_vec3 normal, double radius);

/// Points spread evenly over a horizontal disk, or over the part of it that lies on the plate if there is one; returns
/// their number.
size_t case_receiver_disk(const case_scene *scene, rsv_probe center, double radius,
    rsv_probe points[CASE_RECEIVER_POINTS]);

#endif
