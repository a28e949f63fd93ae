/// Assimp works in a child process: its importers crash on some malformed files, and there is nobody to mend them here.
#include "../scene/scene.h"
#include "assimp_file.h"
#include "child_process.h"
#include "scene_parts.h"

#include <sys/stat.h>

typedef struct job {
    const char *path;
    rsv_file_kind kind;
    const rsv_load_desc *desc;
} job;

static void log_to_answer(void *user, rsv_log_level level, const char *message)
{
    rsv_send_log(user, level, message);
}

/// With a context of its own: the caller's callbacks must not be called from a child.
static rsv_status convert(void *user, FILE *answer)
{
    const job *j = user;
    rsv_context_desc desc = rsv_default_context_desc();
    desc.thread_count = 1;
    desc.log = log_to_answer;
    desc.user = answer;
    rsv_context *context;
    rsv_status status = rsv_context_create(&desc, &context);
    if (status != RSV_OK) return status;
    status = rsv_assimp_convert(context, j->path, j->kind, j->desc, answer);
    rsv_context_destroy(context);
    return status;
}

/// The importer's nodes are placed in single precision; only the numbers of .obj were brought near before.
static void note_places(rsv_scene *scene)
{
    double farthest = 0;
    for (size_t k = 0; k < scene->instance_count; k++)
        for (int row = 12; row < 15; row++)
            farthest = fmax(farthest, fabs(scene->instance[k].transform[row]));
    rsv_scene_note_single(scene, farthest);
}

rsv_status rsv_assimp_read(
    const char *path, rsv_file_kind kind, const rsv_load_desc *desc, rsv_scene *scene)
{
    rsv_status status;
    rsv_context *context = rsv_scene_get_context(scene);
    job j = { path, kind, desc };
    uint8_t *answer = NULL;
    size_t count = 0;
    struct stat info;
    if (stat(path, &info) != 0) RSV_TRY(rsv_fail(RSV_ERROR_IO, "cannot be read"));
    RSV_TRY(rsv_in_child_process(context, convert, &j, (size_t)info.st_size, &answer, &count));
    RSV_TRY(rsv_receive_parts(answer, count, path, scene));
    if (kind != RSV_FILE_OBJ) note_places(scene);
cleanup:
    rsv_free(context, answer);
    return status;
}
