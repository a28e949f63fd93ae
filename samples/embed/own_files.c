/// A scene whose files are in the program, not on a disk: a Wavefront file and the library of materials it names.
#include <resolvent/resolvent.h>

#include <stdio.h>
#include <string.h>

static const char *const archive[][2] = {
    { "archive/room.obj", "mtllib paints.mtl\nv 0 0 0\nv 0 0 4\nv 4 0 4\nv 4 0 0\n"
                          "v 0 3 0\nv 4 3 0\nusemtl red\nf 1 2 3 4\nusemtl white\nf 1 4 6 5\n" },
    { "archive/paints.mtl", "newmtl red\nKd 0.8 0.1 0.1\nnewmtl white\nKd 0.8 0.8 0.8\n" },
};

static const char *find(const char *path)
{
    for (size_t k = 0; k < sizeof archive / sizeof *archive; k++)
        if (strcmp(archive[k][0], path) == 0) return archive[k][1];
    return NULL;
}

static int64_t size_of(void *user, const char *path)
{
    const char *text = find(path);
    (void)user;
    return text ? (int64_t)strlen(text) : -1;
}

static size_t read_bytes(void *user, const char *path, uint64_t offset, void *bytes, size_t count)
{
    (void)user;
    memcpy(bytes, find(path) + offset, count);
    return count;
}

int main(void)
{
    rsv_context *context = NULL;
    rsv_scene *scene = NULL;
    rsv_file_source files = { size_of, read_bytes, NULL };
    rsv_load_desc load = rsv_default_load_desc();
    load.files = &files;
    rsv_status status = rsv_context_create(NULL, &context);
    if (status == RSV_OK) status = rsv_scene_load_with(context, "archive/room.obj", &load, &scene);
    if (status == RSV_OK) {
        const rsv_scene_view *view = rsv_scene_get_view(scene);
        printf("%zu triangles\n", view->triangle_count);
        for (size_t k = 0; k < view->material_count; k++)
            printf("%s: albedo (%.1f, %.1f, %.1f)\n", view->material[k].name,
                (double)view->material[k].base_color.r, (double)view->material[k].base_color.g,
                (double)view->material[k].base_color.b);
    } else {
        fprintf(stderr, "error: %s\n", rsv_last_error());
    }
    rsv_scene_destroy(scene);
    rsv_context_destroy(context);
    return status != RSV_OK;
}
