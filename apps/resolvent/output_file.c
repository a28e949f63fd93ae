#include "output_file.h"

#include "session.h"

#include <cJSON.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

bool cli_ends_in(const char *path, const char *end)
{
    size_t length = strlen(path), tail = strlen(end);
    return length > tail && strcasecmp(path + length - tail, end) == 0;
}

/// "dir/file" -> "dir", "file" -> "."
static void folder_of(const char *path, char *folder, size_t size)
{
    const char *slash = strrchr(path, '/');
    if (!slash)
        snprintf(folder, size, ".");
    else
        snprintf(folder, size, "%.*s", slash == path ? 1 : (int)(slash - path), path);
}

/// True for files that rename() must not replace: devices, pipes, sockets.
static bool is_special_file(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode);
}

bool cli_check_output(const char *path)
{
    struct stat info;
    char folder[PATH_MAX];
    if (stat(path, &info) == 0 && S_ISDIR(info.st_mode)) {
        cli_error("%s: is a folder; name a file in it", path);
        return false;
    }
    if (is_special_file(path)) return true;
    folder_of(path, folder, sizeof folder);
    if (access(folder, W_OK | X_OK) != 0) {
        cli_error("%s: cannot write in the folder '%s': %s%s", path, folder, strerror(errno),
            errno == ENOENT ? "; create it first" : "");
        return false;
    }
    return true;
}

static bool is_same_file(const char *a, const char *b)
{
    struct stat one, other;
    if (strcmp(a, b) == 0) return true;
    return stat(a, &one) == 0 && stat(b, &other) == 0 && one.st_dev == other.st_dev &&
           one.st_ino == other.st_ino;
}

bool cli_make_folder(const char *option, const char *path, bool *made)
{
    struct stat info;
    bool is_new = mkdir(path, 0777) == 0;
    int cause = errno;
    if (made) *made = is_new;
    if (is_new || (stat(path, &info) == 0 && S_ISDIR(info.st_mode))) return true;
    cli_error("%s %s: the folder cannot be made: %s", option, path, strerror(cause));
    return false;
}

bool cli_check_apart(const char *path, const char *other)
{
    if (!path || !other || is_special_file(path) || !is_same_file(path, other)) return true;
    cli_error("%s: would overwrite '%s'; write to another file", path, other);
    return false;
}

static bool write_all(int file, const char *text, size_t length)
{
    while (length > 0) {
        ssize_t written = write(file, text, length);
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return false;
        text += written;
        length -= (size_t)written;
    }
    return true;
}

static bool write_in_place(const char *path, const char *text, size_t length)
{
    int file = open(path, O_WRONLY);
    bool written = file >= 0 && write_all(file, text, length);
    return file >= 0 && close(file) == 0 && written;
}

/// The name of the temporary file does not grow with that of `path`, which may be as long as the file
/// system allows.
static bool write_and_rename(const char *path, const char *text, size_t length)
{
    char folder[PATH_MAX], temporary[PATH_MAX + 32];
    folder_of(path, folder, sizeof folder);
    snprintf(temporary, sizeof temporary, "%s/.resolvent-%ld.part", folder, (long)getpid());
    int file = open(temporary, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    if (file < 0) return false;
    bool written = write_all(file, text, length);
    if (close(file) != 0) written = false;
    if (written) written = rename(temporary, path) == 0;
    if (!written) unlink(temporary);
    return written;
}

bool cli_write_file(const char *path, const char *text, size_t length)
{
    char *linked = realpath(path, NULL); // rename() would replace a symbolic link, not its target
    const char *target = linked ? linked : path;
    bool written = is_special_file(target) ? write_in_place(target, text, length)
                                           : write_and_rename(target, text, length);
    if (!written) cli_error("%s: cannot be written: %s", path, strerror(errno));
    free(linked);
    return written;
}

bool cli_write_json(const char *path, const struct cJSON *root)
{
    char *text = cJSON_Print(root), *line = NULL;
    int length = text ? asprintf(&line, "%s\n", text) : -1;
    free(text);
    if (length < 0) {
        cli_error("out of memory writing JSON");
        return false;
    }
    bool written = path ? cli_write_file(path, line, (size_t)length) : fputs(line, stdout) >= 0;
    free(line);
    return written;
}
