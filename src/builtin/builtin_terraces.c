/// Terraces: a landscape of stepped pyramids and stepwells in blocks of 10 m, meshed in squares of 25 cm. More
/// triangles make it larger, not finer, so that the cost of solvers can be plotted over the size of a scene.
#include "../core/sampling.h"
#include "builtin.h"

#define BLOCK 40 // squares along a block
#define STREET 2 // squares on each of its sides at street level
#define TREAD 4  // squares
#define RISE 2   // squares
#define SQUARE 0.25f
#define FEWEST_STEPS 2
#define MOST_STEPS 4
#define MATERIALS 3

/// The mesh of one material while it grows, in units of squares.
typedef struct growing_mesh {
    rsv_context *context;
    rsv_vec3 *position, *normal;
    uint32_t *index;
    size_t vertex_count, index_count;
    size_t position_capacity, normal_capacity, index_capacity;
} growing_mesh;

typedef struct terraces {
    growing_mesh mesh[MATERIALS];
    uint32_t blocks_along; ///< x
} terraces;

/// A rectangle in whole squares; its front is where `along` turns to `up` counter-clockwise.
typedef struct rectangle {
    rsv_vec3 corner, along, up; ///< edges in unit steps
    int width, height;
} rectangle;

static rsv_status reserve(growing_mesh *m, size_t vertices, size_t indices)
{
    rsv_status status;
    RSV_TRY(rsv_grow(m->context, (void **)&m->position, &m->position_capacity,
        m->vertex_count + vertices, sizeof *m->position));
    RSV_TRY(rsv_grow(m->context, (void **)&m->normal, &m->normal_capacity,
        m->vertex_count + vertices, sizeof *m->normal));
    RSV_TRY(rsv_grow(m->context, (void **)&m->index, &m->index_capacity, m->index_count + indices,
        sizeof *m->index));
cleanup:
    return status;
}

static rsv_status add_rectangle(growing_mesh *m, rectangle r)
{
    size_t width = (size_t)r.width, height = (size_t)r.height, row = width + 1;
    rsv_status status = reserve(m, row * (height + 1), 6 * width * height);
    if (status != RSV_OK) return status;
    uint32_t first = (uint32_t)m->vertex_count;
    rsv_vec3 normal = v3_cross(r.along, r.up);
    for (size_t j = 0; j <= height; j++)
        for (size_t i = 0; i <= width; i++) {
            rsv_vec3 place = v3_mad(v3_mad(r.corner, (float)i, r.along), (float)j, r.up);
            m->position[m->vertex_count] = v3_scale(place, SQUARE);
            m->normal[m->vertex_count++] = normal;
        }
    for (size_t j = 0; j < height; j++)
        for (size_t i = 0; i < width; i++) {
            uint32_t a = first + (uint32_t)(j * row + i), b = a + (uint32_t)row;
            const uint32_t corner[6] = { a, a + 1, b + 1, a, b + 1, b };
            for (int k = 0; k < 6; k++)
                m->index[m->index_count++] = corner[k];
        }
    return RSV_OK;
}

/// Level ground between two squares about a centre: four rectangles, each from a corner to the next.
static rsv_status add_ring(growing_mesh *m, rsv_vec3 centre, int outer, int inner)
{
    rsv_status status = RSV_OK;
    int breadth = (outer - inner) / 2;
    rsv_vec3 along = v3(1, 0, 0), in = v3(0, 0, -1);
    for (int side = 0; side < 4; side++) {
        rsv_vec3 corner =
            v3_mad(v3_mad(centre, -0.5f * (float)outer, along), -0.5f * (float)outer, in);
        RSV_TRY(add_rectangle(m, (rectangle){ corner, along, in, outer - breadth, breadth }));
        along = in;
        in = v3(along.z, 0, -along.x);
    }
cleanup:
    return status;
}

/// The four walls between a level and the one `rise` squares above (or below, facing inwards).
static rsv_status add_walls(growing_mesh *m, rsv_vec3 centre, int side_length, int rise)
{
    rsv_status status = RSV_OK;
    rsv_vec3 along = v3(1, 0, 0), in = v3(0, 0, -1);
    float half = 0.5f * (float)side_length;
    for (int side = 0; side < 4; side++) {
        rectangle wall = { .along = along, .up = v3(0, 1, 0), .width = side_length };
        wall.corner = v3_mad(v3_mad(centre, -half, along), -half, in);
        wall.height = rise > 0 ? rise : -rise;
        if (rise < 0) { // seen from within
            wall.corner =
                v3_mad(v3_mad(wall.corner, (float)side_length, along), (float)rise, wall.up);
            wall.along = v3_neg(along);
        }
        RSV_TRY(add_rectangle(m, wall));
        along = in;
        in = v3(along.z, 0, -along.x);
    }
cleanup:
    return status;
}

static rsv_status add_block(terraces *t, uint32_t block)
{
    rsv_status status;
    uint32_t random = rsv_hash(block + 1);
    int steps = FEWEST_STEPS + (int)(random % (MOST_STEPS - FEWEST_STEPS + 1));
    int rise = random >> 16 & 1 ? RISE : -RISE; // a pyramid or a well
    growing_mesh *m = &t->mesh[(random >> 8) % MATERIALS];
    rsv_vec3 centre = v3(((float)(block % t->blocks_along) + 0.5f) * BLOCK, 0,
        -((float)(block / t->blocks_along) + 0.5f) * BLOCK);
    int outer = BLOCK, inner = BLOCK - 2 * STREET;
    for (int step = 0; step < steps; step++) {
        RSV_TRY(add_ring(m, centre, outer, inner));
        RSV_TRY(add_walls(m, centre, inner, rise));
        centre.y += (float)rise;
        outer = inner;
        inner = outer - 2 * TREAD;
    }
    float half = 0.5f * (float)outer;
    rsv_vec3 corner = v3(centre.x - half, centre.y, centre.z + half);
    RSV_TRY(add_rectangle(m, (rectangle){ corner, v3(1, 0, 0), v3(0, 0, -1), outer, outer }));
cleanup:
    return status;
}

static size_t triangle_count(const terraces *t)
{
    size_t count = 0;
    for (int k = 0; k < MATERIALS; k++)
        count += t->mesh[k].index_count / 3;
    return count;
}

/// Adds blocks, row by row of about as many as there will be rows, until they hold enough triangles.
static rsv_status grow(terraces *t, double triangles)
{
    static const double block_triangles = 4300;
    rsv_status status = RSV_OK;
    t->blocks_along = (uint32_t)ceil(sqrt(triangles / block_triangles));
    for (uint32_t block = 0; (double)triangle_count(t) < triangles - block_triangles / 2; block++)
        RSV_TRY(add_block(t, block));
cleanup:
    return status;
}

static rsv_status add_meshes(rsv_scene *scene, const terraces *t)
{
    static const char *const name[MATERIALS] = { "sandstone", "brick", "plaster" };
    static const rsv_rgb albedo[MATERIALS] = { { 0.62f, 0.5f, 0.34f }, { 0.5f, 0.22f, 0.15f },
        { 0.76f, 0.74f, 0.7f } };
    rsv_status status = RSV_OK;
    for (int k = 0; k < MATERIALS; k++) {
        const growing_mesh *m = &t->mesh[k];
        if (m->index_count == 0) continue;
        uint32_t id;
        rsv_mesh_desc mesh = { .size = sizeof mesh,
            .name = name[k],
            .positions = m->position,
            .normals = m->normal,
            .vertex_count = m->vertex_count,
            .indices = m->index,
            .triangle_count = m->index_count / 3 };
        RSV_TRY(rsv_add_lambert(scene, name[k], albedo[k], rgb_gray(0), &mesh.material));
        RSV_TRY(rsv_scene_add_mesh(scene, &mesh, &id));
        RSV_TRY(rsv_scene_add_instance(scene, id, NULL, name[k]));
    }
cleanup:
    return status;
}

static rsv_status add_sun_and_camera(rsv_scene *scene)
{
    rsv_status status;
    rsv_punctual_light sun = { .name = "sun",
        .kind = RSV_PUNCTUAL_DIRECTIONAL,
        .direction = v3_normalize(v3(-0.7f, -0.62f, -0.25f)),
        .intensity = { 4, 3.7f, 3.2f } };
    RSV_TRY(rsv_scene_add_light(scene, &sun));
    rsv_camera camera =
        rsv_camera_look_at("hill", v3(-3, 7, 4), v3(9, 0, -10), 50 * RSV_PI / 180, 16.0f / 9);
    RSV_TRY(rsv_scene_add_camera(scene, &camera));
cleanup:
    return status;
}

rsv_status rsv_build_terraces(rsv_scene *scene, double triangles)
{
    rsv_status status;
    terraces t = { 0 };
    for (int k = 0; k < MATERIALS; k++)
        t.mesh[k].context = scene->context;
    RSV_TRY(grow(&t, triangles));
    RSV_TRY(add_meshes(scene, &t));
    RSV_TRY(add_sun_and_camera(scene));
cleanup:
    for (int k = 0; k < MATERIALS; k++) {
        rsv_free(scene->context, t.mesh[k].position);
        rsv_free(scene->context, t.mesh[k].normal);
        rsv_free(scene->context, t.mesh[k].index);
    }
    return status;
}
