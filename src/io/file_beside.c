#include "file_beside.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

static bool is_file(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && S_ISREG(info.st_mode);
}

/// @return whether it is there, and its name not too long
static bool try_path(
    const char *folder, int length, const char *inner, const char *name, char *path, size_t size)
{
    int written = snprintf(path, size, "%.*s%s%s", length, folder, inner, name);
    return written > 0 && (size_t)written < size && is_file(path);
}

bool rsv_find_beside(const char *scene, const char *name, char *path, size_t size)
{
    static const char *const usual[] = { "", "textures/", "Textures/", "texture/", "tex/",
        "images/", "maps/", "../textures/" };
    char turned[1024];
    const char *slash = strrchr(scene, '/');
    int length = slash ? (int)(slash - scene) + 1 : 0;
    if (!*name || strlen(name) >= sizeof turned) return false;
    if (try_path(scene, *name == '/' ? 0 : length, "", name, path, size)) return true;
    snprintf(turned, sizeof turned, "%s", name);
    for (char *c = turned; *c; c++)
        if (*c == '\\') *c = '/';
    if (try_path(scene, *turned == '/' ? 0 : length, "", turned, path, size)) return true;
    const char *last = strrchr(turned, '/');
    last = last ? last + 1 : turned;
    for (size_t k = 0; *last && k < sizeof usual / sizeof *usual; k++)
        if (try_path(scene, length, usual[k], last, path, size)) return true;
    return false;
}
