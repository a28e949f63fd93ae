#include "resolvent_rt.h"

#include <float.h>

// ---- four floats ----------------------------------------------------------------------------------

// Vector extensions of GCC and Clang become SSE, NEON or WebAssembly SIMD; RSV_RT_SCALAR asks for the twin without
// them.
#if defined(__GNUC__) && !defined(RSV_RT_SCALAR)
typedef float float4 __attribute__((vector_size(16)));
typedef float unaligned4 __attribute__((vector_size(16), aligned(4), may_alias));

static float4 load4(const float *at) { return *(const unaligned4 *)at; }
static void store4(float *at, float4 a) { *(unaligned4 *)at = a; }
static float4 set4(float x, float y, float z, float w) { return (float4){ x, y, z, w }; }
static float4 add4(float4 a, float4 b) { return a + b; }
static float4 mul4(float4 a, float4 b) { return a * b; }
static float lane4(float4 a, int lane) { return a[lane]; }
#else
typedef struct float4 {
    float v[4];
} float4;

static float4 set4(float x, float y, float z, float w)
{
    float4 a;
    a.v[0] = x, a.v[1] = y, a.v[2] = z, a.v[3] = w;
    return a;
}
static float4 load4(const float *at) { return set4(at[0], at[1], at[2], at[3]); }
static void store4(float *at, float4 a)
{
    for (int k = 0; k < 4; k++)
        at[k] = a.v[k];
}
static float4 add4(float4 a, float4 b)
{
    return set4(a.v[0] + b.v[0], a.v[1] + b.v[1], a.v[2] + b.v[2], a.v[3] + b.v[3]);
}
static float4 mul4(float4 a, float4 b)
{
    return set4(a.v[0] * b.v[0], a.v[1] * b.v[1], a.v[2] * b.v[2], a.v[3] * b.v[3]);
}
static float lane4(float4 a, int lane) { return a.v[lane]; }
#endif

// Not isfinite: there is no math.h. Infinity - infinity and NaN - NaN are not 0.
static int is_finite(float a) { return a - a == 0; }

const char *rsv_rt_status_text(rsv_rt_status status)
{
    static const char *const text[] = { "success",
        "the number of light scales differs from the number of lights in the basis",
        "receivers beyond the last one were asked for",
        "row starts of the operator are inconsistent", "an index points beyond the last element",
        "a number is not finite", "the grid of probes is empty",
        "a hanging element comes before one of its parents, or twice",
        "an element passes on more light than reaches it", "no valid probe is near" };
    return (unsigned)status < sizeof text / sizeof text[0] ? text[status] : "unknown status";
}

static rsv_rt_status check_range(uint32_t first, uint32_t count, uint32_t all)
{
    return first <= all && count <= all - first ? RSV_RT_OK : RSV_RT_RANGE;
}

// ---- basis ----------------------------------------------------------------------------------------

/// Floats [at, at + 12): four RGB values are three vectors, whose lanes have the channels rgbr gbrg brgb.
static void relight12(const rsv_rt_basis *basis, const float *scale, size_t at, float *out)
{
    size_t stride = (size_t)basis->receiver_count * basis->value_count * 3;
    float4 a = set4(0, 0, 0, 0), b = a, c = a;
    for (uint32_t l = 0; l < basis->light_count; l++) {
        const float *value = basis->value + l * stride + at;
        float red = scale[3 * l], green = scale[3 * l + 1], blue = scale[3 * l + 2];
        a = add4(a, mul4(load4(value), set4(red, green, blue, red)));
        b = add4(b, mul4(load4(value + 4), set4(green, blue, red, green)));
        c = add4(c, mul4(load4(value + 8), set4(blue, red, green, blue)));
    }
    store4(out + at, a);
    store4(out + at + 4, b);
    store4(out + at + 8, c);
}

static void relight1(const rsv_rt_basis *basis, const float *scale, size_t at, float *out)
{
    size_t stride = (size_t)basis->receiver_count * basis->value_count * 3;
    float sum = 0;
    for (uint32_t l = 0; l < basis->light_count; l++)
        sum += basis->value[l * stride + at] * scale[3 * l + at % 3];
    out[at] = sum;
}

rsv_rt_status rsv_rt_relight(const rsv_rt_basis *basis, const float *scale, uint32_t scale_count,
    uint32_t first, uint32_t count, float *out)
{
    size_t floats = 3 * (size_t)basis->value_count, at, end;
    if (scale_count != basis->light_count) return RSV_RT_LIGHT_COUNT;
    if (check_range(first, count, basis->receiver_count) != RSV_RT_OK) return RSV_RT_RANGE;
    at = first * floats;
    end = (first + (size_t)count) * floats;
    for (; at + 12 <= end; at += 12)
        relight12(basis, scale, at, out);
    for (; at < end; at++)
        relight1(basis, scale, at, out);
    return RSV_RT_OK;
}

/// The fractional part of a number, 0..1, also for negative ones; 0 for numbers too large to have one.
static float fraction(float a)
{
    if (!(a > -1e6f && a < 1e6f)) return 0;
    a -= (float)(int32_t)a;
    return a < 0 ? a + 1 : a;
}

void rsv_rt_turn(float turn, const float color[3], uint32_t turns, float *scale)
{
    float at = fraction(turn) * (float)turns;
    uint32_t before = (uint32_t)at;
    float share = at - (float)before;
    for (uint32_t k = 0; k < 3 * turns; k++)
        scale[k] = 0;
    for (int c = 0; c < 3 && turns > 0; c++) {
        scale[3 * (before % turns) + c] += (1 - share) * color[c];
        scale[3 * ((before + 1) % turns) + c] += share * color[c];
    }
}

// ---- operator -------------------------------------------------------------------------------------

static rsv_rt_status check_rows(
    const uint64_t *start, const uint32_t *column, uint32_t elements, uint64_t entries)
{
    if (start[0] != 0 || start[elements] != entries) return RSV_RT_ROWS;
    for (uint32_t row = 0; row < elements; row++)
        if (start[row] > start[row + 1]) return RSV_RT_ROWS;
    for (uint64_t k = 0; k < entries; k++)
        if (column[k] >= elements) return RSV_RT_INDEX;
    return RSV_RT_OK;
}

static rsv_rt_status check_numbers(const float *number, uint64_t count)
{
    for (uint64_t k = 0; k < count; k++)
        if (!is_finite(number[k])) return RSV_RT_NUMBER;
    return RSV_RT_OK;
}

/// Whether elements hang once each, and from those that are free or come earlier: no specular path of parents leads
/// back.
/// @param waits [element_count] scratch: elements that hang and have not come yet
static rsv_rt_status check_order(const rsv_rt_operator *t, uint8_t *waits)
{
    for (uint32_t n = 0; n < t->element_count; n++)
        waits[n] = 0;
    for (uint32_t k = 0; k < t->hanging_count; k++) {
        if (waits[t->hanging_node[k]]) return RSV_RT_ORDER;
        waits[t->hanging_node[k]] = 1;
    }
    for (uint32_t k = 0; k < t->hanging_count; k++) {
        for (size_t p = 4 * (size_t)k; p < 4 * (size_t)k + 4; p++)
            if (t->hanging_weight[p] != 0 && waits[t->hanging_parent[p]]) return RSV_RT_ORDER;
        waits[t->hanging_node[k]] = 0;
    }
    return RSV_RT_OK;
}

static rsv_rt_status check_hanging(const rsv_rt_operator *t, uint8_t *scratch)
{
    for (uint32_t k = 0; k < t->hanging_count; k++) {
        if (t->hanging_node[k] >= t->element_count) return RSV_RT_INDEX;
        for (size_t p = 4 * (size_t)k; p < 4 * (size_t)k + 4; p++)
            if (t->hanging_parent[p] >= t->element_count) return RSV_RT_INDEX;
    }
    rsv_rt_status status = check_numbers(t->hanging_weight, 4 * (uint64_t)t->hanging_count);
    return status == RSV_RT_OK ? check_order(t, scratch) : status;
}

/// Albedo relates the light that leaves to the light that entered; rows relate the light that enters to the light that
/// arrives. Only their product is a share of light, at most 1. Rows with few rays are noisy, but never exceed 1 by as
/// much as this.
#define MOST_PASSED_ON 1.75f

static rsv_rt_status check_energy(const rsv_rt_operator *t)
{
    for (uint32_t n = 0; n < t->element_count; n++) {
        float entered = t->scale[n] * (float)(t->row_start[n + 1] - t->row_start[n]);
        if (t->scale[n] < 0) return RSV_RT_ENERGY;
        for (size_t c = 3 * (size_t)n; c < 3 * (size_t)n + 3; c++)
            if (t->albedo[c] < 0 || t->albedo[c] * entered > MOST_PASSED_ON) return RSV_RT_ENERGY;
    }
    return RSV_RT_OK;
}

rsv_rt_status rsv_rt_operator_check(
    const rsv_rt_operator *t, uint64_t entries, uint64_t tinted_entries, uint8_t *scratch)
{
    rsv_rt_status status = check_rows(t->row_start, t->column, t->element_count, entries);
    if (status == RSV_RT_OK && t->tinted_row_start)
        status =
            check_rows(t->tinted_row_start, t->tinted_column, t->element_count, tinted_entries);
    if (status == RSV_RT_OK && t->tinted_row_start)
        status = check_numbers(t->tinted_weight, 3 * tinted_entries);
    if (status == RSV_RT_OK) status = check_hanging(t, scratch);
    if (status == RSV_RT_OK) status = check_numbers(t->scale, t->element_count);
    if (status == RSV_RT_OK) status = check_numbers(t->albedo, 3 * (uint64_t)t->element_count);
    if (status == RSV_RT_OK) status = check_energy(t);
    return status;
}

/// The fourth lane of an element's exitance is 0, or this if the element hangs.
#define HANGS 1.0f

/// K: the light that leaves an element.
static void scatter(const rsv_rt_solver *s, uint32_t element)
{
    const float *e = s->irradiance + 3 * (size_t)element;
    const float *albedo = s->transport->albedo + 3 * (size_t)element;
    float *exitance = s->exitance + 4 * (size_t)element;
    for (int c = 0; c < 3; c++)
        exitance[c] = albedo[c] * e[c];
}

/// A row of G times exitance. Four sums at once: additions that wait for each other take longer than the loads.
static float4 gather(const rsv_rt_solver *s, uint32_t row)
{
    const rsv_rt_operator *t = s->transport;
    const uint32_t *column = t->column;
    const float *exitance = s->exitance;
    size_t k = (size_t)t->row_start[row], end = (size_t)t->row_start[row + 1];
    float4 a = set4(0, 0, 0, 0), b = a, c = a, d = a;
    for (; k + 4 <= end; k += 4) {
        a = add4(a, load4(exitance + 4 * (size_t)column[k]));
        b = add4(b, load4(exitance + 4 * (size_t)column[k + 1]));
        c = add4(c, load4(exitance + 4 * (size_t)column[k + 2]));
        d = add4(d, load4(exitance + 4 * (size_t)column[k + 3]));
    }
    for (; k < end; k++)
        a = add4(a, load4(exitance + 4 * (size_t)column[k]));
    a = add4(add4(a, b), add4(c, d));
    if (t->tinted_row_start) {
        end = (size_t)t->tinted_row_start[row + 1];
        for (k = (size_t)t->tinted_row_start[row]; k < end; k++) {
            const float *w = t->tinted_weight + 3 * k;
            const float *from = exitance + 4 * (size_t)t->tinted_column[k];
            a = add4(a, mul4(set4(w[0], w[1], w[2], 0), load4(from)));
        }
    }
    return mul4(a, set4(t->scale[row], t->scale[row], t->scale[row], 0));
}

/// Replaces a value that is not finite, or whose predecessor was not, by the first finite one of `after`, `other` and
/// `before`, or else by 0. Each such step counts as the largest change there is.
static float mend(rsv_rt_solver *s, float before, float after, float other)
{
    s->largest = FLT_MAX;
    return is_finite(after) ? after : is_finite(other) ? other : is_finite(before) ? before : 0;
}

/// The new value of an irradiance; notes the largest change. A value that is not finite would remain for ever, and
/// spread.
/// @param other replaces one that is not finite
static float settle(rsv_rt_solver *s, float before, float after, float other)
{
    float change = after > before ? after - before : before - after;
    if (!(change <= s->largest)) { // NaN comes here too
        if (!(change <= FLT_MAX)) return mend(s, before, after, other);
        s->largest = change;
    }
    return after;
}

static void keep_bounced(rsv_rt_solver *s, uint32_t row, float4 indirect)
{
    for (int c = 0; c < 3; c++)
        if (is_finite(lane4(indirect, c)))
            s->bounced[3 * (size_t)row + (size_t)c] = lane4(indirect, c);
}

/// One element: E = E0 + G K E. @return operations
static uint64_t visit(rsv_rt_solver *s, const float *direct, uint32_t row)
{
    const rsv_rt_operator *t = s->transport;
    float *e = s->irradiance + 3 * (size_t)row;
    uint64_t entries = 1;
    float4 indirect;
    if (s->exitance[4 * (size_t)row + 3] == HANGS) return entries;
    indirect = gather(s, row);
    if (s->bounced) keep_bounced(s, row, indirect);
    for (int c = 0; c < 3; c++) {
        float arriving = direct[3 * (size_t)row + (size_t)c];
        e[c] = settle(s, e[c], arriving + lane4(indirect, c), arriving);
    }
    scatter(s, row);
    entries += t->row_start[row + 1] - t->row_start[row];
    if (t->tinted_row_start) entries += t->tinted_row_start[row + 1] - t->tinted_row_start[row];
    return entries;
}

static float mean_of_parents(
    const rsv_rt_operator *t, uint32_t hanging, const float *field, size_t channel)
{
    float sum = 0;
    for (size_t p = 4 * (size_t)hanging; p < 4 * (size_t)hanging + 4; p++)
        sum += t->hanging_weight[p] * field[3 * (size_t)t->hanging_parent[p] + channel];
    return sum;
}

/// Hanging elements are means of their parents.
static void fill_hanging(rsv_rt_solver *s)
{
    const rsv_rt_operator *t = s->transport;
    for (uint32_t k = 0; k < t->hanging_count; k++) {
        size_t at = 3 * (size_t)t->hanging_node[k];
        float *e = s->irradiance + at;
        for (size_t c = 0; c < 3; c++) {
            e[c] = settle(s, e[c], mean_of_parents(t, k, s->irradiance, c), e[c]);
            if (s->bounced) s->bounced[at + c] = mean_of_parents(t, k, s->bounced, c);
        }
        scatter(s, t->hanging_node[k]);
    }
}

void rsv_rt_solver_begin(
    rsv_rt_solver *s, const rsv_rt_operator *transport, float *irradiance, float *exitance)
{
    s->transport = transport;
    s->irradiance = irradiance;
    s->exitance = exitance;
    s->bounced = NULL;
    s->next = 0;
    s->sweeps = 0;
    s->largest = s->change = 0;
    for (uint32_t n = 0; n < transport->element_count; n++) {
        for (size_t c = 3 * (size_t)n; c < 3 * (size_t)n + 3; c++)
            if (!is_finite(irradiance[c])) irradiance[c] = 0;
        exitance[4 * (size_t)n + 3] = 0;
        scatter(s, n);
    }
    for (uint32_t k = 0; k < transport->hanging_count; k++)
        exitance[4 * (size_t)transport->hanging_node[k] + 3] = HANGS;
}

void rsv_rt_solver_keep_bounced(rsv_rt_solver *s, float *bounced)
{
    for (size_t k = 0; k < 3 * (size_t)s->transport->element_count; k++)
        bounced[k] = 0;
    s->bounced = bounced;
}

static void end_sweep(rsv_rt_solver *s)
{
    fill_hanging(s);
    s->change = s->largest;
    s->largest = 0;
    s->next = 0;
    s->sweeps++;
}

uint64_t rsv_rt_solver_update(rsv_rt_solver *s, const float *direct, uint64_t operations)
{
    uint64_t used = 0;
    while (used < operations && s->transport->element_count) {
        used += visit(s, direct, s->next++);
        if (s->next == s->transport->element_count) {
            used += 4 * (uint64_t)s->transport->hanging_count;
            end_sweep(s);
        }
    }
    return used;
}

int rsv_rt_solver_update_while(rsv_rt_solver *s, const float *direct, float tolerance,
    uint64_t operations, int (*go_on)(void *user), void *user)
{
    uint32_t sweeps = s->sweeps, first = s->next;
    uint64_t slice = operations ? operations : 1;
    if (!s->transport->element_count) return 1;
    do {
        rsv_rt_solver_update(s, direct, slice);
        // a sweep that began before this call may have seen other direct light
        uint32_t whole = s->sweeps - sweeps;
        if (whole > (first > 0) && s->change <= tolerance) return 1;
    } while (go_on(user));
    return 0;
}

rsv_rt_status rsv_rt_receivers_check(const rsv_rt_receivers *receivers, uint32_t element_count)
{
    for (size_t k = 0; k < 3 * (size_t)receivers->count; k++)
        if (receivers->element[k] >= element_count) return RSV_RT_INDEX;
    return check_numbers(receivers->weight, 3 * (uint64_t)receivers->count);
}

rsv_rt_status rsv_rt_receive(const rsv_rt_receivers *receivers, const float *field, uint32_t first,
    uint32_t count, float *out)
{
    rsv_rt_status status = check_range(first, count, receivers->count);
    if (status != RSV_RT_OK) return status;
    for (size_t n = first; n < (size_t)first + count; n++) {
        const uint32_t *element = receivers->element + 3 * n;
        const float *w = receivers->weight + 3 * n;
        for (size_t c = 0; c < 3; c++)
            out[3 * n + c] = w[0] * field[3 * (size_t)element[0] + c] +
                             w[1] * field[3 * (size_t)element[1] + c] +
                             w[2] * field[3 * (size_t)element[2] + c];
    }
    return RSV_RT_OK;
}

// ---- probes ---------------------------------------------------------------------------------------

/// The probe below a coordinate, and the weight of the one above.
static uint32_t place_between(float at, uint32_t size, float *weight)
{
    float last = (float)(size - 1);
    *weight = 0;
    if (!(at > 0)) return 0; // NaN comes here too
    if (at >= last) return size - 1;
    *weight = at - (float)(uint32_t)at;
    return (uint32_t)at;
}

rsv_rt_status rsv_rt_probe_at(
    const rsv_rt_probe_grid *grid, const float *probe, const float position[3], float *sh)
{
    uint32_t low[3];
    float high[3], weights = 0;
    for (int k = 0; k < 3 * RSV_RT_SH_COUNT; k++)
        sh[k] = 0;
    for (int axis = 0; axis < 3; axis++) {
        if (!grid->size[axis] || !(grid->spacing[axis] > 0)) return RSV_RT_GRID;
        float at = (position[axis] - grid->origin[axis]) / grid->spacing[axis];
        low[axis] = place_between(at, grid->size[axis], &high[axis]);
    }
    for (uint32_t corner = 0; corner < 8; corner++) {
        float weight = 1;
        size_t index = 0;
        for (int axis = 2; axis >= 0; axis--) {
            uint32_t up = corner >> axis & 1;
            weight *= up ? high[axis] : 1 - high[axis];
            index = index * grid->size[axis] + low[axis] + up;
        }
        if (!(weight > 0) || (grid->valid && !grid->valid[index])) continue;
        for (size_t k = 0; k < 3 * RSV_RT_SH_COUNT; k++)
            sh[k] += weight * probe[index * 3 * RSV_RT_SH_COUNT + k];
        weights += weight;
    }
    if (!(weights > 0)) return RSV_RT_NO_PROBE;
    for (int k = 0; k < 3 * RSV_RT_SH_COUNT; k++)
        sh[k] /= weights;
    return RSV_RT_OK;
}

void rsv_rt_sh_irradiance(const float *sh, const float n[3], float irradiance[3])
{
    // the basis functions times pi, 2 pi / 3 and pi / 4, the convolution of each order with a cosine
    const float basis[RSV_RT_SH_COUNT] = { 0.88622693f, 1.02332671f * n[1], 1.02332671f * n[2],
        1.02332671f * n[0], 0.85808553f * n[0] * n[1], 0.85808553f * n[1] * n[2],
        0.24770796f * (3 * n[2] * n[2] - 1), 0.85808553f * n[0] * n[2],
        0.42904276f * (n[0] * n[0] - n[1] * n[1]) };
    for (int c = 0; c < 3; c++) {
        float sum = 0;
        for (int k = 0; k < RSV_RT_SH_COUNT; k++)
            sum += basis[k] * sh[3 * k + c];
        irradiance[c] = sum > 0 ? sum : 0;
    }
}
