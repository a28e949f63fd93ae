/// Build tool: fits what lobe_tables.h declares and writes it as C. `lobes_generate OUTPUT.c`
///
/// For each width and angle, the three numbers of a transformed cosine q that maximise its affinity int sqrt(p q) with the
/// normalised lobe p of the engine's GGX (Bhattacharyya's; 1 = the same), by the simplex method of Nelder and Mead (1965). The
/// square roots weigh peak and tail alike.
#include "../bsdf/ggx.h"
#include "lobe_tables.h"

#include <stdio.h>
#include <string.h>

#define COLUMNS 16 ///< around the normal
#define ROWS 48    ///< away from it, denser towards the long tail of GGX
#define NUMBERS 3
#define STEPS 160 ///< of the simplex at most

/// Directions that the lobe sends light to.
typedef struct lobe_samples {
    rsv_vec3 wi[COLUMNS * ROWS];
    double weight[COLUMNS * ROWS]; ///< sum 1
    double root[COLUMNS * ROWS];   ///< 1 / sqrt(p)
    int count;
    float alpha, cos_o, sin_o;
    double grazing;
} lobe_samples;

static float square(int k, int count)
{
    float x = (float)k / (float)(count - 1);
    return x * x;
}

static void sample_lobe(lobe_samples *s, float alpha, float cos_o)
{
    s->alpha = alpha, s->cos_o = cos_o, s->sin_o = sqrtf(1 - cos_o * cos_o);
    s->count = 0, s->grazing = 0;
    // wi leaves towards +x
    rsv_vec3 wo = v3(-s->sin_o, 0, cos_o), n = v3(0, 0, 1);
    double albedo = 0;
    for (int i = 0; i < COLUMNS * ROWS; i++) {
        float u = ((float)(i % COLUMNS) + 0.5f) / COLUMNS, v = ((float)(i / COLUMNS) + 0.5f) / ROWS;
        rsv_vec3 h = rsv_ggx_sample_visible(wo, alpha, 0.5f * u, 1 - v * v * v);
        float cos_h = v3_dot(wo, h);
        rsv_vec3 wi = v3_sub(v3_scale(h, 2 * cos_h), wo);
        if (!(wi.z > 1e-6f) || !(cos_h > 0)) continue;
        double seen = (double)rsv_ggx_visibility(cos_o, wi.z, alpha);
        double weight = 3 * (double)(v * v) / (COLUMNS * ROWS) * seen;
        double p = (double)rsv_ggx_visible_pdf(n, h, wo, alpha) * seen / (4 * (double)cos_h);
        if (!(p > 0)) continue;
        s->wi[s->count] = wi;
        s->weight[s->count] = weight;
        s->root[s->count++] = p;
        s->grazing += weight * pow(1 - (double)cos_h, 5);
        albedo += weight;
    }
    for (int i = 0; i < s->count; i++) {
        s->weight[i] /= albedo;
        s->root[i] = 1 / sqrt(s->root[i] / albedo);
    }
}

static rsv_lobe_fit fit_of(const double x[NUMBERS])
{
    return (rsv_lobe_fit){ (float)x[0], (float)exp(x[1]), (float)exp(x[2]), 0, 0 };
}

/// What lacks to an affinity of 1.
static double distance(const lobe_samples *s, const double x[NUMBERS])
{
    rsv_lobe_fit fit = fit_of(x);
    if (fabs(x[0]) * (double)s->alpha > 1.5) return 2;
    rsv_lobe_shape shape = rsv_lobe_shape_of(&fit, s->alpha, s->cos_o, s->sin_o);
    double sum = 0;
    for (int i = 0; i < s->count; i++)
        sum += s->weight[i] * s->root[i] * sqrt((double)rsv_lobe_density(&shape, s->wi[i]));
    return 1 - sum;
}

typedef struct simplex {
    double x[NUMBERS + 1][NUMBERS], value[NUMBERS + 1];
} simplex;

static void sort_simplex(simplex *m)
{
    for (int i = 1; i <= NUMBERS; i++) {
        for (int j = i; j > 0 && m->value[j] < m->value[j - 1]; j--) {
            double x[NUMBERS], value = m->value[j];
            memcpy(x, m->x[j], sizeof x);
            memcpy(m->x[j], m->x[j - 1], sizeof x);
            memcpy(m->x[j - 1], x, sizeof x);
            m->value[j] = m->value[j - 1];
            m->value[j - 1] = value;
        }
    }
}

/// The worst corner, moved through the middle of the others. @return its value
static double move_worst(const lobe_samples *s, const simplex *m, double by, double x[NUMBERS])
{
    for (int k = 0; k < NUMBERS; k++) {
        double middle = 0;
        for (int i = 0; i < NUMBERS; i++)
            middle += m->x[i][k] / NUMBERS;
        x[k] = middle + by * (m->x[NUMBERS][k] - middle);
    }
    return distance(s, x);
}

static void replace_worst(simplex *m, const double x[NUMBERS], double value)
{
    memcpy(m->x[NUMBERS], x, sizeof m->x[0]);
    m->value[NUMBERS] = value;
}

static void step_simplex(const lobe_samples *s, simplex *m)
{
    double x[NUMBERS], y[NUMBERS], value = move_worst(s, m, -1, x), other;
    if (value < m->value[0]) {
        other = move_worst(s, m, -2, y);
        replace_worst(m, other < value ? y : x, other < value ? other : value);
    } else if (value < m->value[NUMBERS - 1]) {
        replace_worst(m, x, value);
    } else {
        other = move_worst(s, m, value < m->value[NUMBERS] ? -0.5 : 0.5, y);
        if (other < fmin(value, m->value[NUMBERS])) {
            replace_worst(m, y, other);
            return;
        }
        for (int i = 1; i <= NUMBERS; i++) {
            for (int k = 0; k < NUMBERS; k++)
                m->x[i][k] = 0.5 * (m->x[i][k] + m->x[0][k]);
            m->value[i] = distance(s, m->x[i]);
        }
    }
}

/// @param x in: where to start, out: the best
static double fit_lobe(const lobe_samples *s, double x[NUMBERS])
{
    simplex m = { 0 };
    for (int i = 0; i <= NUMBERS; i++) {
        memcpy(m.x[i], x, sizeof m.x[i]);
        if (i > 0) m.x[i][i - 1] += 0.1;
        m.value[i] = distance(s, m.x[i]);
    }
    sort_simplex(&m);
    for (int k = 0; k < STEPS && m.value[NUMBERS] - m.value[0] > 1e-9; k++) {
        step_simplex(s, &m);
        sort_simplex(&m);
    }
    memcpy(x, m.x[0], sizeof m.x[0]);
    return m.value[0];
}

/// Lobes narrower than this have the shape of this one.
#define LEAST_ALPHA 1e-3f
#define LEAST_COS 1e-4f

/// From the normal to grazing, each fit from the one before.
static void fit_row(int a, rsv_lobe_fit row[RSV_TABLE_COS])
{
    static lobe_samples s;
    double x[NUMBERS] = { 0, log(2.0), log(2.0) };
    for (int c = RSV_TABLE_COS - 1; c >= 0; c--) {
        sample_lobe(&s, f_max(square(a, RSV_TABLE_ALPHA), LEAST_ALPHA),
            f_max(square(c, RSV_TABLE_COS), LEAST_COS));
        double misfit = fit_lobe(&s, x);
        row[c] = fit_of(x);
        row[c].misfit = (float)misfit;
        row[c].grazing = (float)s.grazing;
    }
}

int main(int argc, char **argv)
{
    FILE *file = argc == 2 ? fopen(argv[1], "w") : NULL;
    if (!file) {
        fprintf(stderr, "usage: lobes_generate OUTPUT.c\n");
        return 1;
    }
    fprintf(file, "#include \"highlight/lobe_tables.h\"\n\n"
                  "const rsv_lobe_fit rsv_lobe_fits[RSV_TABLE_ALPHA][RSV_TABLE_COS] = {\n");
    for (int a = 0; a < RSV_TABLE_ALPHA; a++) {
        rsv_lobe_fit row[RSV_TABLE_COS];
        fit_row(a, row);
        fprintf(file, "    {\n");
        for (int c = 0; c < RSV_TABLE_COS; c++)
            fprintf(file, "        { %.7g, %.7g, %.7g, %.7g, %.7g },\n", (double)row[c].turn,
                (double)row[c].width_x, (double)row[c].width_y, (double)row[c].grazing,
                (double)row[c].misfit);
        fprintf(file, "    },\n");
    }
    fprintf(file, "};\n");
    return fclose(file) == 0 ? 0 : 1;
}
