#include "scatter_row.h"

#include "../elements/elements.h"
#include "scatter_integral.h"

rsv_status rsv_scatter_row_create(const rsv_scatter_sources *s, rsv_scatter_row *row)
{
    size_t columns = s->elements->node_count + s->cluster_count;
    row->context = s->context;
    row->count = 0;
    row->patches = (rsv_scatter_patches){ 0 };
    row->column = rsv_alloc(s->context, columns, sizeof *row->column);
    row->weight = rsv_alloc(s->context, columns, sizeof *row->weight);
    row->listed = rsv_alloc(s->context, columns, sizeof *row->listed);
    return row->column && row->weight && row->listed ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_scatter_row_destroy(rsv_scatter_row *row)
{
    rsv_free(row->context, row->column);
    rsv_free(row->context, row->weight);
    rsv_free(row->context, row->listed);
}

/// Profiles end where this share of their energy lies within; the rest is spread over it.
#define KEPT_SHARE 0.999f
#define REACH 19.86f ///< radius of that share over d
/// A cluster counts as one if its radius is below this share of its distance and this multiple of d, over which
/// profile and light change together; or below a smaller share of its distance, where little is left of either.
#define OPENING 0.3f
#define DECAY 1.0f
#define FAR_OPENING 0.12f
/// Cells nearer than this multiple of their radius are integrated exactly.
#define EXACT 2.0f

/// Data for gathering at one point.
typedef struct gathering {
    const rsv_scatter_sources *sources;
    const rsv_scatter_profile *profile;
    rsv_vec3 place;
    float reach, flat; ///< metres: end of the profile, largest radius of a cluster
    float nearest;     ///< metres; keeps the profile finite where a cell has no size
    float share;       ///< of the row, of this place
    rsv_scatter_row *row;
} gathering;

static void add_entry(const gathering *g, uint32_t column, rsv_rgb weight)
{
    rsv_scatter_row *row = g->row;
    if (!row->listed[column]) {
        row->listed[column] = 1;
        row->column[row->count++] = column;
        row->weight[column] = rgb_gray(0);
    }
    row->weight[column] = rgb_mad(row->weight[column], g->share, weight);
}

/// Entries of hanging nodes go to their parents, so that a fine mesh does not make longer rows.
static void add_node(const gathering *g, uint32_t node, rsv_rgb weight)
{
    uint32_t index = g->sources->elements->node_hanging[node];
    if (index == RSV_NONE) {
        add_entry(g, node, weight);
        return;
    }
    const rsv_hanging *hanging = &g->sources->elements->hanging[index];
    for (int p = 0; p < RSV_PARENTS; p++)
        if (hanging->weight[p] > 0)
            add_node(g, hanging->parent[p], rgb_scale(weight, hanging->weight[p]));
}

/// Mean of f = exp(-a r) / r over a piece of surface, as a share of f at its centre: with f' = -f (a + 1/r) and f'' = f
/// ((a + 1/r)^2 + 1/r^2). @param inverse 1/r @param facing squared cosine of the way to it @param spread a quarter of
/// its own
static inline float mean_share(float a, float inverse, float facing, float spread)
{
    float slope = a + inverse, bend = slope * slope + inverse * inverse;
    return f_max(1 + spread * (bend * (1 - facing) - slope * inverse * (1 + facing)), 0);
}

/// Mean of the profile over pieces of surface that are small against their distance, to third order: p at the centre
/// and a quarter of the Laplacian within the surface times the mean square distance from the centre.
static void average_profile(const gathering *g, rsv_scatter_patches *p)
{
    for (int c = 0; c < 3; c++) {
        const float d = g->profile->d[c], nearest = g->nearest;
#pragma omp simd
        for (int k = 0; k < RSV_SCATTER_PATCHES; k++) {
            float x = p->x[k], y = p->y[k], z = p->z[k];
            float r = f_max(sqrtf(x * x + y * y + z * z), nearest), inverse = 1 / r;
            float cos = (x * p->nx[k] + y * p->ny[k] + z * p->nz[k]) * inverse;
            float facing = f_min(cos * cos, 1), spread = 0.25f * p->spread[k];
            float a = 1 / (3 * d), wide = rsv_exp_negative(-r * a);
            float sum = wide * mean_share(a, inverse, facing, spread) +
                        wide * wide * wide * mean_share(3 * a, inverse, facing, spread);
            p->mean[c][k] = sum * inverse / (8 * RSV_PI * d);
        }
    }
}

/// Hands the weights of the patches to the row.
static void settle_patches(const gathering *g)
{
    rsv_scatter_patches *p = &g->row->patches;
    average_profile(g, p);
    for (uint32_t k = 0; k < p->count; k++) {
        rsv_rgb mean = rgb(p->mean[0][k], p->mean[1][k], p->mean[2][k]);
        const uint32_t *node = p->node[k];
        if (!node) add_entry(g, p->column[k], rgb_scale(mean, p->area[k]));
        for (int i = 0; node && i < 3; i++)
            add_node(g, node[i], rgb_scale(mean, p->area[k] / 3));
    }
    p->count = 0;
}

/// A cell or a cluster as one piece.
typedef struct patch {
    rsv_vec3 centre;      ///< relative to the place
    rsv_vec3 normal;      ///< of the surface, at most 1 long
    float spread, area;   ///< m2
    const uint32_t *node; ///< of a cell; NULL = a cluster
    uint32_t column;      ///< of a cluster
} patch;

static void add_patch(const gathering *g, const patch *from)
{
    rsv_scatter_patches *p = &g->row->patches;
    uint32_t k = p->count++;
    p->x[k] = from->centre.x, p->y[k] = from->centre.y, p->z[k] = from->centre.z;
    p->nx[k] = from->normal.x, p->ny[k] = from->normal.y, p->nz[k] = from->normal.z;
    p->spread[k] = from->spread;
    p->area[k] = from->area;
    p->node[k] = from->node;
    p->column[k] = from->column;
    if (p->count == RSV_SCATTER_PATCHES) settle_patches(g);
}

static void add_exactly(const gathering *g, const rsv_vec3 corner[3], const uint32_t *node)
{
    rsv_rgb weight[3];
    rsv_scatter_integrate(g->profile, corner, weight);
    for (int i = 0; i < 3; i++)
        add_node(g, node[i], weight[i]);
}

static void add_cell(const gathering *g, uint32_t k)
{
    const rsv_scatter_sources *s = g->sources;
    const uint32_t *node = s->elements->cell_node[s->cell[k]];
    rsv_vec3 corner[3];
    for (int i = 0; i < 3; i++)
        corner[i] = v3_sub(s->corner[k][i], g->place);
    rsv_vec3 centre = rsv_scatter_centroid(corner);
    float distance = v3_length(centre), radius = 0, squares = 0;
    for (int i = 0; i < 3; i++) {
        float arm = v3_length(v3_sub(corner[i], centre));
        radius = f_max(radius, arm);
        squares += arm * arm;
    }
    if (distance - radius > g->reach) return;
    if (distance < EXACT * radius) {
        add_exactly(g, corner, node);
        return;
    }
    float area = rsv_cell_area(s->elements, s->cell[k]);
    rsv_vec3 normal =
        v3_normalize(v3_cross(v3_sub(corner[1], corner[0]), v3_sub(corner[2], corner[0])));
    add_patch(g, &(patch){ centre, normal, squares / 12, area, node, RSV_NONE });
}

static void visit_cluster(const gathering *g, uint32_t index)
{
    const rsv_scatter_sources *s = g->sources;
    const rsv_scatter_cluster *c = &s->cluster[index];
    rsv_vec3 centre = v3_sub(c->centre, g->place);
    float distance = v3_length(centre);
    if (distance - c->radius > g->reach) return;
    float allowed = f_min(OPENING * distance, f_max(FAR_OPENING * distance, g->flat));
    if (c->radius < allowed) {
        uint32_t column = (uint32_t)s->elements->node_count + index;
        add_patch(g, &(patch){ centre, c->normal, c->spread, c->area, NULL, column });
    } else if (c->right) {
        visit_cluster(g, index + 1);
        visit_cluster(g, c->right);
    } else {
        for (uint32_t k = c->first_cell; k < c->first_cell + c->cell_count; k++)
            add_cell(g, k);
    }
}

/// The body that the cluster is the root of.
static void add_body(const gathering *g, uint32_t root)
{
    visit_cluster(g, root);
    settle_patches(g);
}

/// Whether the cells around a node leave a gap, as at creases and borders. Around inner nodes every neighbour belongs
/// to two of them.
static bool is_border(const rsv_elements *e, uint32_t node)
{
    uint32_t begin = e->support_begin[node], end = e->support_begin[node + 1];
    for (uint32_t i = 2 * begin; i < 2 * end; i++) {
        uint32_t support = e->support[i / 2], cells = 0;
        uint32_t neighbour = e->cell_node[support / 4][((support & 3) + 1 + (i & 1)) % 3];
        for (uint32_t j = begin; j < end; j++)
            for (uint32_t k = 0; k < 3; k++)
                cells += e->cell_node[e->support[j] / 4][k] == neighbour;
        if (cells < 2) return true;
    }
    return false;
}

/// How far into each of its cells a border node is looked at.
#define INSET 0.15f

/// Light at the border itself is half that of the other side, but only within the reach of the profile, and the node
/// represents its cells. So it gathers slightly inside each cell, for the light as interpolated there. Detail that
/// elements do not resolve is assumed to be as at the node, so that a vanishing profile gives the identity.
static void gather_inside(gathering *g, uint32_t support, float share)
{
    const rsv_scatter_sources *s = g->sources;
    uint32_t cell = support / 4, own = support & 3;
    rsv_vec3 corner[3], sum = v3(0, 0, 0);
    for (int k = 0; k < 3; k++) {
        corner[k] = rsv_scatter_corner(s->elements, cell, k);
        sum = v3_add(sum, corner[k]);
    }
    g->place = v3_mad(v3_scale(sum, INSET), 1 - 3 * INSET, corner[own]);
    g->share = share;
    add_body(g, s->body[s->face_body[s->elements->cell[cell].face]].root);
    double finest = (double)(RSV_PI / sqrtf(2 * rsv_cell_area(s->elements, cell)));
    rsv_rgb kept = rgb((float)rsv_diffusion_transfer((double)g->profile->d[0], finest),
        (float)rsv_diffusion_transfer((double)g->profile->d[1], finest),
        (float)rsv_diffusion_transfer((double)g->profile->d[2], finest));
    for (uint32_t k = 0; k < 3; k++)
        add_node(
            g, s->elements->cell_node[cell][k], rgb_scale(kept, k == own ? 2 * INSET : -INSET));
}

static void gather_at_border(gathering *g, uint32_t node)
{
    const rsv_elements *e = g->sources->elements;
    float area = 0;
    for (uint32_t k = e->support_begin[node]; k < e->support_begin[node + 1]; k++)
        area += rsv_cell_area(e, e->support[k] / 4);
    for (uint32_t k = e->support_begin[node]; k < e->support_begin[node + 1] && area > 0; k++)
        gather_inside(g, e->support[k], rsv_cell_area(e, e->support[k] / 4) / area);
}

static rsv_vec3 node_position(const rsv_elements *e, uint32_t node)
{
    uint32_t support = e->support[e->support_begin[node]];
    return rsv_scatter_corner(e, support / 4, (int)(support & 3));
}

void rsv_scatter_gather(const rsv_scatter_sources *s, uint32_t node, rsv_scatter_row *row)
{
    for (uint32_t k = 0; k < row->count; k++)
        row->listed[row->column[k]] = 0;
    row->count = 0;
    const rsv_scatter_body *body = &s->body[rsv_scatter_body_of(s, node)];
    float widest = rsv_scatter_profile_widest(&body->profile);
    gathering g = { s, &body->profile, node_position(s->elements, node), REACH * widest,
        DECAY * widest, 1e-3f * rsv_scatter_profile_narrowest(&body->profile), 1, row };
    if (is_border(s->elements, node))
        gather_at_border(&g, node);
    else
        add_body(&g, body->root);
    for (uint32_t k = 0; k < row->count; k++)
        row->weight[row->column[k]] = rgb_scale(row->weight[row->column[k]], 1 / KEPT_SHARE);
}
