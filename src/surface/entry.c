#include "entry.h"

bool rsv_coat_varies(const rsv_scene_view *scene, uint32_t material)
{
    const rsv_material *m = &scene->material[material];
    for (size_t k = 0; k < m->texture_count; k++)
        switch (m->textures[k].role) {
        case RSV_TEXTURE_BASE_COLOR:
        case RSV_TEXTURE_OPACITY:
        case RSV_TEXTURE_NORMAL:
        case RSV_TEXTURE_CLEARCOAT_NORMAL:
        case RSV_TEXTURE_EMISSION:
        case RSV_TEXTURE_TRANSMISSION:
        case RSV_TEXTURE_DIFFUSE_TRANSMISSION:
        case RSV_TEXTURE_DIFFUSE_TRANSMISSION_COLOR:
            break;
        default:
            return !m->unlit;
        }
    return false;
}

rsv_surface_entry rsv_surface_entry_of(uint32_t material)
{
    return (rsv_surface_entry){ .material = material };
}

/// The cosine of place k.
static float cosine(int k)
{
    float x = (float)k / (RSV_ENTRY_COS - 1);
    return x * x;
}

void rsv_surface_entry_add(rsv_surface_entry *entry, const rsv_scene_view *scene,
    const rsv_bsdf *common, uint32_t triangle, float u, float v)
{
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_surface_entry_bsdf(
        scene, common, (rsv_footprint){ triangle, u, v, 0, RSV_CHANNEL_ALL }, &storage);
    for (int k = 0; k < RSV_ENTRY_COS; k++)
        entry->mean[k] = rgb_add(entry->mean[k], rsv_bsdf_entry(bsdf, cosine(k)));
    entry->points++;
}

/// Mean over the hemisphere of values linear between the samples: 4 int f x^3 dx with x = sqrt(cos).
static rsv_rgb hemispherical_mean(const rsv_rgb mean[RSV_ENTRY_COS])
{
    rsv_rgb sum = rgb_gray(0);
    const float step = 1.0f / (RSV_ENTRY_COS - 1);
    for (int k = 0; k + 1 < RSV_ENTRY_COS; k++) {
        float a = (float)k * step, b = a + step;
        float whole = b * b * b * b - a * a * a * a;                  // 4 int x^3
        float first = 0.8f * (b * b * b * b * b - a * a * a * a * a); // 4 int x^4
        float high = (first - a * whole) / step;
        sum = rgb_mad(rgb_mad(sum, whole - high, mean[k]), high, mean[k + 1]);
    }
    return sum;
}

void rsv_surface_entry_finish(rsv_surface_entry *entry)
{
    if (!entry->points) return;
    rsv_rgb mean = hemispherical_mean(entry->mean);
    rsv_rgb scale =
        rgb(1 / f_max(mean.r, 1e-6f), 1 / f_max(mean.g, 1e-6f), 1 / f_max(mean.b, 1e-6f));
    for (int k = 0; k < RSV_ENTRY_COS; k++)
        entry->mean[k] = rgb_mul(entry->mean[k], scale);
}
