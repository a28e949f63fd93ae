/// One bar per command: it only moves forward, whatever phases the library reports, and its estimate of the time left
/// is of the right order.
#include "progress.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

typedef struct stage {
    const char *phase;
    double reached;
} stage;

/// What the library reports for a picture with pilots, levels and caustics; some phases are announced, and begin later.
static const stage picture[] = { { "assemble", 0 }, { "pilot 1: assemble", 1 },
    { "pilot 1: direct", 0.8 }, { "pilot 1: solve", 0.33 }, { "pilot 1: assemble", 0 },
    { "pilot 2: assemble", 1 }, { "pilot 2: direct", 1 }, { "pilot 2: solve", 0.33 },
    { "assemble", 1 }, { "direct", 1 }, { "level 1: assemble", 0 }, { "level 1: direct", 1 },
    { "caustics", 1 }, { "solve", 0 }, { "render", 1 } };

static double run(cli_progress *progress)
{
    double before = progress->done;
    for (size_t k = 0; k < sizeof picture / sizeof *picture; k++) {
        for (int step = 0; step <= 10; step++) {
            cli_progress_update(progress, picture[k].phase, picture[k].reached * step / 10);
            assert_true(progress->done >= before);
            assert_true(progress->done <= 1);
            before = progress->done;
        }
    }
    return before;
}

static void the_bar_goes_forward_only(void **state)
{
    (void)state;
    cli_progress progress;
    cli_progress_begin(&progress);
    cli_progress_update(&progress, "assemble", 0);
    cli_progress_update(&progress, "pilot 1: assemble", 0);
    assert_float_equal(progress.done, 0, 0.01); // what is only announced is not done
    cli_progress_update(&progress, "assemble", 0.5);
    assert_true(progress.done < 0.4); // much is to come
    assert_true(run(&progress) > 0.9);
}

static void parts_share_the_bar(void **state)
{
    (void)state;
    enum { frames = 12 };
    cli_progress progress;
    cli_progress_begin(&progress);
    cli_progress_part(&progress, "frame", 0, frames);
    run(&progress);
    assert_string_equal(progress.part, "");
    for (unsigned frame = 1; frame <= frames; frame++) {
        char name[32];
        snprintf(name, sizeof name, "frame %u of 12: ", frame);
        cli_progress_part(&progress, "frame", frame, frames);
        assert_string_equal(progress.part, name);
        assert_true(progress.done <= (double)frame / (frames + 1));
        run(&progress);
        assert_true(progress.done > (frame + 0.9) / (frames + 1));
    }
}

/// A planned picture: a minute for the plan, ten for its samples.
static void a_long_last_phase_is_foreseen(void **state)
{
    (void)state;
    const struct {
        const char *phase;
        double seconds;
    } planned[] = { { "assemble", 30 }, { "direct", 10 }, { "spectrum", 4 }, { "solve", 6 },
        { "trial: render", 10 }, { "pass 1: render", 600 } };
    cli_progress progress;
    cli_progress_begin(&progress);
    double now = progress.work_started, end = now + 660;
    for (size_t k = 0; k < sizeof planned / sizeof *planned; k++) {
        for (int step = 0; step <= 100; step++, now += planned[k].seconds / 101) {
            cli_progress_update_at(&progress, planned[k].phase, step / 100.0, now);
            bool is_foreseeable = end - now < 500 && end - now > 30;
            if (is_foreseeable) assert_float_equal(progress.total, 660, 0.2 * 660);
        }
    }
    assert_true(progress.done > 0.9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_bar_goes_forward_only),
        cmocka_unit_test(parts_share_the_bar),
        cmocka_unit_test(a_long_last_phase_is_foreseen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
