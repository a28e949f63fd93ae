/// @file resolvent_rt_file.h
/// Reads operators and light bases from files, for the runtime: hosted C99 with cJSON. Use it as it is, or as a pattern
/// for your engine's own file system: the runtime itself does not read files.
#ifndef RESOLVENT_RT_FILE_H
#define RESOLVENT_RT_FILE_H

#include "resolvent_rt.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct rsv_rt_file {
    char message[320];    ///< the last error, one line that begins with the path
    char path[160];       ///< as it was opened; of a long path only the end
    unsigned char *bytes; ///< the whole file
    size_t size;
    struct cJSON *header;
    size_t data;  ///< offset of the first array
    float *owned; ///< memory for rsv_rt_file_direct and for unpacked bases
} rsv_rt_file;

/// Reads a file in the safetensors format. @return 0, or -1 with file->message; close it in either case
int rsv_rt_file_open(rsv_rt_file *file, const char *path);
/// Frees the file and all arrays obtained from it.
void rsv_rt_file_close(rsv_rt_file *file);

/// Finds an array by name. @param type "F32", "U32", ... @param count out: its number of values; NULL = not needed
/// @return borrowed; NULL with file->message if it is missing, has another type or goes beyond the end of the file
const void *rsv_rt_file_array(rsv_rt_file *file, const char *name, const char *type, size_t *count);

/// Name of a light; NULL beyond the last.
const char *rsv_rt_file_light(const rsv_rt_file *file, uint32_t light);

/// The operator of an operator file, checked. Fails for files with translucent materials, whose light leaves elsewhere
/// than it enters: the runtime does not support them. @return 0, or -1 with file->message
int rsv_rt_file_operator(rsv_rt_file *file, rsv_rt_operator *transport);

/// E0 of an operator file, light by light: value_count is 1, receivers are the elements. Light that the rows found
/// themselves (large lamps, surroundings) is one more light at the end, without a name. @return 0, or -1 with
/// file->message
int rsv_rt_file_direct(rsv_rt_file *file, rsv_rt_basis *direct);

/// The receivers of an operator file that `resolvent bake --operator` wrote, checked: the baked vertices or texels, in
/// the order given in docs/bake-reference.md. @return 0, or -1 with file->message
int rsv_rt_file_receivers(
    rsv_rt_file *file, const rsv_rt_operator *transport, rsv_rt_receivers *receivers);

/// The basis of a file that `resolvent bake` wrote. Files made with `--packed` can be read only if this source was
/// compiled with RSV_RT_ZLIB defined, and linked with zlib. @return 0, or -1 with file->message
int rsv_rt_file_basis(rsv_rt_file *file, rsv_rt_basis *basis);

/// The grid of a basis of probes (basis.value_count RSV_RT_SH_COUNT), for rsv_rt_probe_at. @return 0, or -1 with
/// file->message
int rsv_rt_file_probes(rsv_rt_file *file, const rsv_rt_basis *basis, rsv_rt_probe_grid *grid);

/// The surroundings of a basis that rsv_rt_turn can turn: the last `count` lights, all of the same name.
typedef struct rsv_rt_file_turns {
    uint32_t first, count; ///< lights of the basis; count 0 = no surroundings to turn
    float rotation;        ///< degrees of the first one, as in `--env-rotate`
} rsv_rt_file_turns;

rsv_rt_file_turns rsv_rt_file_find_turns(const rsv_rt_file *file, const rsv_rt_basis *basis);

#ifdef __cplusplus
}
#endif

#endif
