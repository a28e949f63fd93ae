#include "command.h"
#include "options.h"
#include "output_file.h"
#include "session.h"

#include <string.h>

static const char help[] =
    "usage: resolvent scene NAME -o OUT.glb [--mesh FILE]\n"
    "\n"
    "Writes a built-in scene as binary glTF:\n"
    "\n"
    "  cornell-blocks   the Cornell box with its two white blocks, as published\n"
    "  cornell-spheres  the Cornell box with two glass spheres\n"
    "  cornell-glass    the Cornell box with a glass body\n"
    "  cornell-marble   the same with a marble body\n"
    "  cornell-plaster  the same with a plaster body\n"
    "  cornell-showcase the same with a smaller body, behind two glass spheres\n"
    "  character        a head and shoulders, to be lit by an environment\n"
    "  furnace          a closed box whose light is known exactly: all surfaces emit and reflect "
    "the same\n"
    "  two-rooms        light enters the second room through a door left ajar\n"
    "  gallery          a row of rooms with many lights; gallery:20 has 20 rooms (default 6)\n"
    "  terraces         stepped pyramids and wells under the sun; terraces:1e6 has about a million\n"
    "                   triangles (default 1e5)\n"
    "  fog-rooms        two-rooms in fog, with a shaft of light from the door\n"
    "  milk             a glass of milk on a table\n"
    "  smoke            a plume of smoke in the Cornell box\n"
    "\n"
    "  -o FILE            the file to write\n" CLI_MESH_HELP "\n"
    "examples:\n"
    "  resolvent scene cornell-spheres -o spheres.glb\n"
    "  resolvent scene cornell-glass --mesh dragon.ply -o dragon.glb\n"
    "  resolvent info spheres.glb\n";

static int run(cli_session *session, const char *name, const char *output)
{
    rsv_scene *scene = NULL;
    rsv_status status = cli_build_scene(session, name, &scene);
    if (status == RSV_OK) status = rsv_scene_save(scene, output);
    if (status != RSV_OK) cli_report_failure(session, status);
    rsv_scene_destroy(scene);
    return status == RSV_OK ? CLI_SUCCESS : CLI_FAILURE;
}

int cli_scene(int argc, char **argv)
{
    const char *name = NULL, *output = NULL, *mesh = NULL;
    const cli_option options[] = {
        { .name = "-o", .kind = CLI_TEXT, .value = &output },
        CLI_MESH_OPTION(&mesh),
        { .name = NULL },
    };
    const cli_usage usage = { "scene", help, options, "NAME of a built-in scene", 1, 1, NULL };
    int exit_status;
    if (!cli_parse(&usage, argc, argv, &name, &exit_status)) return exit_status;
    if (!output) return cli_usage_error("scene", "-o OUT.glb is missing");
    if (!cli_ends_in(output, ".glb"))
        return cli_usage_error("scene", "-o: '%s' does not end in .glb", output);
    if (!cli_check_output(output)) return CLI_FAILURE;
    cli_session session;
    if (!cli_session_begin(&session, 0)) return CLI_FAILURE;
    session.mesh = mesh;
    exit_status = run(&session, name, output);
    cli_session_end(&session);
    return exit_status;
}
