#include "subject.h"

#include "command.h"
#include "crew.h"

#include "resolvent/scene.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

enum { default_longer_side = 512 };

/// Options that belong to the solve of a scene.
static bool refuse_scene_options(
    const cli_session *session, const char *name, const cli_environment *environment)
{
    if (session->mesh) {
        cli_error(
            "--mesh %s: '%s' is already solved, with its own scene; solve the scene again with this option",
            session->mesh, name);
        return false;
    }
    if (isfinite(session->moment.time)) {
        cli_error(
            "--time: '%s' is already solved, for one moment; solve the scene again with --time",
            name);
        return false;
    }
    const char *given = cli_reading_given(&session->reading);
    if (given) {
        cli_error(
            "%s: '%s' is already solved, with its own scene; solve the scene again with this option",
            given, name);
        return false;
    }
    bool surrounded = environment && (environment->path || environment->intensity != 1 ||
                                         environment->rotation != 0);
    if (environment && environment->fog.medium) {
        cli_error(
            "--fog: '%s' is already solved, with its own air; solve the scene again with --fog",
            name);
        return false;
    }
    if (surrounded)
        cli_error(
            "--env: '%s' is already solved, with its own environment; solve the scene again with --env",
            name);
    return !surrounded;
}

bool cli_is_operator(const char *name)
{
    struct stat info;
    if (rsv_is_operator_file(name)) return true;
    bool found = stat(name, &info) == 0;
    if (!found && !rsv_scene_is_builtin(name))
        cli_error("%s: cannot be opened: %s", name, strerror(errno));
    else if (found && !S_ISREG(info.st_mode))
        cli_error("%s: is a folder, pipe or device, not a regular file", name);
    else
        cli_error(
            "%s: it is not an operator file; `resolvent solve SCENE -o FILE.safetensors` writes "
            "one",
            name);
    return false;
}

bool cli_open_subject(cli_session *session, const char *name, const cli_environment *environment,
    cli_subject *subject)
{
    *subject = (cli_subject){ 0 };
    if (!rsv_is_operator_file(name)) {
        subject->scene = cli_open_scene(session, name, environment);
        return subject->scene != NULL;
    }
    if (!refuse_scene_options(session, name, environment)) return false;
    double started = cli_seconds();
    rsv_status status = rsv_light_load(session->context, name, &subject->scene, &subject->solution);
    if (status == RSV_OK && !session->keep_document) rsv_scene_drop_document(subject->scene);
    if (status == RSV_OK) status = rsv_scene_compare(subject->scene);
    session->time_load = cli_seconds() - started;
    if (status != RSV_OK) cli_report_failure(session, status);
    return status == RSV_OK;
}

static bool wants_petsc(const cli_solve_choice *choice)
{
    return choice->petsc || choice->solver == RSV_SOLVER_PETSC;
}

bool cli_prepare_solve(const cli_solve_choice *choice)
{
    return !wants_petsc(choice) || cli_crew_join_for_petsc(choice->petsc);
}

rsv_solve_desc cli_describe_solve(const cli_solve_choice *choice)
{
    rsv_solve_desc desc = rsv_default_solve_desc((rsv_quality)choice->quality);
    desc.solver = wants_petsc(choice) ? RSV_SOLVER_PETSC : (rsv_solver)choice->solver;
    desc.seed = choice->seed;
    desc.max_elements = choice->max_elements;
    desc.max_bytes = choice->max_bytes;
    return desc;
}

/// Warns of solve options that have no effect on an operator file.
static void warn_of_idle_options(
    cli_session *session, const rsv_solve_desc *desc, const cli_error_target *target)
{
    const struct {
        bool given;
        const char *name;
    } option[] = { { desc->solver != RSV_SOLVER_AUTO, "--solver" },
        { target->share > 0, "--error" }, { desc->max_elements > 0, "--max-elements" },
        { desc->max_bytes > 0, "--max-memory" }, { desc->goal_camera != RSV_NONE, "--goal" },
        { desc->goal_point_count > 0, "--points" } };
    for (size_t k = 0; k < sizeof option / sizeof option[0]; k++)
        if (option[k].given) {
            char text[96];
            snprintf(text, sizeof text,
                "%s has no effect: the operator file already holds a solution", option[k].name);
            cli_warn(session, text);
        }
}

rsv_status cli_solve_subject(cli_session *session, const rsv_solve_desc *desc,
    const cli_error_target *target, cli_subject *subject, rsv_certificate *certificate)
{
    static const cli_error_target none = { 0 };
    if (!target) target = &none;
    if (!subject->solution)
        return cli_solve_to_target(subject->scene, desc, target, &subject->solution, certificate);
    warn_of_idle_options(session, desc, target);
    return RSV_OK;
}

void cli_close_subject(cli_subject *subject)
{
    rsv_light_destroy(subject->solution);
    rsv_scene_destroy(subject->scene);
    *subject = (cli_subject){ 0 };
}

cli_size cli_default_size(const rsv_camera *camera)
{
    float aspect = camera->aspect > 0 ? camera->aspect : 1;
    float shorter = roundf(default_longer_side * fminf(aspect, 1 / aspect));
    uint32_t side = shorter < 1 ? 1 : (uint32_t)shorter;
    return aspect >= 1 ? (cli_size){ default_longer_side, side }
                       : (cli_size){ side, default_longer_side };
}
