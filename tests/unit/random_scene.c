#include "random_scene.h"

#include "core/sampling.h"
#include "core/vec.h"

#include <stdio.h>
#include <string.h>

// ---- chance -------------------------------------------------------------------------------------

static float between(rsv_random *random, float low, float high)
{
    return low + (high - low) * rsv_random_float(random);
}

static bool chance(rsv_random *random, float probability)
{
    return rsv_random_float(random) < probability;
}

static uint32_t below(rsv_random *random, uint32_t count)
{
    return (uint32_t)(rsv_random_float(random) * (float)count);
}

/// 0 or 1, or something between.
static float share(rsv_random *random, float of_nothing, float of_all)
{
    float x = rsv_random_float(random);
    if (x < of_nothing) return 0;
    return x < of_nothing + of_all ? 1 : rsv_random_float(random);
}

static rsv_rgb color_between(rsv_random *random, float low, float high)
{
    float r = between(random, low, high), g = between(random, low, high);
    return rgb(r, g, between(random, low, high));
}

// ---- textures -----------------------------------------------------------------------------------

#define MOST_TEXELS 16

typedef enum pattern { NOISE, HALVES, CHECKS, SPOTS, PATTERNS } pattern;

static float pattern_value(rsv_random *random, pattern kind, uint32_t x, uint32_t y, uint32_t width)
{
    float noise = rsv_random_float(random);
    switch (kind) {
    case HALVES:
        return 2 * x >= width ? 1 : 0;
    case CHECKS:
        return (float)((x + y) & 1);
    case SPOTS:
        return noise < 0.1f ? 1 : 0;
    default:
        return noise;
    }
}

/// @param floor least value of a texel
static rsv_status add_texture(rsv_scene *scene, rsv_random *random, float floor, uint32_t *id)
{
    float texel[MOST_TEXELS * MOST_TEXELS][4];
    rsv_texture_desc desc = { .size = sizeof desc,
        .name = "random",
        .width = 2 + below(random, MOST_TEXELS - 1),
        .height = 1 + below(random, MOST_TEXELS),
        .channel_count = 4,
        .values = texel[0],
        .wrap_u = (rsv_wrap)below(random, 3),
        .wrap_v = (rsv_wrap)below(random, 3),
        .nearest = chance(random, 0.5f) };
    pattern kind = (pattern)below(random, PATTERNS);
    if (kind == CHECKS) desc.width = desc.height = 2;
    for (uint32_t y = 0; y < desc.height; y++)
        for (uint32_t x = 0; x < desc.width; x++)
            for (int channel = 0; channel < 4; channel++)
                texel[y * desc.width + x][channel] =
                    f_max(pattern_value(random, kind, x, y, desc.width), floor);
    return rsv_scene_add_texture(scene, &desc, id);
}

// ---- materials ----------------------------------------------------------------------------------

#define MATT_ROUGHNESS 0.3f

/// A material in the making.
typedef struct maker {
    rsv_scene *scene;
    rsv_random random;
    random_material_choice choice;
    rsv_material m;
    bool open; ///< light gets through
    rsv_texture_ref ref[RSV_TEXTURE_ROLE_COUNT];
} maker;

static void choose_base(maker *k)
{
    rsv_random *random = &k->random;
    static const float ior[] = { 1.5f, 1.5f, 1.5f, 1.33f, 1, 2, 2.8f, 1000 };
    k->m.base_color = k->choice.lossless ? rgb_gray(1) : color_between(random, 0.1f, 0.8f);
    k->m.metallic = share(random, 0.6f, 0.2f);
    k->m.roughness = share(random, 0.15f, 0.2f);
    k->m.ior = ior[below(random, sizeof ior / sizeof *ior)];
    k->m.specular = share(random, 0.2f, 0.6f);
    if (chance(random, 0.3f)) k->m.specular_color = color_between(random, 0, 1);
    if (k->choice.matt) k->m.roughness = f_max(k->m.roughness, MATT_ROUGHNESS);
}

static void choose_layers(maker *k)
{
    rsv_random *random = &k->random;
    k->m.iridescence = share(random, 0.7f, 0.2f);
    k->m.iridescence_ior = between(random, 1, 2.5f);
    k->m.iridescence_thickness_max = between(random, 100, 1200);
    if (!k->choice.matt) k->m.anisotropy = share(random, 0.7f, 0.1f);
    k->m.anisotropy_rotation = between(random, -3, 3);
    k->m.clearcoat = share(random, 0.6f, 0.2f);
    k->m.clearcoat_roughness = share(random, 0.4f, 0.1f);
    if (k->choice.matt) k->m.clearcoat_roughness = f_max(k->m.clearcoat_roughness, MATT_ROUGHNESS);
    if (!chance(random, 0.4f)) return;
    k->m.sheen_color = chance(random, 0.3f) ? rgb_gray(1) : color_between(random, 0, 1);
    k->m.sheen_roughness = rsv_random_float(random);
}

/// Light that passes: through sheets, through bodies, or through partial coverage.
static void choose_passage(maker *k)
{
    rsv_random *random = &k->random;
    k->m.double_sided = !k->choice.body || (!k->choice.lossless && chance(random, 0.5f));
    if (k->choice.opaque) return;
    k->m.transmission = share(random, 0.6f, 0.2f);
    if (chance(random, 0.3f)) {
        k->m.diffuse_transmission = share(random, 0, 0.3f);
        if (!k->choice.lossless)
            k->m.diffuse_transmission_color = color_between(random, 0.1f, 0.8f);
    }
    bool solid = k->choice.body && k->m.transmission > 0 && chance(random, 0.5f);
    if (solid) {
        k->m.thickness = 1;
        k->m.dispersion = share(random, 0.6f, 0.2f);
        k->m.metallic = 0;
        k->m.transmission = 1;            // the rest would be black inside
        k->m.ior = f_min(k->m.ior, 2.8f); // light must get out again
        if (!k->choice.lossless && chance(random, 0.5f)) {
            k->m.attenuation_color = color_between(random, 0.3f, 1);
            k->m.attenuation_distance = between(random, 0.1f, 1);
        }
        return;
    }
    if (chance(random, 0.15f)) k->m.opacity = rsv_random_float(random);
    if (chance(random, 0.1f)) k->m.alpha_cutoff = 0.5f;
    // the inside must look white, too; a closed inside would be a lossless cavity
    k->open = k->m.transmission > 0 || k->m.diffuse_transmission > 0 || k->m.opacity < 1;
    if (k->open) k->m.double_sided = true;
}

/// Least value of the role's texels, or -1 where it must have no texture.
static float least_texel(const maker *k, rsv_texture_role role)
{
    const rsv_material *m = &k->m;
    bool rough = role == RSV_TEXTURE_METALLIC_ROUGHNESS || role == RSV_TEXTURE_CLEARCOAT_ROUGHNESS;
    if (role == RSV_TEXTURE_EMISSION) return -1;
    if (role == RSV_TEXTURE_TRANSMISSION && m->thickness > 0) return -1;
    if (role == RSV_TEXTURE_OPACITY && (k->choice.opaque || m->thickness > 0)) return -1;
    if (role == RSV_TEXTURE_OPACITY && !k->open && !m->double_sided) return -1;
    if (rough && k->choice.matt) return -1;
    if (!k->choice.lossless) return 0;
    bool colours = role == RSV_TEXTURE_BASE_COLOR || role == RSV_TEXTURE_DIFFUSE_TRANSMISSION_COLOR;
    // a bent normal sends light below the surface
    return colours || role == RSV_TEXTURE_NORMAL ? -1 : 0;
}

static rsv_status add_textures(maker *k)
{
    rsv_status status = RSV_OK;
    float share_of_slots = chance(&k->random, 0.15f) ? 1 : between(&k->random, 0, 0.6f);
    for (int role = 0; role < RSV_TEXTURE_ROLE_COUNT && status == RSV_OK; role++) {
        float floor = least_texel(k, (rsv_texture_role)role);
        if (!chance(&k->random, share_of_slots) || floor < 0) continue;
        uint32_t texture;
        status = add_texture(k->scene, &k->random, floor, &texture);
        rsv_texture_ref *ref = &k->ref[k->m.texture_count++];
        *ref = rsv_default_texture_ref((rsv_texture_role)role, texture);
        ref->transform[0][0] = between(&k->random, 0.3f, 2);
        ref->transform[1][1] = between(&k->random, 0.3f, 2);
        ref->transform[1][0] = between(&k->random, -0.3f, 0.3f);
        ref->transform[0][2] = 0.2f * rsv_random_float(&k->random);
        if (role == RSV_TEXTURE_NORMAL) ref->scale = between(&k->random, 0, 0.3f);
    }
    k->m.textures = k->ref;
    return status;
}

static void say(char *words, size_t size, const char *what, float value)
{
    size_t used = strlen(words);
    if (value > 0) snprintf(words + used, size - used, ", %s %.3g", what, (double)value);
}

static void describe(const rsv_material *m, uint32_t seed, char *words, size_t size)
{
    snprintf(words, size, "random %u: roughness %.3g, ior %.4g", seed, (double)m->roughness,
        (double)m->ior);
    say(words, size, "specular", m->specular);
    say(words, size, "metallic", m->metallic);
    say(words, size, "thin film", m->iridescence);
    say(words, size, "anisotropy", m->anisotropy);
    say(words, size, "transmission", m->transmission);
    say(words, size, "thickness", m->thickness);
    say(words, size, "diffuse transmission", m->diffuse_transmission);
    say(words, size, "clearcoat", m->clearcoat);
    say(words, size, "of roughness", m->clearcoat > 0 ? m->clearcoat_roughness : 0);
    say(words, size, "sheen", rgb_max(m->sheen_color));
    say(words, size, "of roughness", rgb_max(m->sheen_color) > 0 ? m->sheen_roughness : 0);
    say(words, size, "gap", 1 - m->opacity);
    say(words, size, "cut at", m->alpha_cutoff);
    strncat(words, ", textures:", size - strlen(words) - 1);
    for (size_t k = 0; k < m->texture_count; k++) {
        size_t used = strlen(words);
        snprintf(words + used, size - used, " %d", (int)m->textures[k].role);
    }
}

rsv_status random_material(
    rsv_scene *scene, uint32_t seed, random_material_choice choice, uint32_t *id)
{
    char words[512];
    maker k = { .scene = scene,
        .random = rsv_random_from(seed, 0x6d61u, 0),
        .choice = choice,
        .m = rsv_default_material() };
    choose_base(&k);
    choose_layers(&k);
    choose_passage(&k);
    rsv_status status = add_textures(&k);
    if (status != RSV_OK) return status;
    describe(&k.m, seed, words, sizeof words);
    k.m.name = words;
    return rsv_scene_add_material(scene, &k.m, id);
}

// ---- bodies -------------------------------------------------------------------------------------

static rsv_status add_mesh(rsv_scene *scene, const rsv_mesh_desc *mesh)
{
    uint32_t id;
    rsv_status status = rsv_scene_add_mesh(scene, mesh, &id);
    return status == RSV_OK ? rsv_scene_add_instance(scene, id, NULL, NULL) : status;
}

/// The front is where the corners appear counter-clockwise.
static rsv_status add_quad(rsv_scene *scene, uint32_t material, const rsv_vec3 corner[4])
{
    static const float uv[4][2] = { { 0, 1 }, { 1, 1 }, { 1, 0 }, { 0, 0 } };
    static const uint32_t index[6] = { 0, 1, 2, 0, 2, 3 };
    return add_mesh(scene, &(rsv_mesh_desc){ .size = sizeof(rsv_mesh_desc),
                               .name = "quad",
                               .positions = corner,
                               .vertex_count = 4,
                               .indices = index,
                               .triangle_count = 2,
                               .material = material,
                               .uvs = { uv, NULL } });
}

/// One of a box's sides by axis (0..2) and end (0, 1).
static void set_side(
    rsv_vec3 low, rsv_vec3 high, int axis, int end, bool inwards, rsv_vec3 corner[4])
{
    const float a[2][3] = { { low.x, low.y, low.z }, { high.x, high.y, high.z } };
    int u = (axis + 1) % 3, v = (axis + 2) % 3;
    bool turn = (end == 0) != inwards;
    for (int k = 0; k < 4; k++) {
        int along = turn ? 3 - k : k;
        float p[3];
        p[axis] = a[end][axis];
        p[u] = a[along == 1 || along == 2][u];
        p[v] = a[along >= 2][v];
        corner[k] = v3(p[0], p[1], p[2]);
    }
}

static rsv_status add_box(rsv_scene *scene, uint32_t material, rsv_vec3 low, rsv_vec3 high)
{
    rsv_vec3 corner[24];
    float uv[24][2];
    uint32_t index[36];
    for (uint32_t side = 0; side < 6; side++) {
        set_side(low, high, (int)side / 2, (int)side % 2, false, corner + 4 * side);
        for (uint32_t k = 0; k < 4; k++) {
            uv[4 * side + k][0] = k == 1 || k == 2 ? 1 : 0;
            uv[4 * side + k][1] = k >= 2 ? 1 : 0;
        }
        for (uint32_t k = 0; k < 6; k++)
            index[6 * side + k] = 4 * side + (k < 3 ? k : k == 3 ? 0 : k - 2);
    }
    return add_mesh(scene, &(rsv_mesh_desc){ .size = sizeof(rsv_mesh_desc),
                               .name = "box",
                               .positions = corner,
                               .vertex_count = 24,
                               .indices = index,
                               .triangle_count = 12,
                               .material = material,
                               .uvs = { (const float(*)[2])uv, NULL } });
}

#define TURNS 24
#define RINGS 12

rsv_status textured_ball(rsv_scene *scene, uint32_t material, rsv_vec3 centre, float radius)
{
    enum { COLUMNS = TURNS + 1, VERTICES = COLUMNS * (RINGS + 1) };
    rsv_vec3 position[VERTICES], normal[VERTICES];
    float uv[VERTICES][2];
    uint32_t index[6 * TURNS * RINGS], count = 0;
    for (uint32_t ring = 0; ring <= RINGS; ring++)
        for (uint32_t turn = 0; turn < COLUMNS; turn++) {
            uint32_t n = ring * COLUMNS + turn;
            float theta = RSV_PI * (float)ring / RINGS;
            float phi = 2 * RSV_PI * (float)(turn % TURNS) / TURNS;
            float sin = ring % RINGS ? sinf(theta) : 0;
            normal[n] = v3(sin * cosf(phi), cosf(theta), sin * sinf(phi));
            position[n] = v3_mad(centre, radius, normal[n]);
            uv[n][0] = (float)turn / TURNS;
            uv[n][1] = (float)ring / RINGS;
        }
    for (uint32_t ring = 0; ring < RINGS; ring++)
        for (uint32_t turn = 0; turn < TURNS; turn++) {
            uint32_t a = ring * COLUMNS + turn, b = a + COLUMNS;
            const uint32_t corner[6] = { a, a + 1, b, a + 1, b + 1, b };
            for (uint32_t k = ring ? 0 : 3; k < (ring + 1 < RINGS ? 6 : 3); k++)
                index[count++] = corner[k];
        }
    return add_mesh(scene, &(rsv_mesh_desc){ .size = sizeof(rsv_mesh_desc),
                               .name = "ball",
                               .positions = position,
                               .normals = normal,
                               .vertex_count = VERTICES,
                               .indices = index,
                               .triangle_count = count / 3,
                               .material = material,
                               .uvs = { (const float(*)[2])uv, NULL } });
}

// ---- the furnace --------------------------------------------------------------------------------

/// The k-th plate and the ball above it, and the camera that looks at them.
static rsv_status add_pair(rsv_scene *scene, uint32_t seed, uint32_t k)
{
    rsv_status status;
    uint32_t plate, ball;
    float x = 5 * (float)k;
    const rsv_vec3 corner[4] = { v3(x - 1, 0, 1), v3(x + 1, 0, 1), v3(x + 1, 0, -1),
        v3(x - 1, 0, -1) };
    RSV_TRY(random_material(
        scene, rsv_hash3(seed, 1, k), (random_material_choice){ .lossless = true }, &plate));
    RSV_TRY(random_material(scene, rsv_hash3(seed, 2, k),
        (random_material_choice){ .lossless = true, .body = true }, &ball));
    RSV_TRY(add_quad(scene, plate, corner));
    RSV_TRY(textured_ball(scene, ball, v3(x + 0.2f, 0.6f, 0), 0.4f));
    rsv_camera camera =
        rsv_camera_look_at("eye", v3(x + 0.3f, 1.1f, 2.2f), v3(x, 0.25f, 0), 0.9f, 1);
    RSV_TRY(rsv_scene_add_camera(scene, &camera));
cleanup:
    return status;
}

rsv_status random_furnace(rsv_scene *scene, uint32_t seed, uint32_t pairs)
{
    rsv_status status;
    for (uint32_t k = 0; k < pairs; k++)
        RSV_TRY(add_pair(scene, seed, k));
    RSV_TRY(rsv_scene_set_builtin_environment(scene, "white", 1, 0));
    RSV_TRY(rsv_scene_commit(scene));
cleanup:
    return status;
}

// ---- rooms --------------------------------------------------------------------------------------

typedef struct room {
    rsv_scene *scene;
    rsv_random random;
    uint32_t seed, materials;
    rsv_vec3 low, high;
    bool matt; ///< there are sources without an area
    bool open;
} room;

static rsv_status next_material(room *r, bool body, bool opaque, uint32_t *id)
{
    random_material_choice choice = { .body = body, .matt = r->matt, .opaque = opaque };
    return random_material(r->scene, rsv_hash3(r->seed, 3, r->materials++), choice, id);
}

static rsv_status add_walls(room *r)
{
    rsv_status status = RSV_OK;
    uint32_t gap = r->open ? 1 + below(&r->random, 5) : 6;
    if (gap == 2) gap = 3; // never the floor
    for (uint32_t side = 0; side < 6 && status == RSV_OK; side++) {
        rsv_vec3 corner[4];
        uint32_t material;
        status = next_material(r, false, true, &material);
        if (side == gap || status != RSV_OK) continue;
        set_side(r->low, r->high, (int)side / 2, (int)side % 2, true, corner);
        status = add_quad(r->scene, material, corner);
    }
    return status;
}

/// A card on edge, lying or slanting.
static rsv_status add_card(room *r, uint32_t material, rsv_vec3 centre, float size)
{
    rsv_vec3 n = rsv_square_to_sphere(rsv_random_float(&r->random), rsv_random_float(&r->random));
    rsv_vec3 t, b, corner[4];
    v3_frame(n, &t, &b);
    t = v3_scale(t, size);
    b = v3_scale(b, size);
    corner[0] = v3_sub(v3_sub(centre, t), b);
    corner[1] = v3_sub(v3_add(centre, t), b);
    corner[2] = v3_add(v3_add(centre, t), b);
    corner[3] = v3_add(v3_sub(centre, t), b);
    return add_quad(r->scene, material, corner);
}

/// One piece in the middle of a cell of the floor, on it or above.
static rsv_status add_piece(room *r, rsv_vec3 centre, float reach)
{
    uint32_t kind = below(&r->random, 3), material;
    bool lies = chance(&r->random, 0.6f);
    float size = reach * between(&r->random, 0.5f, 0.95f);
    rsv_status status = next_material(r, kind != 2, false, &material);
    if (status != RSV_OK) return status;
    float tall = kind == 0 ? size * between(&r->random, 0.3f, 1.5f) : size;
    centre.y = r->low.y + (lies && kind != 2 ? 0 : between(&r->random, 0.1f, 0.4f)) + tall;
    rsv_vec3 half = v3(size * between(&r->random, 0.4f, 1), tall, size);
    if (kind == 0) return add_box(r->scene, material, v3_sub(centre, half), v3_add(centre, half));
    if (kind == 1) return textured_ball(r->scene, material, centre, size);
    return add_card(r, material, centre, 0.7f * size);
}

static rsv_status furnish(room *r)
{
    rsv_status status = RSV_OK;
    uint32_t wanted = 3 + below(&r->random, 4), first = below(&r->random, 9);
    float x = (r->high.x - r->low.x) / 3, z = (r->high.z - r->low.z) / 3;
    for (uint32_t k = 0; k < wanted && status == RSV_OK; k++) {
        uint32_t cell = (first + 3 * k) % 8; // the camera is in the last
        rsv_vec3 centre = v3(r->low.x + ((float)(cell % 3) + 0.5f) * x, 0,
            r->low.z + ((float)(cell / 3) + 0.5f) * z);
        status = add_piece(r, centre, 0.45f * f_min(f_min(x, z), (r->high.y - r->low.y) / 3));
    }
    return status;
}

static rsv_status add_lamp(room *r)
{
    rsv_material lamp = rsv_default_material();
    rsv_texture_ref ref;
    rsv_status status = RSV_OK;
    lamp.name = "lamp";
    lamp.specular = 0;
    lamp.base_color = rgb_gray(0.5f);
    lamp.emission = color_between(&r->random, 2, 8);
    lamp.double_sided = chance(&r->random, 0.5f);
    if (chance(&r->random, 0.3f)) {
        uint32_t texture;
        status = add_texture(r->scene, &r->random, 0.2f, &texture);
        ref = rsv_default_texture_ref(RSV_TEXTURE_EMISSION, texture);
        lamp.textures = &ref;
        lamp.texture_count = 1;
    }
    uint32_t material;
    if (status == RSV_OK) status = rsv_scene_add_material(r->scene, &lamp, &material);
    if (status != RSV_OK) return status;
    float y = r->high.y - between(&r->random, 0.02f, 0.2f);
    float x = between(&r->random, 0.15f, 0.4f) * (r->high.x - r->low.x);
    float z = between(&r->random, 0.15f, 0.4f) * (r->high.z - r->low.z);
    const rsv_vec3 corner[4] = { v3(-x, y, -z), v3(x, y, -z), v3(x, y, z), v3(-x, y, z) };
    return add_quad(r->scene, material, corner);
}

static rsv_status add_light(room *r)
{
    rsv_random *random = &r->random;
    rsv_punctual_light light = { .name = "light",
        .kind = (rsv_punctual_light_kind)below(random, r->open ? 3 : 2) };
    rsv_vec3 size = v3_sub(r->high, r->low);
    light.position = v3(between(random, -0.3f, 0.3f) * size.x, r->low.y + 0.85f * size.y,
        between(random, -0.3f, 0.3f) * size.z);
    light.direction =
        v3_normalize(v3(between(random, -0.5f, 0.5f), -1, between(random, -0.5f, 0.5f)));
    light.intensity = color_between(random, 2, 8);
    light.inner_cone_angle = between(random, 0, 0.5f);
    light.outer_cone_angle = light.inner_cone_angle + between(random, 0.1f, 0.8f);
    return rsv_scene_add_light(r->scene, &light);
}

static rsv_status add_sources(room *r)
{
    rsv_status status = RSV_OK;
    bool white = chance(&r->random, 0.5f);
    if (r->open)
        status = rsv_scene_set_builtin_environment(
            r->scene, white || !r->matt ? "white" : "sky", between(&r->random, 0.5f, 1), 0);
    if (status == RSV_OK && (!r->matt || chance(&r->random, 0.5f))) status = add_lamp(r);
    if (status == RSV_OK && r->matt) status = add_light(r);
    if (status == RSV_OK && r->matt && chance(&r->random, 0.4f)) status = add_light(r);
    return status;
}

rsv_status random_room(rsv_scene *scene, uint32_t seed)
{
    room r = { .scene = scene, .random = rsv_random_from(seed, 0x726fu, 1), .seed = seed };
    rsv_status status;
    rsv_vec3 half = v3(between(&r.random, 1.2f, 2.5f), between(&r.random, 1, 1.5f),
        between(&r.random, 1.2f, 2.5f));
    r.low = v3_neg(half);
    r.high = half;
    r.matt = chance(&r.random, 0.4f);
    r.open = chance(&r.random, 0.4f);
    RSV_TRY(add_walls(&r));
    RSV_TRY(furnish(&r));
    RSV_TRY(add_sources(&r));
    rsv_vec3 eye = v3(0.8f * half.x, 0.3f * half.y, 0.9f * half.z);
    rsv_camera camera =
        rsv_camera_look_at("eye", eye, v3(-0.3f * half.x, -0.5f * half.y, -half.z), 1.3f, 1);
    RSV_TRY(rsv_scene_add_camera(scene, &camera));
    RSV_TRY(rsv_scene_commit(scene));
cleanup:
    return status;
}
