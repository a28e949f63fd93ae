/// From instances of meshes to world-space triangles.
#include "../core/vec.h"
#include "scene.h"

#include <float.h>
#include <string.h>

/// A triangle whose height is below this share of its longest edge has no usable normal in float.
#define DEGENERATE_HEIGHT (4 * (double)FLT_EPSILON)

/// A mesh is flat if no vertex is farther from a plane than this share of its size.
#define FLAT_HEIGHT 1e-6

/// A transform whose volume is below this share of the product of its axes is singular.
#define SINGULAR_VOLUME 1e-9

/// An object suffers from where it lies if places there are farther apart than this share of its size.
#define COARSE 1e-2f

/// Meshes with degenerate triangles that get a warning of their own.
#define MAX_NAMED_MESHES 8

typedef struct linear_map {
    double axis[3][3];     ///< columns: images of x, y, z
    double cofactor[3][3]; ///< columns of the inverse transpose, up to a positive factor
    double offset[3];
    bool mirrored;
} linear_map;

/// Scratch for the mesh at hand, and the object being written.
typedef struct flattener {
    rsv_scene *scene;
    rsv_vec3 *position, *normal; ///< [largest vertex_count] in world space; normal zero = geometric
    const rsv_mesh *mesh;        ///< at hand
    linear_map map;
    bool has_uv[2], has_tangent, has_color; ///< whether any mesh has
    uint32_t *emitted; ///< output vertex that carries the mesh's own normal; RSV_NONE = none
    size_t coarse_count;
    const char *coarse; ///< the first object that lies so far away that its shape suffers
    float coarse_reach; ///< metres
} flattener;

static void cross(const double a[3], const double b[3], double result[3])
{
    result[0] = a[1] * b[2] - a[2] * b[1];
    result[1] = a[2] * b[0] - a[0] * b[2];
    result[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Near the origin transforms are floats, as users of the library give them.
static double narrow(const rsv_scene *scene, double value)
{
    return rsv_scene_is_far(scene) ? value : (double)(float)value;
}

/// False if the transform is singular.
static bool make_map(const rsv_scene *scene, const double m[16], linear_map *map)
{
    for (int column = 0; column < 3; column++)
        for (int row = 0; row < 3; row++)
            map->axis[column][row] = narrow(scene, m[4 * column + row]);
    for (int row = 0; row < 3; row++)
        map->offset[row] = narrow(scene, m[12 + row]) - scene->origin[row];
    for (int column = 0; column < 3; column++)
        cross(map->axis[(column + 1) % 3], map->axis[(column + 2) % 3], map->cofactor[column]);

    double volume = dot(map->axis[0], map->cofactor[0]);
    double extent = 1;
    for (int column = 0; column < 3; column++)
        extent *= sqrt(dot(map->axis[column], map->axis[column]));
    map->mirrored = volume < 0;
    for (int i = 0; map->mirrored && i < 9; i++)
        map->cofactor[i / 3][i % 3] *= -1;
    return fabs(volume) > SINGULAR_VOLUME * extent;
}

static rsv_vec3 apply(const double columns[3][3], const double offset[3], rsv_vec3 v)
{
    double r[3];
    for (int i = 0; i < 3; i++)
        r[i] = columns[0][i] * v.x + columns[1][i] * v.y + columns[2][i] * v.z + offset[i];
    return v3((float)r[0], (float)r[1], (float)r[2]);
}

/// Unit image of a normal; scaled in double so that tiny and huge transforms do no harm.
static rsv_vec3 apply_normal(const linear_map *map, rsv_vec3 n)
{
    double r[3];
    for (int i = 0; i < 3; i++)
        r[i] = map->cofactor[0][i] * n.x + map->cofactor[1][i] * n.y + map->cofactor[2][i] * n.z;
    double length = sqrt(dot(r, r));
    if (!(length > 0)) return v3(0, 0, 0);
    return v3((float)(r[0] / length), (float)(r[1] / length), (float)(r[2] / length));
}

static rsv_status transform_vertices(
    flattener *f, const rsv_mesh *mesh, const linear_map *map, const char *object)
{
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        rsv_vec3 p = apply(map->axis, map->offset, mesh->position[i]);
        if (!rsv_within_reach(p))
            return rsv_fail(RSV_ERROR_FORMAT,
                "node '%s': vertex %zu of mesh '%s' is farther than %g m from the origin", object,
                i, mesh->name, (double)RSV_FARTHEST);
        f->position[i] = p;
        f->normal[i] = mesh->normal ? apply_normal(map, mesh->normal[i]) : v3(0, 0, 0);
        f->emitted[i] = RSV_NONE;
    }
    return RSV_OK;
}

bool rsv_triangle_normal(rsv_vec3 a, rsv_vec3 b, rsv_vec3 c, rsv_vec3 *normal)
{
    double ab[3] = { (double)b.x - a.x, (double)b.y - a.y, (double)b.z - a.z };
    double ac[3] = { (double)c.x - a.x, (double)c.y - a.y, (double)c.z - a.z };
    double bc[3] = { ac[0] - ab[0], ac[1] - ab[1], ac[2] - ab[2] };
    double n[3];
    cross(ab, ac, n);
    double length = sqrt(dot(n, n));
    double longest_squared = fmax(dot(ab, ab), fmax(dot(ac, ac), dot(bc, bc)));
    if (!(length > DEGENERATE_HEIGHT * longest_squared)) return false;
    *normal = v3((float)(n[0] / length), (float)(n[1] / length), (float)(n[2] / length));
    return true;
}

/// A tangent in world space: along the surface, so it transforms like an edge. Mirroring swaps its hand.
static void world_tangent(const linear_map *map, const float from[4], float to[4])
{
    static const double no_offset[3] = { 0, 0, 0 };
    rsv_vec3 t = apply(map->axis, no_offset, v3(from[0], from[1], from[2]));
    float scale = v3_max_abs(t);
    t = scale > 0 && isfinite(scale) ? v3_normalize(v3_scale(t, 1 / scale)) : v3(0, 0, 0);
    to[0] = t.x, to[1] = t.y, to[2] = t.z;
    to[3] = (from[3] < 0) != map->mirrored ? -1 : 1;
}

/// Room for one more vertex in an attribute that some mesh has.
static rsv_status grow_attribute(
    rsv_scene *scene, bool wanted, void *array, size_t *capacity, size_t width)
{
    if (!wanted) return RSV_OK;
    return rsv_grow(
        scene->context, array, capacity, scene->vertex_count + 1, width * sizeof(float));
}

/// Writes the texture coordinates, tangent and colour of the output vertex to come; meshes without get zeros
/// and white.
static rsv_status append_attributes(flattener *f, uint32_t vertex)
{
    rsv_scene *scene = f->scene;
    const rsv_mesh *mesh = f->mesh;
    size_t id = scene->vertex_count;
    rsv_status status;
    for (int set = 0; set < 2; set++) {
        RSV_TRY(grow_attribute(
            scene, f->has_uv[set], (void **)&scene->uv[set], &scene->uv_capacity[set], 2));
        for (int k = 0; k < 2 && f->has_uv[set]; k++)
            scene->uv[set][id][k] = mesh->uv[set] ? mesh->uv[set][vertex][k] : 0;
    }
    RSV_TRY(grow_attribute(
        scene, f->has_tangent, (void **)&scene->tangent, &scene->tangent_capacity, 4));
    if (f->has_tangent) memset(scene->tangent[id], 0, sizeof scene->tangent[id]);
    if (mesh->tangent) world_tangent(&f->map, mesh->tangent[vertex], scene->tangent[id]);
    RSV_TRY(grow_attribute(scene, f->has_color, (void **)&scene->color, &scene->color_capacity, 4));
    for (int k = 0; k < 4 && f->has_color; k++)
        scene->color[id][k] = mesh->color ? mesh->color[vertex][k] : 1;
cleanup:
    return status;
}

/// A new output vertex from a vertex of the mesh at hand.
static rsv_status append_vertex(flattener *f, uint32_t vertex, rsv_vec3 normal, uint32_t *id)
{
    rsv_status status;
    rsv_scene *scene = f->scene;
    size_t count = scene->vertex_count;
    if (count >= RSV_NONE - 1)
        return rsv_fail(RSV_ERROR_UNSUPPORTED, "scene: more than 2^32 vertices after flattening");
    RSV_TRY(rsv_grow(scene->context, (void **)&scene->position, &scene->position_capacity,
        count + 1, sizeof *scene->position));
    RSV_TRY(rsv_grow(scene->context, (void **)&scene->normal, &scene->normal_capacity, count + 1,
        sizeof normal));
    RSV_TRY(append_attributes(f, vertex));
    scene->position[count] = f->position[vertex];
    scene->normal[count] = normal;
    scene->vertex_count = count + 1;
    *id = (uint32_t)count;
cleanup:
    return status;
}

/// The output vertex for one corner: shared where the mesh's normal is on the geometric side, split off with the
/// geometric normal where it is not. Which corners these are depends on the pose, so nothing is shared where the mesh
/// deforms.
static rsv_status emit_corner(flattener *f, uint32_t vertex, rsv_vec3 geometric, uint32_t *id)
{
    bool faces = v3_dot(f->normal[vertex], geometric) > 0;
    if (!faces || f->mesh->deforms)
        return append_vertex(f, vertex, faces ? f->normal[vertex] : geometric, id);
    rsv_status status = RSV_OK;
    if (f->emitted[vertex] == RSV_NONE)
        status = append_vertex(f, vertex, f->normal[vertex], &f->emitted[vertex]);
    *id = f->emitted[vertex];
    return status;
}

/// @param source its index within the mesh
static rsv_status emit_triangle(
    flattener *f, rsv_mesh *mesh, uint32_t source, const uint32_t corner[3])
{
    rsv_scene *scene = f->scene;
    rsv_vec3 normal;
    if (!rsv_triangle_normal(
            f->position[corner[0]], f->position[corner[1]], f->position[corner[2]], &normal)) {
        mesh->degenerate_count++;
        return RSV_OK;
    }
    rsv_status status = RSV_OK;
    size_t t = scene->triangle_count;
    for (int i = 0; i < 3; i++)
        RSV_TRY(emit_corner(f, corner[i], normal, &scene->triangle[t][i]));
    scene->triangle_material[t] = mesh->material;
    scene->triangle_object[t] = (uint32_t)scene->object_count;
    scene->triangle_source[t] = source;
    scene->triangle_count = t + 1;
cleanup:
    return status;
}

static double distance_to(const rsv_mesh *mesh, uint32_t vertex, uint32_t from, const double n[3])
{
    rsv_vec3 a = mesh->position[from], b = mesh->position[vertex];
    const double d[3] = { (double)b.x - a.x, (double)b.y - a.y, (double)b.z - a.z };
    return n ? fabs(dot(d, n)) : sqrt(dot(d, d));
}

/// Whether all triangles of a mesh lie in one plane.
static bool is_flat(const rsv_mesh *mesh)
{
    rsv_vec3 normal = v3(0, 0, 0);
    const uint32_t *corner = mesh->index;
    size_t t = 0;
    while (t < mesh->triangle_count &&
           !rsv_triangle_normal(mesh->position[corner[0]], mesh->position[corner[1]],
               mesh->position[corner[2]], &normal))
        corner = &mesh->index[3 * ++t];
    if (t == mesh->triangle_count) return false;
    const double n[3] = { normal.x, normal.y, normal.z };
    double size = 0, height = 0;
    for (size_t k = 0; k < 3 * mesh->triangle_count; k++) {
        size = fmax(size, distance_to(mesh, mesh->index[k], corner[0], NULL));
        height = fmax(height, distance_to(mesh, mesh->index[k], corner[0], n));
    }
    return height <= FLAT_HEIGHT * size;
}

/// Records an object whose corners single precision hardly distinguishes. @param name of the node
static void judge_place(flattener *f, const rsv_mesh *mesh, const char *name)
{
    rsv_vec3 low = f->position[0], high = low;
    for (size_t k = 1; k < mesh->vertex_count; k++) {
        low = v3_min(low, f->position[k]);
        high = v3_max(high, f->position[k]);
    }
    float reach = f_max(v3_max_abs(low), v3_max_abs(high));
    float size = v3_max_abs(v3_sub(high, low));
    if (size == 0 || FLT_EPSILON * reach <= COARSE * size || f->coarse_count++) return;
    f->coarse = name;
    f->coarse_reach = reach;
}

/// After an origin was subtracted because everything is far away, the objects left behind have been named already.
static void report_coarse(const flattener *f)
{
    const rsv_scene *scene = f->scene;
    if (!f->coarse_count || scene->is_part || scene->origin[0] != 0 || scene->origin[1] != 0 ||
        scene->origin[2] != 0)
        return;
    rsv_log(scene->context, RSV_LOG_WARNING,
        "%zu object%s (first: '%s', %.3g m from the origin) too far away for single precision, which resolves "
        "%.2g m there: its shape suffers; move it closer to the origin",
        f->coarse_count, f->coarse_count > 1 ? "s lie" : " lies", f->coarse, f->coarse_reach,
        FLT_EPSILON * f->coarse_reach / 2);
}

static rsv_status flatten_instance(flattener *f, rsv_instance *instance)
{
    rsv_scene *scene = f->scene;
    rsv_mesh *mesh = &scene->mesh[instance->mesh];
    f->mesh = mesh;
    bool singular = !make_map(scene, instance->transform, &f->map);
    size_t first = scene->triangle_count, degenerate = mesh->degenerate_count;
    rsv_status status = RSV_OK;
    // a scale of zero across a flat mesh takes nothing from it
    if (singular && !is_flat(mesh)) goto cleanup;
    RSV_TRY(transform_vertices(f, mesh, &f->map, instance->name));
    if (!singular) judge_place(f, mesh, instance->name);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *index = &mesh->index[3 * t];
        // a mirroring transform turns the winding: swapping two corners keeps the front in front
        uint32_t corner[3] = { index[0], index[f->map.mirrored ? 2 : 1],
            index[f->map.mirrored ? 1 : 2] };
        RSV_TRY(emit_triangle(f, mesh, (uint32_t)t, corner));
    }
    if (scene->triangle_count > first) {
        scene->object_instance[scene->object_count] = (uint32_t)(instance - scene->instance);
        scene->object_name[scene->object_count++] = instance->name;
        instance->name = NULL;
    }
cleanup:
    if (status == RSV_OK && singular && scene->triangle_count == first) {
        mesh->degenerate_count = degenerate;
        rsv_log(scene->context, RSV_LOG_WARNING,
            "node '%s': its transform is singular (a zero scale?); the node is skipped",
            instance->name);
    }
    return status;
}

/// Allocates the per-triangle arrays for the largest possible outcome, and the scratch.
static rsv_status allocate(flattener *f)
{
    rsv_scene *scene = f->scene;
    size_t triangles = 0, vertices = 0;
    for (size_t i = 0; i < scene->instance_count; i++) {
        const rsv_mesh *mesh = &scene->mesh[scene->instance[i].mesh];
        triangles += mesh->triangle_count;
        if (mesh->vertex_count > vertices) vertices = mesh->vertex_count;
        f->has_uv[0] |= mesh->uv[0] != NULL;
        f->has_uv[1] |= mesh->uv[1] != NULL;
        f->has_tangent |= mesh->tangent != NULL;
        f->has_color |= mesh->color != NULL;
        if (triangles >= RSV_NONE)
            return rsv_fail(
                RSV_ERROR_UNSUPPORTED, "scene: more than 2^32 triangles after flattening");
    }
    scene->triangle = rsv_alloc(scene->context, triangles, sizeof *scene->triangle);
    scene->triangle_material = rsv_alloc(scene->context, triangles, sizeof(uint32_t));
    scene->triangle_object = rsv_alloc(scene->context, triangles, sizeof(uint32_t));
    scene->triangle_source = rsv_alloc(scene->context, triangles, sizeof(uint32_t));
    scene->object_instance = rsv_alloc(scene->context, scene->instance_count, sizeof(uint32_t));
    scene->object_name = rsv_alloc(scene->context, scene->instance_count, sizeof(char *));
    f->position = rsv_alloc(scene->context, vertices, sizeof *f->position);
    f->normal = rsv_alloc(scene->context, vertices, sizeof *f->normal);
    f->emitted = rsv_alloc(scene->context, vertices, sizeof *f->emitted);
    bool complete = scene->triangle && scene->triangle_material && scene->triangle_object &&
                    scene->triangle_source && scene->object_instance && scene->object_name &&
                    f->position && f->normal && f->emitted;
    return complete ? RSV_OK : RSV_ERROR_MEMORY;
}

/// One warning per mesh, but not hundreds of them.
static void report_degenerate(const rsv_scene *scene)
{
    size_t named = 0, others = 0, skipped = 0;
    for (size_t i = 0; i < scene->mesh_count; i++) {
        const rsv_mesh *mesh = &scene->mesh[i];
        if (!mesh->degenerate_count) continue;
        if (named++ < MAX_NAMED_MESHES) {
            rsv_log(scene->context, RSV_LOG_WARNING,
                "mesh '%s': %zu degenerate triangles (of no area) skipped", mesh->name,
                mesh->degenerate_count);
        } else {
            others++;
            skipped += mesh->degenerate_count;
        }
    }
    if (others)
        rsv_log(scene->context, RSV_LOG_WARNING,
            "%zu more meshes: %zu degenerate triangles (of no area) skipped", others, skipped);
}

rsv_status rsv_scene_flatten(rsv_scene *scene)
{
    rsv_status status;
    flattener f = { .scene = scene };
    for (size_t i = 0; i < scene->mesh_count; i++)
        RSV_TRY(rsv_mesh_create_tangents(
            scene->context, &scene->material[scene->mesh[i].material], &scene->mesh[i]));
    RSV_TRY(allocate(&f));
    for (size_t i = 0; i < scene->instance_count; i++)
        RSV_TRY(flatten_instance(&f, &scene->instance[i]));
    report_degenerate(scene);
    report_coarse(&f);
cleanup:
    rsv_free(scene->context, f.position);
    rsv_free(scene->context, f.normal);
    rsv_free(scene->context, f.emitted);
    return status;
}
