/// The loop of an engine: reads a solved operator once, then follows its own lights from frame to frame, within a
/// budget.
///
///     engine_loop OPERATOR.safetensors [FRAMES]
///
/// The lights of the scene are switched on in turn. Direct light comes from the file, light by light; an engine can
/// supply its own instead. Bounced light follows at 200,000 operations per frame. It is shown at the vertices that the
/// file names (`resolvent bake --operator`), or at the elements if it names none (`resolvent solve`).
#include <resolvent_rt_file.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { OPERATIONS_PER_FRAME = 200000, TURN = 8 };

typedef struct engine {
    rsv_rt_file file;
    rsv_rt_operator transport;
    rsv_rt_basis lights; // direct light, light by light
    rsv_rt_solver solver;
    rsv_rt_receivers vertices; // count 0: the file names none
    float *scale, *direct, *irradiance, *exitance, *bounced, *at_vertices;
} engine;

static int load(engine *e, const char *path)
{
    if (rsv_rt_file_open(&e->file, path) != 0 ||
        rsv_rt_file_operator(&e->file, &e->transport) != 0 ||
        rsv_rt_file_direct(&e->file, &e->lights) != 0)
        return -1;
    rsv_rt_file_receivers(&e->file, &e->transport, &e->vertices);
    size_t elements = e->transport.element_count;
    e->scale = calloc(3 * (size_t)e->lights.light_count, sizeof *e->scale);
    e->direct = calloc(3 * elements, sizeof *e->direct);
    e->irradiance = calloc(3 * elements, sizeof *e->irradiance);
    e->exitance = malloc(4 * elements * sizeof *e->exitance);
    e->bounced = malloc(3 * elements * sizeof *e->bounced);
    e->at_vertices = calloc(3 * (size_t)e->vertices.count + 1, sizeof *e->at_vertices);
    if (!e->scale || !e->direct || !e->irradiance || !e->exitance || !e->bounced || !e->at_vertices)
        return -1;
    rsv_rt_solver_begin(&e->solver, &e->transport, e->irradiance, e->exitance);
    rsv_rt_solver_keep_bounced(&e->solver, e->bounced);
    return 0;
}

/// One light after the other shines, each for some frames.
static void animate(engine *e, int frame)
{
    uint32_t lit = (uint32_t)(frame / TURN) % e->lights.light_count;
    for (uint32_t k = 0; k < 3 * e->lights.light_count; k++)
        e->scale[k] = k / 3 == lit;
}

/// An engine would hand `at_vertices` to its shader, which adds direct light of its own.
static void draw(engine *e, int frame)
{
    double sum = 0;
    uint32_t count = e->vertices.count ? e->vertices.count : e->transport.element_count;
    const float *light = e->vertices.count ? e->at_vertices : e->bounced;
    rsv_rt_receive(&e->vertices, e->bounced, 0, e->vertices.count, e->at_vertices);
    for (size_t k = 1; k < 3 * (size_t)count; k += 3)
        sum += light[k];
    printf("frame %3d: mean green irradiance %.4g W/m2 at %u %s, last change %.2g\n", frame,
        sum / count, (unsigned)count, e->vertices.count ? "vertices" : "elements",
        e->solver.change);
}

int main(int argc, char **argv)
{
    engine e;
    memset(&e, 0, sizeof e);
    int frames = argc > 2 ? atoi(argv[2]) : 3 * TURN;
    int failed = argc < 2 || load(&e, argv[1]) != 0;
    if (failed)
        fprintf(stderr, "error: %s\n", argc < 2 ? "usage: engine_loop OPERATOR" : e.file.message);
    for (int frame = 0; !failed && frame < frames; frame++) {
        animate(&e, frame);
        rsv_rt_relight(
            &e.lights, e.scale, e.lights.light_count, 0, e.lights.receiver_count, e.direct);
        rsv_rt_solver_update(&e.solver, e.direct, OPERATIONS_PER_FRAME);
        draw(&e, frame);
    }
    rsv_rt_file_close(&e.file);
    free(e.scale);
    free(e.direct);
    free(e.irradiance);
    free(e.exitance);
    free(e.bounced);
    free(e.at_vertices);
    return failed;
}
