#include "matrix.h"

#include <string.h>

static const rsv_division *division_of(const rsv_mpi_rows *r)
{
    return r->system.transport->division;
}

static size_t node_count(const rsv_mpi_rows *r) { return r->system.transport->row_count; }

// ---- which values a process needs ----------------------------------------------------------------

/// Marks the nodes that its rows refer to, and the parents of those that hang.
static void mark_needed(const rsv_mpi_rows *r, uint8_t *needed)
{
    const rsv_transport *t = r->system.transport;
    const rsv_elements *e = r->system.elements;
    if (r->system.scatter) { // clusters of a translucent body reach all over it
        memset(needed, 1, t->row_count);
        return;
    }
    for (size_t n = 0; n < t->row_count; n++) {
        rsv_transport_row row = rsv_transport_row_at(t, n);
        for (size_t k = 0; k < row.count; k++)
            needed[row.column[k]] = 1;
        for (size_t k = 0; k < row.tinted_count; k++)
            needed[row.tinted_column[k]] = 1;
    }
    for (size_t h = e->hanging_count; h-- > 0;) // children come after their parents
        for (int p = 0; p < RSV_PARENTS && needed[e->hanging[h].node]; p++)
            if (e->hanging[h].weight[p] > 0) needed[e->hanging[h].parent[p]] = 1;
}

/// Values of nodes that hang follow from those of their parents and need not be sent.
static bool is_sent(const rsv_mpi_rows *r, const uint8_t *needed, size_t node)
{
    return needed[node] &&
           (r->system.scatter || r->system.elements->node_hanging[node] == RSV_NONE);
}

static PetscErrorCode list_needed(rsv_mpi_rows *r)
{
    const rsv_elements *e = r->system.elements;
    uint8_t *needed;
    PetscFunctionBeginUser;
    PetscCall(PetscCalloc1(node_count(r) + 1, &needed));
    mark_needed(r, needed);
    for (size_t n = 0; n < node_count(r); n++)
        r->needed_count += is_sent(r, needed, n);
    PetscCall(PetscMalloc1(r->needed_count + 1, &r->needed));
    PetscCall(PetscMalloc1(e->hanging_count + 1, &r->hanging));
    for (size_t n = 0, k = 0; n < node_count(r); n++)
        if (is_sent(r, needed, n)) r->needed[k++] = (uint32_t)n;
    for (size_t h = 0; h < e->hanging_count; h++)
        if (needed[e->hanging[h].node]) r->hanging[r->hanging_count++] = (uint32_t)h;
    PetscCall(PetscFree(needed));
    PetscFunctionReturn(0);
}

/// How much comes from how many others.
static void count_traffic(rsv_mpi_rows *r, const PetscInt *place)
{
    const rsv_division *d = division_of(r);
    for (uint32_t part = 0; d && part < d->part_count; part++) {
        size_t from = 0;
        for (size_t k = 0; k < r->needed_count && part != d->part; k++)
            from += (size_t)place[k] >= d->begin[part] && (size_t)place[k] < d->begin[part + 1];
        r->traffic.received += 3 * from;
        r->traffic.senders += from > 0;
    }
}

static PetscErrorCode create_exchange(rsv_mpi_rows *r)
{
    PetscInt *along, *place;
    Vec x;
    IS from;
    PetscFunctionBeginUser;
    PetscCall(PetscMalloc2(node_count(r) + 1, &along, r->needed_count + 1, &place));
    for (size_t k = 0; k < node_count(r); k++)
        along[r->order[k]] = (PetscInt)k;
    for (size_t k = 0; k < r->needed_count; k++)
        place[k] = along[r->needed[k]];
    count_traffic(r, place);
    PetscCall(ISCreateBlock(
        r->communicator, 3, (PetscInt)r->needed_count, place, PETSC_COPY_VALUES, &from));
    PetscCall(VecCreateMPI(r->communicator, (PetscInt)(3 * r->count), PETSC_DETERMINE, &x));
    PetscCall(VecCreateSeq(PETSC_COMM_SELF, (PetscInt)(3 * r->needed_count), &r->values));
    PetscCall(VecScatterCreate(x, from, r->values, NULL, &r->exchange));
    PetscCall(ISDestroy(&from));
    PetscCall(VecDestroy(&x));
    PetscCall(PetscFree2(along, place));
    PetscFunctionReturn(0);
}

PetscErrorCode rsv_mpi_rows_create(const rsv_krylov_system *system, rsv_mpi_rows *r)
{
    PetscFunctionBeginUser;
    *r = (rsv_mpi_rows){ .system = *system,
        .communicator = rsv_mpi_communicator(system->team),
        .count = system->transport->row_count };
    const rsv_division *d = division_of(r);
    if (d) {
        r->first = d->begin[d->part];
        r->count = d->begin[d->part + 1] - r->first;
        r->order = d->order;
    } else {
        PetscCall(PetscMalloc1(node_count(r) + 1, &r->identity));
        for (size_t n = 0; n < node_count(r); n++)
            r->identity[n] = (uint32_t)n;
        r->order = r->identity;
    }
    PetscCall(PetscCalloc1(node_count(r) + 1, &r->filled));
    PetscCall(PetscCalloc1(node_count(r) + 1, &r->exitance));
    PetscCall(list_needed(r));
    PetscCall(create_exchange(r));
    PetscFunctionReturn(0);
}

void rsv_mpi_rows_destroy(rsv_mpi_rows *r)
{
    PetscCallVoid(VecScatterDestroy(&r->exchange));
    PetscCallVoid(VecDestroy(&r->values));
    PetscCallVoid(PetscFree(r->identity));
    PetscCallVoid(PetscFree(r->needed));
    PetscCallVoid(PetscFree(r->hanging));
    PetscCallVoid(PetscFree(r->filled));
    PetscCallVoid(PetscFree(r->exitance));
}

// ---- products ------------------------------------------------------------------------------------

/// B = K E at the needed nodes.
static PetscErrorCode scatter(rsv_mpi_rows *r, Vec x)
{
    const rsv_krylov_system *s = &r->system;
    const PetscScalar *value;
    PetscFunctionBeginUser;
    PetscCall(VecScatterBegin(r->exchange, x, r->values, INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecScatterEnd(r->exchange, x, r->values, INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecGetArrayRead(r->values, &value));
    for (size_t k = 0; k < r->needed_count; k++)
        r->filled[r->needed[k]] =
            rgb((float)value[3 * k], (float)value[3 * k + 1], (float)value[3 * k + 2]);
    PetscCall(VecRestoreArrayRead(r->values, &value));
    if (s->scatter) {
        s->scatter(s->user, r->filled, r->exitance);
        PetscFunctionReturn(0);
    }
    for (size_t k = 0; k < r->needed_count; k++) {
        uint32_t n = r->needed[k];
        r->exitance[n] = rgb_mul(s->albedo[n], r->filled[n]);
    }
    for (size_t k = 0; k < r->hanging_count; k++) {
        const rsv_hanging *h = &s->elements->hanging[r->hanging[k]];
        rsv_rgb sum = rgb_gray(0);
        for (int p = 0; p < RSV_PARENTS; p++)
            if (h->weight[p] > 0) sum = rgb_mad(sum, h->weight[p], r->filled[h->parent[p]]);
        r->filled[h->node] = sum;
        r->exitance[h->node] = rgb_mul(s->albedo[h->node], sum);
    }
    PetscFunctionReturn(0);
}

/// One row of G B, with sums in double.
static void gather_row(const rsv_transport *t, const rsv_rgb *exitance, size_t node, double sum[3])
{
    rsv_transport_row row = rsv_transport_row_at(t, node);
    sum[0] = sum[1] = sum[2] = 0;
    for (size_t k = 0; k < row.count; k++) {
        rsv_rgb b = exitance[row.column[k]];
        sum[0] += (double)b.r, sum[1] += (double)b.g, sum[2] += (double)b.b;
    }
    for (size_t k = 0; k < row.tinted_count; k++) {
        rsv_rgb b = rgb_mul(row.tinted_weight[k], exitance[row.tinted_column[k]]);
        sum[0] += (double)b.r, sum[1] += (double)b.g, sum[2] += (double)b.b;
    }
    for (int c = 0; c < 3; c++)
        sum[c] *= (double)t->scale[node];
}

typedef struct product_job {
    const rsv_mpi_rows *rows;
    const PetscScalar *in;
    PetscScalar *out;
    double base, sign;
} product_job;

static void multiply_rows(void *data, rsv_span span)
{
    const product_job *job = data;
    const rsv_mpi_rows *r = job->rows;
    for (size_t k = span.begin; k < span.end; k++) {
        double sum[3];
        gather_row(r->system.transport, r->exitance, r->order[r->first + k], sum);
        for (size_t i = 3 * k; i < 3 * k + 3; i++)
            job->out[i] = job->base * job->in[i] + job->sign * sum[i - 3 * k];
    }
}

/// y = base x + sign G K x
static PetscErrorCode multiply(Mat matrix, Vec x, Vec y, double base, double sign)
{
    rsv_mpi_rows *r;
    const PetscScalar *in;
    PetscScalar *out;
    PetscFunctionBeginUser;
    PetscCall(MatShellGetContext(matrix, &r));
    PetscCall(scatter(r, x));
    PetscCall(VecGetArrayRead(x, &in));
    PetscCall(VecGetArrayWrite(y, &out));
    product_job job = { r, in, out, base, sign };
    r->system.parallel_for(r->system.context, r->count, 64, multiply_rows, &job);
    PetscCall(VecRestoreArrayWrite(y, &out));
    PetscCall(VecRestoreArrayRead(x, &in));
    PetscFunctionReturn(0);
}

static PetscErrorCode multiply_gather(Mat matrix, Vec x, Vec y)
{
    return multiply(matrix, x, y, 0, 1);
}

static PetscErrorCode multiply_system(Mat matrix, Vec x, Vec y)
{
    return multiply(matrix, x, y, 1, -1);
}

static PetscErrorCode create_shell(
    rsv_mpi_rows *r, PetscErrorCode (*product)(Mat, Vec, Vec), Mat *matrix)
{
    PetscInt local = (PetscInt)(3 * r->count);
    PetscFunctionBeginUser;
    PetscCall(
        MatCreateShell(r->communicator, local, local, PETSC_DETERMINE, PETSC_DETERMINE, r, matrix));
    PetscCall(MatShellSetOperation(*matrix, MATOP_MULT, (void (*)(void))product));
    PetscFunctionReturn(0);
}

PetscErrorCode rsv_mpi_shell_gather(rsv_mpi_rows *r, Mat *matrix)
{
    return create_shell(r, multiply_gather, matrix);
}

PetscErrorCode rsv_mpi_shell_system(rsv_mpi_rows *r, Mat *matrix)
{
    return create_shell(r, multiply_system, matrix);
}

// ---- entry by entry ------------------------------------------------------------------------------

/// The entries of one row of G K, channel by channel, summed by node.
typedef struct row_sums {
    double (*sum)[3]; ///< [node_count] 0 except at listed nodes
    uint8_t *listed;  ///< [node_count]
    uint32_t *node;   ///< [count]
    size_t count;
} row_sums;

static void add_node(const rsv_elements *e, row_sums *row, uint32_t node, const double weight[3])
{
    uint32_t hangs = e->node_hanging[node];
    if (hangs != RSV_NONE) {
        const rsv_hanging *h = &e->hanging[hangs];
        for (int p = 0; p < RSV_PARENTS; p++) {
            double w = (double)h->weight[p];
            if (w > 0)
                add_node(e, row, h->parent[p],
                    (const double[3]){ w * weight[0], w * weight[1], w * weight[2] });
        }
        return;
    }
    if (!row->listed[node]) row->node[row->count++] = node;
    row->listed[node] = 1;
    for (int c = 0; c < 3; c++)
        row->sum[node][c] += weight[c];
}

static void clear_row(row_sums *row)
{
    for (size_t k = 0; k < row->count; k++) {
        memset(row->sum[row->node[k]], 0, sizeof *row->sum);
        row->listed[row->node[k]] = 0;
    }
    row->count = 0;
}

static void sum_row(const rsv_mpi_rows *r, size_t node, row_sums *row)
{
    const rsv_transport *t = r->system.transport;
    rsv_transport_row entry = rsv_transport_row_at(t, node);
    double scale = (double)t->scale[node];
    clear_row(row);
    for (size_t k = 0; k < entry.count; k++) {
        rsv_rgb a = r->system.albedo[entry.column[k]];
        const double weight[3] = { scale * (double)a.r, scale * (double)a.g, scale * (double)a.b };
        add_node(r->system.elements, row, entry.column[k], weight);
    }
    for (size_t k = 0; k < entry.tinted_count; k++) {
        rsv_rgb a = rgb_mul(r->system.albedo[entry.tinted_column[k]], entry.tinted_weight[k]);
        const double weight[3] = { scale * (double)a.r, scale * (double)a.g, scale * (double)a.b };
        add_node(r->system.elements, row, entry.tinted_column[k], weight);
    }
}

/// Goes through the rows twice: to count entries, and to set them.
static PetscErrorCode fill(const rsv_mpi_rows *r, const PetscInt *along, row_sums *row, Mat matrix)
{
    PetscInt *own, *other;
    PetscFunctionBeginUser;
    PetscCall(PetscMalloc2(3 * r->count + 1, &own, 3 * r->count + 1, &other));
    for (size_t k = 0; k < r->count; k++) {
        PetscInt inside = 1; // the diagonal
        sum_row(r, r->order[r->first + k], row);
        for (size_t j = 0; j < row->count; j++) {
            size_t place = (size_t)along[row->node[j]];
            inside += place >= r->first && place < r->first + r->count;
        }
        for (size_t c = 0; c < 3; c++) {
            own[3 * k + c] = inside;
            other[3 * k + c] = (PetscInt)row->count + 1 - inside;
        }
    }
    PetscCall(MatSeqAIJSetPreallocation(matrix, 0, own));
    PetscCall(MatMPIAIJSetPreallocation(matrix, 0, own, 0, other));
    PetscCall(PetscFree2(own, other));
    for (size_t k = 0; k < r->count; k++) {
        sum_row(r, r->order[r->first + k], row);
        for (PetscInt c = 0; c < 3; c++) {
            PetscInt at = 3 * (PetscInt)(r->first + k) + c;
            PetscCall(MatSetValue(matrix, at, at, 1, ADD_VALUES));
            for (size_t j = 0; j < row->count; j++)
                PetscCall(MatSetValue(matrix, at, 3 * along[row->node[j]] + c,
                    -row->sum[row->node[j]][c], ADD_VALUES));
        }
    }
    PetscCall(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
    PetscFunctionReturn(0);
}

PetscErrorCode rsv_mpi_assembled_system(rsv_mpi_rows *r, Mat *matrix)
{
    PetscInt local = (PetscInt)(3 * r->count), *along;
    row_sums row = { 0 };
    PetscFunctionBeginUser;
    PetscCheck(!r->system.scatter, r->communicator, PETSC_ERR_SUP,
        "translucent materials couple whole bodies; use -resolvent_mat_type shell");
    PetscCall(MatCreate(r->communicator, matrix));
    PetscCall(MatSetSizes(*matrix, local, local, PETSC_DETERMINE, PETSC_DETERMINE));
    PetscCall(MatSetType(*matrix, MATAIJ));
    PetscCall(PetscMalloc2(node_count(r) + 1, &along, node_count(r) + 1, &row.node));
    PetscCall(PetscCalloc2(node_count(r) + 1, &row.sum, node_count(r) + 1, &row.listed));
    for (size_t k = 0; k < node_count(r); k++)
        along[r->order[k]] = (PetscInt)k;
    PetscCall(fill(r, along, &row, *matrix));
    PetscCall(PetscFree2(along, row.node));
    PetscCall(PetscFree2(row.sum, row.listed));
    PetscFunctionReturn(0);
}

// ---- fields --------------------------------------------------------------------------------------

PetscErrorCode rsv_mpi_set(const rsv_mpi_rows *r, const rsv_rgb *field, Vec x)
{
    PetscScalar *out;
    PetscFunctionBeginUser;
    PetscCall(VecGetArrayWrite(x, &out));
    for (size_t k = 0; k < r->count; k++) {
        rsv_rgb value = field[r->order[r->first + k]];
        out[3 * k] = (double)value.r;
        out[3 * k + 1] = (double)value.g;
        out[3 * k + 2] = (double)value.b;
    }
    PetscCall(VecRestoreArrayWrite(x, &out));
    PetscFunctionReturn(0);
}

PetscErrorCode rsv_mpi_get(const rsv_mpi_rows *r, Vec x, rsv_rgb *field)
{
    const PetscScalar *in;
    const rsv_division *d = division_of(r);
    rsv_rgb *along;
    PetscFunctionBeginUser;
    PetscCall(PetscMalloc1(node_count(r) + 1, &along));
    PetscCall(VecGetArrayRead(x, &in));
    for (size_t k = 0; k < r->count; k++)
        along[r->first + k] = rgb((float)in[3 * k], (float)in[3 * k + 1], (float)in[3 * k + 2]);
    PetscCall(VecRestoreArrayRead(x, &in));
    if (d) r->system.team->table->share(r->system.team, along, sizeof *along, d->begin);
    for (size_t k = 0; k < node_count(r); k++)
        field[r->order[k]] = along[k];
    PetscCall(PetscFree(along));
    PetscFunctionReturn(0);
}
