/// Files of a test, in a folder of their own.
#ifndef RSV_TEST_FILE_FIXTURE_H
#define RSV_TEST_FILE_FIXTURE_H

#include "resolvent/io.h"
#include "scene_fixture.h"

#include <dirent.h>
#include <sys/stat.h>
#include <unistd.h>

/// A folder for one test's files.
typedef struct folder {
    char path[128];
} folder;

static inline folder new_folder(void)
{
    folder made;
    const char *root = getenv("TMPDIR");
    snprintf(made.path, sizeof made.path, "%.80s/resolvent-gltf-XXXXXX", root ? root : "/tmp");
    assert_non_null(mkdtemp(made.path));
    return made;
}

static inline void remove_folder(const char *path)
{
    DIR *directory = opendir(path);
    assert_non_null(directory);
    for (struct dirent *entry; (entry = readdir(directory));) {
        char name[512];
        if (entry->d_name[0] == '.') continue;
        snprintf(name, sizeof name, "%.200s/%s", path, entry->d_name);
        if (unlink(name) != 0) remove_folder(name);
    }
    closedir(directory);
    rmdir(path);
}

static inline const char *path_in(const folder *f, const char *name)
{
    static char path[256];
    snprintf(path, sizeof path, "%s/%s", f->path, name);
    return path;
}

static inline void write_bytes(const char *path, const void *data, size_t bytes)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, bytes, file), bytes);
    fclose(file);
}

static inline uint8_t *read_bytes(const char *path, size_t *bytes)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    *bytes = (size_t)ftell(file);
    rewind(file);
    uint8_t *data = malloc(*bytes + 1);
    assert_non_null(data);
    assert_int_equal(fread(data, 1, *bytes, file), *bytes);
    fclose(file);
    return data;
}

/// The scene of a file of these bytes, or NULL and one line of rsv_last_error() that names it.
static inline rsv_scene *load_written(fixture *f, const char *path, const void *bytes, size_t count)
{
    rsv_scene *scene = NULL;
    f->log[0] = '\0';
    write_bytes(path, bytes, count);
    if (rsv_scene_load(f->context, path, &scene) != RSV_OK) {
        assert_null(scene);
        assert_mentions(rsv_last_error(), strrchr(path, '/') + 1);
        assert_null(strchr(rsv_last_error(), '\n'));
    }
    return scene;
}

/// A context and a folder, for readers of files that hold no scene.
typedef struct file_fixture {
    rsv_context *context;
    folder folder;
} file_fixture;

static inline int file_set_up(void **state)
{
    static file_fixture f;
    assert_int_equal(rsv_context_create(NULL, &f.context), RSV_OK);
    f.folder = new_folder();
    *state = &f;
    return 0;
}

static inline int file_tear_down(void **state)
{
    file_fixture *f = *state;
    remove_folder(f->folder.path);
    rsv_context_destroy(f->context);
    return 0;
}

#endif
