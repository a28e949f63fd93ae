/// The benchmarks behind `resolvent bench`.
#ifndef CLI_BENCH_H
#define CLI_BENCH_H

#include "session.h"

struct cJSON;

/// Rays per second against one scene: single and in packets, coherent and not, nearest and any hit.
/// @param result receives `bvh_s` and the object `rays_per_second`
rsv_status cli_bench_trace(const rsv_scene *scene, uint32_t threads, struct cJSON *result);

#endif
