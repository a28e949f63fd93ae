/// The `resolvent` program: finds the command and hands over.
#include "bench.h"
#include "command.h"
#include "crew.h"
#include "device.h"
#include "options.h"

#include "resolvent/scene.h"

#include <errno.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <stdio.h>
#include <string.h>

typedef struct command {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *summary;
} command;

static const command commands[] = {
    { "render", cli_render, "render a picture of a scene" },
    { "solve", cli_solve, "solve the light of a scene once and save it as an operator file" },
    { "relight", cli_relight, "change the lights and colours of an operator file" },
    { "bake", cli_bake, "write the light of a scene into a glTF file, for engines and web pages" },
    { "view", cli_view, "fly through a scene and change its lights, in a window" },
    { "probe", cli_probe, "read irradiance or lux at points, with standard errors" },
    { "daylight", cli_daylight, "report daylight over a year of weather" },
    { "fit", cli_fit, "find how far to dim lights to reach target lux with the least power" },
    { "certify", cli_certify, "measure how accurate a solution is" },
    { "compare", cli_compare, "measure how one picture differs from another" },
    { "layers", cli_layers, "show the layers of a picture side by side" },
    { "falsecolor", cli_falsecolor, "show luminance or lux in colours, with a scale" },
    { "glare", cli_glare_command, "compute glare of a view: DGP and UGR" },
    { "sheet", cli_sheet, "arrange pictures side by side" },
    { "scene", cli_scene, "write a built-in scene as a .glb file" },
    { "info", cli_info, "list the contents of a scene, and check it for mistakes" },
    { "bench", cli_bench, "measure this machine" },
};

static const size_t command_count = sizeof commands / sizeof commands[0];

static void print_help(void)
{
    printf("resolvent %s - global illumination as one linear equation, solved once and reused\n\n"
           "usage: resolvent COMMAND [...]\n\ncommands:\n",
        rsv_version());
    for (size_t i = 0; i < command_count; i++)
        printf("  %-10s %s\n", commands[i].name, commands[i].summary);
    printf("\n"
           "`resolvent COMMAND --help` explains a command, with examples. To begin:\n\n"
           "  resolvent render cornell-spheres -o spheres.png\n"
           "  resolvent view cornell-spheres\n\n"
           "SCENE is a file (.gltf, .glb, .obj, .ply, .fbx, .dae, .stl) or the name of a built-in "
           "scene:");
    for (const char *const *name = rsv_scene_builtin_names(); *name; name++)
        printf(" %s", *name);
    printf(
        "\nExit status: 0 success, 2 wrong usage, 1 any other error, with one line that says why.\n");
}

static const command *find_command(const char *name)
{
    for (size_t i = 0; i < command_count; i++)
        if (strcmp(commands[i].name, name) == 0) return &commands[i];
    return NULL;
}

static int report_unknown_command(const char *name)
{
    const char *names[sizeof commands / sizeof commands[0]];
    for (size_t i = 0; i < command_count; i++)
        names[i] = commands[i].name;
    return cli_unknown_name(NULL, name, "a command", names, command_count);
}

/// Results that a full disk swallowed are a failure.
static int flush_results(int exit_status)
{
    if (fflush(stdout) == 0 && !ferror(stdout)) return exit_status;
    fprintf(stderr, "error: cannot write to standard output: %s\n", strerror(errno));
    return CLI_FAILURE;
}

/// Runs a command. If it does not share work, only the first process runs it.
static int run_command(const command *found, int argc, char **argv)
{
    bool shared = found->run == cli_render || found->run == cli_solve ||
                  found->run == cli_relight ||
                  (found->run == cli_bench && argc > 0 && strcmp(argv[0], "scale") == 0);
    if (!shared && !cli_crew_speaks()) return CLI_SUCCESS;
    if (shared && !cli_crew_join()) return CLI_FAILURE;
    int exit_status = found->run(argc, argv);
    cli_device_close();
    return cli_crew_leave(exit_status);
}

/// Without this check, a program built for AVX2 would crash on other CPUs.
static bool processor_serves(void)
{
#if defined(__x86_64__) && defined(__AVX2__)
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
    return true;
#endif
}

/// Prints all commands, or the help of the one named; "all" after it includes all of its options.
static int help(int argc, char **argv)
{
    static char option[] = "--help";
    char *arguments[] = { option, argc > 1 ? argv[1] : NULL, NULL };
    const command *found = argc > 0 ? find_command(argv[0]) : NULL;
    if (found) return found->run(argc > 1 ? 2 : 1, arguments);
    if (argc > 0) return report_unknown_command(argv[0]);
    print_help();
    return CLI_SUCCESS;
}

/// Returns large blocks to the system as soon as they are freed. By default, the GNU C library may keep up to 32 MiB of
/// each size, which doubles the peak memory of readers.
static void return_large_blocks(void)
{
#ifdef M_MMAP_THRESHOLD
    mallopt(M_MMAP_THRESHOLD, 4 << 20);
#endif
}

int main(int argc, char **argv)
{
    return_large_blocks();
    if (!processor_serves()) {
        fputs("error: this program requires a CPU with AVX2, which this machine lacks; build it "
              "with -DRSV_AVX2=OFF\n",
            stderr);
        return CLI_FAILURE;
    }
    if (argc < 2) return cli_usage_error(NULL, "no command given");
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0 ||
        strcmp(argv[1], "help") == 0)
        return help(argc - 2, argv + 2);
    if (strcmp(argv[1], "--version") == 0) {
        printf("resolvent %s\n", rsv_version());
        return CLI_SUCCESS;
    }
    const command *found = find_command(argv[1]);
    if (!found) return report_unknown_command(argv[1]);
    return flush_results(run_command(found, argc - 2, argv + 2));
}
