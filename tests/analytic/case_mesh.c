#include "case_mesh.h"

#include "core/vec.h"

#include <stdlib.h>

/// At most 64 triangles, so that next-event estimation still weighs each by its irradiance.
#define DISK_CORNERS 64
#define SPHERE_RINGS 48
#define SPHERE_SECTORS 96

typedef struct case_mesh {
    rsv_vec3 *positions, *normals;
    uint32_t *indices;
    size_t vertex_count, triangle_count;
} case_mesh;

static bool mesh_reserve(case_mesh *mesh, size_t vertices, size_t triangles)
{
    mesh->positions = malloc(vertices * sizeof *mesh->positions);
    mesh->normals = malloc(vertices * sizeof *mesh->normals);
    mesh->indices = malloc(3 * triangles * sizeof *mesh->indices);
    return mesh->positions && mesh->normals && mesh->indices;
}

static void mesh_release(case_mesh *mesh)
{
    free(mesh->positions);
    free(mesh->normals);
    free(mesh->indices);
}

static void mesh_vertex(case_mesh *mesh, rsv_vec3 position, rsv_vec3 normal)
{
    mesh->positions[mesh->vertex_count] = position;
    mesh->normals[mesh->vertex_count++] = normal;
}

static void mesh_triangle(case_mesh *mesh, size_t a, size_t b, size_t c)
{
    uint32_t *index = &mesh->indices[3 * mesh->triangle_count++];
    index[0] = (uint32_t)a, index[1] = (uint32_t)b, index[2] = (uint32_t)c;
}

static bool quad_mesh(const case_surface *surface, case_mesh *mesh)
{
    if (!mesh_reserve(mesh, 4, 2)) return false;
    for (int i = 0; i < 4; i++)
        mesh_vertex(mesh, surface->corner[i], surface->normal);
    mesh_triangle(mesh, 0, 1, 2);
    mesh_triangle(mesh, 0, 2, 3);
    return true;
}

/// A regular polygon as a fan about the centre.
static bool disk_mesh(const case_surface *surface, case_mesh *mesh)
{
    if (!mesh_reserve(mesh, DISK_CORNERS + 1, DISK_CORNERS)) return false;
    double step = 2 * (double)RSV_PI / DISK_CORNERS,
           radius = surface->radius * sqrt(step / sin(step));
    rsv_vec3 tangent, bitangent;
    v3_frame(surface->normal, &tangent, &bitangent);
    mesh_vertex(mesh, surface->center, surface->normal);
    for (int i = 0; i < DISK_CORNERS; i++) {
        rsv_vec3 point = v3_mad(surface->center, (float)(radius * cos(i * step)), tangent);
        point = v3_mad(point, (float)(radius * sin(i * step)), bitangent);
        mesh_vertex(mesh, point, surface->normal);
        mesh_triangle(mesh, 0, 1 + (size_t)i, 1 + (size_t)(i + 1) % DISK_CORNERS);
    }
    return true;
}

static int sector_count(const case_surface *surface)
{
    return SPHERE_SECTORS * surface->refinement;
}

static int zone_rings(const case_surface *surface, const case_zone *zone)
{
    double share = (acos(zone->cos_min) - acos(zone->cos_max)) / (double)RSV_PI;
    return (int)fmax(lround(SPHERE_RINGS * surface->refinement * share), 2);
}

/// Direction of vertex (ring, sector) of a zone's grid of polar angles and azimuths.
static rsv_vec3 grid_direction(
    const case_surface *surface, const case_zone *zone, int ring, int sector)
{
    double low = acos(zone->cos_min), high = acos(zone->cos_max);
    double polar = low + (high - low) * ring / zone_rings(surface, zone);
    double azimuth = 2 * (double)RSV_PI * sector / sector_count(surface);
    return v3(
        (float)(sin(polar) * cos(azimuth)), (float)(sin(polar) * sin(azimuth)), (float)cos(polar));
}

static bool sphere_mesh(const case_surface *surface, const case_zone *zone, case_mesh *mesh)
{
    int rings = zone_rings(surface, zone), sectors = sector_count(surface);
    size_t vertices = (size_t)(rings + 1) * (size_t)sectors;
    if (!mesh_reserve(mesh, vertices, 2 * (size_t)rings * (size_t)sectors)) return false;
    for (int ring = 0; ring <= rings; ring++)
        for (int sector = 0; sector < sectors; sector++) {
            rsv_vec3 outward = grid_direction(surface, zone, ring, sector);
            mesh_vertex(mesh, v3_mad(surface->center, (float)surface->mesh_radius, outward),
                surface->inside ? v3_neg(outward) : outward);
        }
    for (int ring = 0; ring < rings; ring++)
        for (int sector = 0; sector < sectors; sector++) {
            size_t row = (size_t)ring * (size_t)sectors,
                   next = (size_t)(sector + 1) % (size_t)sectors;
            size_t a = row + (size_t)sector, b = row + next;
            size_t c = b + (size_t)sectors, d = a + (size_t)sectors;
            bool at_south = ring == 0 && zone->cos_min == -1;
            bool at_north = ring == rings - 1 && zone->cos_max == 1;
            if (!at_south) mesh_triangle(mesh, a, surface->inside ? c : b, surface->inside ? b : c);
            if (!at_north) mesh_triangle(mesh, a, surface->inside ? d : c, surface->inside ? c : d);
        }
    return true;
}

static bool make_mesh(const case_surface *surface, const case_zone *zone, case_mesh *mesh)
{
    *mesh = (case_mesh){ 0 };
    if (surface->shape == CASE_QUAD) return quad_mesh(surface, mesh);
    if (surface->shape == CASE_DISK) return disk_mesh(surface, mesh);
    return sphere_mesh(surface, zone, mesh);
}

void case_mesh_measure(case_surface *surface)
{
    if (surface->shape != CASE_SPHERE) return;
    double area = 0;
    surface->mesh_radius = surface->radius;
    for (int z = 0; z < surface->zone_count; z++) {
        case_mesh mesh = { 0 };
        if (!sphere_mesh(surface, &surface->zone[z], &mesh)) abort();
        for (size_t i = 0; i < mesh.triangle_count; i++) {
            rsv_vec3 a = mesh.positions[mesh.indices[3 * i]];
            area += 0.5 * v3_length(v3_cross(v3_sub(mesh.positions[mesh.indices[3 * i + 1]], a),
                              v3_sub(mesh.positions[mesh.indices[3 * i + 2]], a)));
        }
        mesh_release(&mesh);
    }
    surface->mesh_radius *= sqrt(4 * (double)RSV_PI * surface->radius * surface->radius / area);
}

double case_mesh_distance(const case_surface *surface, rsv_vec3 direction)
{
    const case_zone *zone = case_surface_zone(surface, v3_add(surface->center, direction));
    double low = acos(zone->cos_min), high = acos(zone->cos_max);
    double polar = acos(fmax(-1, fmin(1, direction.z))), azimuth = atan2(direction.y, direction.x);
    int rings = zone_rings(surface, zone);
    int ring = (int)fmin(fmax((polar - low) / (high - low) * rings, 0), rings - 1);
    int sector = (int)floor(azimuth / (2 * (double)RSV_PI) * sector_count(surface));
    // the four corners of a cell lie in a plane: its diagonals span it
    rsv_vec3 a = grid_direction(surface, zone, ring, sector),
             b = grid_direction(surface, zone, ring, sector + 1);
    rsv_vec3 c = grid_direction(surface, zone, ring + 1, sector + 1),
             d = grid_direction(surface, zone, ring + 1, sector);
    rsv_vec3 normal = v3_normalize(v3_cross(v3_sub(c, a), v3_sub(d, b)));
    rsv_vec3 middle = v3_scale(v3_add(v3_add(a, b), v3_add(c, d)), 0.25f);
    return surface->mesh_radius * v3_dot(normal, middle) / v3_dot(normal, direction);
}

rsv_status case_mesh_add(rsv_scene *scene, const case_surface *surface, const case_zone *zone,
    uint32_t material, uint32_t *mesh_id)
{
    case_mesh mesh;
    rsv_status status = RSV_ERROR_MEMORY;
    if (make_mesh(surface, zone, &mesh)) {
        // mirrors and coarse glass keep their facets: shading normals would bend rays into the surface
        bool smooth = surface->bsdf == CASE_DIFFUSE || surface->refinement > 1;
        rsv_mesh_desc desc = { .size = sizeof desc,
            .name = surface->name,
            .positions = mesh.positions,
            .normals = smooth ? mesh.normals : NULL,
            .vertex_count = mesh.vertex_count,
            .indices = mesh.indices,
            .triangle_count = mesh.triangle_count,
            .material = material };
        status = rsv_scene_add_mesh(scene, &desc, mesh_id);
    }
    mesh_release(&mesh);
    return status;
}
