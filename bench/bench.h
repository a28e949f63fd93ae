/// `resolvent bench`, as the program calls it.
#ifndef CLI_BENCH_H
#define CLI_BENCH_H

/// Takes the arguments after the command's name. @return the exit status
int cli_bench(int argc, char **argv);

#endif
