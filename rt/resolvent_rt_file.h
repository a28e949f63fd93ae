/// @file resolvent_rt_file.h
/// Operators and light bases from files, for the runtime: hosted C99 with cJSON. Take it as it is, or as a pattern for your
/// engine's own file system: the runtime itself knows no files.
#ifndef RESOLVENT_RT_FILE_H
#define RESOLVENT_RT_FILE_H

#include "resolvent_rt.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct rsv_rt_file {
    char message[320];    ///< what went wrong, one line that begins with the path
    char path[160];       ///< as it was opened, its end where it is long
    unsigned char *bytes; ///< the whole file
    size_t size;
    struct cJSON *header;
    size_t data;  ///< where the arrays begin
    float *owned; ///< of rsv_rt_file_direct, and of bases that were packed
} rsv_rt_file;

/// Reads a file in the safetensors layout. @return 0, or -1 with file->message; close it in either case
int rsv_rt_file_open(rsv_rt_file *file, const char *path);
/// Frees the file, and with it all arrays that were got from it.
void rsv_rt_file_close(rsv_rt_file *file);

/// An array by name. @param type "F32", "U32", ... @param count out: numbers in it; NULL = not of interest
/// @return borrowed; NULL with file->message if it is missing, of another type or beyond the end
const void *rsv_rt_file_array(rsv_rt_file *file, const char *name, const char *type, size_t *count);

/// Name of a light; NULL beyond the last.
const char *rsv_rt_file_light(const rsv_rt_file *file, uint32_t light);

/// The operator of an operator file, checked. Refuses what the runtime does not do: translucent materials, whose light
/// leaves elsewhere than it enters. @return 0, or -1 with file->message
int rsv_rt_file_operator(rsv_rt_file *file, rsv_rt_operator *transport);

/// E0 of an operator file light by light: value_count 1, receivers are the elements. Light that the rows themselves
/// found - large lamps, surroundings - is one light more at the end, without a name.
int rsv_rt_file_direct(rsv_rt_file *file, rsv_rt_basis *direct);

/// Receivers of an operator file that `resolvent bake --operator` wrote, checked: the vertices or texels of what was baked,
/// in the order that docs/bake.md tells. @return 0, or -1 with file->message
int rsv_rt_file_receivers(
    rsv_rt_file *file, const rsv_rt_operator *transport, rsv_rt_receivers *receivers);

/// The basis of a file that `resolvent bake` wrote. Those of `--packed` are unpacked where this file was compiled with
/// RSV_RT_ZLIB defined, and linked with zlib; else they are refused. @return 0, or -1 with file->message
int rsv_rt_file_basis(rsv_rt_file *file, rsv_rt_basis *basis);

/// The grid of a basis of probes (basis.value_count RSV_RT_SH_COUNT), for rsv_rt_probe_at. @return 0, or -1 with
/// file->message
int rsv_rt_file_probes(rsv_rt_file *file, const rsv_rt_basis *basis, rsv_rt_probe_grid *grid);

/// Surroundings of a basis that can be turned by rsv_rt_turn: the last `count` lights, all of one name.
typedef struct rsv_rt_file_turns {
    uint32_t first, count; ///< lights of the basis; count 0 = there are none to be turned
    float rotation;        ///< degrees of the first one, as `--env-rotate` has it
} rsv_rt_file_turns;

rsv_rt_file_turns rsv_rt_file_find_turns(const rsv_rt_file *file, const rsv_rt_basis *basis);

#ifdef __cplusplus
}
#endif

#endif
