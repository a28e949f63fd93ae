/// Test programs in two parts: quick tests, which the sanitizers also run, and slow ones; or in three. And reductions
/// for the sanitizers.
#ifndef SLOW_TESTS_H
#define SLOW_TESTS_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

/// Smaller numbers for the sanitizers, which take five times as long.
#ifdef __SANITIZE_ADDRESS__
#define UNLESS_SANITIZED(all, sanitized) (sanitized)
#else
#define UNLESS_SANITIZED(all, sanitized) (all)
#endif

/// Whether the only argument selects more than the quick tests: `slow` or `long`, see rsv_add_part in CMakeLists.txt.
static inline int asks_for_more(int argc, char **argv)
{
    return argc > 1 && (strcmp(argv[1], "slow") == 0 || strcmp(argv[1], "long") == 0);
}

/// Exit status of a test program of two parts.
#define RUN_HALF(argc, argv, quick, slow) RUN_HALF_WITH(argc, argv, quick, slow, NULL, NULL)

/// The same, with a third part for `long`.
#define RUN_THIRD(argc, argv, quick, slow, longest)                                                \
    ((argc) > 1 && strcmp((argv)[1], "long") == 0 ? cmocka_run_group_tests(longest, NULL, NULL)    \
                                                  : RUN_HALF(argc, argv, quick, slow))

/// The same, with functions to run before the first and after the last test (cmocka's group fixtures).
#define RUN_HALF_WITH(argc, argv, quick, slow, setup, teardown)                                    \
    (asks_for_more(argc, argv) ? cmocka_run_group_tests(slow, setup, teardown)                     \
                               : cmocka_run_group_tests(quick, setup, teardown))

#endif
