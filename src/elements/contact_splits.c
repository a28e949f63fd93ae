#include "../core/parallel.h"
#include "contact.h"
#include "elements_constants.h"
#include "elements_internal.h"
#include "known_cells.h"
#include "open_corners.h"

static float cell_size(const rsv_elements *e, uint32_t cell)
{
    return sqrtf(2 * rsv_cell_area(e, cell));
}

/// Size above which a cell is split that other geometry cuts; INFINITY where nothing does.
/// @param growth NULL = cells have their usual size @param splits that the cell went through
static float finest_size(
    const rsv_elements *e, uint32_t cell, const rsv_growth *growth, uint32_t splits)
{
    uint8_t openness = e->cell_openness[cell];
    bool through = openness & RSV_CELL_CUT_THROUGH;
    uint32_t levels = through ? THIN_WALL_LEVELS : CONTACT_LEVELS;
    if (!through && !(openness & RSV_CELL_CUT)) return INFINITY;
    if (growth) {
        // Next to an object on a cell, the error of light does not depend on the cell's size, but its area shrinks with
        // it: with the square of the size that smooth light requires. Through a wall, light may be wrong by any factor.
        float larger = through ? 1 : growth->at(growth->user, e, cell);
        return RSV_GROWTH_TOLERANCE * larger * larger * ldexpf(e->spacing, -(int)levels);
    }
    if (splits >= levels) return INFINITY;
    float least = (through ? THIN_WALL_SIZE : CONTACT_SIZE) * e->spacing;
    return f_max(least, ldexpf(cell_size(e, cell), (int)splits - (int)levels));
}

typedef struct size_job {
    const rsv_elements *e;
    const rsv_growth *growth;
    uint32_t splits;
    float *finest; ///< [cell_count], out
} size_job;

static void size_cells(void *user, rsv_span span)
{
    const size_job *job = user;
    for (size_t c = span.begin; c < span.end; c++)
        job->finest[c] = finest_size(job->e, (uint32_t)c, job->growth, job->splits);
}

/// @param finest [cell_count], out
static void find_finest_sizes(
    const rsv_elements *e, const rsv_growth *growth, uint32_t splits, float *finest)
{
    size_job job = { e, growth, splits, finest };
    rsv_parallel_for(e->context, e->cell_count, 256, size_cells, &job);
}

/// Number of nodes that further splits would add if no cell below a given size were split. The cutting geometry is
/// assumed to be a line, which meets twice as many cells of half the size.
static double nodes_for(const rsv_elements *e, const float *finest, float least)
{
    double cells = 0;
    for (uint32_t c = 0; c < e->cell_count; c++) {
        float size = cell_size(e, c);
        for (uint32_t k = 0; size > f_max(least, finest[c]); k++) {
            cells += 1 << k;
            size /= 2;
        }
    }
    return RSV_NODES_PER_SPLIT * cells;
}

/// The splits that are affordable: those of all cells larger than `least`, and a share of those a step below it.
typedef struct allowance {
    float least, share;
} allowance;

/// @param most_nodes approximate limit @param least size that is known to be too small
static allowance afford(const rsv_elements *e, const float *finest, size_t most_nodes, float least)
{
    double most = (double)most_nodes, step_below = 0, nodes;
    for (;; least *= SIZE_STEP, step_below = nodes) {
        nodes = nodes_for(e, finest, least);
        if (nodes <= most) break;
    }
    // cells that are split here and there have fewer neighbours to share nodes with
    double share = (most - nodes) / (1.5 * (step_below - nodes));
    return (allowance){ least, step_below > 0 ? (float)share : 0 };
}

/// @param known decides if it knows the cell, because the limit depends on the whole scene
static bool is_affordable(const rsv_known_cells *known, const rsv_elements *e, uint32_t cell,
    float finest, const allowance *a)
{
    if (e->cell[cell].level >= RSV_MAX_LEVEL) return false;
    bool split;
    if (known && known->is_split(known->user, e, cell, &split)) return split;
    float size = cell_size(e, cell), drawn = rsv_unit_float(rsv_hash(cell));
    return size > f_max(a->least, finest) ||
           (drawn < a->share && size > f_max(a->least / SIZE_STEP, finest));
}

rsv_status rsv_elements_refine_contacts(const rsv_transport_scene *scene, size_t most_nodes,
    const rsv_growth *growth, rsv_elements **elements, uint64_t *rays)
{
    rsv_context *context = (*elements)->context;
    float least = THIN_WALL_SIZE * (*elements)->spacing;
    size_t most = (*elements)->node_count + most_nodes;
    rsv_elements *earlier = NULL;
    rsv_status status;
    for (uint32_t level = 0; level < THIN_WALL_LEVELS; level++) {
        rsv_elements *e = *elements;
        status = rsv_elements_find_open_corners(scene, earlier, e, rays);
        rsv_elements_destroy(earlier);
        earlier = NULL;
        if (status != RSV_OK) return status;
        uint8_t *split = rsv_alloc(context, e->cell_count, 1);
        float *finest = rsv_alloc(context, e->cell_count, sizeof *finest);
        size_t marked = 0;
        if (split && finest) {
            find_finest_sizes(e, growth, level, finest);
            size_t left = most > e->node_count ? most - e->node_count : 0;
            allowance a = afford(e, finest, left, least);
            for (uint32_t c = 0; c < e->cell_count; c++)
                marked += split[c] = is_affordable(scene->known_cells, e, c, finest[c], &a);
            least = a.least;
            if (marked) status = rsv_elements_refine(e, split, elements);
        } else {
            status = RSV_ERROR_MEMORY;
        }
        rsv_free(context, finest);
        rsv_free(context, split);
        if (status != RSV_OK || !marked) return status;
        earlier = e;
    }
    status = rsv_elements_find_open_corners(scene, earlier, *elements, rays);
    rsv_elements_destroy(earlier);
    return status;
}

// ---- contacts that come later ---------------------------------------------------------------------

/// The cell that was split into this one and others.
static rsv_cell parent_of(rsv_cell cell)
{
    bool both_odd = cell.i & cell.j & 1, both_even = !((cell.i | cell.j) & 1);
    bool middle = cell.flipped ? both_even : both_odd;
    cell.flipped = middle ? !cell.flipped : cell.flipped;
    cell.i /= 2;
    cell.j /= 2;
    cell.level--;
    return cell;
}

/// How many times a cell was split because something cut it.
static uint32_t splits_at_contacts(const rsv_elements *e, uint32_t cell)
{
    uint32_t count = 0;
    if (!e->slot_openness) return 0;
    for (rsv_cell c = e->cell[cell]; c.level > e->face_level[c.face];) {
        c = parent_of(c);
        uint32_t slot = rsv_elements_find_slot(e, &c);
        uint8_t then = slot == RSV_NONE ? 0 : e->slot_openness[slot];
        count += (then & (RSV_CELL_CUT | RSV_CELL_CUT_THROUGH)) != 0;
    }
    return count;
}

bool rsv_cell_wants_contact_split(const rsv_elements *e, uint32_t cell, float least)
{
    if (!(e->cell_openness[cell] & (RSV_CELL_CUT | RSV_CELL_CUT_THROUGH)) ||
        e->cell[cell].level >= RSV_MAX_LEVEL)
        return false;
    float finest = finest_size(e, cell, NULL, splits_at_contacts(e, cell));
    return cell_size(e, cell) > f_max(least, finest) * (1 + 1e-4f);
}

float rsv_elements_contact_size(const rsv_elements *e)
{
    size_t cut = 0, whole = 0, larger = 0;
    if (!e->cell_openness) return INFINITY;
    for (uint32_t c = 0; c < e->cell_count; c++) {
        cut += (e->cell_openness[c] & (RSV_CELL_CUT | RSV_CELL_CUT_THROUGH)) != 0;
        whole += rsv_cell_wants_contact_split(e, c, 0);
    }
    float size = THIN_WALL_SIZE * e->spacing;
    for (larger = whole; (float)larger > WHOLE_CONTACTS * (float)cut; size *= SIZE_STEP) {
        larger = 0;
        for (uint32_t c = 0; c < e->cell_count; c++)
            larger += rsv_cell_wants_contact_split(e, c, size);
    }
    return size;
}
