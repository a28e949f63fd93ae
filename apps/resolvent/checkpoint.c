#include "checkpoint.h"

#include "command.h"
#include "crew.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static bool make_folder(const char *path) { return mkdir(path, 0777) == 0 || errno == EEXIST; }

static bool find_folder(cli_checkpoint *c)
{
    if (c->resume && access(c->rows, F_OK) != 0) {
        cli_error(
            "--resume: '%s' holds no rows of this scene by this version of the program", c->folder);
        return false;
    }
    if (make_folder(c->folder) && make_folder(c->rows)) return true;
    cli_error("--checkpoint %s: cannot make the folder: %s", c->folder, strerror(errno));
    return false;
}

static bool is_later(const struct stat *a, const struct stat *b)
{
    return a->st_mtim.tv_sec != b->st_mtim.tv_sec ? a->st_mtim.tv_sec > b->st_mtim.tv_sec
                                                  : a->st_mtim.tv_nsec > b->st_mtim.tv_nsec;
}

/// Finds the folder that was written to last of those for other scenes: this scene before it was edited, most likely. If
/// it is not, its rows are of no use, and do no harm.
static void find_earlier(cli_checkpoint *c)
{
    struct stat latest = { 0 };
    char version[64];
    int length = snprintf(version, sizeof version, "%s-", rsv_version());
    DIR *directory = opendir(c->folder);
    for (struct dirent *entry; directory && (entry = readdir(directory));) {
        struct stat info;
        char path[PATH_MAX];
        if (strncmp(entry->d_name, version, (size_t)length) != 0 ||
            snprintf(path, sizeof path, "%s/%s", c->folder, entry->d_name) >= PATH_MAX ||
            strcmp(path, c->rows) == 0 || stat(path, &info) != 0 || !S_ISDIR(info.st_mode))
            continue;
        if (c->earlier[0] && !is_later(&info, &latest)) continue;
        latest = info;
        memcpy(c->earlier, path, sizeof path);
    }
    if (directory) closedir(directory);
}

bool cli_checkpoint_prepare(
    cli_session *session, cli_checkpoint *c, const rsv_scene *scene, rsv_solve_desc *desc)
{
    char digits[RSV_FINGERPRINT_DIGITS + 1];
    if (!c->folder) return true;
    rsv_status status = rsv_scene_fingerprint(scene, digits);
    if (status != RSV_OK) {
        cli_report_failure(session, status);
        return false;
    }
    int length = snprintf(c->rows, PATH_MAX, "%s/%s-%.16s", c->folder, rsv_version(), digits);
    if (length >= PATH_MAX) {
        cli_error("--checkpoint: the name of the folder is too long");
        return false;
    }
    if (!find_folder(c)) return false;
    session->checkpoint = c->folder;
    desc->checkpoint = c->rows;
    find_earlier(c);
    if (c->earlier[0]) desc->earlier = c->earlier;
    return true;
}
