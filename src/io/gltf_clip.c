#include "gltf_clip.h"

#include "../core/core.h"

#include <math.h>

enum { PATHS = RSV_GLTF_OTHER_PATH };

static bool refers(int reference, size_t count)
{
    return reference >= 0 && (size_t)reference < count;
}

// ---- reading --------------------------------------------------------------------------------------

/// Channels of which something is not done, named once.
typedef struct left_out {
    size_t count;
    const char *node;
} left_out;

typedef struct reading {
    rsv_context *context;
    const rsv_gltf_document *document;
    const rsv_gltf_animation *animation;
    rsv_gltf_clip *clip;
    bool *moved; ///< [node_count][PATHS]
    double bytes;
    left_out fixed, unmorphed, twice;
} reading;

static void leave_out(left_out *group, const char *node)
{
    if (!group->count++) group->node = node;
}

static void tell(const reading *r, const left_out *group, const char *what)
{
    if (group->count)
        rsv_log(r->context, RSV_LOG_WARNING,
            "animation '%s': %zu channel%s (first: of node '%s') %s", r->animation->name,
            group->count, group->count > 1 ? "s" : "", group->node, what);
}

static size_t target_count(const rsv_gltf_document *document, const rsv_gltf_node *node)
{
    size_t most = 0;
    if (!refers(node->mesh, document->mesh_count)) return 0;
    const rsv_gltf_mesh *mesh = &document->mesh[node->mesh];
    for (size_t k = 0; k < mesh->primitive_count; k++)
        if (mesh->primitive[k].target_count > most) most = mesh->primitive[k].target_count;
    return most;
}

/// Fails before an allocation that memory cannot hold: accessors without bytes in the file can state any size.
static rsv_status account(reading *r, int accessor)
{
    if (!refers(accessor, r->document->accessor_count)) return RSV_OK; // refused when it is read
    const rsv_gltf_accessor *a = &r->document->accessor[accessor];
    r->bytes += sizeof(float) * (double)a->count * (double)a->component_count;
    if (r->bytes <= rsv_machine_memory()) return RSV_OK;
    return rsv_fail(RSV_ERROR_UNSUPPORTED,
        "animation '%s': its keys need more memory than is available; export it with fewer",
        r->animation->name);
}

static rsv_status check_times(const reading *r, const rsv_gltf_keys *keys, int accessor)
{
    if (!keys->time.count)
        return rsv_fail(RSV_ERROR_FORMAT, "animation '%s': accessor %d holds no keys",
            r->animation->name, accessor);
    for (size_t k = 1; k < keys->time.count; k++)
        if (keys->time.value[k] < keys->time.value[k - 1])
            return rsv_fail(RSV_ERROR_FORMAT,
                "animation '%s': accessor %d: key %zu is at %g s, after one at %g s; times must "
                "rise: export it again",
                r->animation->name, accessor, k, (double)keys->time.value[k],
                (double)keys->time.value[k - 1]);
    return RSV_OK;
}

/// The keys of a sampler; read once, however many channels use it.
static rsv_status read_keys(reading *r, int sampler, size_t width, const rsv_gltf_keys **found)
{
    rsv_status status;
    const rsv_gltf_sampler *from = &r->animation->sampler[sampler];
    rsv_gltf_keys *keys = &r->clip->keys[sampler];
    *found = keys;
    if (keys->number.value && keys->number.width == width) return RSV_OK;
    if (keys->number.value)
        return rsv_fail(RSV_ERROR_FORMAT,
            "animation '%s': sampler %d is used for different kinds "
            "of values",
            r->animation->name, sampler);
    RSV_TRY(account(r, from->input));
    RSV_TRY(account(r, from->output));
    keys->time.width = 1;
    keys->number.width = width;
    RSV_TRY(
        rsv_gltf_read_keys(r->context, r->document, from->input, r->animation->name, &keys->time));
    RSV_TRY(check_times(r, keys, from->input));
    RSV_TRY(rsv_gltf_read_keys(
        r->context, r->document, from->output, r->animation->name, &keys->number));
cleanup:
    return status;
}

static rsv_status check_sampler(const reading *r, int sampler)
{
    if (!refers(sampler, r->animation->sampler_count))
        return rsv_fail(RSV_ERROR_FORMAT, "animation '%s': sampler %d does not exist",
            r->animation->name, sampler);
    if (r->animation->sampler[sampler].interpolation == RSV_GLTF_OTHER_INTERPOLATION)
        return rsv_fail(RSV_ERROR_FORMAT,
            "animation '%s': the interpolation of sampler %d is not LINEAR, STEP or "
            "CUBICSPLINE",
            r->animation->name, sampler);
    return RSV_OK;
}

static rsv_status add_track(reading *r, const rsv_gltf_channel *channel, size_t width)
{
    rsv_status status;
    const rsv_gltf_keys *keys;
    RSV_TRY(check_sampler(r, channel->sampler));
    bool is_weights = channel->path == RSV_GLTF_WEIGHTS;
    RSV_TRY(read_keys(r, channel->sampler, is_weights ? 1 : width, &keys));
    rsv_gltf_track track = { .node = (uint32_t)channel->node,
        .path = channel->path,
        .interpolation = r->animation->sampler[channel->sampler].interpolation,
        .time = keys->time.value,
        .value = keys->number.value,
        .key_count = keys->time.count,
        .width = width };
    size_t tripled = track.interpolation == RSV_GLTF_CUBIC_SPLINE ? 3 : 1;
    size_t needed = keys->time.count * tripled * (is_weights ? width : 1);
    if (keys->number.count != needed)
        return rsv_fail(RSV_ERROR_FORMAT,
            "animation '%s': sampler %d has %zu values where its %zu keys need %zu",
            r->animation->name, channel->sampler, keys->number.count, keys->time.count, needed);
    r->clip->track[r->clip->count++] = track;
cleanup:
    return status;
}

static rsv_status read_channel(reading *r, const rsv_gltf_channel *channel)
{
    if (channel->node == -1 || channel->path == RSV_GLTF_OTHER_PATH) return RSV_OK; // in notes
    if (!refers(channel->node, r->document->node_count))
        return rsv_fail(RSV_ERROR_FORMAT, "animation '%s': node %d does not exist",
            r->animation->name, channel->node);
    const rsv_gltf_node *node = &r->document->node[channel->node];
    size_t width = channel->path == RSV_GLTF_ROTATION  ? 4
                   : channel->path == RSV_GLTF_WEIGHTS ? target_count(r->document, node)
                                                       : 3;
    bool is_weights = channel->path == RSV_GLTF_WEIGHTS;
    bool *moved = &r->moved[(size_t)channel->node * PATHS + channel->path];
    if (*moved) leave_out(&r->twice, node->name);
    if (!is_weights && node->has_matrix) leave_out(&r->fixed, node->name);
    if (is_weights && !width) leave_out(&r->unmorphed, node->name);
    if (*moved || !width || (!is_weights && node->has_matrix)) return RSV_OK;
    *moved = true;
    return add_track(r, channel, width);
}

static void find_range(rsv_gltf_clip *clip)
{
    for (size_t k = 0; k < clip->count; k++) {
        const rsv_gltf_track *t = &clip->track[k];
        double first = (double)t->time[0], last = (double)t->time[t->key_count - 1];
        clip->start = k ? fmin(clip->start, first) : first;
        clip->end = k ? fmax(clip->end, last) : last;
    }
}

/// Notes unknown paths, unless they belong to an extension that is reported itself.
static void note_others(const reading *r)
{
    size_t count = 0;
    for (size_t k = 0; k < r->animation->channel_count; k++)
        count += r->animation->channel[k].path == RSV_GLTF_OTHER_PATH;
    if (count)
        rsv_log(r->context, RSV_LOG_WARNING,
            "animation '%s': %zu channel%s no translation, rotation, scale or weights "
            "(KHR_animation_pointer?), and %s not played",
            r->animation->name, count, count > 1 ? "s move" : " moves", count > 1 ? "are" : "is");
}

rsv_status rsv_gltf_clip_create(
    rsv_context *context, const rsv_gltf_document *document, size_t index, rsv_gltf_clip *clip)
{
    rsv_status status;
    const rsv_gltf_animation *a = &document->animation[index];
    reading r = { .context = context, .document = document, .animation = a, .clip = clip };
    *clip =
        (rsv_gltf_clip){ .context = context, .name = a->name, .sampler_count = a->sampler_count };
    r.moved = rsv_alloc(context, document->node_count, PATHS * sizeof *r.moved);
    clip->keys = rsv_alloc(context, a->sampler_count, sizeof *clip->keys);
    clip->track = rsv_alloc(context, a->channel_count, sizeof *clip->track);
    RSV_TRY(r.moved && clip->keys && clip->track ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t k = 0; k < a->channel_count; k++)
        RSV_TRY(read_channel(&r, &a->channel[k]));
    find_range(clip);
    note_others(&r);
    tell(&r, &r.fixed, "would move nodes that have a matrix, and are not played");
    tell(&r, &r.unmorphed, "have weights without morph targets, and are not played");
    tell(&r, &r.twice, "move something that another channel already moves, and are not played");
cleanup:
    rsv_free(context, r.moved);
    if (status != RSV_OK) rsv_gltf_clip_destroy(clip);
    return status;
}

void rsv_gltf_clip_destroy(rsv_gltf_clip *clip)
{
    for (size_t k = 0; clip->keys && k < clip->sampler_count; k++) {
        rsv_free(clip->context, clip->keys[k].time.value);
        rsv_free(clip->context, clip->keys[k].number.value);
    }
    rsv_free(clip->context, clip->keys);
    rsv_free(clip->context, clip->track);
    *clip = (rsv_gltf_clip){ .context = clip->context };
}

// ---- playing --------------------------------------------------------------------------------------

/// How many keys are at a time or before it.
static size_t keys_until(const rsv_gltf_track *track, double time)
{
    size_t low = 0, high = track->key_count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if ((double)track->time[middle] <= time)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/// A key's numbers. @param part of a cubic spline: 0 = tangent in, 1 = value, 2 = tangent out
static const float *key_at(const rsv_gltf_track *track, size_t key, size_t part)
{
    bool is_cubic = track->interpolation == RSV_GLTF_CUBIC_SPLINE;
    return track->value + (is_cubic ? 3 * key + part : key) * track->width;
}

static double length_of(const double q[4])
{
    return sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
}

static void unit_quaternion(const float from[4], double to[4])
{
    const double q[4] = { (double)from[0], (double)from[1], (double)from[2], (double)from[3] };
    double length = length_of(q);
    for (int k = 0; k < 4; k++)
        to[k] = length > 0 ? q[k] / length : 0;
}

/// Along the shorter arc, at a constant speed (Shoemake 1985).
static void slerp(const float from[4], const float to[4], double s, double result[4])
{
    double a[4], b[4], across[4], cosine = 0;
    unit_quaternion(from, a);
    unit_quaternion(to, b);
    for (int k = 0; k < 4; k++)
        cosine += a[k] * b[k];
    double sign = cosine < 0 ? -1 : 1;
    for (int k = 0; k < 4; k++)
        across[k] = sign * b[k] - sign * cosine * a[k];
    double sine = length_of(across), angle = atan2(sine, sign * cosine);
    for (int k = 0; k < 4; k++)
        result[k] = cos(s * angle) * a[k] + (sine > 0 ? sin(s * angle) * across[k] / sine : 0);
}

static void hermite(
    const rsv_gltf_track *track, size_t key, double seconds, double s, double *value)
{
    const float *from = key_at(track, key, 1), *leaving = key_at(track, key, 2);
    const float *arriving = key_at(track, key + 1, 0), *to = key_at(track, key + 1, 1);
    double s2 = s * s, s3 = s2 * s;
    for (size_t k = 0; k < track->width; k++)
        value[k] = (2 * s3 - 3 * s2 + 1) * (double)from[k] +
                   seconds * (s3 - 2 * s2 + s) * (double)leaving[k] +
                   (3 * s2 - 2 * s3) * (double)to[k] + seconds * (s3 - s2) * (double)arriving[k];
}

static void blend(const rsv_gltf_track *track, size_t key, double time, double *value)
{
    double seconds = (double)track->time[key + 1] - (double)track->time[key];
    double s = (time - (double)track->time[key]) / seconds;
    const float *from = key_at(track, key, 1), *to = key_at(track, key + 1, 1);
    if (track->interpolation == RSV_GLTF_CUBIC_SPLINE)
        hermite(track, key, seconds, s, value);
    else if (track->path == RSV_GLTF_ROTATION)
        slerp(from, to, s, value);
    else
        for (size_t k = 0; k < track->width; k++)
            value[k] = (1 - s) * (double)from[k] + s * (double)to[k];
}

void rsv_gltf_track_at(const rsv_gltf_track *track, double time, double *value)
{
    size_t before = keys_until(track, time);
    bool between = before > 0 && before < track->key_count;
    if (between && track->interpolation != RSV_GLTF_STEP) {
        blend(track, before - 1, time, value);
        return;
    }
    const float *key = key_at(track, before ? before - 1 : 0, 1);
    for (size_t k = 0; k < track->width; k++)
        value[k] = (double)key[k];
}
