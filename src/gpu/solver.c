/// Solvers on the device: steps are recorded once and replayed, a few at a time; in between the host reads how far they
/// got.
#include "../solver/stagnation.h"
#include "bicgstab_kernels.h"
#include "chebyshev_kernels.h"
#include "transport.h"

#include <string.h>

/// Applications of A in a recording.
#define APPLICATIONS 4

void rsv_gpu_solver_lay_out(rsv_device_transport *t, rsv_gpu_block *b)
{
    rsv_solver_args *s = &t->solver;
    size_t nodes = t->system.node_count;
    rsv_rgb **field[] = { &s->residual, &s->correction, &s->shadow, &s->p, &s->v, &s->t };
    s->node_count = (uint32_t)nodes;
    s->part_count = (uint32_t)((nodes + RSV_NODES_PER_SUM - 1) / RSV_NODES_PER_SUM);
    s->state = rsv_gpu_place(b, 1, sizeof *s->state);
    s->part = rsv_gpu_place(b, s->part_count, sizeof *s->part);
    for (size_t k = 0; k < sizeof field / sizeof field[0]; k++)
        *field[k] = rsv_gpu_place(b, nodes, sizeof **field[k]);
}

typedef void (*decide_launch)(rsv_gpu *gpu, const rsv_solver_args *args, size_t count);

/// Forms <a, b>, <b, b> and max |b| and decides.
static void decide(
    rsv_device_transport *t, const rsv_rgb *a, const rsv_rgb *b, decide_launch launch)
{
    rsv_solver_args s = t->solver;
    s.a = a;
    s.b = b;
    rsv_launch_reduce(t->gpu, &s, s.part_count);
    launch(t->gpu, &s, 1);
}

// ---- steps of the methods ------------------------------------------------------------------------

static void begin_nothing(rsv_device_transport *t) { (void)t; }

/// Two terms: each is the residual of the sum before it.
static void step_series(rsv_device_transport *t)
{
    rsv_solver_args s = t->solver;
    for (int term = 0; term < 2; term++) {
        rsv_rgb *next = term == 0 ? t->solver.v : t->solver.residual;
        s.residual = term == 0 ? t->solver.residual : t->solver.v;
        rsv_launch_series_add(t->gpu, &s, s.node_count);
        rsv_gpu_product(t, s.residual, next, rsv_launch_gather);
        decide(t, next, next, rsv_launch_series_check);
    }
}

static void begin_chebyshev(rsv_device_transport *t)
{
    rsv_gpu_clear(t->gpu, t->solver.p, t->system.node_count * sizeof *t->solver.p);
}

static void step_chebyshev(rsv_device_transport *t)
{
    const rsv_solver_args *s = &t->solver;
    rsv_launch_chebyshev_turn(t->gpu, s, s->node_count);
    rsv_gpu_product(t, s->p, s->v, rsv_launch_gather_system);
    rsv_launch_chebyshev_follow(t->gpu, s, s->node_count);
    decide(t, s->residual, s->residual, rsv_launch_chebyshev_check);
}

static void begin_bicgstab(rsv_device_transport *t)
{
    const rsv_solver_args *s = &t->solver;
    size_t bytes = t->system.node_count * sizeof *s->p;
    rsv_gpu_copy(t->gpu, s->shadow, s->residual, bytes);
    rsv_gpu_copy(t->gpu, s->p, s->residual, bytes);
}

static void step_bicgstab(rsv_device_transport *t)
{
    const rsv_solver_args *s = &t->solver;
    rsv_gpu_product(t, s->p, s->v, rsv_launch_gather_system);
    decide(t, s->shadow, s->v, rsv_launch_bicgstab_alpha);
    rsv_launch_bicgstab_half_step(t->gpu, s, s->node_count);
    rsv_gpu_product(t, s->residual, s->t, rsv_launch_gather_system);
    decide(t, s->residual, s->t, rsv_launch_bicgstab_omega);
    rsv_launch_bicgstab_whole_step(t->gpu, s, s->node_count);
    decide(t, s->shadow, s->residual, rsv_launch_bicgstab_beta);
    rsv_launch_bicgstab_turn(t->gpu, s, s->node_count);
}

typedef struct method {
    rsv_solver solver;
    uint32_t applications; ///< of A in a step
    void (*begin)(rsv_device_transport *transport);
    void (*step)(rsv_device_transport *transport);
} method;

static const method methods[] = {
    { RSV_SOLVER_NEUMANN, 2, begin_nothing, step_series },
    { RSV_SOLVER_CHEBYSHEV, 1, begin_chebyshev, step_chebyshev },
    { RSV_SOLVER_BICGSTAB, 2, begin_bicgstab, step_bicgstab },
};

// ---- solving -------------------------------------------------------------------------------------

enum { METHODS = sizeof methods / sizeof *methods };
_Static_assert(METHODS <= RSV_GPU_SOLVERS, "recordings have no room for so many solvers");

/// @return METHODS = that is none
static uint32_t method_of(rsv_solver solver)
{
    uint32_t k = 0;
    while (k < METHODS && methods[k].solver != solver)
        k++;
    return k;
}

bool rsv_gpu_solves(rsv_solver solver) { return method_of(solver) < METHODS; }

static rsv_gpu_recording *steps_of(rsv_device_transport *t, uint32_t k)
{
    if (t->steps[k]) return t->steps[k];
    rsv_gpu_record(t->gpu);
    for (uint32_t step = 0; step < APPLICATIONS / methods[k].applications; step++)
        methods[k].step(t);
    return t->steps[k] = rsv_gpu_recorded(t->gpu);
}

/// How far the worst channel is from its goal, as a factor; at most 1 = all have arrived.
static double excess(const rsv_solver_state *s)
{
    double worst = 0;
    for (int c = 0; c < 3; c++) {
        double factor = s->size[c] / s->goal[c];
        if (s->size[c] != 0 && !(factor <= worst)) worst = factor;
    }
    return worst;
}

/// Replays steps until there is nothing more to gain.
static void iterate(rsv_device_transport *t, uint32_t k, rsv_device_solve *solve)
{
    double best = INFINITY;
    uint32_t waiting = 0;
    while (t->gpu->status == RSV_OK) {
        rsv_solver_state state;
        memset(&state, 0, sizeof state);
        rsv_gpu_download(t->gpu, &state, t->solver.state, sizeof state);
        double now = excess(&state);
        solve->converged = now <= 1;
        if (now <= 1 || !(now < RSV_BLOW_UP * best) || state.broke_down) return;
        waiting = now < RSV_IMPROVEMENT * best ? 0 : waiting + APPLICATIONS;
        if (now < RSV_IMPROVEMENT * best) best = now;
        if (waiting >= RSV_PATIENCE || solve->applications >= solve->max_applications) return;
        if (solve->stops && solve->stops(solve->user)) return;
        rsv_gpu_replay(t->gpu, steps_of(t, k));
        solve->applications += APPLICATIONS;
    }
}

rsv_status rsv_gpu_solve(rsv_device_transport *t, rsv_device_solve *solve, const rsv_rgb *residual,
    rsv_rgb *correction, char *message)
{
    uint32_t k = method_of(solve->solver);
    size_t bytes = t->system.node_count * sizeof *residual;
    solve->applications = 0;
    solve->converged = false;
    rsv_gpu_transport_refresh(t);
    rsv_gpu_upload(t->gpu, t->solver.residual, residual, bytes);
    rsv_gpu_clear(t->gpu, t->solver.correction, bytes);
    t->solver.relative = solve->relative;
    decide(t, t->solver.residual, t->solver.residual, rsv_launch_begin);
    methods[k].begin(t);
    iterate(t, k, solve);
    rsv_gpu_download(t->gpu, correction, t->solver.correction, bytes);
    return rsv_gpu_wait(t->gpu, message);
}
