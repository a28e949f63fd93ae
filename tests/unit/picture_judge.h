/// Whether one way of making a picture errs no more than another.
#ifndef RSV_TEST_PICTURE_JUDGE_H
#define RSV_TEST_PICTURE_JUDGE_H

#include "light_fixture.h"
#include "resolvent/image.h"

/// Asserts a relative error of at most 0.5 % for the mean. For each pixel, the error must not be distinguishable from
/// noise by comparison with two better pictures with other seeds.
static inline void assert_errs_no_more(
    rsv_image *const judge[2], const rsv_image *ours, const rsv_image *theirs)
{
    const uint32_t layer[2] = { 0, 0 };
    const rsv_image *judges[2] = { judge[0], judge[1] };
    rsv_image_judgement own, other;
    rsv_image_difference difference;
    assert_int_equal(rsv_image_judge(judges, layer, ours, 0, &own), RSV_OK);
    assert_int_equal(rsv_image_judge(judges, layer, theirs, 0, &other), RSV_OK);
    assert_int_equal(rsv_image_compare(judge[0], 0, ours, 0, &difference), RSV_OK);
    double allowed = other.relative_mse + 4 * other.relative_mse_error;
    if (own.relative_mse > allowed || fabs(difference.mean_ratio - 1) > 5e-3)
        fail_msg("relative MSE %g, of the other way %g; mean %g of the judge's", own.relative_mse,
            other.relative_mse, difference.mean_ratio);
}

#endif
