#include "pixel_direct.h"

#include <string.h>

/// Shadow rays of a sample at most, the first included.
#define MOST_RAYS 8
/// Cost of a camera ray, in shadow rays.
#define CAMERA_RAY_COST 5
/// Samples whose light is this share of the brightest of their pixel, or less, are content with one.
#define FAINT_SHARE 0.2f
/// Pixels on either side that a pixel uses to estimate its noise.
#define NEIGHBOURS 2
/// Weight of a pixel's own shadow rays, relative to those of its neighbours.
#define OWN_WORTH 4.0f

rsv_status rsv_pixel_direct_begin(
    rsv_pixel_direct *d, const rsv_light_view *solution, uint32_t width)
{
    memset(d, 0, sizeof *d);
    d->solution = solution;
    d->width = width;
    d->tally = rsv_alloc(solution->context, width, sizeof *d->tally);
    return d->tally ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_pixel_direct_end(rsv_pixel_direct *d)
{
    rsv_context *context = d->solution->context;
    rsv_free(context, d->tally);
    rsv_free(context, d->term);
    rsv_free(context, d->spot);
}

static void trace_pending(rsv_pixel_direct *d)
{
    float passed[RSV_PACKET_WIDTH];
    if (d->pending) rsv_next_events_passed(d->solution->tracer, d->event, d->pending, passed);
    for (uint32_t k = 0; k < d->pending; k++) {
        if (!(passed[k] > 0)) continue;
        rsv_direct_term *term = &d->term[d->owner[k]];
        term->arrived = rgb_mad(term->arrived, passed[k], d->event[k].light);
        if (!d->event[k].known) continue;
        term->seen += passed[k];
        term->veiled += passed[k] * (1 - passed[k]);
    }
    d->pending = 0;
}

static bool push_term(rsv_pixel_direct *d, rsv_direct_term term)
{
    if (d->status == RSV_OK)
        d->status = rsv_grow(d->solution->context, (void **)&d->term, &d->term_capacity,
            d->term_count + 1, sizeof *d->term);
    if (d->status == RSV_OK) d->term[d->term_count++] = term;
    return d->status == RSV_OK;
}

/// Of the last term.
static void push_spot(
    rsv_pixel_direct *d, const rsv_specular_path *path, rsv_rgb weight, rsv_pixel_sample sample)
{
    if (d->status == RSV_OK)
        d->status = rsv_grow(d->solution->context, (void **)&d->spot, &d->spot_capacity,
            d->spot_count + 1, sizeof *d->spot);
    if (d->status == RSV_OK)
        d->spot[d->spot_count++] = (rsv_direct_spot){ *path, weight, sample, d->term_count - 1 };
}

/// Adds the shadow ray of a term's event.
static void push_event(rsv_pixel_direct *d, size_t term, const rsv_next_event *event)
{
    if (!rsv_next_event_asks(event)) return;
    d->event[d->pending] = *event;
    d->owner[d->pending++] = term;
    if (d->pending == RSV_PACKET_WIDTH) trace_pending(d);
}

/// Shadow rays of half of a pixel's samples.
typedef struct direct_half {
    uint32_t asked;
    float seen;
} direct_half;

/// The half of a pixel's samples that one belongs to.
static uint32_t half_of(uint32_t sample) { return sample & 1; }

/// The sample within its half, which is stratified separately.
static rsv_pixel_sample within_half(rsv_pixel_sample sample)
{
    uint32_t half = half_of(sample.index);
    return (rsv_pixel_sample){ sample.index / 2, (sample.count + 1 - half) / 2,
        rsv_hash2(sample.seed, 7 + half) };
}

/// A diffuse surface for light from sources. Must not be copied.
typedef struct lit_point {
    rsv_receiver receiver;
    rsv_entrance entrance;
    rsv_bsdf storage;
} lit_point;

/// @param weight of its irradiance
static void set_up_point(const rsv_light_view *s, const rsv_specular_path *path,
    rsv_surface_point point, rsv_rgb weight, lit_point *lit)
{
    lit->receiver =
        rsv_receiver_at(s->scene.view, s->tracer, path->triangle, path->u, path->v, point);
    lit->entrance = rsv_entrance_through(&path->medium, s->bsdf, RSV_COVER_COAT);
    lit->entrance.coat = rsv_specular_bsdf(&s->scene, path, &lit->storage);
    lit->entrance.weight = weight;
}

/// Sends a shadow ray of a term to one of the emitters.
static void aim(rsv_pixel_direct *d, size_t term, const rsv_local_lights *local,
    const lit_point *lit, rsv_pixel_sample sample)
{
    float u[3] = { rsv_pixel_sample_1d(sample, 3), 0, 0 };
    rsv_pixel_sample_2d(sample, 4, &u[1], &u[2]);
    rsv_next_event event;
    rsv_next_event_draw(&lit->receiver, &lit->entrance, local, u, &event);
    d->term[term].rays++;
    d->term[term].asked += event.known;
    d->term[term].control = rgb_add(d->term[term].control, event.open);
    push_event(d, term, &event);
}

static void add_emitters(rsv_pixel_direct *d, const rsv_specular_path *path, const lit_point *lit,
    uint32_t column, rsv_pixel_sample sample)
{
    rsv_rgb weight = lit->entrance.weight;
    rsv_local_lights local;
    rsv_receiver_weigh(&lit->receiver, d->solution->lights, &local);
    if (rsv_local_lights_are_dark(&local)) return;
    rsv_direct_term term = { .column = column,
        .sample = sample.index,
        .of_first = path->events == 0,
        .exact = rgb_mul(weight, local.unshadowed) };
    term.expected = rgb_luminance(term.exact) + rgb_luminance(weight) * local.tree_estimate;
    if (!push_term(d, term)) return;
    push_spot(d, path, weight, sample);
    aim(d, d->term_count - 1, &local, lit, within_half(sample));
}

/// @param like a term without light
static void add_punctual(
    rsv_pixel_direct *d, const lit_point *lit, rsv_pixel_sample sample, const rsv_direct_term *like)
{
    const rsv_lights *lights = d->solution->lights;
    float u = rsv_pixel_sample_1d(sample, 5);
    for (uint32_t k = 0; k < rsv_punctual_count(lights); k++) {
        rsv_next_event event;
        rsv_next_event_punctual(&lit->receiver, &lit->entrance, lights, k, u, &event);
        if (rsv_next_event_asks(&event) && push_term(d, *like))
            push_event(d, d->term_count - 1, &event);
    }
}

static void set_up_seen(const rsv_light_view *s, const rsv_specular_path *path,
    rsv_pixel_sample sample, rsv_rgb weight, lit_point *lit)
{
    float width = rsv_width_of_sample(path->width, sample);
    set_up_point(s, path,
        rsv_surface_point_seen(s->scene.view, path->triangle, path->u, path->v, path->back, width),
        weight, lit);
}

void rsv_pixel_direct_add(rsv_pixel_direct *d, const rsv_specular_path *path, rsv_rgb weight,
    uint32_t column, rsv_pixel_sample sample)
{
    lit_point lit;
    set_up_seen(d->solution, path, sample, weight, &lit);
    const rsv_direct_term like = {
        .column = column, .sample = sample.index, .of_first = path->events == 0, .rays = 1
    };
    if (rsv_lights_any_sampled(d->solution->lights)) add_emitters(d, path, &lit, column, sample);
    add_punctual(d, &lit, sample, &like);
}

// ---- penumbrae ----------------------------------------------------------------------------------

static void tally_rays(rsv_pixel_direct *d)
{
    memset(d->tally, 0, d->width * sizeof *d->tally);
    for (size_t k = 0; k < d->spot_count; k++) {
        const rsv_direct_term *term = &d->term[d->spot[k].term];
        rsv_shadow_tally *tally = &d->tally[term->column];
        float exact = rgb_luminance(term->exact);
        tally->asked += term->asked;
        tally->seen += term->seen;
        tally->veiled += term->veiled;
        tally->brightest = f_max(tally->brightest, term->expected);
        tally->squares += exact * exact;
        float further = term->asked ? 0 : rgb_luminance(term->arrived);
        tally->terms++;
        tally->further += further;
        tally->further_squares += further * further;
    }
}

/// Sum of squared deviations of the first shadow rays' results: by visibility, because everything else is known, and by
/// the tree's choice of emitters.
static float light_spread(const rsv_shadow_tally *t)
{
    float share = t->asked ? t->seen / (float)t->asked : 0;
    float veiled = t->asked ? t->veiled / (float)t->asked : 0;
    float by_choice = t->terms ? t->further_squares - t->further * t->further / (float)t->terms : 0;
    return t->squares * f_max(share * (1 - share) - veiled, 0) + f_max(by_choice, 0);
}

/// Results of the neighbours of a pixel in its row. @param spread out: other uncertainty there; may be NULL
static rsv_shadow_tally look_around(
    const rsv_pixel_direct *d, const rsv_pixel_noise *noise, uint32_t column, float *spread)
{
    rsv_shadow_tally around = { 0 };
    uint32_t first = column > NEIGHBOURS ? column - NEIGHBOURS : 0;
    for (uint32_t k = first; k <= column + NEIGHBOURS && k < d->width; k++) {
        if (k == column) continue;
        around.asked += d->tally[k].asked;
        around.seen += d->tally[k].seen;
        around.veiled += d->tally[k].veiled;
        around.squares += d->tally[k].squares;
        around.terms += d->tally[k].terms;
        around.further += d->tally[k].further;
        around.further_squares += d->tally[k].further_squares;
        if (spread) *spread += rsv_pixel_noise_spread(&noise[k]);
    }
    return around;
}

/// Further shadow rays of each sample of a pixel, by its neighbours.
static uint32_t further_rays(
    const rsv_pixel_direct *d, const rsv_pixel_noise *noise, uint32_t column)
{
    float spread = 0;
    rsv_shadow_tally around = look_around(d, noise, column, &spread);
    float light = light_spread(&around);
    if (!(light > 0)) return 0;
    // nothing else is uncertain
    if (spread * (MOST_RAYS * MOST_RAYS) <= CAMERA_RAY_COST * light) return MOST_RAYS - 1;
    float rays = sqrtf(CAMERA_RAY_COST * light / spread);
    return rays > 1 ? (uint32_t)(rays - 0.5f) : 0;
}

static void send_further_rays(rsv_pixel_direct *d, const rsv_direct_spot *spot, uint32_t further)
{
    const rsv_light_view *s = d->solution;
    lit_point lit;
    rsv_local_lights local;
    set_up_seen(s, &spot->path, spot->sample, spot->weight, &lit);
    rsv_receiver_weigh(&lit.receiver, s->lights, &local);
    rsv_pixel_sample own = within_half(spot->sample);
    rsv_pixel_sample sample = { own.index * further, own.count * further, rsv_hash2(own.seed, 6) };
    for (uint32_t ray = 0; ray < further; ray++, sample.index++)
        aim(d, spot->term, &local, &lit, sample);
}

static void look_into_penumbrae(rsv_pixel_direct *d, const rsv_pixel_noise *noise)
{
    tally_rays(d);
    for (size_t k = 0; k < d->spot_count; k++) {
        const rsv_direct_term *term = &d->term[d->spot[k].term];
        if (term->expected <= FAINT_SHARE * d->tally[term->column].brightest) continue;
        uint32_t further = further_rays(d, noise, term->column);
        if (further) send_further_rays(d, &d->spot[k], further);
    }
    trace_pending(d);
}

/// Visible fraction of the emitters for samples of one half, independent of that half: from the other half and, with
/// less weight, the pixel's neighbours. @return below 0 = unknown
static float share_seen(const direct_half *other, const rsv_shadow_tally *around)
{
    float asked = OWN_WORTH * (float)other->asked + (float)around->asked;
    return asked > 0 ? (OWN_WORTH * other->seen + around->seen) / asked : -1;
}

static rsv_pixel_light resolve_pixel(
    const rsv_direct_term *term, size_t count, const rsv_shadow_tally *around)
{
    rsv_pixel_light sum = { .squares = 0 };
    direct_half half[2] = { { 0 }, { 0 } };
    float of_sample = 0;
    for (size_t i = 0; i < count; i++) {
        half[half_of(term[i].sample)].seen += term[i].seen;
        half[half_of(term[i].sample)].asked += term[i].asked;
    }
    const float seen[2] = { share_seen(&half[1], around), share_seen(&half[0], around) };
    for (size_t i = 0; i < count; i++) {
        float share = 1 / (float)term[i].rays, visible = seen[half_of(term[i].sample)];
        rsv_rgb light = rgb_scale(term[i].arrived, share);
        if (visible >= 0)
            light =
                rgb_mad(light, visible, rgb_sub(term[i].exact, rgb_scale(term[i].control, share)));
        rsv_rgb *part = term[i].of_first ? &sum.of_first : &sum.of_others;
        *part = rgb_add(*part, light);
        of_sample += rgb_luminance(light);
        if (i + 1 < count && term[i + 1].sample == term[i].sample) continue;
        sum.squares += of_sample * of_sample;
        of_sample = 0;
    }
    return sum;
}

rsv_status rsv_pixel_direct_resolve(
    rsv_pixel_direct *d, const rsv_pixel_noise *noise, rsv_pixel_direct_sink add, void *user)
{
    trace_pending(d);
    look_into_penumbrae(d, noise);
    for (size_t begin = 0, end; begin < d->term_count; begin = end) {
        uint32_t column = d->term[begin].column;
        for (end = begin; end < d->term_count && d->term[end].column == column; end++)
            ;
        rsv_shadow_tally around = look_around(d, noise, column, NULL);
        rsv_pixel_light light = resolve_pixel(d->term + begin, end - begin, &around);
        add(user, column, &light);
    }
    d->term_count = d->spot_count = 0;
    return d->status;
}

static rsv_rgb sampled_emitter(const rsv_light_view *s, const lit_point *lit, rsv_random *random)
{
    rsv_local_lights local;
    rsv_next_event event;
    float u[3];
    rsv_receiver_weigh(&lit->receiver, s->lights, &local);
    for (int k = 0; k < 3; k++)
        u[k] = rsv_random_float(random);
    rsv_next_event_draw(&lit->receiver, &lit->entrance, &local, u, &event);
    return rgb_scale(event.light, rsv_next_event_passed(s->tracer, &event));
}

rsv_rgb rsv_sampled_irradiance(
    const rsv_light_view *s, const rsv_specular_path *path, rsv_random *random)
{
    lit_point lit;
    rsv_surface_point point =
        rsv_surface_point_at(s->scene.view, path->triangle, path->u, path->v, path->back);
    set_up_point(s, path, point, rgb_gray(1), &lit);
    rsv_rgb sum = rgb_gray(0);
    uint64_t rays = 0;
    if (rsv_lights_any_sampled(s->lights)) sum = sampled_emitter(s, &lit, random);
    float u = rsv_random_float(random);
    return rgb_add(sum,
        rsv_punctual_irradiance_at(&lit.receiver, &lit.entrance, s->lights, s->tracer, u, &rays));
}

/// One sample of the emitters' light, and the stored fraction of their unshadowed light.
static rsv_rgb seen_emitters(
    const rsv_light_view *s, const lit_point *lit, rsv_rgb stored, uint32_t seed)
{
    rsv_local_lights local;
    rsv_next_event event;
    rsv_random random = rsv_random_from(seed, 0, 31);
    float u[3];
    for (int k = 0; k < 3; k++)
        u[k] = rsv_random_float(&random);
    rsv_receiver_weigh(&lit->receiver, s->lights, &local);
    rsv_next_event_draw(&lit->receiver, &lit->entrance, &local, u, &event);
    float open = rgb_luminance(local.unshadowed);
    float share = open > 0 ? f_min(f_max(rgb_luminance(stored) / open, 0), 1) : 0;
    rsv_rgb light = rgb_scale(event.light, rsv_next_event_passed(s->tracer, &event));
    return rgb_mad(light, share, rgb_sub(local.unshadowed, event.open));
}

rsv_rgb rsv_seen_irradiance(
    const rsv_light_view *s, const rsv_specular_path *path, rsv_rgb stored, uint32_t seed)
{
    lit_point lit;
    uint64_t rays = 0;
    set_up_point(s, path,
        rsv_surface_point_seen(
            s->scene.view, path->triangle, path->u, path->v, path->back, path->width),
        rgb_gray(1), &lit);
    float u = rsv_unit_float(rsv_hash2(seed, 32));
    rsv_rgb punctual =
        rsv_punctual_irradiance_at(&lit.receiver, &lit.entrance, s->lights, s->tracer, u, &rays);
    if (!rsv_lights_any_sampled(s->lights)) return punctual;
    return rgb_add(punctual, seen_emitters(s, &lit, rgb_sub(stored, punctual), seed));
}
