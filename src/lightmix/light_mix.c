/// Pictures as sums over sources: light transport, pixels included, is linear in its sources.
#include "../core/descriptor.h"
#include "../core/parallel.h"
#include "../relight/relight_responses.h"
#include "resolvent/frame.h"
#include "resolvent/lightmix.h"

#include <string.h>

#define MOST_BYTES ((size_t)512 << 20)

/// The picture of sources whose factors have always been equal.
typedef struct mix_part {
    rsv_image *image; ///< with factors of 1; NULL = not rendered
} mix_part;

struct rsv_light_mix {
    rsv_context *context;
    rsv_relighter *r;
    rsv_render_desc picture;
    rsv_light_settings kept; ///< settings of the pictures, without factors
    size_t source_count, part_count;
    uint32_t replacements;
    uint32_t *part_of;       ///< [source_count]
    mix_part *part;          ///< [source_count], part_count of them in use
    rsv_rgb *scale, *wanted; ///< [source_count]
    bool is_unlit;           ///< there are unlit surfaces
    rsv_image *dark;         ///< unlit surfaces only; NULL = not rendered
    size_t rendered;
};

// ---- stored pictures -----------------------------------------------------------------------------

static bool same_color(rsv_rgb a, rsv_rgb b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

static bool same_place(rsv_vec3 a, rsv_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

/// Whether nothing but factors has changed since the pictures were rendered.
static bool holds(const rsv_light_mix *m)
{
    const rsv_light_settings *now = &m->r->now;
    bool same = m->part_count > 0 && m->source_count == m->r->basis->source_count &&
                m->replacements == m->r->replacements && m->kept.rotation == now->rotation;
    for (size_t k = 0; k < m->source_count && same; k++)
        same = same_place(m->kept.offset[k], now->offset[k]);
    for (size_t k = 0; k < m->r->scene->material_count && same; k++)
        same = same_color(m->kept.base_color[k], now->base_color[k]);
    return same;
}

static void drop_pictures(rsv_light_mix *m)
{
    for (size_t p = 0; p < m->part_count; p++)
        rsv_image_destroy(m->part[p].image);
    rsv_image_destroy(m->dark);
    m->dark = NULL;
    m->part_count = 0;
}

static void free_sources(rsv_light_mix *m)
{
    rsv_light_settings_free(m->context, &m->kept);
    rsv_free(m->context, m->part_of);
    rsv_free(m->context, m->part);
    rsv_free(m->context, m->scale);
    rsv_free(m->context, m->wanted);
    m->part_of = NULL;
    m->part = NULL;
    m->scale = m->wanted = NULL;
}

/// Lights may have been added.
static rsv_status allocate_sources(rsv_light_mix *m)
{
    size_t count = m->r->basis->source_count;
    free_sources(m);
    m->source_count = count;
    m->part_of = rsv_alloc(m->context, count, sizeof *m->part_of);
    m->part = rsv_alloc(m->context, count, sizeof *m->part);
    m->scale = rsv_alloc(m->context, count, sizeof *m->scale);
    m->wanted = rsv_alloc(m->context, count, sizeof *m->wanted);
    if (!m->part_of || !m->part || !m->scale || !m->wanted) return RSV_ERROR_MEMORY;
    return rsv_light_settings_allocate(m->context, count, m->r->scene->material_count, &m->kept);
}

/// All sources as one part, as places and colours are now.
static rsv_status start_over(rsv_light_mix *m)
{
    const rsv_light_settings *now = &m->r->now;
    drop_pictures(m);
    rsv_status status = allocate_sources(m);
    if (status != RSV_OK) return status;
    m->replacements = m->r->replacements;
    m->kept.rotation = now->rotation;
    memcpy(m->kept.offset, now->offset, m->source_count * sizeof *now->offset);
    memcpy(
        m->kept.base_color, now->base_color, m->r->scene->material_count * sizeof *now->base_color);
    m->part_count = m->source_count > 0;
    return RSV_OK;
}

static size_t first_of(const rsv_light_mix *m, size_t part)
{
    size_t k = 0;
    while (m->part_of[k] != part)
        k++;
    return k;
}

static rsv_rgb factor_of(const rsv_light_mix *m, size_t part)
{
    return m->r->now.scale[first_of(m, part)];
}

/// Moves sources whose factor is not that of the part's first one to a part of their own. @return whether there are any
static bool split(rsv_light_mix *m, size_t p)
{
    rsv_rgb factor = factor_of(m, p);
    bool any = false;
    for (size_t k = 0; k < m->source_count; k++) {
        if (m->part_of[k] != p || same_color(m->r->now.scale[k], factor)) continue;
        m->part_of[k] = (uint32_t)m->part_count;
        any = true;
    }
    if (!any) return false;
    rsv_image_destroy(m->part[p].image);
    m->part[p].image = NULL;
    m->part_count++;
    return true;
}

// ---- pictures -------------------------------------------------------------------------------------

/// Parts with different random numbers add up to less noise, but unlit surfaces, which all of them show, must cancel.
static uint32_t seed_of(const rsv_light_mix *m, uint32_t part)
{
    return m->is_unlit || part == 0 ? m->picture.seed : rsv_hash2(m->picture.seed, part);
}

static rsv_status render(rsv_light_mix *m, uint32_t part, rsv_image **image)
{
    rsv_relighter *r = m->r;
    rsv_render_desc desc = m->picture;
    rsv_status status = RSV_OK;
    desc.seed = seed_of(m, part);
    if (!r->responses || r->s->diffused.elements) status = rsv_relighter_settle(r);
    if (status != RSV_OK) return status;
    m->rendered++;
    return desc.mode == RSV_RENDER_OPERATOR
               ? rsv_render_operator(r->light, &desc, RSV_GLOSS_PATHS, image)
               : rsv_render(r->light, &desc, image);
}

/// Renders the sources of a part alone, at their original strength. @param part RSV_NONE = without any source
static rsv_status render_part(rsv_light_mix *m, uint32_t part, uint32_t seed, rsv_image **image)
{
    for (size_t k = 0; k < m->source_count; k++)
        m->scale[k] = rgb_gray(m->part_of[k] == part);
    rsv_status status = rsv_relighter_scale(m->r, m->scale);
    return status == RSV_OK ? render(m, seed, image) : status;
}

/// Renders the missing pictures, and restores the light.
static rsv_status complete(rsv_light_mix *m)
{
    rsv_status status = RSV_OK;
    size_t before = m->rendered;
    memcpy(m->wanted, m->r->now.scale, m->source_count * sizeof *m->wanted);
    for (uint32_t p = 0; p < m->part_count; p++) {
        size_t first = first_of(m, p);
        if (m->part[p].image || rgb_is_black(m->wanted[first])) continue;
        RSV_TRY(render_part(m, p, (uint32_t)first, &m->part[p].image));
    }
    if (!m->dark && m->is_unlit) RSV_TRY(render_part(m, RSV_NONE, RSV_NONE, &m->dark));
    if (m->rendered > before) RSV_TRY(rsv_relighter_scale(m->r, m->wanted));
cleanup:
    return status;
}

/// Contribution of a part to the picture.
typedef struct addend {
    const rsv_rgb *part, *dark; ///< pixels; `dark` may be NULL
    rsv_rgb factor, *sum;
} addend;

static void add_pixels(void *job, rsv_span span)
{
    const addend *a = job;
    const rsv_rgb *restrict part = a->part, *restrict dark = a->dark;
    rsv_rgb factor = a->factor, *restrict sum = a->sum;
    for (size_t k = span.begin; k < span.end; k++) {
        rsv_rgb own = dark ? rgb_sub(part[k], dark[k]) : part[k];
        sum[k] = rgb_add(sum[k], rgb_mul(factor, own));
    }
}

static rsv_status add_up(const rsv_light_mix *m, rsv_image **image)
{
    size_t pixels = (size_t)m->picture.width * m->picture.height;
    rsv_status status = rsv_image_create(m->context, m->picture.width, m->picture.height, 1, image);
    if (status != RSV_OK) return status;
    rsv_rgb *sum = rsv_image_pixels(*image, 0);
    const rsv_rgb *dark = m->dark ? rsv_image_const_pixels(m->dark, 0) : NULL;
    if (dark) memcpy(sum, dark, pixels * sizeof *sum);
    for (size_t p = 0; p < m->part_count; p++) {
        if (!m->part[p].image) continue;
        addend a = { rsv_image_const_pixels(m->part[p].image, 0), dark, factor_of(m, p), sum };
        rsv_parallel_for(m->context, pixels, 0, add_pixels, &a);
    }
    for (size_t k = 0; dark && k < pixels; k++)
        sum[k] = rgb_positive(sum[k]);
    return RSV_OK;
}

rsv_status rsv_light_mix_take(rsv_light_mix *m, rsv_image **image)
{
    rsv_status status = holds(m) ? RSV_OK : start_over(m);
    if (status != RSV_OK) return status;
    for (size_t p = 0; p < m->part_count;)
        p += !split(m, p);
    size_t pixels = (size_t)m->picture.width * m->picture.height;
    if ((m->part_count + 1) * pixels * sizeof(rsv_rgb) > MOST_BYTES) {
        drop_pictures(m);
        return render(m, 0, image);
    }
    status = complete(m);
    return status == RSV_OK ? add_up(m, image) : status;
}

size_t rsv_light_mix_rendered(const rsv_light_mix *m) { return m->rendered; }

// ---- creation -------------------------------------------------------------------------------------

static bool shows_unlit(const rsv_scene *scene)
{
    bool any = false;
    for (size_t k = 0; k < scene->material_count; k++)
        any = any || scene->material[k].unlit;
    return any;
}

rsv_status rsv_light_mix_create(
    rsv_relighter *r, const rsv_render_desc *picture, rsv_light_mix **mix)
{
    rsv_render_desc settings = rsv_default_render_desc();
    rsv_status status = RSV_READ_DESC(rsv_render_desc, &settings, picture);
    if (status != RSV_OK) return status;
    bool is_solved = settings.mode == RSV_RENDER_FINAL || settings.mode == RSV_RENDER_OPERATOR;
    if (!is_solved || settings.layers)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "light mix: only modes final and operator are supported, and no layers");
    rsv_light_mix *m = rsv_alloc(r->context, 1, sizeof *m);
    if (!m) return RSV_ERROR_MEMORY;
    *m = (rsv_light_mix){
        .context = r->context, .r = r, .picture = settings, .is_unlit = shows_unlit(r->scene)
    };
    *mix = m;
    return RSV_OK;
}

void rsv_light_mix_destroy(rsv_light_mix *m)
{
    if (!m) return;
    drop_pictures(m);
    free_sources(m);
    rsv_free(m->context, m);
}
