/// Launches on the emulated device: loops.
#ifndef RSV_LAUNCH_EMULATED_H
#define RSV_LAUNCH_EMULATED_H

/// Runs `run` for items count - 1 .. 0, or notes it down where a recording is made.
void rsv_gpu_run(rsv_gpu *gpu, void (*run)(const void *args, uint32_t item), const void *args,
    size_t args_bytes, size_t count);

#define RSV_LAUNCH_LOOP(name, args)                                                                \
    _Static_assert(sizeof(args) <= RSV_ARGS_BYTES, "too many arguments");                          \
    RSV_LAUNCH(name, args);                                                                        \
    RSV_LAUNCH(name, args) { rsv_gpu_run(gpu, rsv_run_##name, a, sizeof *a, count); }

#define RSV_KERNEL(name, args, body)                                                               \
    static void rsv_run_##name(const void *a, uint32_t item) { body((const args *)a, item); }      \
    RSV_LAUNCH_LOOP(name, args)

#define RSV_KERNEL_SUM(name, args, value, lane, add, store)                                        \
    static void rsv_run_##name(const void *a, uint32_t item)                                       \
    {                                                                                              \
        value part[RSV_LANES];                                                                     \
        for (uint32_t k = 0; k < RSV_LANES; k++)                                                   \
            part[k] = lane((const args *)a, item, k);                                              \
        for (uint32_t half = RSV_LANES / 2; half > 0; half /= 2)                                   \
            for (uint32_t k = 0; k < half; k++)                                                    \
                part[k] = add(part[k], part[k + half]);                                            \
        store((const args *)a, item, part[0]);                                                     \
    }                                                                                              \
    RSV_LAUNCH_LOOP(name, args)

#endif
