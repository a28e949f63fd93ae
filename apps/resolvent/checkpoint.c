#include "checkpoint.h"

#include "command.h"
#include "crew.h"
#include "output_file.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { SCENE_DIGITS = 16 }; ///< of a scene's fingerprint, in the name of its folder

static bool make_folder(const char *path) { return mkdir(path, 0777) == 0 || errno == EEXIST; }

static bool find_folder(cli_checkpoint *c)
{
    if (c->resume && access(c->rows, F_OK) != 0) {
        cli_error("--resume: '%s' holds no rows of this scene from this version of the program",
            c->folder);
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

/// Whether an entry of the folder holds rows of another scene, written by this version of the program.
/// @param path out: [PATH_MAX] of the entry
static bool is_other_scene(const cli_checkpoint *c, const char *name, char *path)
{
    char version[64];
    struct stat info;
    int length = snprintf(version, sizeof version, "%s-", rsv_version());
    return strncmp(name, version, (size_t)length) == 0 &&
           strspn(name + length, "0123456789abcdef") == SCENE_DIGITS &&
           strlen(name) == (size_t)length + SCENE_DIGITS &&
           snprintf(path, PATH_MAX, "%s/%s", c->folder, name) < PATH_MAX &&
           strcmp(path, c->rows) != 0 && lstat(path, &info) == 0 && S_ISDIR(info.st_mode);
}

/// Whether a solution was finished there, with its data kept for later.
static bool is_finished(const char *path)
{
    bool found = false;
    DIR *directory = opendir(path);
    for (struct dirent *entry; directory && !found && (entry = readdir(directory));)
        found = cli_ends_in(entry->d_name, ".history");
    if (directory) closedir(directory);
    return found;
}

/// Finds the most recently written folder of another scene, preferring finished solutions: most likely this scene
/// before it was edited. If it is not, its contents are useless but harmless.
static void find_earlier(cli_checkpoint *c)
{
    struct stat latest = { 0 }, info;
    bool finished = false;
    char path[PATH_MAX];
    DIR *directory = opendir(c->folder);
    for (struct dirent *entry; directory && (entry = readdir(directory));) {
        if (!is_other_scene(c, entry->d_name, path) || stat(path, &info) != 0) continue;
        bool is = is_finished(path), better = is != finished ? is : is_later(&info, &latest);
        if (c->earlier[0] && !better) continue;
        latest = info;
        finished = is;
        memcpy(c->earlier, path, sizeof path);
    }
    if (directory) closedir(directory);
}

/// Removes a folder and the files in it that runs leave there.
static void remove_kept(const char *path)
{
    static const char *const endings[] = { ".rows", ".scene", ".history", ".part" };
    char file[PATH_MAX];
    DIR *directory = opendir(path);
    for (struct dirent *entry; directory && (entry = readdir(directory));) {
        bool ours = false;
        for (size_t k = 0; k < sizeof endings / sizeof endings[0]; k++)
            ours = ours || cli_ends_in(entry->d_name, endings[k]);
        if (ours && snprintf(file, sizeof file, "%s/%s", path, entry->d_name) < PATH_MAX)
            unlink(file);
    }
    if (directory) closedir(directory);
    rmdir(path);
}

void cli_checkpoint_prune(const cli_checkpoint *c)
{
    char path[PATH_MAX];
    if (!c->folder || !cli_crew_speaks() || !is_finished(c->rows)) return;
    DIR *directory = opendir(c->folder);
    for (struct dirent *entry; directory && (entry = readdir(directory));)
        if (is_other_scene(c, entry->d_name, path) && strcmp(path, c->earlier) != 0 &&
            is_finished(path))
            remove_kept(path);
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
