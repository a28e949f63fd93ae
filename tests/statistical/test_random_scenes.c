/// Random materials and rooms: what every mode of rendering shows of them.
#include "builtin/shapes.h"
#include "resolvent/render.h"
#include "resolvent/solve.h"
#include "unit/random_scene.h"
#include "unit/scene_fixture.h"
#include "unit/slow_tests.h"

#include <stdlib.h>

static rsv_scene *begin_scene(fixture *f)
{
    rsv_scene *scene;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    return scene;
}

// ---- the scenes themselves ----------------------------------------------------------------------

static uint64_t hash_of(const void *data, size_t bytes, uint64_t hash)
{
    const uint8_t *byte = data;
    for (size_t k = 0; k < bytes; k++)
        hash = (hash ^ byte[k]) * 0x100000001b3ull;
    return hash;
}

static uint64_t hash_of_scene(const rsv_scene *scene)
{
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    uint64_t hash = 0xcbf29ce484222325ull;
    hash = hash_of(view->position, view->vertex_count * sizeof *view->position, hash);
    for (size_t k = 0; k < view->material_count; k++)
        hash = hash_of(view->material[k].name, strlen(view->material[k].name), hash);
    return hash;
}

/// Another seed is another scene, the same seed the same; and no part of them is warned of.
static void a_seed_names_a_scene(void **state)
{
    fixture *f = *state;
    uint64_t hash[2][8];
    for (int again = 0; again < 2; again++)
        for (uint32_t seed = 0; seed < 8; seed++) {
            rsv_scene *scene = begin_scene(f);
            assert_int_equal(random_room(scene, seed), RSV_OK);
            hash[again][seed] = hash_of_scene(scene);
            rsv_scene_destroy(scene);
        }
    assert_memory_equal(hash[0], hash[1], sizeof hash[0]);
    for (int k = 1; k < 8; k++)
        assert_true(hash[0][k] != hash[0][k - 1]);
    rsv_scene *scene = begin_scene(f);
    assert_int_equal(random_furnace(scene, 0, 20), RSV_OK);
    assert_int_equal(rsv_scene_get_view(scene)->camera_count, 20);
    rsv_scene_destroy(scene);
    assert_string_equal(f->log, "");
}

#define SAMPLES 16

static const char *const mode_name[] = { "operator", "final", "reference" };

/// Where a picture is taken, how large, and with how many camera rays per pixel.
typedef struct shot {
    uint32_t camera, width, height, samples;
} shot;

/// A picture with other random numbers for each seed.
static rsv_image *picture(const rsv_scene *scene, const rsv_light *solution, shot from,
    rsv_render_mode mode, uint32_t seed)
{
    rsv_render_desc desc = rsv_default_render_desc();
    rsv_image *image;
    desc.width = from.width;
    desc.height = from.height;
    desc.samples = from.samples;
    desc.camera = from.camera;
    desc.mode = mode;
    desc.seed = seed;
    if (mode == RSV_RENDER_REFERENCE)
        assert_int_equal(rsv_render_reference(scene, &desc, &image, NULL), RSV_OK);
    else
        assert_int_equal(rsv_render(solution, &desc, &image), RSV_OK);
    return image;
}

typedef struct moments {
    double mean, error;
} moments;

/// Sums over pixels.
typedef struct sums {
    double value, squares, count;
} sums;

static void add_value(sums *s, double value)
{
    s->value += value;
    s->squares += value * value;
    s->count += 1;
}

static moments moments_of(const sums *s)
{
    double mean = s->value / s->count;
    double variance = fmax(s->squares / s->count - mean * mean, 0);
    return (moments){ mean, sqrt(variance / (s->count - 1)) };
}

static double value_at(const rsv_image *image, uint32_t x, uint32_t y)
{
    const rsv_rgb *pixels = rsv_image_const_pixels(image, 0);
    return (double)rgb_luminance(pixels[y * rsv_image_width(image) + x]);
}

// ---- furnaces -----------------------------------------------------------------------------------

#define MEAN_TOLERANCE 3e-3
#define FURNACE_ELEMENTS 1500
#define PIXEL_TOLERANCE 1e-2

/// A block of pixels of two pictures of what should be 1.
typedef struct block {
    moments mean;   ///< of the pixels of both
    moments square; ///< of the error that a pixel has in both, squared
} block;

static block block_of(
    rsv_image *const image[2], uint32_t x, uint32_t y, uint32_t width, uint32_t height)
{
    sums mean = { 0 }, square = { 0 };
    for (uint32_t k = 0; k < width * height; k++) {
        double a = value_at(image[0], x + k % width, y + k / width) - 1;
        double b = value_at(image[1], x + k % width, y + k / width) - 1;
        add_value(&mean, 1 + (a + b) / 2);
        add_value(&square, a * b);
    }
    return (block){ moments_of(&mean), moments_of(&square) };
}

static bool is_one(const block *b)
{
    return fabs(b->mean.mean - 1) <= MEAN_TOLERANCE + 3 * b->mean.error &&
           b->square.mean <= PIXEL_TOLERANCE * PIXEL_TOLERANCE + 4 * b->square.error;
}

static void say_block(const char *what, uint32_t number, int mode, const block *b)
{
    print_message("%s %u, %s: %.4f +- %.4f, pixels are off by %.4f%s\n", what, number,
        mode_name[mode], b->mean.mean, b->mean.error, sqrt(fmax(b->square.mean, 0)),
        is_one(b) ? "" : " WRONG");
}

/// What the k-th camera sees in all modes. @return how many are wrong
static uint32_t check_shot(
    const rsv_scene *scene, const rsv_light *solution, const char *what, uint32_t k)
{
    uint32_t wrong = 0;
    const shot seen = { k, 16, 16, SAMPLES };
    for (int mode = RSV_RENDER_OPERATOR; mode <= RSV_RENDER_REFERENCE; mode++) {
        rsv_image *image[2];
        for (uint32_t n = 0; n < 2; n++)
            image[n] = picture(scene, solution, seen, (rsv_render_mode)mode, n);
        block b = block_of(image, 0, 0, seen.width, seen.height);
        say_block(what, k, mode, &b);
        wrong += !is_one(&b);
        rsv_image_destroy(image[0]);
        rsv_image_destroy(image[1]);
    }
    return wrong;
}

static uint32_t check_pair(const rsv_scene *scene, const rsv_light *solution, uint32_t pair)
{
    uint32_t wrong = check_shot(scene, solution, "pair", pair);
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    for (size_t k = 2 * pair; k < 2 * pair + 2 && wrong; k++)
        print_message("    %s\n", view->material[k].name);
    return wrong;
}

/// @return how many pictures are wrong
static uint32_t look_at_furnace(fixture *f, uint32_t seed, uint32_t pairs)
{
    rsv_scene *scene = begin_scene(f);
    rsv_light *solution;
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    solve.element_target = FURNACE_ELEMENTS;
    uint32_t wrong = 0;
    assert_int_equal(random_furnace(scene, seed, pairs), RSV_OK);
    assert_int_equal(rsv_light_create(scene, &solve, &solution), RSV_OK);
    print_message("furnace %u\n", seed);
    for (uint32_t pair = 0; pair < pairs; pair++)
        wrong += check_pair(scene, solution, pair);
    rsv_light_destroy(solution);
    rsv_scene_destroy(scene);
    return wrong;
}

static void check_furnace(fixture *f, uint32_t seed, uint32_t pairs)
{
    assert_int_equal(look_at_furnace(f, seed, pairs), 0);
}

static void lossless_things_cannot_be_seen(void **state) { check_furnace(*state, 0, 6); }

static void many_lossless_things_cannot_be_seen(void **state)
{
    for (uint32_t seed = 1; seed <= 10; seed++)
        check_furnace(*state, seed, 20);
}

// ---- pairs of slots -----------------------------------------------------------------------------

static const rsv_texture_role slot[] = { RSV_TEXTURE_METALLIC_ROUGHNESS, RSV_TEXTURE_SPECULAR,
    RSV_TEXTURE_SPECULAR_COLOR, RSV_TEXTURE_TRANSMISSION, RSV_TEXTURE_CLEARCOAT,
    RSV_TEXTURE_CLEARCOAT_ROUGHNESS, RSV_TEXTURE_SHEEN_COLOR, RSV_TEXTURE_SHEEN_ROUGHNESS,
    RSV_TEXTURE_DIFFUSE_TRANSMISSION, RSV_TEXTURE_OPACITY, RSV_TEXTURE_IRIDESCENCE_THICKNESS };
#define SLOTS (sizeof slot / sizeof *slot)
#define PLATES (SLOTS * (SLOTS + 1) / 2)
#define PLATES_ABREAST 8
#define PLATE_ROWS ((PLATES - 1) / PLATES_ABREAST + 1)
#define PLATE_PITCH 1.25f ///< metres from plate to plate
#define PLATE_PIXELS 8    ///< of its height

/// White, with all that the slots vary.
static rsv_material material_with(rsv_texture_role a, rsv_texture_role b)
{
    rsv_material m = rsv_default_material();
    bool all[RSV_TEXTURE_ROLE_COUNT] = { false };
    all[a] = all[b] = true;
    m.ior = 2;
    m.double_sided = true;
    m.metallic = all[RSV_TEXTURE_METALLIC_ROUGHNESS] && a != b ? 0.5f : 0;
    m.transmission = all[RSV_TEXTURE_TRANSMISSION];
    m.clearcoat = all[RSV_TEXTURE_CLEARCOAT] || all[RSV_TEXTURE_CLEARCOAT_ROUGHNESS];
    m.clearcoat_roughness = 1;
    if (all[RSV_TEXTURE_SHEEN_COLOR] || all[RSV_TEXTURE_SHEEN_ROUGHNESS])
        m.sheen_color = rgb_gray(0.9f);
    m.sheen_roughness = 1;
    m.diffuse_transmission = all[RSV_TEXTURE_DIFFUSE_TRANSMISSION];
    m.iridescence = all[RSV_TEXTURE_IRIDESCENCE_THICKNESS];
    m.iridescence_thickness_min = 0;
    return m;
}

/// Where something with two textured slots lies, and whether it is a ball.
typedef struct specimen {
    rsv_texture_role slot[2];
    rsv_vec3 at; ///< its left front corner
    bool ball;
} specimen;

static void add_plate(rsv_scene *scene, uint32_t material, rsv_vec3 at)
{
    static const float uv[4][2] = { { 0, 0 }, { 1, 0 }, { 1, 1 }, { 0, 1 } };
    static const uint32_t index[6] = { 0, 1, 2, 0, 2, 3 };
    const rsv_vec3 corner[4] = { at, v3(at.x + 1, at.y, at.z), v3(at.x + 1, at.y, at.z - 1),
        v3(at.x, at.y, at.z - 1) };
    uint32_t mesh;
    const rsv_mesh_desc desc = { .size = sizeof desc,
        .positions = corner,
        .vertex_count = 4,
        .indices = index,
        .triangle_count = 2,
        .material = material,
        .uvs = { uv, NULL } };
    assert_int_equal(rsv_scene_add_mesh(scene, &desc, &mesh), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(scene, mesh, NULL, NULL), RSV_OK);
}

/// One slot is 0 on the left and 1 on the right, another is 0 in front and 1 behind.
static void add_specimen(rsv_scene *scene, uint32_t texture, const specimen *s)
{
    rsv_texture_ref ref[2] = { rsv_default_texture_ref(s->slot[0], texture),
        rsv_default_texture_ref(s->slot[1], texture) };
    rsv_material m = material_with(s->slot[0], s->slot[1]);
    uint32_t material;
    ref[1].transform[0][0] = ref[1].transform[1][1] = 0;
    ref[1].transform[0][1] = ref[1].transform[1][0] = 1;
    m.textures = ref;
    m.texture_count = s->slot[0] == s->slot[1] ? 1 : 2;
    assert_int_equal(rsv_scene_add_material(scene, &m, &material), RSV_OK);
    rsv_vec3 centre = v3(s->at.x + 0.5f, s->at.y, s->at.z - 0.5f);
    if (s->ball)
        assert_int_equal(textured_ball(scene, material, centre, 0.5f), RSV_OK);
    else
        add_plate(scene, material, s->at);
}

static uint32_t add_halves(rsv_scene *scene)
{
    static const float half[2][4] = { { 0, 0, 0, 0 }, { 1, 1, 1, 1 } };
    const rsv_texture_desc desc = { .size = sizeof desc,
        .width = 2,
        .height = 1,
        .channel_count = 4,
        .values = half[0],
        .nearest = true,
        .wrap_u = RSV_WRAP_CLAMP,
        .wrap_v = RSV_WRAP_CLAMP };
    uint32_t texture;
    assert_int_equal(rsv_scene_add_texture(scene, &desc, &texture), RSV_OK);
    return texture;
}

/// Plates or balls of all pairs of slots, and a camera far away that looks down at them: row by row, each in a block of
/// pixels. @param down sine of the angle below the horizontal
static void add_specimens(rsv_scene *scene, bool balls, float down)
{
    uint32_t texture = add_halves(scene), count = 0;
    for (size_t a = 0; a < SLOTS; a++)
        for (size_t b = a; b < SLOTS; b++, count++) {
            float x = (float)(count % PLATES_ABREAST), z = (float)(count / PLATES_ABREAST);
            specimen s = { { slot[a], slot[b] },
                v3(PLATE_PITCH * x + 0.125f, 0, PLATE_PITCH * z + 1.125f), balls };
            add_specimen(scene, texture, &s);
        }
    const float depth = PLATE_PITCH * PLATE_ROWS;
    rsv_vec3 forward = v3(0, -down, -sqrtf(1 - down * down)), right = v3(1, 0, 0);
    rsv_vec3 centre = v3(0.5f * PLATE_PITCH * PLATES_ABREAST, 0, 0.5f * depth);
    rsv_camera camera = { .name = "eye",
        .position = v3_mad(centre, -20, forward),
        .right = right,
        .up = v3_cross(right, forward),
        .forward = forward,
        .vertical_extent = 0.5f * down * depth };
    assert_int_equal(rsv_scene_add_camera(scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_set_builtin_environment(scene, "white", 1, 0), RSV_OK);
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
}

static uint32_t check_plates(const rsv_scene *scene, const rsv_light *solution, int mode)
{
    const shot seen = { 0, PLATES_ABREAST * 2 * PLATE_PIXELS, PLATE_ROWS * PLATE_PIXELS, SAMPLES };
    rsv_image *image[2];
    uint32_t wrong = 0, count = 0;
    for (uint32_t k = 0; k < 2; k++)
        image[k] = picture(scene, solution, seen, (rsv_render_mode)mode, k);
    for (size_t a = 0; a < SLOTS; a++)
        for (size_t b = a; b < SLOTS; b++, count++) {
            uint32_t x = count % PLATES_ABREAST, y = count / PLATES_ABREAST;
            block found = block_of(
                image, 2 * PLATE_PIXELS * x, PLATE_PIXELS * y, 2 * PLATE_PIXELS, PLATE_PIXELS);
            if (is_one(&found)) continue;
            print_message("slots %d and %d: ", (int)slot[a], (int)slot[b]);
            say_block("plate", count, mode, &found);
            wrong++;
        }
    rsv_image_destroy(image[0]);
    rsv_image_destroy(image[1]);
    return wrong;
}

static void check_specimens(fixture *f, bool balls, float down)
{
    rsv_scene *scene = begin_scene(f);
    rsv_light *solution;
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    solve.element_target = FURNACE_ELEMENTS;
    uint32_t wrong = 0;
    add_specimens(scene, balls, down);
    assert_int_equal(rsv_light_create(scene, &solve, &solution), RSV_OK);
    for (int mode = RSV_RENDER_OPERATOR; mode <= RSV_RENDER_REFERENCE; mode++)
        wrong += check_plates(scene, solution, mode);
    rsv_light_destroy(solution);
    rsv_scene_destroy(scene);
    assert_int_equal(wrong, 0);
}

/// What one texel's layers keep back of the light must not be given to another's.
static void no_pair_of_textures_can_be_seen(void **state) { check_specimens(*state, false, 0.5f); }

static void no_pair_of_textures_can_be_seen_at_a_glance(void **state)
{
    check_specimens(*state, false, 0.1f);
}

static void no_pair_of_textures_can_be_seen_on_balls(void **state)
{
    check_specimens(*state, true, 1);
}

// ---- at the ends of the ranges ------------------------------------------------------------------

/// What glTF's KHR_materials_ior calls 0.
#define ENDLESS_IOR 1000

static rsv_material extreme_material(uint32_t kind)
{
    rsv_material m = rsv_default_material();
    m.roughness = 0.5f;
    switch (kind) {
    case 0:
        m.ior = ENDLESS_IOR;
        break;
    case 1:
        m.ior = ENDLESS_IOR;
        m.roughness = 0;
        m.clearcoat = 1;
        break;
    case 2:
    case 3:
    case 4:
        m.ior = kind == 2 ? 1 : kind == 3 ? 1.004f : 1.05f;
        m.transmission = m.thickness = 1;
        break;
    case 5:
        m.ior = 1;
        m.transmission = m.thickness = 1;
        m.metallic = 0.5f;
        break;
    case 6:
        m.double_sided = true;
        m.diffuse_transmission = 1;
        break;
    default:
        m.double_sided = true;
        m.diffuse_transmission = 1;
        m.roughness = 0;
        m.transmission = 0.3f;
        m.sheen_color = rgb_gray(1);
        m.sheen_roughness = 0.7f;
        break;
    }
    return m;
}
#define EXTREMES 8

static void extremes_cannot_be_seen(void **state)
{
    rsv_scene *scene = begin_scene(*state);
    rsv_light *solution;
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    solve.element_target = FURNACE_ELEMENTS;
    uint32_t wrong = 0;
    for (uint32_t k = 0; k < EXTREMES; k++) {
        rsv_material m = extreme_material(k);
        uint32_t id;
        assert_int_equal(rsv_scene_add_material(scene, &m, &id), RSV_OK);
        rsv_vec3 at = v3(4 * (float)k, 0, 0);
        assert_int_equal(rsv_add_sphere((rsv_shape){ scene, "ball", id, NULL }, at, 1, 2), RSV_OK);
        rsv_camera camera = rsv_camera_look_at("eye", v3(at.x, 0, 4), at, 0.6f, 1);
        assert_int_equal(rsv_scene_add_camera(scene, &camera), RSV_OK);
    }
    assert_int_equal(rsv_scene_set_builtin_environment(scene, "white", 1, 0), RSV_OK);
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    assert_int_equal(rsv_light_create(scene, &solve, &solution), RSV_OK);
    for (uint32_t k = 0; k < EXTREMES; k++)
        wrong += check_shot(scene, solution, "extreme", k);
    rsv_light_destroy(solution);
    rsv_scene_destroy(scene);
    assert_int_equal(wrong, 0);
}

// ---- bent normals -------------------------------------------------------------------------------

#define BEND 0.7f ///< sine of the tilt of all normals

/// A plate whose normal map tilts all normals alike, seen from above.
static void add_bent_plate(rsv_scene *scene)
{
    static const float texel[4] = { 0.5f + 0.5f * BEND, 0.5f, 0.857071f, 1 };
    static const float uv[4][2] = { { 0, 0 }, { 1, 0 }, { 1, 1 }, { 0, 1 } };
    static const uint32_t index[6] = { 0, 1, 2, 0, 2, 3 };
    const rsv_vec3 corner[4] = { v3(-1, 0, 1), v3(1, 0, 1), v3(1, 0, -1), v3(-1, 0, -1) };
    const rsv_texture_desc texture = { .size = sizeof texture,
        .name = "bent",
        .width = 1,
        .height = 1,
        .channel_count = 4,
        .values = texel };
    rsv_texture_ref ref = rsv_default_texture_ref(RSV_TEXTURE_NORMAL, 0);
    rsv_material m = rsv_default_material();
    uint32_t mesh;
    m.specular = 0;
    m.texture_count = 1;
    m.textures = &ref;
    assert_int_equal(rsv_scene_add_texture(scene, &texture, &ref.texture), RSV_OK);
    rsv_mesh_desc desc = { .size = sizeof desc,
        .positions = corner,
        .vertex_count = 4,
        .indices = index,
        .triangle_count = 2,
        .uvs = { uv, NULL } };
    assert_int_equal(rsv_scene_add_material(scene, &m, &desc.material), RSV_OK);
    assert_int_equal(rsv_scene_add_mesh(scene, &desc, &mesh), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(scene, mesh, NULL, NULL), RSV_OK);
    rsv_camera camera = rsv_camera_look_at("eye", v3(0, 3, 0.1f), v3(0, 0, 0), 0.3f, 1);
    assert_int_equal(rsv_scene_add_camera(scene, &camera), RSV_OK);
}

/// What each mode shows of the bent plate. @param seen the expected value
static void check_bent_plate(rsv_scene *scene, double seen)
{
    rsv_light *solution;
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    solve.element_target = FURNACE_ELEMENTS;
    assert_int_equal(rsv_light_create(scene, &solve, &solution), RSV_OK);
    for (int mode = RSV_RENDER_OPERATOR; mode <= RSV_RENDER_REFERENCE; mode++) {
        rsv_image *image =
            picture(scene, solution, (shot){ 0, 16, 16, SAMPLES }, (rsv_render_mode)mode, 0);
        sums mean = { 0 };
        for (uint32_t k = 0; k < 256; k++)
            add_value(&mean, value_at(image, k % 16, k / 16));
        moments found = moments_of(&mean);
        print_message(
            "%s: %.4f +- %.4f, right: %.4f\n", mode_name[mode], found.mean, found.error, seen);
        assert_true(fabs(found.mean - seen) < MEAN_TOLERANCE + 3 * found.error);
        rsv_image_destroy(image);
    }
    rsv_light_destroy(solution);
}

/// With a uniform sky, a normal tilted by t receives (1 + cos t) / 2.
static void bent_normals_receive_what_they_see(void **state)
{
    rsv_scene *scene = begin_scene(*state);
    add_bent_plate(scene);
    assert_int_equal(rsv_scene_set_builtin_environment(scene, "white", 1, 0), RSV_OK);
    check_bent_plate(scene, (1 + sqrt(1 - (double)BEND * BEND)) / 2);
    rsv_scene_destroy(scene);
}

/// With a sun at the zenith, it receives cos t, also where light is stored.
static void bent_normals_receive_a_sun(void **state)
{
    rsv_scene *scene = begin_scene(*state);
    const rsv_punctual_light sun = { .name = "sun",
        .kind = RSV_PUNCTUAL_DIRECTIONAL,
        .direction = { 0, -1, 0 },
        .intensity = { RSV_PI, RSV_PI, RSV_PI } };
    add_bent_plate(scene);
    assert_int_equal(rsv_scene_add_light(scene, &sun), RSV_OK);
    check_bent_plate(scene, sqrt(1 - (double)BEND * BEND));
    rsv_scene_destroy(scene);
}

// ---- rooms --------------------------------------------------------------------------------------

#define ROOM_PIXELS 32 ///< along an edge of a picture
#define ROOM_BLOCKS 4  ///< of them likewise
#define ROOM_MEAN_TOLERANCE 1e-2
#define ROOM_BLOCK_TOLERANCE 2e-2

/// Two pictures of one mode, which differ by chance alone.
typedef struct twins {
    rsv_image *image[2];
} twins;

static twins take_twins(
    const rsv_scene *scene, const rsv_light *solution, int mode, uint32_t samples)
{
    const shot seen = { 0, ROOM_PIXELS, ROOM_PIXELS, samples };
    twins t;
    for (uint32_t k = 0; k < 2; k++)
        t.image[k] = picture(scene, solution, seen, (rsv_render_mode)mode, k);
    return t;
}

static void drop_twins(const twins *t)
{
    rsv_image_destroy(t->image[0]);
    rsv_image_destroy(t->image[1]);
}

/// Mean of a square of pixels of both, and its noise as the two differ.
static moments mean_of_square(const twins *t, uint32_t x, uint32_t y, uint32_t size)
{
    double sum = 0, squares = 0, count = size * size;
    for (uint32_t k = 0; k < size * size; k++) {
        double a = value_at(t->image[0], x + k % size, y + k / size);
        double b = value_at(t->image[1], x + k % size, y + k / size);
        sum += a + b;
        squares += (a - b) * (a - b);
    }
    return (moments){ sum / (2 * count), sqrt(squares) / (2 * count) };
}

/// By how many standard errors two means differ more than is tolerated; 0 = no more.
static double excess(moments found, moments expected, double tolerated)
{
    double difference = fabs(found.mean - expected.mean) - tolerated;
    double error = hypot(found.error, expected.error);
    return difference > 0 ? difference / fmax(error, 1e-9) : 0;
}

/// The path tracer's pictures of a room. If rare paths carry much of the light, pictures with few samples usually miss
/// them, and then their noise is underestimated too. Deviations are therefore checked again with many samples.
typedef struct judge {
    const rsv_scene *scene;
    twins few, many;
    bool asked; ///< for many
    double mean;
} judge;

#define MANY_SAMPLES (64 * SAMPLES)

static judge begin_judge(const rsv_scene *scene)
{
    judge j = { .scene = scene, .few = take_twins(scene, NULL, RSV_RENDER_REFERENCE, SAMPLES) };
    j.mean = mean_of_square(&j.few, 0, 0, ROOM_PIXELS).mean;
    return j;
}

static void end_judge(const judge *j)
{
    drop_twins(&j->few);
    if (j->asked) drop_twins(&j->many);
}

static const twins *many_paths(judge *j)
{
    if (!j->asked) j->many = take_twins(j->scene, NULL, RSV_RENDER_REFERENCE, MANY_SAMPLES);
    j->asked = true;
    return &j->many;
}

/// Where a picture is looked at, and what is tolerated there.
typedef struct square {
    uint32_t x, y, size;
    double
        tolerance; ///< of the mean; of a fifth of the picture's where that is more: what is all but black
} square;

/// As `excess`. @param expected out: what it should be
static double judge_square(judge *j, const twins *found, square at, moments *expected)
{
    moments is = mean_of_square(found, at.x, at.y, at.size);
    double z = 0;
    for (int careful = 0; careful < 2 && (!careful || z > 4); careful++) {
        *expected = mean_of_square(careful ? many_paths(j) : &j->few, at.x, at.y, at.size);
        z = excess(is, *expected, at.tolerance * fmax(expected->mean, 0.2 * j->mean));
    }
    return z;
}

static uint32_t judge_blocks(judge *j, const twins *found)
{
    const uint32_t size = ROOM_PIXELS / ROOM_BLOCKS;
    uint32_t wrong = 0;
    for (uint32_t k = 0; k < ROOM_BLOCKS * ROOM_BLOCKS; k++) {
        square at = { k % ROOM_BLOCKS * size, k / ROOM_BLOCKS * size, size, ROOM_BLOCK_TOLERANCE };
        moments b, a = mean_of_square(found, at.x, at.y, size);
        double z = judge_square(j, found, at, &b);
        if (z <= 4) continue;
        print_message("    block %u %u: %.3g, reference %.3g, %.1f sigma beyond 2 %%\n",
            k % ROOM_BLOCKS, k / ROOM_BLOCKS, a.mean, b.mean, z);
        wrong++;
    }
    return wrong;
}

static uint32_t judge_mode(judge *j, const rsv_light *solution, uint32_t seed, int mode)
{
    twins t = take_twins(j->scene, solution, mode, SAMPLES);
    moments expected, found = mean_of_square(&t, 0, 0, ROOM_PIXELS);
    double z = judge_square(j, &t, (square){ 0, 0, ROOM_PIXELS, ROOM_MEAN_TOLERANCE }, &expected);
    print_message("room %u, %s: %.4g +- %.1g, reference %.4g +- %.1g%s\n", seed, mode_name[mode],
        found.mean, found.error, expected.mean, expected.error, z > 4 ? " WRONG" : "");
    uint32_t wrong = (z > 4) + judge_blocks(j, &t);
    drop_twins(&t);
    return wrong;
}

/// @return whether anything is wrong
static bool check_room(fixture *f, uint32_t seed)
{
    rsv_scene *scene = begin_scene(f);
    rsv_light *solution;
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    uint32_t wrong = 0;
    solve.photon_count = 100000;
    assert_int_equal(random_room(scene, seed), RSV_OK);
    assert_int_equal(rsv_light_create(scene, &solve, &solution), RSV_OK);
    judge j = begin_judge(scene);
    for (int mode = RSV_RENDER_OPERATOR; mode <= RSV_RENDER_FINAL; mode++)
        wrong += judge_mode(&j, solution, seed, mode);
    end_judge(&j);
    rsv_light_destroy(solution);
    rsv_scene_destroy(scene);
    return wrong > 0;
}

static void check_rooms(fixture *f, uint32_t first, uint32_t count)
{
    uint32_t wrong = 0;
    for (uint32_t seed = first; seed < first + count; seed++)
        wrong += check_room(f, seed);
    print_message("%u of %u rooms are wrong somewhere\n", wrong, count);
    assert_int_equal(wrong, 0);
}

static void rooms_are_as_the_path_tracer_sees_them(void **state) { check_rooms(*state, 1, 1); }

static void many_rooms_are_as_the_path_tracer_sees_them(void **state)
{
    check_rooms(*state, 0, 100);
}

#define SCENE_TEST(test) cmocka_unit_test_setup_teardown(test, fixture_setup, fixture_teardown)

/// `rooms FIRST COUNT`: runs only these, and continues after failures.
static int look_at_rooms(char **argv)
{
    void *state = NULL;
    fixture_setup(&state);
    for (uint32_t seed = (uint32_t)atoi(argv[0]), k = 0; k < (uint32_t)atoi(argv[1]); k++)
        check_room(state, seed + k);
    return fixture_teardown(&state);
}

/// `furnaces FIRST COUNT` likewise.
static int look_at_furnaces(char **argv)
{
    void *state = NULL;
    fixture_setup(&state);
    for (uint32_t seed = (uint32_t)atoi(argv[0]), k = 0; k < (uint32_t)atoi(argv[1]); k++)
        look_at_furnace(state, seed + k, 20);
    return fixture_teardown(&state);
}

int main(int argc, char **argv)
{
    if (argc == 4 && strcmp(argv[1], "furnaces") == 0) return look_at_furnaces(argv + 2);
    if (argc == 4 && strcmp(argv[1], "rooms") == 0) return look_at_rooms(argv + 2);
    const struct CMUnitTest quick[] = {
        SCENE_TEST(a_seed_names_a_scene),
        SCENE_TEST(no_pair_of_textures_can_be_seen),
        SCENE_TEST(no_pair_of_textures_can_be_seen_at_a_glance),
        SCENE_TEST(extremes_cannot_be_seen),
        SCENE_TEST(bent_normals_receive_what_they_see),
        SCENE_TEST(bent_normals_receive_a_sun),
        SCENE_TEST(lossless_things_cannot_be_seen),
    };
    const struct CMUnitTest slow[] = {
        SCENE_TEST(rooms_are_as_the_path_tracer_sees_them),
    };
    const struct CMUnitTest longest[] = {
        SCENE_TEST(no_pair_of_textures_can_be_seen_on_balls),
        SCENE_TEST(many_lossless_things_cannot_be_seen),
        SCENE_TEST(many_rooms_are_as_the_path_tracer_sees_them),
    };
    return RUN_THIRD(argc, argv, quick, slow, longest);
}
