#include "view_turns.h"

#include "../progress.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/// If a step without objects takes longer than the budget, objects may add this share of it.
#define SHARE_OF_LEAST 0.5
/// Weight of what is behind the camera: its light and shadows may still be seen.
#define WEIGHT_UNSEEN 0.1f
/// Triangles whose own light is computed again in a step: at least, and at first.
#define LEAST_TRIANGLES 100
#define FIRST_TRIANGLES 400
/// So many are all.
#define MOST_TRIANGLES ((size_t)1 << 30)
/// The least time of a step is forgotten at this rate.
#define FORGETTING 1.02

static bool make_room(cli_turns *t, size_t count)
{
    if (t->object_count == count && t->moved) return true;
    cli_turns_end(t);
    t->moved = calloc(count + 1, sizeof *t->moved);
    t->since = calloc(count + 1, sizeof *t->since);
    t->weight = calloc(count + 1, sizeof *t->weight);
    t->order = calloc(count + 1, sizeof *t->order);
    t->object_count = count;
    return t->moved && t->since && t->weight && t->order;
}

void cli_turns_end(cli_turns *t)
{
    free(t->moved);
    free(t->since);
    free(t->weight);
    free(t->order);
    t->moved = NULL;
    t->since = NULL;
    t->weight = NULL;
    t->order = NULL;
    t->object_count = 0;
}

static rsv_vec3 between(rsv_vec3 a, rsv_vec3 b)
{
    return (rsv_vec3){ b.x - a.x, b.y - a.y, b.z - a.z };
}

static float dot(rsv_vec3 a, rsv_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static bool same(rsv_vec3 a, rsv_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

/// The solid angle that a moving triangle sweeps, about.
static float swept(const rsv_vec3 p[3], const rsv_vec3 q[3], const rsv_camera *camera)
{
    rsv_vec3 way = between(p[0], q[0]), view = between(camera->position, q[0]);
    rsv_vec3 side = between(q[0], q[1]);
    float size = sqrtf(dot(side, side)), far = dot(view, view) + size * size;
    float angle = far > 0 ? size * fminf(sqrtf(dot(way, way)) + 0.1f * size, size) / far : 0;
    return dot(view, camera->forward) > 0 ? angle : WEIGHT_UNSEEN * angle;
}

/// Weighs what has moved; the weight of the rest is 0.
static void weigh(cli_turns *t, const rsv_scene_view *shown, const rsv_scene_view *wanted,
    const rsv_camera *camera)
{
    memset(t->weight, 0, t->object_count * sizeof *t->weight);
    for (size_t k = 0; k < wanted->triangle_count; k++) {
        rsv_vec3 p[3], q[3];
        bool moved = false;
        for (int c = 0; c < 3; c++) {
            uint32_t vertex = wanted->triangle[k][c];
            p[c] = shown->position[vertex];
            q[c] = wanted->position[vertex];
            moved =
                moved || !same(p[c], q[c]) || !same(shown->normal[vertex], wanted->normal[vertex]);
        }
        if (moved) t->weight[wanted->triangle_object[k]] += swept(p, q, camera) + 1e-20f;
    }
}

/// Who waits becomes more urgent, so that everyone's turn comes.
static void list_waiting(cli_turns *t)
{
    double now = cli_seconds();
    t->waiting = 0;
    for (uint32_t k = 0; k < t->object_count; k++) {
        t->moved[k] = false;
        if (!(t->weight[k] > 0)) {
            t->since[k] = 0;
            continue;
        }
        if (t->since[k] == 0) t->since[k] = now;
        t->weight[k] *= 1 + 10 * (float)(now - t->since[k]);
        t->order[t->waiting++] = k;
    }
}

/// Heaviest first; the same order every time for equal ones.
static void sort(cli_turns *t)
{
    for (size_t gap = t->waiting / 2; gap > 0; gap /= 2)
        for (size_t k = gap; k < t->waiting; k++) {
            uint32_t object = t->order[k];
            size_t at = k;
            while (at >= gap && t->weight[t->order[at - gap]] < t->weight[object]) {
                t->order[at] = t->order[at - gap];
                at -= gap;
            }
            t->order[at] = object;
        }
}

/// At most twice as many as before: times vary.
static size_t affordable(const cli_turns *t)
{
    double left = fmax(t->budget_ms - t->least_ms, SHARE_OF_LEAST * t->least_ms);
    if (t->budget_ms == 0) return t->waiting;
    if (t->least_ms == 0) return 1;
    double count = fmin(t->each_ms > 0 ? left / t->each_ms : 1e9, 2 * (double)t->going);
    return count < 1 ? 1 : (size_t)count;
}

bool cli_turns_take(cli_turns *t, const rsv_scene_view *shown, const rsv_scene_view *wanted,
    const rsv_camera *camera)
{
    if (!make_room(t, wanted->object_count)) return false;
    if (t->most_triangles == 0 && t->budget_ms > 0) t->most_triangles = FIRST_TRIANGLES;
    weigh(t, shown, wanted, camera);
    list_waiting(t);
    sort(t);
    size_t most = affordable(t);
    t->going = t->waiting < most ? t->waiting : most;
    for (size_t k = 0; k < t->going; k++) {
        t->moved[t->order[k]] = true;
        t->since[t->order[k]] = 0;
    }
    t->waiting -= t->going;
    t->late_frames += t->waiting > 0;
    return true;
}

/// Steps that take too long compute the light on fewer triangles from then on.
static void limit_triangles(cli_turns *t, double ms)
{
    if (t->budget_ms == 0) return;
    if (ms > t->budget_ms) {
        size_t fewer = t->most_triangles / 2;
        t->most_triangles = fewer > LEAST_TRIANGLES ? fewer : LEAST_TRIANGLES;
    } else if (ms < 0.5 * t->budget_ms && t->most_triangles < MOST_TRIANGLES) {
        t->most_triangles *= 2;
    }
}

void cli_turns_note(cli_turns *t, double ms)
{
    limit_triangles(t, ms);
    bool less = t->least_ms == 0 || ms < t->least_ms;
    t->least_ms = less ? ms : t->least_ms * FORGETTING;
    t->steps++;
    t->sum_ms += ms;
    t->longest_ms = fmax(t->longest_ms, ms);
    if (t->going > 0) t->each_ms = fmax(ms - t->least_ms, 0) / (double)t->going;
}

double cli_turns_lag(const cli_turns *t)
{
    double first = 0;
    for (size_t k = 0; k < t->object_count; k++)
        if (t->since[k] > 0 && (first == 0 || t->since[k] < first)) first = t->since[k];
    return first > 0 ? 1e3 * (cli_seconds() - first) : 0;
}
