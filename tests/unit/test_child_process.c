/// Third-party code in a child process on hostile input: the caller always survives and gets a message.
#include "io/child_process.h"

#include "core/core.h"

#include "scene_fixture.h"

#include <signal.h>
#include <sys/resource.h>

static rsv_status try_it(rsv_child_work work)
{
    int touched = 0;
    uint8_t *answer;
    size_t count;
    rsv_context *context;
    assert_int_equal(rsv_context_create(NULL, &context), RSV_OK);
    rsv_status status = rsv_in_child_process(context, work, &touched, 100, &answer, &count);
    assert_int_equal(touched, 0); // the copy's memory is not ours
    if (status == RSV_OK) {
        assert_int_equal(count, 6);
        assert_memory_equal(answer, "result", 6);
    } else {
        assert_null(answer);
        assert_int_equal(count, 0);
    }
    rsv_free(context, answer);
    rsv_context_destroy(context);
    return status;
}

static rsv_status succeeds(void *user, FILE *answer)
{
    *(int *)user = 1;
    fputs("result", answer);
    return RSV_OK;
}

static rsv_status complains(void *user, FILE *answer)
{
    (void)user;
    fputs("half a res", answer);
    return rsv_fail(RSV_ERROR_UNSUPPORTED, "no triangles at all");
}

static rsv_status babbles(void *user, FILE *answer)
{
    (void)user;
    static const char nonsense[1 << 20];
    while (fwrite(nonsense, sizeof nonsense, 1, answer) == 1) {}
    return RSV_OK;
}

static rsv_status crashes(void *user, FILE *answer)
{
    (void)user, (void)answer;
    raise(SIGSEGV);
    return RSV_OK;
}

/// An importer that trusts a count in a file: without memory it either crashes or continues.
static rsv_status devours(void *user, FILE *answer)
{
    (void)user, (void)answer;
    enum { pieces = 4096, piece = 1 << 20 };
    for (int k = 0; k < pieces; k++) {
        volatile char *memory = malloc(piece);
        if (!memory) abort();
        memory[0] = memory[piece / 2] = 1;
    }
    return RSV_OK;
}

static rsv_status hangs(void *user, FILE *answer)
{
    (void)user, (void)answer;
    for (volatile unsigned long k = 0;; k++) {}
    return RSV_OK;
}

static void good_work_is_let_through(void **state)
{
    (void)state;
    assert_int_equal(try_it(succeeds), RSV_OK);
}

static void a_complaint_is_passed_on(void **state)
{
    (void)state;
    assert_int_equal(try_it(complains), RSV_ERROR_UNSUPPORTED);
    assert_non_null(strstr(rsv_last_error(), "no triangles at all"));
}

static void a_crash_is_survived(void **state)
{
    (void)state;
    assert_int_equal(try_it(crashes), RSV_ERROR_FORMAT);
    assert_non_null(strstr(rsv_last_error(), "importer crash"));
}

static void memory_is_bounded(void **state)
{
    (void)state;
    assert_int_equal(try_it(devours), RSV_ERROR_FORMAT);
}

static void an_answer_without_end_is_cut_off(void **state)
{
    (void)state;
    assert_int_equal(try_it(babbles), RSV_ERROR_FORMAT);
    assert_non_null(strstr(rsv_last_error(), "too much memory"));
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
    assert_non_null(strstr(rsv_last_error(), "takes too long"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(good_work_is_let_through),
        cmocka_unit_test(a_complaint_is_passed_on),
        cmocka_unit_test(a_crash_is_survived),
        cmocka_unit_test(memory_is_bounded),
        cmocka_unit_test(an_answer_without_end_is_cut_off),
        cmocka_unit_test(time_is_bounded),
    };
    return cmocka_run_group_tests_name("child_process", tests, NULL, NULL);
}
