/// Built-in scenes around one body: a dragon or a head where a mesh of one is given.
#include "body.h"
#include "builtin.h"

#define GAP 1e-4f // a hair above what it stands on: they do not touch

static rsv_status build_cornell_body(
    rsv_scene *scene, const rsv_builtin_desc *desc, const rsv_material *material)
{
    rsv_status status;
    rsv_body body = { .name = material->name,
        .given = desc->body,
        .stand_in = rsv_sculpture_knot(),
        .triangles = desc->body_triangles,
        .foot = { -0.276f, GAP, -0.28f },
        .size = { 0.4f, 0.36f, 0.36f } };
    RSV_TRY(rsv_build_cornell_box(scene));
    RSV_TRY(rsv_scene_add_material(scene, material, &body.material));
    RSV_TRY(rsv_add_body(scene, &body));
cleanup:
    return status;
}

static rsv_material glass_material(void)
{
    rsv_material glass = rsv_default_material();
    glass.name = "glass";
    glass.roughness = 0;
    glass.transmission = 1;
    glass.thickness = 0.1f;
    return glass;
}

rsv_status rsv_build_cornell_glass(rsv_scene *scene, const rsv_builtin_desc *desc)
{
    rsv_material glass = glass_material();
    return build_cornell_body(scene, desc, &glass);
}

rsv_status rsv_build_cornell_marble(rsv_scene *scene, const rsv_builtin_desc *desc)
{
    rsv_material marble;
    rsv_material_preset("marble", &marble);
    marble.name = "marble";
    marble.roughness = 0.1f;
    return build_cornell_body(scene, desc, &marble);
}

static rsv_material plaster_material(void)
{
    rsv_material plaster = rsv_default_material();
    plaster.name = "plaster";
    plaster.base_color = rgb(0.725f, 0.71f, 0.68f);
    plaster.specular = 0;
    return plaster;
}

rsv_status rsv_build_cornell_plaster(rsv_scene *scene, const rsv_builtin_desc *desc)
{
    rsv_material plaster = plaster_material();
    return build_cornell_body(scene, desc, &plaster);
}

/// Two glass spheres before a body of plaster.
rsv_status rsv_build_cornell_showcase(rsv_scene *scene, const rsv_builtin_desc *desc)
{
    const float radius = 0.09f;
    const rsv_vec3 centre[2] = { { -0.15f, radius + GAP, -0.12f },
        { -0.4f, radius + GAP, -0.12f } };
    rsv_status status;
    uint32_t glass;
    rsv_material plaster = plaster_material(), clear = glass_material();
    rsv_body body = { .name = plaster.name,
        .given = desc->body,
        .stand_in = rsv_sculpture_knot(),
        .triangles = desc->body_triangles,
        .foot = { -0.276f, GAP, -0.38f },
        .size = { 0.34f, 0.3f, 0.28f } };
    RSV_TRY(rsv_build_cornell_box(scene));
    RSV_TRY(rsv_scene_add_material(scene, &plaster, &body.material));
    RSV_TRY(rsv_scene_add_material(scene, &clear, &glass));
    RSV_TRY(rsv_add_body(scene, &body));
    for (int k = 0; k < 2; k++)
        RSV_TRY(rsv_add_sphere(
            (rsv_shape){ scene, "glass sphere", glass, NULL }, centre[k], radius, 5));
cleanup:
    return status;
}

/// Measured skin under the thin film of oil that skin has.
static rsv_status add_skin(rsv_scene *scene, uint32_t *id)
{
    rsv_material skin;
    rsv_material_preset("skin2", &skin);
    skin.name = "skin";
    skin.roughness = 0.45f;
    skin.ior = 1.4f;
    return rsv_scene_add_material(scene, &skin, id);
}

rsv_status rsv_build_character(rsv_scene *scene, const rsv_builtin_desc *desc)
{
    rsv_status status;
    uint32_t stone;
    rsv_body body = { .name = "head",
        .given = desc->body,
        .stand_in = rsv_sculpture_bust(),
        .triangles = desc->body_triangles,
        .foot = { 0, GAP, 0 },
        .size = { 0.5f, 0.46f, 0.4f } };
    RSV_TRY(rsv_add_lambert(scene, "stone", rgb_gray(0.3f), rgb_gray(0), &stone));
    RSV_TRY(rsv_add_box((rsv_shape){ scene, "pedestal", stone, NULL }, v3(-0.17f, -0.6f, -0.12f),
        v3(0.17f, 0, 0.12f)));
    RSV_TRY(add_skin(scene, &body.material));
    RSV_TRY(rsv_add_body(scene, &body));
    rsv_camera camera = rsv_camera_look_at(
        "portrait", v3(0.25f, 0.32f, 1.25f), v3(0, 0.23f, 0), 26 * RSV_PI / 180, 1);
    RSV_TRY(rsv_scene_add_camera(scene, &camera));
cleanup:
    return status;
}
