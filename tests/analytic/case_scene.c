#include "case_scene.h"

#include "case_mesh.h"

#include "core/sampling.h"

#include <string.h>

rsv_vec3 case_vector(const cJSON *json)
{
    float value[3] = { 0 };
    for (int i = 0; i < 3 && cJSON_IsArray(json); i++)
        value[i] = (float)cJSON_GetNumberValue(cJSON_GetArrayItem(json, i));
    return v3(value[0], value[1], value[2]);
}

/// Absent and null count as `otherwise`.
static double number(const cJSON *object, const char *name, double otherwise)
{
    const cJSON *item = cJSON_GetObjectItem(object, name);
    return cJSON_IsNumber(item) ? item->valuedouble : otherwise;
}

static bool names(const cJSON *object, const char *member, const char *value)
{
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItem(object, member));
    return text && strcmp(text, value) == 0;
}

static void read_zones(const cJSON *json, case_surface *surface)
{
    const cJSON *zones = cJSON_GetObjectItem(json, "zones"), *zone;
    surface->zone_count = 1;
    surface->zone[0] = (case_zone){ -1, 1, number(json, "rho", 0), number(json, "exitance", 0) };
    int count = 0;
    cJSON_ArrayForEach(zone, zones)
    {
        surface->zone[count++] = (case_zone){ number(zone, "cos_min", -1),
            number(zone, "cos_max", 1), number(zone, "rho", 0), number(zone, "M", 0) };
        surface->zone_count = count;
    }
}

static const char *read_shape(const cJSON *json, case_surface *surface)
{
    surface->center = case_vector(cJSON_GetObjectItem(json, "center"));
    surface->radius = number(json, "radius", 0);
    if (names(json, "type", "disk")) {
        surface->shape = CASE_DISK;
        surface->normal = v3_normalize(case_vector(cJSON_GetObjectItem(json, "normal")));
    } else if (names(json, "type", "sphere")) {
        surface->shape = CASE_SPHERE;
        surface->inside = names(json, "active_side", "inside");
    } else {
        const cJSON *vertices = cJSON_GetObjectItem(json, "vertices");
        if (cJSON_GetArraySize(vertices) != 4) return "a polygon without four vertices";
        surface->shape = CASE_QUAD;
        for (int i = 0; i < 4; i++)
            surface->corner[i] = case_vector(cJSON_GetArrayItem(vertices, i));
        rsv_vec3 edge1 = v3_sub(surface->corner[1], surface->corner[0]);
        rsv_vec3 edge2 = v3_sub(surface->corner[3], surface->corner[0]);
        surface->normal = v3_normalize(v3_cross(edge1, edge2));
    }
    return NULL;
}

static const char *read_surface(const cJSON *json, case_surface *surface)
{
    surface->name = cJSON_GetStringValue(cJSON_GetObjectItem(json, "name"));
    surface->two_sided = cJSON_IsTrue(cJSON_GetObjectItem(json, "two_sided"));
    surface->ior = number(json, "ior", 1.5);
    read_zones(json, surface);
    if (names(json, "bsdf", "mirror")) surface->bsdf = CASE_MIRROR;
    if (names(json, "bsdf", "dielectric")) surface->bsdf = CASE_DIELECTRIC;
    return read_shape(json, surface);
}

static void read_light(const cJSON *json, rsv_punctual_light *light)
{
    double angle = number(json, "cone_half_angle_deg", 0) * (double)RSV_PI / 180;
    *light = (rsv_punctual_light){ .kind = RSV_PUNCTUAL_POINT,
        .position = case_vector(cJSON_GetObjectItem(json, "position")),
        .direction = v3_normalize(case_vector(cJSON_GetObjectItem(json, "direction"))),
        .intensity = rgb_gray((float)number(json, "intensity", 0)),
        .inner_cone_angle = (float)angle,
        .outer_cone_angle = (float)angle,
        .exponent = (float)number(json, "exponent", 0) };
    if (names(json, "type", "spot")) light->kind = RSV_PUNCTUAL_SPOT;
    if (names(json, "type", "directional")) {
        light->kind = RSV_PUNCTUAL_DIRECTIONAL;
        light->intensity = rgb_gray((float)number(json, "irradiance", 0));
    }
}

/// For a glass sphere, which has smooth normals: its facets must be small compared with its curvature.
#define LENS_REFINEMENT 4

const char *case_scene_read(const cJSON *json, case_scene *scene)
{
    *scene = (case_scene){ 0 };
    if (!cJSON_IsObject(json)) return "no scene";
    const cJSON *environment = cJSON_GetObjectItem(json, "environment_alternative");
    scene->sky_is_alternative = environment != NULL;
    if (!environment) environment = cJSON_GetObjectItem(json, "environment");
    if (environment && !case_sky_read(environment, &scene->sky)) return "an unknown environment";
    const cJSON *surfaces = cJSON_GetObjectItem(json, "surfaces");
    const cJSON *lights = cJSON_GetObjectItem(json, "lights"), *item;
    if (cJSON_GetArraySize(surfaces) > CASE_MAX_SURFACES) return "too many surfaces";
    if (cJSON_GetArraySize(lights) > CASE_MAX_LIGHTS) return "too many lights";
    cJSON_ArrayForEach(item, surfaces)
    {
        const char *problem = read_surface(item, &scene->surface[scene->surface_count++]);
        if (problem) return problem;
    }
    cJSON_ArrayForEach(item, lights) read_light(item, &scene->light[scene->light_count++]);
    for (int i = 0; i < scene->surface_count; i++) {
        bool lens = scene->light_count && scene->surface[i].bsdf == CASE_DIELECTRIC;
        scene->surface[i].refinement = lens ? LENS_REFINEMENT : 1;
        case_mesh_measure(&scene->surface[i]);
    }
    return NULL;
}

static rsv_material surface_material(const case_surface *surface, const case_zone *zone)
{
    rsv_material material = rsv_default_material();
    material.name = surface->name;
    material.base_color = rgb_gray((float)zone->rho);
    material.specular = 0;
    material.roughness = 1;
    material.double_sided = surface->two_sided;
    material.emission = rgb_gray((float)(zone->exitance / (double)RSV_PI));
    if (surface->bsdf == CASE_MIRROR) {
        // no metal reflects equally at all angles, but a perfect mirror may have holes: nothing is behind these
        material.base_color = rgb_gray(1);
        material.opacity = (float)zone->rho;
        material.metallic = 1;
        material.roughness = 0;
    } else if (surface->bsdf == CASE_DIELECTRIC) {
        material.base_color = rgb_gray(1);
        material.specular = 1;
        material.roughness = 0;
        material.ior = (float)surface->ior;
        material.transmission = 1;
        material.thickness = 1;
    }
    return material;
}

static rsv_status add_zone(rsv_scene *scene, const case_surface *surface, case_zone zone)
{
    rsv_status status;
    rsv_material material = surface_material(surface, &zone);
    uint32_t material_id, mesh_id;
    status = rsv_scene_add_material(scene, &material, &material_id);
    if (status == RSV_OK) status = case_mesh_add(scene, surface, &zone, material_id, &mesh_id);
    if (status == RSV_OK) status = rsv_scene_add_instance(scene, mesh_id, NULL, surface->name);
    return status;
}

/// Mirrors and interfaces without an end, as far as points of light are seen in them: rays leave polygons that are
/// kilometres wide millimetres off.
#define SPECULAR_EXTENT 5

static case_surface cropped(const case_scene *scene, const case_surface *surface)
{
    case_surface result = *surface;
    rsv_vec3 extent = v3(SPECULAR_EXTENT, SPECULAR_EXTENT, SPECULAR_EXTENT);
    for (int i = 0; i < 4 && scene->light_count && surface->bsdf != CASE_DIFFUSE; i++)
        result.corner[i] = v3_min(v3_max(surface->corner[i], v3_neg(extent)), extent);
    return result;
}

/// Some cases consist only of lights, but a scene needs a triangle: a black speck far from everything.
static rsv_status add_speck(rsv_scene *scene)
{
    case_surface speck = { .name = "speck",
        .corner = {
            v3(0, 0, -100), v3(0.01f, 0, -100), v3(0.01f, 0.01f, -100), v3(0, 0.01f, -100) } };
    return add_zone(scene, &speck, (case_zone){ -1, 1, 0, 0 });
}

static rsv_status add_everything(
    rsv_scene *scene, const case_scene *description, case_variant variant)
{
    rsv_status status = description->surface_count ? RSV_OK : add_speck(scene);
    for (int i = 0; i < description->surface_count; i++) {
        case_surface surface = description->surface[i];
        if (!variant.sky) surface = cropped(description, &surface);
        for (int k = 0; k < surface.zone_count && status == RSV_OK; k++) {
            case_zone zone = surface.zone[k];
            if (variant.emitters) zone.exitance = variant.emitters >> i & 1;
            if (variant.black && surface.bsdf == CASE_DIFFUSE) zone.rho = 0;
            status = add_zone(scene, &surface, zone);
        }
    }
    if (status == RSV_OK && description->receiver.name && !variant.sky)
        status = add_zone(scene, &description->receiver, description->receiver.zone[0]);
    bool lit = !variant.emitters && !variant.sky;
    for (int i = 0; i < description->light_count && status == RSV_OK && lit; i++)
        status = rsv_scene_add_light(scene, &description->light[i]);
    for (int i = 0; i < description->camera_count && status == RSV_OK; i++)
        status = rsv_scene_add_camera(scene, &description->camera[i]);
    return status;
}

rsv_status case_scene_build(
    rsv_context *context, const case_scene *scene, case_variant variant, rsv_scene **built)
{
    rsv_scene *created = NULL;
    rsv_status status = rsv_scene_create(context, &created);
    if (status == RSV_OK) status = add_everything(created, scene, variant);
    if (status == RSV_OK && (variant.sky || !scene->sky_is_alternative))
        status = case_sky_add(created, &scene->sky);
    if (status == RSV_OK) status = rsv_scene_commit(created);
    if (status == RSV_OK)
        *built = created;
    else
        rsv_scene_destroy(created);
    return status;
}

int case_scene_find(const case_scene *scene, const char *name)
{
    for (int i = 0; i < scene->surface_count; i++)
        if (strcmp(scene->surface[i].name, name) == 0) return i;
    return -1;
}

double case_surface_area(const case_surface *surface)
{
    double squared = surface->radius * surface->radius;
    if (surface->shape == CASE_DISK) return (double)RSV_PI * squared;
    if (surface->shape == CASE_SPHERE) return 4 * (double)RSV_PI * squared;
    return v3_length(v3_cross(v3_sub(surface->corner[1], surface->corner[0]),
        v3_sub(surface->corner[3], surface->corner[0])));
}

const case_zone *case_surface_zone(const case_surface *surface, rsv_vec3 point)
{
    double cosine = v3_normalize(v3_sub(point, surface->center)).z;
    for (int i = 0; i < surface->zone_count - 1; i++)
        if (cosine >= surface->zone[i].cos_min && cosine <= surface->zone[i].cos_max)
            return &surface->zone[i];
    return &surface->zone[surface->zone_count - 1];
}

static bool quad_contains(const case_surface *surface, rsv_vec3 point)
{
    rsv_vec3 edge1 = v3_sub(surface->corner[1], surface->corner[0]);
    rsv_vec3 edge2 = v3_sub(surface->corner[3], surface->corner[0]);
    rsv_vec3 offset = v3_sub(point, surface->corner[0]);
    float area = v3_length(v3_cross(edge1, edge2));
    float u = v3_dot(surface->normal, v3_cross(offset, edge2)) / area;
    float v = v3_dot(surface->normal, v3_cross(edge1, offset)) / area;
    float height = fabsf(v3_dot(surface->normal, offset));
    return u >= 0 && u <= 1 && v >= 0 && v <= 1 && height < 1e-5f * sqrtf(area);
}

bool case_surface_contains(const case_surface *surface, rsv_vec3 point)
{
    if (surface->shape == CASE_QUAD) return quad_contains(surface, point);
    rsv_vec3 offset = v3_sub(point, surface->center);
    double distance = v3_length(offset), rounding = 1e-5 * surface->radius;
    if (surface->shape == CASE_SPHERE) return fabs(distance - surface->radius) < rounding;
    return distance <= surface->radius && fabs(v3_dot(surface->normal, offset)) < rounding;
}

rsv_probe case_surface_probe(const case_surface *surface, rsv_vec3 point)
{
    if (surface->shape != CASE_SPHERE) return (rsv_probe){ point, surface->normal };
    rsv_vec3 outward = v3_normalize(v3_sub(point, surface->center));
    double mesh = case_mesh_distance(surface, outward);
    double radius = surface->inside ? fmin(surface->radius, mesh) : fmax(surface->radius, mesh);
    return (rsv_probe){ v3_mad(surface->center, (float)radius, outward),
        surface->inside ? v3_neg(outward) : outward };
}

rsv_probe case_surface_sample(const case_surface *surface, float x, float y)
{
    rsv_vec3 point = surface->center;
    if (surface->shape == CASE_QUAD) {
        point = v3_mad(surface->corner[0], x, v3_sub(surface->corner[1], surface->corner[0]));
        point = v3_mad(point, y, v3_sub(surface->corner[3], surface->corner[0]));
    } else if (surface->shape == CASE_DISK) {
        rsv_vec3 tangent, bitangent;
        v3_frame(surface->normal, &tangent, &bitangent);
        rsv_square_to_disk(x, y, &x, &y);
        point = v3_mad(point, (float)surface->radius * x, tangent);
        point = v3_mad(point, (float)surface->radius * y, bitangent);
    } else {
        point = v3_mad(point, (float)surface->radius, rsv_square_to_sphere(x, y));
    }
    return case_surface_probe(surface, point);
}

bool case_scene_reflects(const case_scene *scene)
{
    for (int i = 0; i < scene->surface_count; i++) {
        const case_surface *surface = &scene->surface[i];
        for (int z = 0; z < surface->zone_count; z++)
            if (surface->zone[z].rho > 0) return true;
    }
    return false;
}
