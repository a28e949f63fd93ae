/// Runs Assimp in a child process: its importers crash on some malformed files, and cannot be mended here.
#include "../scene/scene.h"
#include "assimp_file.h"
#include "child_process.h"
#include "file_source.h"
#include "scene_parts.h"

#include <string.h>

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

/// The libraries of materials that a Wavefront file names. @param text is cut up
static rsv_status know_libraries(rsv_context *context, const rsv_file_source *files,
    const char *path, char *text, rsv_known_files *known)
{
    char name[1024];
    const char *slash = strrchr(path, '/');
    int folder = slash ? (int)(slash - path) + 1 : 0;
    rsv_status status = RSV_OK;
    for (char *rest = text, *line; status == RSV_OK && (line = strtok_r(rest, "\r\n", &rest));) {
        line += strspn(line, " \t");
        if (strncmp(line, "mtllib", 6) != 0 || !strchr(" \t", line[6])) continue;
        line += 6 + strspn(line + 6, " \t");
        for (size_t end = strlen(line); end && strchr(" \t", line[end - 1]);)
            line[--end] = '\0';
        int length = snprintf(name, sizeof name, "%.*s%s", folder, path, line);
        if (length > 0 && (size_t)length < sizeof name)
            status = rsv_know_file(context, files, name, known);
    }
    return status;
}

/// Collects beforehand what the child will ask for, as it cannot call the caller's callbacks.
static rsv_status know_files(rsv_context *context, const rsv_file_source *files, const char *path,
    rsv_file_kind kind, rsv_known_files *known)
{
    char *text = NULL;
    size_t size;
    rsv_status status = rsv_know_file(context, files, path, known);
    if (status != RSV_OK || kind != RSV_FILE_OBJ) return status;
    RSV_TRY(rsv_file_read(context, files, path, &text, &size));
    RSV_TRY(know_libraries(context, files, path, text, known));
cleanup:
    rsv_free(context, text);
    return status;
}

rsv_status rsv_assimp_read(
    const char *path, rsv_file_kind kind, const rsv_load_desc *desc, rsv_scene *scene)
{
    rsv_status status;
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_known_files known = { .count = 0 };
    const rsv_file_source in_memory = rsv_known_source(&known);
    rsv_load_desc there = *desc;
    job j = { path, kind, &there };
    uint8_t *answer = NULL;
    size_t count = 0;
    int64_t size = rsv_file_size(desc->files, path);
    if (size < 0) RSV_TRY(rsv_fail(RSV_ERROR_IO, "cannot be read"));
    if (desc->files) {
        RSV_TRY(know_files(context, desc->files, path, kind, &known));
        there.files = &in_memory;
    }
    RSV_TRY(rsv_in_child_process(context, convert, &j, (size_t)size, &answer, &count));
    RSV_TRY(rsv_receive_parts(answer, count, desc->files, path, scene));
    if (kind != RSV_FILE_OBJ) note_places(scene);
cleanup:
    rsv_free(context, answer);
    rsv_forget_files(context, &known);
    return status;
}
