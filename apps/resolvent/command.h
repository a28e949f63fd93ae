/// The program's commands and exit statuses.
///
/// Functions and types of the program start with `cli_`, so that every `rsv_` in these files is a call
/// of the library's public interface.
#ifndef CLI_COMMAND_H
#define CLI_COMMAND_H

enum cli_exit_status { CLI_SUCCESS = 0, CLI_FAILURE = 1, CLI_BAD_USAGE = 2 };

/// Each takes the arguments after the command's name and returns the exit status.
int cli_solve(int argc, char **argv);
int cli_relight(int argc, char **argv);
int cli_render(int argc, char **argv);
int cli_bake(int argc, char **argv);
int cli_probe(int argc, char **argv);
int cli_daylight(int argc, char **argv);
int cli_fit(int argc, char **argv);
int cli_certify(int argc, char **argv);
int cli_compare(int argc, char **argv);
int cli_layers(int argc, char **argv);
int cli_falsecolor(int argc, char **argv);
int cli_glare_command(int argc, char **argv);
int cli_sheet(int argc, char **argv);
int cli_scene(int argc, char **argv);
int cli_info(int argc, char **argv);
int cli_view(int argc, char **argv);

#endif
