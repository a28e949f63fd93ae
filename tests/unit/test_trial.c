/// Code of others tried on hostile input: whatever it does, the caller lives and learns of it.
#include "io/trial.h"

#include "scene_fixture.h"

#include <signal.h>
#include <sys/resource.h>

static rsv_status try_it(bool (*work)(void *, char *))
{
    int touched = 0;
    rsv_status status = rsv_trial(work, &touched, 100);
    assert_int_equal(touched, 0); // the copy's memory is not ours
    return status;
}

static bool succeeds(void *user, char *message)
{
    (void)message;
    *(int *)user = 1;
    return true;
}

static bool complains(void *user, char *message)
{
    (void)user;
    snprintf(message, RSV_TRIAL_MESSAGE_BYTES, "no triangles at all");
    return false;
}

static bool crashes(void *user, char *message)
{
    (void)user, (void)message;
    raise(SIGSEGV);
    return true;
}

/// An importer that believes a count in a file: it dies when it gets no memory, or goes on without.
static bool devours(void *user, char *message)
{
    (void)user, (void)message;
    enum { pieces = 4096, piece = 1 << 20 };
    for (int k = 0; k < pieces; k++) {
        volatile char *memory = malloc(piece);
        if (!memory) abort();
        memory[0] = memory[piece / 2] = 1;
    }
    return true;
}

static bool hangs(void *user, char *message)
{
    (void)user, (void)message;
    for (volatile unsigned long k = 0;; k++) {}
    return true;
}

static void good_work_is_let_through(void **state)
{
    (void)state;
    assert_int_equal(try_it(succeeds), RSV_OK);
}

static void a_complaint_is_passed_on(void **state)
{
    (void)state;
    assert_int_equal(try_it(complains), RSV_ERROR_FORMAT);
    assert_non_null(strstr(rsv_last_error(), "no triangles at all"));
}

static void a_crash_is_survived(void **state)
{
    (void)state;
    assert_int_equal(try_it(crashes), RSV_ERROR_FORMAT);
    assert_non_null(strstr(rsv_last_error(), "crashes"));
}

static void memory_is_bounded(void **state)
{
    (void)state;
    assert_int_equal(try_it(devours), RSV_ERROR_FORMAT);
}

/// The bound on time is the caller's own where that is tighter: one second, so that the test need not wait longer.
static void time_is_bounded(void **state)
{
    (void)state;
    struct rlimit before, second;
    assert_int_equal(getrlimit(RLIMIT_CPU, &before), 0);
    second = before;
    second.rlim_cur = 1;
    signal(SIGXCPU, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_CPU, &second), 0);
    rsv_status status = try_it(hangs);
    assert_int_equal(setrlimit(RLIMIT_CPU, &before), 0);
    signal(SIGXCPU, SIG_DFL);
    assert_int_equal(status, RSV_ERROR_FORMAT);
    assert_non_null(strstr(rsv_last_error(), "busy beyond all measure"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(good_work_is_let_through),
        cmocka_unit_test(a_complaint_is_passed_on),
        cmocka_unit_test(a_crash_is_survived),
        cmocka_unit_test(memory_is_bounded),
        cmocka_unit_test(time_is_bounded),
    };
    return cmocka_run_group_tests_name("trial", tests, NULL, NULL);
}
