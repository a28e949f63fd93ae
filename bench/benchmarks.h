/// The benchmarks behind `resolvent bench`: each measures one scene into a JSON object, and prints such
/// an object as text.
#ifndef CLI_BENCHMARKS_H
#define CLI_BENCHMARKS_H

#include "options.h"
#include "session.h"

#include "resolvent/solve.h"

struct cJSON;

/// The quality of benchmarks that compare two.
enum { BENCH_DRAFT_AND_MEDIUM = RSV_QUALITY_HIGH + 1 };

/// The subject of a measurement, and its settings.
typedef struct cli_bench_task {
    cli_session *session;
    const char *scene;                   ///< file or built-in scene
    cli_environment environment;         ///< surroundings of the scene in bench quality
    uint32_t threads;                    ///< at least 1
    uint32_t repetitions;                ///< of every timed step
    uint32_t size;                       ///< quality: pixels along each side; fig8: rows of them
    cli_size frame_size;                 ///< fps, rooms and pictures
    cli_size judged_size;                ///< rooms: of frames that are compared with a reference
    int gloss;                           ///< fps and rooms: an rsv_frame_gloss
    uint32_t frames;                     ///< fps and rooms: length of the flight; 0 = a few seconds
    const char *assets, *cache, *strips; ///< rooms, pictures: folders; NULL = none
    uint32_t
        reference_samples; ///< quality, rooms, pictures: camera rays per pixel of the reference
    int quality;       ///< of those that solve with one: an rsv_quality, or BENCH_DRAFT_AND_MEDIUM
    uint32_t max_elements; ///< of those that solve with a quality; 0 = any number
    float max_seconds; ///< pictures: by the clock, for each scene
    uint32_t paths;    ///< certificate: of each reading of the truth, 0 = default
    cli_list references; ///< quality: pictures whose mean is the reference; none = render it
} cli_bench_task;

/// Opens the task's scene: "bright-box" is a closed box of albedo 0.95 with a lamp in it, those of moving_scenes.h are
/// rooms in which something moves, others are those of cli_open_scene. NULL after a message.
rsv_scene *cli_open_bench_scene(const cli_bench_task *bench);

/// How the task solves at this quality, with no more elements than it allows.
rsv_solve_desc cli_bench_solve_desc(const cli_bench_task *bench, int quality);

/// Opens the task's scene; the body of a built-in one has about this many triangles. NULL after an error message.
rsv_scene *cli_open_bench_body(const cli_bench_task *bench, size_t triangles);

/// Rays per second against one scene: single and in packets, coherent and not, nearest and any hit.
/// Like the functions below, prints errors on standard error.
bool cli_bench_trace(const cli_bench_task *bench, struct cJSON *result);
void cli_print_trace(const struct cJSON *result);

/// Assembly of the operator's rows compared with bare ray tracing of the same rays, in one run.
bool cli_bench_assemble(const cli_bench_task *bench, struct cJSON *result);
void cli_print_assemble(const struct cJSON *result);

/// The runtime for engines: light of 100,000 receivers from 4 lights. Takes no scene.
bool cli_bench_relight(const cli_bench_task *bench, struct cJSON *result);
void cli_print_relight(const struct cJSON *result);

/// Error over time, from scene to picture: mode final by quality, mode reference by samples.
bool cli_bench_quality(const cli_bench_task *bench, struct cJSON *result);
void cli_print_quality(const struct cJSON *result);

/// Writes the curve of cli_bench_quality as comma-separated text, and as a log-log plot in SVG.
/// @param scenes the results as an array; the first one counts
bool cli_write_quality_csv(const char *path, const struct cJSON *scenes);
bool cli_write_quality_plot(const char *path, const struct cJSON *scenes);

/// The same of a scene with fog; then frames of a flight, and a light that is dimmed. Its table and curve are those of
/// cli_bench_quality.
bool cli_bench_media(const cli_bench_task *bench, struct cJSON *result);
void cli_print_media(const struct cJSON *result);

/// Residual over applications of the operator, and over time, for every solver.
bool cli_bench_solvers(const cli_bench_task *bench, struct cJSON *result);
void cli_print_solvers(const struct cJSON *result);

/// Writes the curves of all scenes: comma-separated text, and a plot with one row per scene.
bool cli_write_solvers_csv(const char *path, const struct cJSON *scenes);
bool cli_write_solvers_plot(const char *path, const struct cJSON *scenes);

/// Bounds and estimates of certificates compared with true errors, over qualities and seeds.
bool cli_bench_certificate(const cli_bench_task *bench, struct cJSON *result);
void cli_print_certificate(const struct cJSON *result);
/// @param scenes the results as an array
void cli_print_certificate_summary(const struct cJSON *scenes);
bool cli_write_certificate_csv(const char *path, const struct cJSON *scenes);
bool cli_write_certificate_plot(const char *path, const struct cJSON *scenes);

/// Whole frames of a flight compared with bare tracing of their camera rays. With repetitions, also the cost of a
/// second eye, and whether 10,000 frames leak memory.
bool cli_bench_fps(const cli_bench_task *bench, struct cJSON *result);
void cli_print_fps(const struct cJSON *result);
bool cli_write_fps_csv(const char *path, const struct cJSON *scenes);
bool cli_write_fps_plot(const char *path, const struct cJSON *scenes);

/// Frames in real rooms and of glossy things: time, error while moving and at rest, flicker, a light that is switched.
bool cli_bench_rooms(const cli_bench_task *bench, struct cJSON *result);
void cli_print_rooms(const struct cJSON *result);
void cli_print_rooms_summary(const struct cJSON *scenes);
bool cli_write_rooms_csv(const char *path, const struct cJSON *scenes);
bool cli_write_rooms_plot(const char *path, const struct cJSON *scenes);

/// Time to given errors of pictures of rooms: from the file, of a second view, and relit, compared with mode reference.
bool cli_bench_pictures(const cli_bench_task *bench, struct cJSON *result);
void cli_print_pictures(const struct cJSON *result);
void cli_print_pictures_summary(const struct cJSON *scenes);
bool cli_write_pictures_csv(const char *path, const struct cJSON *scenes);

/// Bakes compared with path tracing: time, errors, blotches, seams, bytes.
bool cli_bench_bake(const cli_bench_task *bench, struct cJSON *result);
void cli_print_bake(const struct cJSON *result);
void cli_print_bake_summary(const struct cJSON *scenes);
bool cli_write_bake_csv(const char *path, const struct cJSON *scenes);

/// An object moved: a solve with data of the previous solution, compared with a solve from scratch.
bool cli_bench_rebake(const cli_bench_task *bench, struct cJSON *result);
void cli_print_rebake(const struct cJSON *result);
bool cli_write_rebake_csv(const char *path, const struct cJSON *scenes);

/// A light moved, and the strengths of all changed: the time until E0 is right, and until E is.
bool cli_bench_move(const cli_bench_task *bench, struct cJSON *result);
void cli_print_move(const struct cJSON *result);
bool cli_write_move_csv(const char *path, const struct cJSON *scenes);

/// Shadow rays of neighbours towards one lamp in packets, and nothing else.
typedef struct cli_shadow_rays cli_shadow_rays;

/// Shadow rays from vertices of the scene towards the light. @param rays out, to be destroyed even after an error
rsv_status cli_shadow_rays_create(
    const rsv_scene *scene, rsv_vec3 light, size_t count, uint32_t threads, cli_shadow_rays **rays);
void cli_shadow_rays_destroy(cli_shadow_rays *rays);
/// Seconds that they all take. @param coherent as in rsv_tracer_occluded_packet
double cli_shadow_rays_time(const cli_shadow_rays *rays, bool coherent);

/// Frames against ambient occlusion over the size of the mesh (figure 8 of the paper).
bool cli_bench_fig8(const cli_bench_task *bench, struct cJSON *result);
void cli_print_fig8(const struct cJSON *result);
bool cli_write_fig8_csv(const char *path, const struct cJSON *scenes);
bool cli_write_fig8_plot(const char *path, const struct cJSON *scenes);

/// Writes members of JSON objects as comma-separated text, one row per object, which starts with its member "scene".
bool cli_write_columns(
    const char *path, const struct cJSON *rows, const char *const *columns, size_t column_count);

/// An object that moves from frame to frame: updates of its light compared with solving from scratch.
bool cli_bench_moving(const cli_bench_task *bench, struct cJSON *result);
void cli_print_moving(const struct cJSON *result);
bool cli_write_moving_csv(const char *path, const struct cJSON *scenes);

/// Error of the first camera's picture over elements, with and without that picture as the goal.
bool cli_bench_goal(const cli_bench_task *bench, struct cJSON *result);
void cli_print_goal(const struct cJSON *result);
bool cli_write_goal_csv(const char *path, const struct cJSON *scenes);
bool cli_write_goal_plot(const char *path, const struct cJSON *scenes);

/// Rays over error of indirect light: on elements of its own, and on one level of elements as fine as direct light's.
bool cli_bench_levels(const cli_bench_task *bench, struct cJSON *result);
void cli_print_levels(const struct cJSON *result);
bool cli_write_levels_csv(const char *path, const struct cJSON *scenes);
bool cli_write_levels_plot(const char *path, const struct cJSON *scenes);

/// Time and memory of a solution over the size of a scene, at a constant spacing of elements.
bool cli_bench_scale(const cli_bench_task *bench, struct cJSON *result);
void cli_print_scale(const struct cJSON *result);
void cli_print_scale_summary(const struct cJSON *scenes);
bool cli_write_scale_csv(const char *path, const struct cJSON *scenes);
bool cli_write_scale_plot(const char *path, const struct cJSON *scenes);

/// How evenly rows can be divided among processes, and how much data those would have to exchange.
bool cli_bench_cluster(const cli_bench_task *bench, struct cJSON *result);
void cli_print_cluster(const struct cJSON *result);
bool cli_write_cluster_csv(const char *path, const struct cJSON *scenes);
bool cli_write_cluster_plot(const char *path, const struct cJSON *scenes);

/// Processes compared with threads, and scenes that grow with the processes, if there is an mpirun. @param result also
/// of cli_bench_cluster
bool cli_measure_scaling(const cli_bench_task *bench, struct cJSON *result);
void cli_print_scaling(const struct cJSON *result);

/// The GPU: the operator compared with copies of memory, solvers, relighting by factors. Prints a Markdown table.
bool cli_bench_gpu(const cli_bench_task *bench, struct cJSON *result);
void cli_print_gpu(const struct cJSON *result);

/// A number of a JSON object; NAN if it holds none of that name.
double cli_json_number(const struct cJSON *object, const char *name);

/// The middle of `count` values, which it sorts.
double cli_median(double *values, size_t count);

#endif
