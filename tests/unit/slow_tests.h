/// Programs of two parts: quick tests, which the sanitizers run as well, and long sums; or of three.
#ifndef SLOW_TESTS_H
#define SLOW_TESTS_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

/// Exit status of a test program that takes `slow` as its only argument (see rsv_add_part in CMakeLists.txt).
#define RUN_HALF(argc, argv, quick, slow) RUN_HALF_WITH(argc, argv, quick, slow, NULL, NULL)

/// The same, with a third part for `./dev validate` alone, which runs the program with `long` as its only argument.
#define RUN_THIRD(argc, argv, quick, slow, longest)                                                \
    ((argc) > 1 && strcmp((argv)[1], "long") == 0 ? cmocka_run_group_tests(longest, NULL, NULL)    \
                                                  : RUN_HALF(argc, argv, quick, slow))

/// The same, with what is done before the first and after the last test (cmocka's group fixtures).
#define RUN_HALF_WITH(argc, argv, quick, slow, setup, teardown)                                    \
    ((argc) > 1 && strcmp((argv)[1], "slow") == 0                                                  \
            ? cmocka_run_group_tests(slow, setup, teardown)                                        \
            : cmocka_run_group_tests(quick, setup, teardown))

#endif
