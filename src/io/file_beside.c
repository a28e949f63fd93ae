#include "file_beside.h"

#include "file_source.h"

#include <stdio.h>
#include <string.h>

/// The first `length` letters of a folder's name.
typedef struct place {
    const rsv_file_source *files;
    const char *folder;
    int length;
} place;

/// @return whether it is there, and its name not too long
static bool try_path(
    const place *from, const char *inner, const char *name, char *path, size_t size)
{
    int written = snprintf(path, size, "%.*s%s%s", from->length, from->folder, inner, name);
    return written > 0 && (size_t)written < size && rsv_file_size(from->files, path) >= 0;
}

bool rsv_find_beside(
    const rsv_file_source *files, const char *scene, const char *name, char *path, size_t size)
{
    static const char *const usual[] = { "", "textures/", "Textures/", "texture/", "tex/",
        "images/", "maps/", "../textures/" };
    char turned[1024];
    const char *slash = strrchr(scene, '/');
    const place nowhere = { files, scene, 0 };
    const place beside = { files, scene, slash ? (int)(slash - scene) + 1 : 0 };
    if (!*name || strlen(name) >= sizeof turned) return false;
    if (try_path(*name == '/' ? &nowhere : &beside, "", name, path, size)) return true;
    snprintf(turned, sizeof turned, "%s", name);
    for (char *c = turned; *c; c++)
        if (*c == '\\') *c = '/';
    if (try_path(*turned == '/' ? &nowhere : &beside, "", turned, path, size)) return true;
    const char *last = strrchr(turned, '/');
    last = last ? last + 1 : turned;
    for (size_t k = 0; *last && k < sizeof usual / sizeof *usual; k++)
        if (try_path(&beside, usual[k], last, path, size)) return true;
    return false;
}
