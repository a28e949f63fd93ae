/// The `resolvent` program: finds the command and hands over.
#include "bench.h"
#include "command.h"
#include "crew.h"
#include "device.h"
#include "options.h"

#include "resolvent/scene.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

typedef struct command {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *summary;
} command;

static const command commands[] = {
    { "render", cli_render, "a picture of a scene, from the solved operator or path traced" },
    { "solve", cli_solve, "the solved operator of a scene, kept in a file" },
    { "relight", cli_relight, "a solved operator under other lights and colours" },
    { "bake", cli_bake, "solved light in a glTF file, for engines and web pages" },
    { "view", cli_view, "a window onto the light of a scene, or frames of one by a script" },
    { "probe", cli_probe, "irradiance at the points of a CSV file, with its standard error" },
    { "daylight", cli_daylight, "daylight at sensors over a year of weather, for reports" },
    { "fit", cli_fit, "strengths of lights that meet wanted lux at least power" },
    { "certify", cli_certify, "how wrong the solved light of a scene is: a bound and an estimate" },
    { "compare", cli_compare, "how one picture differs from another" },
    { "layers", cli_layers, "the layers of a picture side by side" },
    { "falsecolor", cli_falsecolor,
        "the luminance of a picture in colours, with a scale in cd/m2" },
    { "glare", cli_glare_command, "glare of a fisheye view: DGP and UGR" },
    { "sheet", cli_sheet, "pictures side by side" },
    { "scene", cli_scene, "write a built-in scene as a .glb file" },
    { "info", cli_info, "what a scene holds: counts, bounds, materials, lights, cameras" },
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
           "  resolvent render cornell-spheres -o judge.exr --mode reference\n\n"
           "SCENE is a file (.gltf, .glb, .obj, .ply, .fbx, .dae, .stl) or the name of a built-in "
           "scene:");
    for (const char *const *name = rsv_scene_builtin_names(); *name; name++)
        printf(" %s", *name);
    printf(
        "\nExit status: 0 success, 2 wrong usage, 1 anything else, with one line that says why.\n");
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

/// What is not worth sharing, the first process does alone.
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

/// A program that is built for AVX2 would end without a word elsewhere.
static bool processor_serves(void)
{
#if defined(__x86_64__) && defined(__AVX2__)
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
    return true;
#endif
}

/// All commands, or the one that is named.
static int help(int argc, char **argv)
{
    static char option[] = "--help";
    char *arguments[] = { option, NULL };
    const command *found = argc > 0 ? find_command(argv[0]) : NULL;
    if (found) return found->run(1, arguments);
    if (argc > 0) return report_unknown_command(argv[0]);
    print_help();
    return CLI_SUCCESS;
}

int main(int argc, char **argv)
{
    if (!processor_serves()) {
        fputs(
            "error: this program is built for processors with AVX2, which this one lacks; build it "
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
