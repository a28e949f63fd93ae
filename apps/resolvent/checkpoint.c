#include "checkpoint.h"

#include "command.h"
#include "crew.h"

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
    return true;
}
