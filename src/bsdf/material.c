#include "vary_body.h"

/// 1/m of a colour channel that nothing passes.
#define OPAQUE_ABSORPTION 1e9f

static float absorption(float color, float distance)
{
    if (!(distance < INFINITY) || color >= 1) return 0;
    if (color <= 0 || distance <= 0) return OPAQUE_ABSORPTION;
    return f_min(-logf(color) / distance, OPAQUE_ABSORPTION);
}

static rsv_bsdf unlit_bsdf(const rsv_material *material)
{
    return (rsv_bsdf){ .emission = material->base_color,
        .entry_scale = { 1, 1, 1 },
        .ior = 1,
        .diffuse = 1,
        .opacity = material->opacity,
        .camera_emission = material->camera_emission,
        .double_sided = material->double_sided,
        .lambert = true,
        .unlit = true };
}

static float interface_ior(float ior) { return ior < RSV_LEAST_IOR ? 1 : f_min(ior, RSV_MOST_IOR); }

rsv_bsdf rsv_bsdf_from_material(const rsv_material *material)
{
    if (material->unlit) return unlit_bsdf(material);
    rsv_bsdf bsdf = { .ior = interface_ior(material->ior),
        .opacity = material->opacity,
        .camera_emission = material->camera_emission,
        .tables = &rsv_bsdf_tables_data };
    bsdf.smooth_mean = (float)rsv_fresnel_dielectric_mean(bsdf.ior);
    bsdf.eta_place = rsv_table_eta(bsdf.ior);
    bsdf.clearcoat_eta_place = rsv_table_eta(RSV_CLEARCOAT_IOR);
    bsdf.solid = material->thickness > 0 && material->transmission > 0 && material->metallic < 1;
    bsdf.straight = bsdf.solid && bsdf.ior == 1;
    bsdf.double_sided = material->double_sided || bsdf.solid;
    if (bsdf.solid && !bsdf.straight) bsdf.dispersion = f_min(material->dispersion, 1e6f) / 20;
    if (bsdf.solid) bsdf.opacity = 1; // a body has no holes
    if (bsdf.solid) {
        float distance = material->attenuation_distance;
        bsdf.absorption = rgb(absorption(material->attenuation_color.r, distance),
            absorption(material->attenuation_color.g, distance),
            absorption(material->attenuation_color.b, distance));
    }
    rsv_bsdf varied;
    rsv_bsdf_vary(&bsdf, material, &varied);
    return varied;
}
