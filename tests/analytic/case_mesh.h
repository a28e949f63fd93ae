/// Triangles for the surfaces of a case. Disks and spheres are scaled so that the area of the mesh
/// is that of the true surface.
#ifndef CASE_MESH_H
#define CASE_MESH_H

#include "case_scene.h"

/// Sets mesh_radius, the radius of the vertices of a sphere's mesh.
void case_mesh_measure(case_surface *surface);

/// Distance from the centre of a sphere to its mesh in a unit direction.
double case_mesh_distance(const case_surface *surface, rsv_vec3 direction);

/// Adds the part of a surface that lies in `zone`.
rsv_status case_mesh_add(rsv_scene *scene, const case_surface *surface, const case_zone *zone,
    uint32_t material, uint32_t *mesh);

#endif
