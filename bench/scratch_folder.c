#include "scratch_folder.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

bool cli_make_scratch_folder(const char *benchmark, char *path)
{
    const char *root = getenv("TMPDIR");
    bool made = snprintf(path, PATH_MAX, "%s/resolvent-%s-XXXXXX", root && root[0] ? root : "/tmp",
                    benchmark) < PATH_MAX &&
                mkdtemp(path);
    if (!made) path[0] = 0;
    return made;
}

/// Sums up the files of a folder, and removes them if asked to.
static double visit_files(const char *path, bool remove_them)
{
    char file[PATH_MAX];
    struct stat info;
    double bytes = 0;
    DIR *directory = opendir(path);
    for (struct dirent *entry; directory && (entry = readdir(directory));) {
        if (entry->d_name[0] == '.' ||
            snprintf(file, sizeof file, "%s/%s", path, entry->d_name) >= (int)sizeof file)
            continue;
        if (stat(file, &info) == 0) bytes += (double)info.st_size;
        if (remove_them) remove(file);
    }
    if (directory) closedir(directory);
    return bytes;
}

void cli_remove_scratch_folder(const char *path)
{
    if (!path[0]) return;
    visit_files(path, true);
    rmdir(path);
}

double cli_scratch_folder_bytes(const char *path) { return visit_files(path, false); }
