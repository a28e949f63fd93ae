#include "command.h"
#include "luminaire_info.h"
#include "moment.h"
#include "options.h"
#include "output_file.h"
#include "subject.h"

#include "resolvent/check.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char help[] =
    "usage: resolvent info SCENE [options]\n"
    "\n"
    "Lists the contents of SCENE (a file or a built-in scene) with all instances: counts,\n"
    "bounds, area, objects, materials, lights, cameras. For a file from `resolvent solve`, also what was\n"
    "solved. For a luminaire (.ies, .ldt): its angles, flux, peak and power.\n"
    "\n"
    "  --check            look for likely mistakes: flipped and duplicate faces, open seams, gaps that\n"
    "                     leak light, tiny or huge scale, missing light; and list what of the file is\n"
    "                     approximated or ignored\n"
    "  --json             print JSON\n" CLI_MESH_HELP CLI_READING_HELP CLI_MOMENT_HELP
        CLI_ENVIRONMENT_HELP CLI_FOG_HELP CLI_FOG_HEIGHT_HELP "\n"
    "examples:\n"
    "  resolvent info room.glb\n"
    "  resolvent info --check room.glb\n"
    "  resolvent info cornell-blocks --json\n";

/// Sums over triangles, by object and by material.
typedef struct totals {
    double area; ///< m2
    size_t *object_triangles, *material_triangles;
    double *object_area, *material_area;
} totals;

static double triangle_area(const rsv_scene_view *view, size_t triangle)
{
    const uint32_t *corner = view->triangle[triangle];
    rsv_vec3 a = view->position[corner[0]], b = view->position[corner[1]],
             c = view->position[corner[2]];
    double e[3] = { (double)b.x - a.x, (double)b.y - a.y, (double)b.z - a.z };
    double f[3] = { (double)c.x - a.x, (double)c.y - a.y, (double)c.z - a.z };
    double x = e[1] * f[2] - e[2] * f[1], y = e[2] * f[0] - e[0] * f[2],
           z = e[0] * f[1] - e[1] * f[0];
    return 0.5 * sqrt(x * x + y * y + z * z);
}

static void free_totals(totals *t)
{
    free(t->object_triangles);
    free(t->material_triangles);
    free(t->object_area);
    free(t->material_area);
}

static bool add_up(const rsv_scene_view *view, totals *t)
{
    *t = (totals){ .object_triangles = calloc(view->object_count + 1, sizeof(size_t)),
        .material_triangles = calloc(view->material_count + 1, sizeof(size_t)),
        .object_area = calloc(view->object_count + 1, sizeof(double)),
        .material_area = calloc(view->material_count + 1, sizeof(double)) };
    if (!t->object_triangles || !t->material_triangles || !t->object_area || !t->material_area) {
        cli_error("out of memory");
        return false;
    }
    for (size_t i = 0; i < view->triangle_count; i++) {
        double area = triangle_area(view, i);
        uint32_t object = view->triangle_object[i], material = view->triangle_material[i];
        t->area += area;
        t->object_triangles[object]++;
        t->object_area[object] += area;
        t->material_triangles[material]++;
        t->material_area[material] += area;
    }
    return true;
}

static double degrees(float radians) { return radians * (180 / 3.14159265358979323846); }

/// The digits a float has, and no negative zero.
static double tidy(float value)
{
    char digits[32];
    snprintf(digits, sizeof digits, "%.6g", value);
    return strtod(digits, NULL) + 0.0;
}

static void add_triple(cJSON *object, const char *name, float x, float y, float z)
{
    double values[3] = { tidy(x), tidy(y), tidy(z) };
    cJSON_AddItemToObject(object, name, cJSON_CreateDoubleArray(values, 3));
}

/// A coordinate as it stands in the file: the scene's, plus the scene's origin.
static double placed(float value, double origin)
{
    return origin == 0 ? tidy(value) : origin + tidy(value);
}

/// A point of the scene.
static void add_point(cJSON *object, const char *name, rsv_vec3 p, const double origin[3])
{
    const double at[3] = { placed(p.x, origin[0]), placed(p.y, origin[1]), placed(p.z, origin[2]) };
    cJSON_AddItemToObject(object, name, cJSON_CreateDoubleArray(at, 3));
}

/// The node that placed a light or camera, where that has another name.
static bool has_node(const char *node, const char *name) { return node && strcmp(node, name) != 0; }

static void add_rgb(cJSON *object, const char *name, rsv_rgb c)
{
    add_triple(object, name, c.r, c.g, c.b);
}
static void add_vec3(cJSON *object, const char *name, rsv_vec3 v)
{
    add_triple(object, name, v.x, v.y, v.z);
}

static void add_number(cJSON *object, const char *name, float value)
{
    cJSON_AddNumberToObject(object, name, tidy(value));
}

static cJSON *add_named_item(cJSON *array, const char *name)
{
    cJSON *item = cJSON_CreateObject();
    cJSON_AddStringToObject(item, "name", name);
    cJSON_AddItemToArray(array, item);
    return item;
}

static void add_objects(cJSON *root, const rsv_scene_view *view, const totals *t)
{
    cJSON *objects = cJSON_AddArrayToObject(root, "objects");
    for (size_t i = 0; i < view->object_count; i++) {
        cJSON *item = add_named_item(objects, view->object_name[i]);
        cJSON_AddNumberToObject(item, "triangles", (double)t->object_triangles[i]);
        cJSON_AddNumberToObject(item, "area", t->object_area[i]);
    }
}

static const char *const role_names[RSV_TEXTURE_ROLE_COUNT] = {
    [RSV_TEXTURE_BASE_COLOR] = "base color",
    [RSV_TEXTURE_OPACITY] = "opacity",
    [RSV_TEXTURE_METALLIC_ROUGHNESS] = "metal and roughness",
    [RSV_TEXTURE_NORMAL] = "normal map",
    [RSV_TEXTURE_EMISSION] = "emission",
    [RSV_TEXTURE_SPECULAR] = "specular",
    [RSV_TEXTURE_SPECULAR_COLOR] = "specular color",
    [RSV_TEXTURE_TRANSMISSION] = "transmission",
    [RSV_TEXTURE_CLEARCOAT] = "clear coat",
    [RSV_TEXTURE_CLEARCOAT_ROUGHNESS] = "clear coat roughness",
    [RSV_TEXTURE_CLEARCOAT_NORMAL] = "clear coat normal map",
    [RSV_TEXTURE_SHEEN_COLOR] = "sheen color",
    [RSV_TEXTURE_SHEEN_ROUGHNESS] = "sheen roughness",
    [RSV_TEXTURE_DIFFUSE_TRANSMISSION] = "diffuse transmission",
    [RSV_TEXTURE_DIFFUSE_TRANSMISSION_COLOR] = "diffuse transmission color",
    [RSV_TEXTURE_ANISOTROPY] = "anisotropy",
    [RSV_TEXTURE_IRIDESCENCE] = "iridescence",
    [RSV_TEXTURE_IRIDESCENCE_THICKNESS] = "iridescence thickness",
};

static void add_textures(cJSON *item, const rsv_scene *scene, const rsv_material *material)
{
    cJSON *textures = cJSON_AddArrayToObject(item, "textures");
    for (size_t k = 0; k < material->texture_count; k++) {
        const rsv_texture_info info = rsv_scene_texture_info(scene, material->textures[k].texture);
        cJSON *texture = cJSON_CreateObject();
        cJSON_AddItemToArray(textures, texture);
        cJSON_AddStringToObject(texture, "role", role_names[material->textures[k].role]);
        cJSON_AddStringToObject(texture, "name", info.name ? info.name : "");
        cJSON_AddNumberToObject(texture, "width", info.width);
        cJSON_AddNumberToObject(texture, "height", info.height);
    }
}

static void add_materials(cJSON *root, const rsv_scene *scene, const totals *t)
{
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    cJSON *materials = cJSON_AddArrayToObject(root, "materials");
    for (size_t i = 0; i < view->material_count; i++) {
        const rsv_material *material = &view->material[i];
        cJSON *item = add_named_item(materials, material->name);
        cJSON_AddNumberToObject(item, "triangles", (double)t->material_triangles[i]);
        cJSON_AddNumberToObject(item, "area", t->material_area[i]);
        add_rgb(item, "base_color", material->base_color);
        add_rgb(item, "emission", material->emission);
        add_number(item, "metallic", material->metallic);
        add_number(item, "roughness", material->roughness);
        add_number(item, "ior", material->ior);
        add_number(item, "specular", material->specular);
        add_number(item, "transmission", material->transmission);
        add_number(item, "thickness", material->thickness);
        cJSON_AddBoolToObject(item, "double_sided", material->double_sided);
        cJSON_AddBoolToObject(item, "unlit", material->unlit);
        add_number(item, "opacity", material->opacity);
        add_number(item, "clearcoat", material->clearcoat);
        add_rgb(item, "sheen_color", material->sheen_color);
        add_textures(item, scene, material);
    }
}

static void add_lights(cJSON *root, const rsv_scene_view *view)
{
    cJSON *lights = cJSON_AddArrayToObject(root, "lights");
    for (size_t i = 0; i < view->light_count; i++) {
        const rsv_punctual_light *light = &view->light[i];
        const rsv_punctual_facts facts = rsv_punctual_facts_of(light->kind);
        cJSON *item = add_named_item(lights, light->name);
        if (has_node(view->light_node[i], light->name))
            cJSON_AddStringToObject(item, "node", view->light_node[i]);
        cJSON_AddStringToObject(item, "kind", facts.name);
        add_rgb(item, "intensity", light->intensity);
        if (facts.has_place) add_point(item, "position", light->position, view->origin);
        if (facts.has_direction) add_vec3(item, "direction", light->direction);
        if (facts.has_place)
            cJSON_AddNumberToObject(item, "lumens", rsv_punctual_lumens(view, light));
        if (light->kind == RSV_PUNCTUAL_LUMINAIRE)
            cJSON_AddStringToObject(item, "luminaire", view->luminaire[light->luminaire].name);
    }
}

static void add_environment(cJSON *root, const rsv_scene_view *view)
{
    if (!view->environment) return;
    cJSON *item = cJSON_AddObjectToObject(root, "environment");
    cJSON_AddStringToObject(item, "name", view->environment->name);
    cJSON_AddNumberToObject(item, "width", view->environment->width);
    cJSON_AddNumberToObject(item, "height", view->environment->height);
    add_number(item, "rotation_degrees", view->environment->rotation);
}

static void add_fog(cJSON *root, const rsv_scene_view *view)
{
    const rsv_fog *fog = view->fog;
    if (!fog) return;
    cJSON *item = cJSON_AddObjectToObject(root, "fog");
    add_rgb(item, "extinction", fog->extinction);
    add_rgb(item, "albedo", fog->albedo);
    add_number(item, "anisotropy", fog->anisotropy);
    if (fog->scale_height < INFINITY) {
        add_number(item, "scale_height", fog->scale_height);
        cJSON_AddNumberToObject(item, "base_height", fog->base_height + view->origin[1]);
        return;
    }
    uint32_t side[3];
    if (rsv_scene_volume_size(view, side)) {
        cJSON *grid = cJSON_AddArrayToObject(item, "grid");
        for (int k = 0; k < 3; k++)
            cJSON_AddItemToArray(grid, cJSON_CreateNumber(side[k]));
    }
    add_point(item, "bounds_min", fog->bounds_min, view->origin);
    add_point(item, "bounds_max", fog->bounds_max, view->origin);
}

static void add_operator(cJSON *root, const rsv_light *solution)
{
    if (!solution) return;
    const rsv_solve_report *report = rsv_light_report(solution);
    cJSON *item = cJSON_AddObjectToObject(root, "operator");
    cJSON_AddNumberToObject(item, "elements", (double)report->elements);
    cJSON_AddNumberToObject(item, "direct_elements", (double)report->direct_elements);
    cJSON_AddNumberToObject(item, "entries", (double)report->entries);
    cJSON_AddNumberToObject(item, "norm_inf", report->norm_inf);
    cJSON_AddNumberToObject(item, "spectral_radius", report->spectral_radius);
    cJSON_AddNumberToObject(item, "mean_irradiance", report->mean_irradiance);
    cJSON_AddNumberToObject(item, "truncation_bound", report->truncation_bound);
    cJSON_AddStringToObject(item, "solver", rsv_solver_name(report->solver));
}

static void add_cameras(cJSON *root, const rsv_scene_view *view)
{
    cJSON *cameras = cJSON_AddArrayToObject(root, "cameras");
    for (size_t i = 0; i < view->camera_count; i++) {
        const rsv_camera *camera = &view->camera[i];
        cJSON *item = add_named_item(cameras, camera->name);
        if (has_node(view->camera_node[i], camera->name))
            cJSON_AddStringToObject(item, "node", view->camera_node[i]);
        add_point(item, "position", camera->position, view->origin);
        add_vec3(item, "forward", camera->forward);
        cJSON_AddNumberToObject(item, "vertical_fov_degrees", degrees(camera->vertical_fov));
        add_number(item, "aspect", camera->aspect);
    }
}

static void add_clips(cJSON *root, const rsv_animation *animation)
{
    cJSON *clips = cJSON_AddArrayToObject(root, "animations");
    for (size_t k = 0; animation && k < rsv_animation_clip_count(animation); k++) {
        const rsv_clip *clip = rsv_animation_clip(animation, k);
        cJSON *item = add_named_item(clips, clip->name);
        cJSON_AddNumberToObject(item, "start", clip->start);
        cJSON_AddNumberToObject(item, "end", clip->end);
        cJSON_AddNumberToObject(item, "channels", (double)clip->channel_count);
    }
}

/// Results of --check.
typedef struct findings {
    bool wanted;
    rsv_finding *finding; ///< [count]
    size_t count;
} findings;

static bool look_for_mistakes(cli_session *session, const rsv_scene *scene, findings *f)
{
    if (!f->wanted) return true;
    rsv_status status = rsv_scene_check(scene, &f->finding, &f->count);
    if (status != RSV_OK) cli_report_failure(session, status);
    return status == RSV_OK;
}

static void add_findings(cJSON *root, const cli_session *session, const findings *f)
{
    if (!f->wanted) return;
    cJSON *notes = cJSON_AddArrayToObject(root, "notes");
    for (size_t i = 0; i < session->notes.count; i++)
        cJSON_AddItemToArray(notes, cJSON_CreateString(session->notes.text[i]));
    cJSON *mistakes = cJSON_AddArrayToObject(root, "mistakes");
    for (size_t i = 0; i < f->count; i++) {
        cJSON *item = cJSON_CreateObject();
        cJSON_AddItemToArray(mistakes, item);
        cJSON_AddStringToObject(item, "kind", rsv_mistake_name(f->finding[i].mistake));
        cJSON_AddStringToObject(item, "where", f->finding[i].where);
        cJSON_AddNumberToObject(item, "count", (double)f->finding[i].count);
        cJSON_AddNumberToObject(item, "amount", f->finding[i].amount);
        cJSON_AddStringToObject(item, "text", f->finding[i].text);
    }
}

static bool print_json(const cli_session *session, const char *name, const cli_subject *subject,
    const totals *t, const findings *found)
{
    const rsv_scene_view *view = rsv_scene_get_view(subject->scene);
    cJSON *root = cJSON_CreateObject();
    cJSON_AddStringToObject(root, "scene", name);
    cJSON_AddNumberToObject(root, "triangle_count", (double)view->triangle_count);
    cJSON_AddNumberToObject(root, "vertex_count", (double)view->vertex_count);
    cJSON_AddNumberToObject(root, "area", t->area);
    add_point(root, "bounds_min", view->bounds_min, view->origin);
    add_point(root, "bounds_max", view->bounds_max, view->origin);
    add_objects(root, view, t);
    add_materials(root, subject->scene, t);
    add_lights(root, view);
    add_environment(root, view);
    add_fog(root, view);
    add_cameras(root, view);
    add_clips(root, session->animation);
    add_operator(root, subject->solution);
    cJSON *warnings = cJSON_AddArrayToObject(root, "warnings");
    for (size_t i = 0; i < session->warnings.count; i++)
        cJSON_AddItemToArray(warnings, cJSON_CreateString(session->warnings.text[i]));
    add_findings(root, session, found);
    bool printed = cli_write_json(NULL, root);
    cJSON_Delete(root);
    return printed;
}

/// Prints a name from a file; control characters become '?', as they could steer a terminal.
static void print_name(const char *name)
{
    fputs("  ", stdout);
    for (; *name; name++)
        putchar((unsigned char)*name < 0x20 || *name == 0x7f ? '?' : *name);
}

static void print_node(const char *node, const char *name)
{
    if (!has_node(node, name)) return;
    fputs("  node", stdout);
    print_name(node);
}

/// Prints three coordinates, far from the origin with as many digits as are needed to tell points apart.
static void print_point(rsv_vec3 p, const double origin[3], int digits)
{
    bool far = origin[0] != 0 || origin[1] != 0 || origin[2] != 0;
    digits = far ? 12 : digits;
    printf("%.*g %.*g %.*g", digits, placed(p.x, origin[0]), digits, placed(p.y, origin[1]), digits,
        placed(p.z, origin[2]));
}

static void print_rgb(const char *label, rsv_rgb c)
{
    printf("  %s (%.4g %.4g %.4g)", label, c.r, c.g, c.b);
}

static bool is_black(rsv_rgb c) { return c.r == 0 && c.g == 0 && c.b == 0; }

static void print_objects(const rsv_scene_view *view, const totals *t)
{
    printf("\nobjects: %zu\n", view->object_count);
    for (size_t i = 0; i < view->object_count; i++) {
        print_name(view->object_name[i]);
        printf("  %zu triangles, %.6g m2\n", t->object_triangles[i], t->object_area[i]);
    }
}

static void print_layers(const rsv_material *m)
{
    if (m->opacity < 1) printf("  opacity %.3g", m->opacity);
    if (m->alpha_cutoff > 0) printf("  cut out below %.3g", m->alpha_cutoff);
    if (m->clearcoat > 0)
        printf("  clear coat %.3g of roughness %.3g", m->clearcoat, m->clearcoat_roughness);
    if (!is_black(m->sheen_color)) print_rgb("sheen", m->sheen_color);
    if (m->dispersion > 0) printf("  Abbe number %.3g", 20 / m->dispersion);
    if (m->anisotropy > 0) printf("  anisotropy %.3g", m->anisotropy);
    if (m->iridescence > 0)
        printf("  thin film %.3g of ior %.3g, %.4g nm", m->iridescence, m->iridescence_ior,
            m->iridescence_thickness_max);
    if (m->diffuse_transmission > 0) printf("  diffuse transmission %.3g", m->diffuse_transmission);
    if (!is_black(m->scatter_distance)) print_rgb("scatters within m", m->scatter_distance);
}

/// One line each.
static void print_textures(const rsv_scene *scene, const rsv_material *material)
{
    for (size_t k = 0; k < material->texture_count; k++) {
        const rsv_texture_info info = rsv_scene_texture_info(scene, material->textures[k].texture);
        printf("    %s:", role_names[material->textures[k].role]);
        print_name(info.name ? info.name : "unnamed");
        printf("  %u x %u\n", info.width, info.height);
    }
}

static void print_materials(const rsv_scene *scene, const totals *t)
{
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    printf("\nmaterials: %zu\n", view->material_count);
    for (size_t i = 0; i < view->material_count; i++) {
        const rsv_material *material = &view->material[i];
        print_name(material->name);
        printf("  %.6g m2", t->material_area[i]);
        print_rgb("base color", material->base_color);
        if (!is_black(material->emission)) print_rgb("emits", material->emission);
        if (material->metallic > 0) printf("  metallic %.3g", material->metallic);
        if (material->transmission > 0)
            printf("  transmission %.3g  ior %.4g", material->transmission, material->ior);
        printf("  roughness %.3g%s%s", material->roughness,
            material->double_sided ? "  double-sided" : "", material->unlit ? "  unlit" : "");
        print_layers(material);
        putchar('\n');
        print_textures(scene, material);
    }
}

static void print_lights(const rsv_scene_view *view)
{
    printf("\npunctual lights: %zu\n", view->light_count);
    for (size_t i = 0; i < view->light_count; i++) {
        const rsv_punctual_light *light = &view->light[i];
        const rsv_punctual_facts facts = rsv_punctual_facts_of(light->kind);
        print_name(light->name);
        print_node(view->light_node[i], light->name);
        printf("  %s", facts.name);
        print_rgb(facts.has_place ? "W/sr" : "W/m2", light->intensity);
        if (light->kind == RSV_PUNCTUAL_LUMINAIRE)
            printf("  '%s', %.4g lm", view->luminaire[light->luminaire].name,
                rsv_punctual_lumens(view, light));
        putchar('\n');
    }
}

static void print_environment(const rsv_scene_view *view)
{
    if (!view->environment) return;
    printf("\nenvironment:\n");
    print_name(view->environment->name);
    printf("  %u x %u, turned by %.4g degrees\n", view->environment->width,
        view->environment->height, view->environment->rotation);
}

static void print_fog(const rsv_scene_view *view)
{
    const rsv_fog *fog = view->fog;
    if (!fog) return;
    printf("\nfog:\n ");
    print_rgb("1/m", fog->extinction);
    print_rgb("albedo", fog->albedo);
    printf("  g %.4g\n", fog->anisotropy);
    if (fog->scale_height < INFINITY) {
        printf("  above y = %.4g thinner by 1/e every %.4g m\n", fog->base_height + view->origin[1],
            fog->scale_height);
        return;
    }
    fputs("  from (", stdout);
    print_point(fog->bounds_min, view->origin, 4);
    fputs(") to (", stdout);
    print_point(fog->bounds_max, view->origin, 4);
    fputs(")", stdout);
    uint32_t side[3];
    if (rsv_scene_volume_size(view, side))
        printf(", on a grid of %u x %u x %u points", side[0], side[1], side[2]);
    puts("");
}

static void print_cameras(const rsv_scene_view *view)
{
    printf("\ncameras: %zu\n", view->camera_count);
    for (size_t i = 0; i < view->camera_count; i++) {
        const rsv_camera *camera = &view->camera[i];
        rsv_vec3 p = camera->position, f = camera->forward;
        print_name(camera->name);
        print_node(view->camera_node[i], camera->name);
        fputs("  at (", stdout);
        print_point(p, view->origin, 4);
        printf(") towards (%.3g %.3g %.3g)", tidy(f.x), tidy(f.y), tidy(f.z));
        if (camera->vertical_fov > 0)
            printf(", %.4g degrees high\n", degrees(camera->vertical_fov));
        else
            printf(", orthographic\n");
    }
}

static void print_clips(const rsv_animation *animation)
{
    size_t count = animation ? rsv_animation_clip_count(animation) : 0;
    if (count) printf("\nanimations: %zu\n", count);
    for (size_t k = 0; k < count; k++) {
        const rsv_clip *clip = rsv_animation_clip(animation, k);
        print_name(clip->name);
        printf("  %.4g s to %.4g s, %zu channels\n", clip->start, clip->end, clip->channel_count);
    }
}

static void print_operator(const rsv_light *solution)
{
    if (!solution) return;
    const rsv_solve_report *report = rsv_light_report(solution);
    printf("\nsolved operator:\n");
    printf("  %zu elements, %zu of direct light and caustics, %zu entries\n", report->elements,
        report->direct_elements, report->entries);
    printf("  norm %.4f, spectral radius %.4f (leading eigenvalue)\n", report->norm_inf,
        report->spectral_radius);
    printf("  mean irradiance %.5g W/m2, truncated by %.2g at most, by solver %s\n",
        report->mean_irradiance, report->truncation_bound, rsv_solver_name(report->solver));
}

static void print_text(
    const cli_session *session, const char *name, const cli_subject *subject, const totals *t)
{
    const rsv_scene_view *view = rsv_scene_get_view(subject->scene);
    rsv_vec3 low = view->bounds_min, high = view->bounds_max;
    printf("%s: %zu triangles, %zu vertices, %.6g m2\n", name, view->triangle_count,
        view->vertex_count, t->area);
    fputs("bounds: (", stdout);
    print_point(low, view->origin, 6);
    fputs(") to (", stdout);
    print_point(high, view->origin, 6);
    fputs(") m\n", stdout);
    print_objects(view, t);
    print_materials(subject->scene, t);
    print_lights(view);
    print_environment(view);
    print_fog(view);
    print_cameras(view);
    print_clips(session->animation);
    print_operator(subject->solution);
}

/// The animations of a glTF file, or of the one in an operator file; one that cannot be played is no reason to say
/// nothing of the rest.
static bool open_clips(cli_session *session, const char *name, const rsv_scene *scene)
{
    bool may_have = cli_ends_in(name, ".glb") || cli_ends_in(name, ".gltf");
    bool is_operator = rsv_is_operator_file(name) && rsv_scene_has_document(scene);
    if (session->animation || !(may_have || is_operator) || access(name, F_OK) != 0) return true;
    rsv_status status = is_operator
                            ? rsv_animation_open_document(scene, &session->animation)
                            : rsv_animation_open(session->context, name, NULL, &session->animation);
    if (status == RSV_ERROR_FORMAT || status == RSV_ERROR_UNSUPPORTED)
        cli_warn(session, rsv_last_error());
    else if (status != RSV_OK)
        cli_report_failure(session, status);
    return status == RSV_OK || status == RSV_ERROR_FORMAT || status == RSV_ERROR_UNSUPPORTED;
}

static void print_messages(const char *title, const cli_messages *messages)
{
    printf("\n%s: %zu\n", title, messages->count);
    for (size_t k = 0; k < messages->count; k++) {
        print_name(messages->text[k]);
        putchar('\n');
    }
}

static void print_findings(const cli_session *session, const findings *found)
{
    print_messages("approximated, left out or doubtful", &session->warnings);
    print_messages("notes", &session->notes);
    printf("\nlikely mistakes: %zu\n", found->count);
    for (size_t k = 0; k < found->count; k++) {
        print_name(found->finding[k].text);
        putchar('\n');
    }
}

/// The questions to answer about a scene, besides its contents.
typedef struct request {
    const char *name;
    cli_environment environment;
    bool json, check;
} request;

/// A scene or an operator file.
static bool print_subject(cli_session *session, const request *r)
{
    cli_subject subject;
    totals t = { 0 };
    findings found = { .wanted = r->check };
    bool printed = cli_open_subject(session, r->name, &r->environment, &subject) &&
                   open_clips(session, r->name, subject.scene) &&
                   add_up(rsv_scene_get_view(subject.scene), &t) &&
                   look_for_mistakes(session, subject.scene, &found);
    if (printed && r->json) printed = print_json(session, r->name, &subject, &t, &found);
    if (printed && !r->json) print_text(session, r->name, &subject, &t);
    if (printed && !r->json && r->check) print_findings(session, &found);
    if (found.finding) rsv_findings_release(subject.scene, found.finding);
    free_totals(&t);
    cli_close_animation(session);
    cli_close_subject(&subject);
    return printed;
}

int cli_info(int argc, char **argv)
{
    const char *mesh = NULL;
    request r = { .environment = CLI_DEFAULT_ENVIRONMENT };
    cli_reading reading = { 0 };
    cli_moment moment = CLI_AT_REST;
    const cli_option options[] = {
        { .name = "--json", .kind = CLI_FLAG, .value = &r.json },
        { .name = "--check", .kind = CLI_FLAG, .value = &r.check },
        CLI_MESH_OPTION(&mesh),
        CLI_MOMENT_OPTIONS(&moment),
        CLI_ENVIRONMENT_OPTIONS(&r.environment),
        CLI_READING_OPTIONS(&reading),
        CLI_FOG_OPTIONS(&r.environment),
        CLI_FOG_HEIGHT_OPTION(&r.environment),
        { .name = NULL },
    };
    const cli_usage usage = { "info", help, options, "SCENE", 1, 1,
        "--check --json --light-units --variant --time --clip" };
    int exit_status;
    if (!cli_parse(&usage, argc, argv, &r.name, &exit_status)) return exit_status;
    cli_session session;
    if (!cli_session_begin(&session, 0)) return CLI_FAILURE;
    session.mesh = mesh;
    session.moment = moment;
    session.reading = reading;
    session.keep_document = rsv_is_operator_file(r.name);
    bool printed = cli_is_luminaire(r.name) ? cli_print_luminaire(&session, r.name, r.json)
                                            : print_subject(&session, &r);
    cli_session_end(&session);
    return printed ? CLI_SUCCESS : CLI_FAILURE;
}
