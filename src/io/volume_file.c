/// Densities of fog from files.
#include "../core/core.h"
#include "child_process.h"
#include "file_source.h"
#include "resolvent/io.h"
#include "volume_vdb.h"

#include <dlfcn.h>
#include <errno.h>
#include <string.h>

/// Names the file in a message that has been set.
static rsv_status name_file(const char *path, rsv_status status)
{
    char message[400];
    snprintf(message, sizeof message, "%s", rsv_last_error());
    return rsv_fail(status, "%s: %s", path, message);
}

/// In the child process.
static rsv_status work(void *user, FILE *answer)
{
    char message[RSV_VDB_MESSAGE_BYTES] = "";
    void *library = dlopen(RSV_VDB_PLUG_IN, RTLD_NOW | RTLD_LOCAL);
    if (!library)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "OpenVDB files need the plug-in " RSV_VDB_PLUG_IN
            ", which is built where libopenvdb-dev and libboost-dev are installed: %s",
            dlerror());
    rsv_vdb_converter convert = (rsv_vdb_converter)dlsym(library, RSV_VDB_CONVERT);
    if (!convert)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            RSV_VDB_PLUG_IN " belongs to another version of this program; install it again");
    rsv_status status = convert(user, answer, message);
    return status == RSV_OK ? RSV_OK : rsv_fail(status, "%s", message);
}

/// What a child sent may have gone astray.
static rsv_status take(const uint8_t *answer, size_t count, rsv_scene *scene, const rsv_fog *fog)
{
    rsv_vdb_header h;
    size_t points = 1;
    if (count < sizeof h) return rsv_fail(RSV_ERROR_FORMAT, "is damaged");
    memcpy(&h, answer, sizeof h);
    for (int k = 0; k < 3; k++) {
        if (h.side[k] < 2 || h.side[k] > RSV_VOLUME_MAX_POINTS / points)
            return rsv_fail(RSV_ERROR_FORMAT, "is damaged");
        points *= h.side[k];
    }
    if ((count - sizeof h) / sizeof(float) != points)
        return rsv_fail(RSV_ERROR_FORMAT, "is damaged");
    const void *density = answer + sizeof h;
    const rsv_volume_grid grid = { .side = { h.side[0], h.side[1], h.side[2] },
        .low = { h.low[0], h.low[1], h.low[2] },
        .high = { h.high[0], h.high[1], h.high[2] },
        .density = density };
    return rsv_scene_set_volume(scene, fog, &grid);
}

rsv_status rsv_scene_load_volume(rsv_scene *scene, const rsv_fog *fog, const char *path)
{
    rsv_context *context = rsv_scene_get_context(scene);
    uint8_t *answer = NULL;
    size_t count = 0;
    int64_t size = rsv_file_size(NULL, path);
    if (size < 0) return rsv_fail(RSV_ERROR_IO, "%s: cannot be opened: %s", path, strerror(errno));
    rsv_status status =
        rsv_in_child_process(context, work, (void *)path, (size_t)size, &answer, &count);
    if (status == RSV_OK) status = take(answer, count, scene, fog);
    rsv_free(context, answer);
    return status == RSV_OK ? status : name_file(path, status);
}
