#include "caustic_judge.h"

#include "../direct/photon_turn.h"

/// A point is compared over the smallest part of its cell in which this many photons are expected.
#define ENOUGH_PHOTONS 16
#define CHILDREN 4
#define MIDDLE 3 ///< of the children; the others have the corner of their number

rsv_status rsv_caustic_judge_create(const rsv_light_view *s, rsv_caustic_judge *judge)
{
    const rsv_elements *e = s->caustics.elements;
    double area = 0;
    *judge = (rsv_caustic_judge){ .solution = s };
    judge->slot = rsv_alloc(s->context, e->cell_count, sizeof *judge->slot);
    if (!judge->slot) return RSV_ERROR_MEMORY;
    for (uint32_t c = 0; c < e->cell_count; c++) {
        judge->slot[c] = RSV_NONE;
        area += (double)rsv_cell_area(e, c);
    }
    judge->unit = fmax(s->report.mean_irradiance * area, 1e-30) * 0x1p-40;
    return RSV_OK;
}

void rsv_caustic_judge_destroy(rsv_caustic_judge *judge)
{
    if (!judge->solution) return;
    rsv_free(judge->solution->context, judge->slot);
    rsv_free(judge->solution->context, judge->cell);
    *judge = (rsv_caustic_judge){ 0 };
}

void rsv_caustic_judge_add(rsv_caustic_judge *judge, const rsv_face_point *p)
{
    float weight[3];
    uint32_t cell =
        rsv_elements_locate(judge->solution->caustics.elements, p->face, p->u, p->v, weight);
    if (judge->slot[cell] == RSV_NONE) judge->slot[cell] = judge->cell_count++;
}

/// Replaces barycentric weights in a triangle by those in the one of its four children that they lie in.
static int descend(float weight[3])
{
    for (int k = 0; k < MIDDLE; k++) {
        if (weight[k] < 0.5f) continue;
        for (int i = 0; i < 3; i++)
            weight[i] = 2 * weight[i] - (i == k ? 1 : 0);
        return k;
    }
    for (int i = 0; i < 3; i++)
        weight[i] = 1 - 2 * weight[i];
    return MIDDLE;
}

static void ascend(int child, double weight[3])
{
    for (int i = 0; i < 3; i++)
        weight[i] = child == MIDDLE ? (1 - weight[i]) / 2 : (weight[i] + (i == child ? 1 : 0)) / 2;
}

/// The part of a cell, the coarsest division in its highest digit.
static uint32_t part_of(const float weight[3])
{
    float rest[3] = { weight[0], weight[1], weight[2] };
    uint32_t part = 0;
    for (int level = 0; level < RSV_JUDGED_LEVELS; level++)
        part = CHILDREN * part + (uint32_t)descend(rest);
    return part;
}

/// One pass.
typedef struct counting {
    rsv_caustic_judge *judge;
    int pass;
    int64_t landed; ///< photons
    int64_t flux;   ///< luminance of all of them
} counting;

/// Part of the light that enters the surface, as for the photons of stored caustics.
static rsv_rgb entering(const rsv_light_view *s, const rsv_specular_path *path, rsv_rgb flux)
{
    rsv_vec3 shading, geometric;
    rsv_bsdf storage;
    rsv_specular_normals(&s->scene, path, &shading, &geometric);
    const rsv_bsdf *bsdf = rsv_specular_bsdf(&s->scene, path, &storage);
    rsv_rgb share = rsv_bsdf_entry(bsdf, -v3_dot(shading, path->direction));
    return rgb_mul(flux, rgb_scale(share, rsv_photon_tilt(shading, geometric, path->direction)));
}

static void land(void *user, size_t photon_slot, const rsv_specular_path *path, rsv_rgb flux)
{
    counting *c = user;
    (void)photon_slot; // sums of whole numbers are the same in any order
    const rsv_caustic_judge *judge = c->judge;
    const rsv_elements *e = judge->solution->caustics.elements;
    uint32_t face = e->face_of[path->back][path->triangle];
    float weight[3];
    if (face == RSV_NONE) return;
    rsv_rgb entered = entering(judge->solution, path, flux);
    rsv_add_atomically(&c->landed, 1);
    rsv_add_fixed(&c->flux, (double)rgb_luminance(entered) / judge->unit);
    uint32_t slot = judge->slot[rsv_elements_locate(e, face, path->u, path->v, weight)];
    if (slot == RSV_NONE) return;
    int64_t *sum = judge->cell[slot].flux[c->pass][part_of(weight)];
    rsv_add_fixed(&sum[0], (double)entered.r / judge->unit);
    rsv_add_fixed(&sum[1], (double)entered.g / judge->unit);
    rsv_add_fixed(&sum[2], (double)entered.b / judge->unit);
}

rsv_status rsv_caustic_judge_shoot(rsv_caustic_judge *judge, uint32_t seed, uint64_t *rays)
{
    const rsv_light_view *s = judge->solution;
    rsv_status status = RSV_OK;
    double landed = 0, flux = 0;
    judge->cell = rsv_alloc(s->context, judge->cell_count + 1, sizeof *judge->cell);
    if (!judge->cell) return RSV_ERROR_MEMORY;
    for (int pass = 0; pass < 2; pass++) {
        counting c = { judge, pass, 0, 0 };
        const rsv_photon_sink sink = { .user = &c, .land = land };
        RSV_TRY(rsv_photons_trace(&s->scene, s->lights, s->desc.photon_count,
            rsv_hash2(seed, (uint32_t)pass), &sink, rays));
        landed += (double)c.landed;
        flux += (double)c.flux * judge->unit;
    }
    judge->photons = flux > 0 ? landed / flux : 0;
cleanup:
    return status;
}

/// How often to split a cell around a point. @param expected photons in all of it
static int level_for(double expected)
{
    int level = 1; // in less than a quarter of a cell the noise of its nodes hardly differs
    while (level < RSV_JUDGED_LEVELS && expected >= ENOUGH_PHOTONS << 2 * (level + 1))
        level++;
    return level;
}

/// Mean of the stored caustic over the part of a cell with these leading digits.
static rsv_rgb stored_in(const rsv_light_view *s, uint32_t cell, uint32_t digits, int level)
{
    const uint32_t *node = s->caustics.elements->cell_node[cell];
    double weight[3] = { 1.0 / 3, 1.0 / 3, 1.0 / 3 };
    rsv_rgb sum = rgb_gray(0);
    for (int k = 0; k < level; k++, digits /= CHILDREN)
        ascend((int)(digits % CHILDREN), weight);
    for (int k = 0; k < 3; k++)
        sum = rgb_mad(sum, (float)weight[k], s->caustics.caustic[node[k]]);
    return sum;
}

static rsv_rgb brought(const rsv_caustic_judge *judge, const int64_t flux[RSV_JUDGED_PARTS][3],
    uint32_t first, uint32_t end)
{
    double sum[3] = { 0 };
    for (uint32_t part = first; part < end; part++)
        for (int c = 0; c < 3; c++)
            sum[c] += (double)flux[part][c] * judge->unit;
    return rgb((float)sum[0], (float)sum[1], (float)sum[2]);
}

void rsv_caustic_judge_at(
    const rsv_caustic_judge *judge, const rsv_face_point *p, rsv_rgb difference[2])
{
    const rsv_light_view *s = judge->solution;
    const rsv_elements *e = s->caustics.elements;
    float weight[3];
    uint32_t cell = rsv_elements_locate(e, p->face, p->u, p->v, weight);
    double area = (double)rsv_cell_area(e, cell);
    double light = (double)rgb_luminance(
        rsv_elements_interpolate(e, s->caustics.caustic, p->face, p->u, p->v));
    int level = level_for(light * area * judge->photons);
    uint32_t below = 1u << 2 * (RSV_JUDGED_LEVELS - level);
    uint32_t digits = part_of(weight) / below;
    rsv_rgb stored = stored_in(s, cell, digits, level);
    float per_area = (float)((double)(1u << 2 * level) / area);
    for (int pass = 0; pass < 2; pass++) {
        rsv_rgb flux = brought(
            judge, judge->cell[judge->slot[cell]].flux[pass], digits * below, (digits + 1) * below);
        difference[pass] = rgb_sub(rgb_scale(flux, per_area), stored);
    }
}
