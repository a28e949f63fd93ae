#include "case_probe.h"

#include "case_lens.h"
#include "case_receiver.h"

#include "core/sampling.h"

#include <stdlib.h>
#include <string.h>

/// Sampling goes on until the standard error is this share of the reading, or the limit is reached.
#define WANTED_RELATIVE_ERROR 1.8e-3
#define PILOT_SAMPLES 8192
#define MAX_SAMPLES (1u << 20)
/// Means over a surface: independent randomisations of a set of points, with few samples at each.
#define REPLICATES 32
#define PILOT_POINTS 16
#define MAX_POINTS 512
#define SAMPLES_PER_POINT 32

/// Settings for points of light seen in mirrors and glass: the number of light paths, the radius over which a reading
/// is averaged, and the size of the elements that it is stored on. Irradiance varies by 0.1 % over that radius, except
/// behind a lens, where the effect of averaging is known (case_lens.h).
#define PHOTONS (1u << 20)
#define RECEIVER_RADIUS 0.1
#define RECEIVER_RADIUS_BEHIND_LENS 0.07
#define RECEIVER_SPACING 0.02

/// offset + weight * reading
static case_reading affine(case_reading reading, double offset, double weight)
{
    return (case_reading){ offset + weight * reading.value, weight * reading.standard_error };
}

/// @param run 0 = the pilot run, 1 = the run that counts
static uint32_t run_seed(const case_bench *bench, uint32_t run)
{
    return 1 + run + 2 * bench->opinion;
}

static rsv_status make_solution(const case_bench *bench, case_solution *created)
{
    rsv_status status =
        case_scene_build(bench->context, &bench->scene, created->variant, &created->scene);
    if (status != RSV_OK || bench->mode == RSV_PROBE_REFERENCE) return status;
    // without reflection all light comes directly from the sources, however it is stored
    bool reflects = !created->variant.black && case_scene_reflects(&bench->scene);
    rsv_solve_desc desc = rsv_default_solve_desc(reflects ? RSV_QUALITY_MEDIUM : RSV_QUALITY_DRAFT);
    desc.seed = run_seed(bench, 0);
    if (bench->scene.receiver.name) {
        double area = case_receiver_area(&bench->scene);
        desc.element_target = (uint32_t)(area / (RECEIVER_SPACING * RECEIVER_SPACING));
        desc.photon_count = PHOTONS;
    }
    return rsv_light_create(created->scene, &desc, &created->solution);
}

/// The scene of a variant, solved when it is first needed.
static rsv_status find_solution(
    case_bench *bench, case_variant variant, const case_solution **found)
{
    int i = 0;
    for (; i < bench->solution_count; i++) {
        *found = &bench->solution[i];
        case_variant known = bench->solution[i].variant;
        if (known.black == variant.black && known.emitters == variant.emitters &&
            known.sky == variant.sky && bench->solution[i].opinion == bench->opinion)
            return RSV_OK;
    }
    if (i == CASE_MAX_VARIANTS * (1 + CASE_OPINIONS)) abort();
    case_solution created = { .variant = variant, .opinion = bench->opinion };
    rsv_status status = make_solution(bench, &created);
    bench->solution[i] = created;
    *found = &bench->solution[i];
    if (status == RSV_OK)
        bench->solution_count++;
    else
        rsv_scene_destroy(created.scene);
    return status;
}

static rsv_status read_probes(const case_bench *bench, const case_solution *solution,
    const rsv_probe *probes, size_t count, uint32_t samples, uint32_t seed,
    rsv_probe_reading *readings)
{
    if (bench->mode == RSV_PROBE_REFERENCE)
        return rsv_probe_reference(solution->scene, probes, count, samples, seed, readings);
    return rsv_probe_irradiance(solution->solution,
        &(rsv_probe_desc){ sizeof(rsv_probe_desc), bench->mode, samples, seed }, probes, count,
        readings);
}

/// Factor for the number of samples that brings the standard error down to the one wanted.
static double wanted_factor(case_reading pilot)
{
    double wanted = WANTED_RELATIVE_ERROR * fabs(pilot.value);
    double ratio = pilot.standard_error / wanted;
    return pilot.standard_error > 0 && pilot.value != 0 ? ratio * ratio : 1;
}

/// Irradiance at one point. A pilot run sizes the run that counts, which has a seed of its own.
static rsv_status read_point(
    case_bench *bench, case_variant variant, rsv_probe probe, case_reading *reading)
{
    const case_solution *solution;
    rsv_status status = find_solution(bench, variant, &solution);
    double samples = PILOT_SAMPLES;
    for (uint32_t run = 0; run < 2 && status == RSV_OK; run++) {
        rsv_probe_reading raw = { 0 };
        status =
            read_probes(bench, solution, &probe, 1, (uint32_t)samples, run_seed(bench, run), &raw);
        *reading = (case_reading){ (double)raw.irradiance.g, (double)raw.standard_error.g };
        samples = fmin(fmax(samples * wanted_factor(*reading), PILOT_SAMPLES), MAX_SAMPLES);
    }
    return status;
}

/// Irradiance averaged over a disk: of virtual receivers, or as stored on the plate that they lie on.
static rsv_status read_disk(
    case_bench *bench, rsv_probe center, double radius, case_reading *reading)
{
    const case_solution *solution;
    rsv_probe points[CASE_RECEIVER_POINTS];
    rsv_probe_reading raw[CASE_RECEIVER_POINTS];
    size_t count = case_receiver_disk(&bench->scene, center, radius, points);
    rsv_status status = find_solution(bench, (case_variant){ 0 }, &solution);
    if (status == RSV_OK)
        status = read_probes(bench, solution, points, count, 32, run_seed(bench, 1), raw);
    for (size_t i = 0; i < count && status == RSV_OK; i++)
        reading->value += (double)raw[i].irradiance.g / (double)count;
    return status;
}

/// Point `index` of a set that spreads over several surfaces in proportion to their area.
static rsv_probe sample_surfaces(
    const case_scene *scene, uint32_t surfaces, double area, uint32_t index, uint32_t seed)
{
    float x, y;
    rsv_sobol_2d(index, seed, &x, &y);
    double target = x * area;
    const case_surface *chosen = NULL;
    for (int i = 0; i < scene->surface_count && (!chosen || target >= case_surface_area(chosen));
         i++) {
        if (!(surfaces >> i & 1)) continue;
        if (chosen) target -= case_surface_area(chosen);
        chosen = &scene->surface[i];
    }
    float within = (float)fmin(target / case_surface_area(chosen), 1 - 0x1p-24);
    return case_surface_sample(chosen, within, y);
}

static double total_area(const case_scene *scene, uint32_t surfaces)
{
    double area = 0;
    for (int i = 0; i < scene->surface_count; i++)
        if (surfaces >> i & 1) area += case_surface_area(&scene->surface[i]);
    return area;
}

/// Mean of the readings, with the error from the spread of the means of the replicates.
static case_reading summarise_replicates(const rsv_probe_reading *readings, uint32_t points)
{
    double mean[REPLICATES], total = 0, squares = 0;
    for (uint32_t r = 0; r < REPLICATES; r++) {
        double sum = 0;
        for (uint32_t i = 0; i < points; i++)
            sum += (double)readings[r * points + i].irradiance.g;
        mean[r] = sum / points;
        total += mean[r] / REPLICATES;
    }
    for (uint32_t r = 0; r < REPLICATES; r++)
        squares += (mean[r] - total) * (mean[r] - total);
    return (case_reading){ total, sqrt(squares / (REPLICATES - 1) / REPLICATES) };
}

static rsv_status read_replicates(case_bench *bench, const case_solution *solution,
    uint32_t surfaces, uint32_t points, uint32_t seed, case_reading *reading)
{
    size_t count = (size_t)REPLICATES * points;
    double area = total_area(&bench->scene, surfaces);
    rsv_probe *probes = malloc(count * sizeof *probes);
    rsv_probe_reading *readings = malloc(count * sizeof *readings);
    if (!probes || !readings) abort();
    for (uint32_t i = 0; i < count; i++)
        probes[i] =
            sample_surfaces(&bench->scene, surfaces, area, i % points, rsv_hash2(seed, i / points));
    rsv_status status =
        read_probes(bench, solution, probes, count, SAMPLES_PER_POINT, seed, readings);
    if (status == RSV_OK) *reading = summarise_replicates(readings, points);
    free(probes);
    free(readings);
    return status;
}

/// Area mean of the irradiance over a set of surfaces (bits).
static rsv_status read_mean(
    case_bench *bench, case_variant variant, uint32_t surfaces, case_reading *reading)
{
    const case_solution *solution;
    rsv_status status = find_solution(bench, variant, &solution);
    uint32_t points = PILOT_POINTS;
    for (uint32_t run = 0; run < 2 && status == RSV_OK; run++) {
        status = read_replicates(bench, solution, surfaces, points, run_seed(bench, run), reading);
        double wanted = points * wanted_factor(*reading);
        while (points < wanted && points < MAX_POINTS)
            points *= 2;
    }
    return status;
}

static rsv_status read_radiance(
    case_bench *bench, case_variant variant, uint32_t camera, case_reading *reading)
{
    const case_solution *solution;
    rsv_image *image = NULL;
    double relative_error = 0;
    rsv_render_desc desc = rsv_default_render_desc();
    desc.width = desc.height = 1;
    desc.camera = camera;
    rsv_status status = find_solution(bench, variant, &solution);
    if (status == RSV_OK && bench->mode == RSV_PROBE_REFERENCE) {
        desc.mode = RSV_RENDER_REFERENCE;
        desc.samples = 1u << 16;
        desc.seed = run_seed(bench, 1);
        status = rsv_render_reference(solution->scene, &desc, &image, &relative_error);
    } else if (status == RSV_OK) {
        desc.mode = RSV_RENDER_OPERATOR;
        desc.samples = 64;
        status = rsv_render(solution->solution, &desc, &image);
    }
    if (status == RSV_OK) {
        reading->value = (double)rsv_image_const_pixels(image, 0)->g;
        reading->standard_error = relative_error * reading->value;
    }
    rsv_image_destroy(image);
    return status;
}

static const char *text(const cJSON *object, const char *name)
{
    const char *value = cJSON_GetStringValue(cJSON_GetObjectItem(object, name));
    return value ? value : "";
}

static rsv_vec3 vector(const cJSON *object, const char *name)
{
    return case_vector(cJSON_GetObjectItem(object, name));
}

static void add_camera(case_scene *scene, rsv_vec3 position, rsv_vec3 forward)
{
    if (scene->camera_count == CASE_MAX_CAMERAS) abort();
    rsv_vec3 right, up;
    v3_frame(forward, &up, &right);
    scene->camera[scene->camera_count++] = (rsv_camera){ .name = "probe",
        .position = position,
        .right = right,
        .up = up,
        .forward = forward,
        .vertical_extent = 1e-4f,
        .aspect = 1 };
}

/// A quantity that has no probe in the file: straight up, from below the interface.
static const char below_interface[] = "L_transmitted_normal";

/// At a point or over a disk.
static bool is_irradiance(const cJSON *probe)
{
    const char *type = text(probe, "type");
    return strcmp(type, "irradiance") == 0 || strcmp(type, "disk_irradiance") == 0;
}

static double radius_of(const case_scene *scene, const cJSON *probe)
{
    const cJSON *radius = cJSON_GetObjectItem(probe, "radius");
    if (radius) return cJSON_GetNumberValue(radius);
    bool lens = scene->surface[0].shape == CASE_SPHERE;
    return lens ? RECEIVER_RADIUS_BEHIND_LENS : RECEIVER_RADIUS;
}

/// Reads light from mirrors and glass. For a point behind a lens, corrects for the averaging over a disk.
static rsv_status read_received(case_bench *bench, const cJSON *probe, case_reading *reading)
{
    const case_surface *lens = &bench->scene.surface[0];
    rsv_vec3 point = vector(probe, "point"), offset = v3_sub(point, lens->center);
    rsv_probe receiver = { point, vector(probe, "normal") };
    double radius = radius_of(&bench->scene, probe);
    bool is_point = !cJSON_HasObjectItem(probe, "radius");
    if (bench->mode != RSV_PROBE_LOOKUP && is_point)
        return read_point(bench, (case_variant){ 0 }, receiver, reading);
    rsv_status status = read_disk(bench, receiver, radius, reading);
    if (lens->shape == CASE_SPHERE && is_point)
        reading->value /= case_lens_blur(lens->ior, fabs((double)offset.z) / lens->radius,
            hypot((double)offset.x, (double)offset.y) / lens->radius, radius / lens->radius);
    return status;
}

void case_bench_announce(case_bench *bench, const cJSON *expected)
{
    const cJSON *probe = cJSON_GetObjectItem(expected, "probe");
    if (strcmp(text(expected, "name"), below_interface) == 0)
        add_camera(&bench->scene, v3(0, 0, -1), v3(0, 0, 1));
    if (strcmp(text(probe, "type"), "radiance") == 0)
        add_camera(
            &bench->scene, vector(probe, "origin"), v3_normalize(vector(probe, "direction")));
    bool stored = bench->mode == RSV_PROBE_LOOKUP && case_receiver_needed(&bench->scene);
    if (stored && is_irradiance(probe))
        case_receiver_cover(&bench->scene, vector(probe, "point"), vector(probe, "normal"),
            radius_of(&bench->scene, probe));
}

/// The camera that case_bench_announce made for a radiance probe.
static uint32_t find_camera(const case_scene *scene, const cJSON *probe)
{
    rsv_vec3 origin = vector(probe, "origin"), direction = v3_normalize(vector(probe, "direction"));
    for (int i = 0; i < scene->camera_count; i++) {
        const rsv_camera *camera = &scene->camera[i];
        float offset = v3_max_abs(v3_sub(camera->position, origin));
        if (offset == 0 && v3_max_abs(v3_sub(camera->forward, direction)) == 0) return (uint32_t)i;
    }
    abort();
}

/// The surface a probe names; "any" is the one that holds its point.
static const case_surface *probed_surface(const case_scene *scene, const cJSON *probe)
{
    int index = case_scene_find(scene, text(probe, "surface"));
    for (int i = 0; i < scene->surface_count && index < 0; i++)
        if (case_surface_contains(&scene->surface[i], vector(probe, "point"))) index = i;
    return index < 0 ? NULL : &scene->surface[index];
}

static rsv_status read_radiosity(case_bench *bench, const cJSON *probe, case_reading *reading)
{
    const case_surface *surface = probed_surface(&bench->scene, probe);
    if (!surface) abort();
    rsv_vec3 point = vector(probe, "point");
    const case_zone *zone = case_surface_zone(surface, point);
    rsv_status status =
        read_point(bench, (case_variant){ 0 }, case_surface_probe(surface, point), reading);
    *reading = affine(*reading, zone->exitance, zone->rho);
    return status;
}

/// Points said to lie on a sphere are moved to its mesh; others are taken as they are.
static rsv_probe irradiance_probe(const case_scene *scene, const cJSON *probe)
{
    rsv_probe given = { vector(probe, "point"), v3_normalize(vector(probe, "normal")) };
    for (int i = 0; i < scene->surface_count; i++) {
        const case_surface *surface = &scene->surface[i];
        if (surface->shape == CASE_SPHERE && case_surface_contains(surface, given.position))
            return case_surface_probe(surface, given.position);
    }
    return given;
}

/// total - direct; the two runs are independent, or the direct one has next to no error.
static case_reading difference(case_reading total, case_reading direct)
{
    return (case_reading){ total.value - direct.value,
        hypot(total.standard_error, direct.standard_error) };
}

static rsv_status read_indirect(case_bench *bench, rsv_probe probe, case_reading *reading)
{
    case_reading direct = { 0 };
    rsv_status status = read_point(bench, (case_variant){ .black = true }, probe, &direct);
    if (status == RSV_OK) status = read_point(bench, (case_variant){ 0 }, probe, reading);
    *reading = difference(*reading, direct);
    return status;
}

/// B = M + rho H of a surface of uniform albedo and exitance, or of several surfaces that differ only in M.
static rsv_status read_mean_radiosity(case_bench *bench, uint32_t surfaces, case_reading *reading)
{
    const case_scene *scene = &bench->scene;
    double exitance = 0, rho = 0, area = total_area(scene, surfaces);
    for (int i = 0; i < scene->surface_count; i++) {
        if (!(surfaces >> i & 1)) continue;
        exitance +=
            scene->surface[i].zone[0].exitance * case_surface_area(&scene->surface[i]) / area;
        rho = scene->surface[i].zone[0].rho;
    }
    rsv_status status = read_mean(bench, (case_variant){ 0 }, surfaces, reading);
    *reading = affine(*reading, exitance, rho);
    return status;
}

static uint32_t named_surface(const case_scene *scene, const cJSON *probe, const char *role)
{
    int index = case_scene_find(scene, text(probe, role));
    if (index < 0) abort();
    return 1u << index;
}

static rsv_status read_flux(case_bench *bench, const cJSON *probe, case_reading *reading)
{
    uint32_t surface = named_surface(&bench->scene, probe, "surface");
    rsv_status status = read_mean(bench, (case_variant){ 0 }, surface, reading);
    *reading = affine(*reading, 0, total_area(&bench->scene, surface));
    return status;
}

/// Flux that arrives over flux that leaves.
static rsv_status read_form_factor(case_bench *bench, const cJSON *probe, case_reading *reading)
{
    uint32_t from = named_surface(&bench->scene, probe, "from");
    uint32_t to = named_surface(&bench->scene, probe, "to");
    rsv_status status =
        read_mean(bench, (case_variant){ .black = true, .emitters = from }, to, reading);
    double ratio = total_area(&bench->scene, to) / total_area(&bench->scene, from);
    *reading = affine(*reading, 0, ratio);
    return status;
}

/// Wall groups of the reciprocity case: the bits of x0 x1 y0 y1 z0 z1.
static uint32_t wall_group(const char *name)
{
    if (strncmp(name, "floor", 5) == 0) return 1u << 4;
    return strncmp(name, "ceiling", 7) == 0 ? 1u << 5 : 0xf;
}

/// Quantities that have no probe in the file, but a name that defines them.
static rsv_status read_by_name(
    case_bench *bench, const char *name, case_reading *reading, bool *known)
{
    const char mean_irradiance[] = "H_mean_", *from = strstr(name, "_from_");
    uint32_t all = (1u << bench->scene.surface_count) - 1;
    if (strcmp(name, below_interface) == 0)
        return read_radiance(bench, (case_variant){ .sky = true }, 0, reading);
    if (strcmp(name, "B_area_mean") == 0) return read_mean_radiosity(bench, all, reading);
    if (strncmp(name, mean_irradiance, strlen(mean_irradiance)) == 0 && from) {
        case_variant variant = { .emitters = wall_group(from + strlen("_from_")) };
        return read_mean(bench, variant, wall_group(name + strlen(mean_irradiance)), reading);
    }
    if (strcmp(name, "E_indirect_mean") == 0) {
        case_reading direct = { 0 };
        rsv_status status = read_mean(bench, (case_variant){ .black = true }, all, &direct);
        if (status == RSV_OK) status = read_mean(bench, (case_variant){ 0 }, all, reading);
        *reading = difference(*reading, direct);
        return status;
    }
    *known = false;
    return RSV_OK;
}

/// The divisor of the probe's reading: the value that the file gives for another quantity of the case.
static double divisor_of(const case_bench *bench, const cJSON *probe)
{
    const char *name = text(probe, "divide_by");
    const cJSON *other;
    cJSON_ArrayForEach(other,
        bench->expected) if (strcmp(text(other, "name"), name) ==
                             0) return cJSON_GetNumberValue(cJSON_GetObjectItem(other, "value"));
    return 1;
}

static rsv_status read_quantity(
    case_bench *bench, const cJSON *expected, case_reading *reading, bool *known)
{
    const cJSON *probe = cJSON_GetObjectItem(expected, "probe");
    const char *type = text(probe, "type");
    rsv_probe receiver = irradiance_probe(&bench->scene, probe);
    *known = true;
    *reading = (case_reading){ 0 };
    bool alternative = strncmp(text(expected, "name"), "E_uniform_env", 13) == 0;
    if (case_receiver_needed(&bench->scene) && is_irradiance(probe) && !alternative)
        return read_received(bench, probe, reading);
    if (bench->mode == RSV_PROBE_LOOKUP) type = "unknown";
    if (!*type) return read_by_name(bench, text(expected, "name"), reading, known);
    if (strcmp(type, "irradiance") == 0)
        return read_point(bench, (case_variant){ .sky = alternative }, receiver, reading);
    if (strcmp(type, "direct_irradiance") == 0)
        return read_point(bench, (case_variant){ .black = true }, receiver, reading);
    if (strcmp(type, "indirect_irradiance") == 0) return read_indirect(bench, receiver, reading);
    if (strcmp(type, "radiosity") == 0) return read_radiosity(bench, probe, reading);
    if (strcmp(type, "mean_radiosity") == 0)
        return read_mean_radiosity(bench, named_surface(&bench->scene, probe, "surface"), reading);
    if (strcmp(type, "flux") == 0) return read_flux(bench, probe, reading);
    if (strcmp(type, "form_factor") == 0) return read_form_factor(bench, probe, reading);
    if (strcmp(type, "radiance") == 0)
        return read_radiance(
            bench, (case_variant){ 0 }, find_camera(&bench->scene, probe), reading);
    *known = false;
    return RSV_OK;
}

rsv_status case_bench_read(
    case_bench *bench, const cJSON *expected, case_reading *reading, bool *known)
{
    rsv_status status = read_quantity(bench, expected, reading, known);
    const cJSON *probe = cJSON_GetObjectItem(expected, "probe");
    *reading = affine(*reading, 0, 1 / divisor_of(bench, probe));
    return status;
}

void case_bench_close(case_bench *bench)
{
    for (int i = 0; i < bench->solution_count; i++) {
        rsv_light_destroy(bench->solution[i].solution);
        rsv_scene_destroy(bench->solution[i].scene);
    }
    bench->solution_count = 0;
}
