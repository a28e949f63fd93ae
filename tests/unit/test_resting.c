/// Frames that differ from what paths find: corrections converge to that, in the mean and in every pixel.
#include "frame/resting.h"
#include "light_fixture.h"

#include <string.h>

enum { across = 2, tile_count = across * across, side = RSV_RESTING_SIDE };

/// What frames show everywhere.
static const float shown_radiance = 1;

static rsv_resting_tile tiles[tile_count];
static rsv_resting_paths paths[tile_count];
static float shown[tile_count][RSV_RESTING_PIXELS][4];
static rsv_resting_node nodes[2 * tile_count + 64];
static rsv_resting_given given[2 * tile_count + 64];

/// What paths find in the mean. The first tile has thin bright lines on darker ground, so that it is as bright as the frame.
static float truth_of(uint32_t tile, uint32_t pixel)
{
    if (tile > 0) return shown_radiance;
    return pixel % 8 == 3 ? 4.5f : 0.5f;
}

/// A path: mostly nothing on bright lines, so that they are noisier than the rest.
static float sample_of(uint32_t tile, uint32_t pixel, uint32_t frame)
{
    float truth = truth_of(tile, pixel), x = rsv_unit_float(rsv_hash3(tile, pixel, frame));
    if (truth > 1) return x < 0.25f ? 4 * truth : 0;
    return truth * (0.5f + x);
}

static void take_paths(uint32_t tile, uint32_t frame)
{
    const uint32_t blocks_across = side / 4;
    memset(&paths[tile], 0, sizeof paths[tile]);
    for (uint32_t b = 0; b < RSV_RESTING_BLOCKS; b++) {
        paths[tile].open[b] = 0xffff;
        for (uint32_t k = rsv_resting_turns(&tiles[tile], b); k > 0; k--) {
            uint32_t lane = rsv_resting_lane(&tiles[tile], b, rsv_hash2(tile, b));
            uint32_t x = b % blocks_across * 4 + lane % 4, y = b / blocks_across * 4 + lane / 4;
            uint32_t at = paths[tile].count++;
            paths[tile].pixel[at] = (uint16_t)(y * side + x);
            for (int c = 0; c < 3; c++)
                paths[tile].radiance[at][c] = sample_of(tile, paths[tile].pixel[at], frame);
        }
    }
}

/// @return paths taken
static uint32_t rest(uint32_t frames)
{
    uint32_t count = 0;
    for (uint32_t t = 0; t < tile_count; t++)
        rsv_resting_begin(&tiles[t], t);
    for (uint32_t frame = 0; frame < frames; frame++) {
        for (uint32_t t = 0; t < tile_count; t++) {
            for (uint32_t k = 0; k < RSV_RESTING_PIXELS; k++)
                for (int c = 0; c < 4; c++)
                    shown[t][k][c] = shown_radiance;
            take_paths(t, frame);
            count += paths[t].count;
            rsv_resting_add(&tiles[t], &paths[t], (const float(*)[4])shown[t]);
            rsv_resting_update(&tiles[t], shown[t]);
        }
        rsv_resting_share(tiles, across, across, nodes, given);
    }
    return count;
}

/// Of pixels of one tile. @param mean of them, out @return mean square of what is wrong
static double error_of(uint32_t tile, double *mean)
{
    double squares = 0;
    *mean = 0;
    for (uint32_t k = 0; k < RSV_RESTING_PIXELS; k++) {
        double wrong = (double)shown[tile][k][1] - (double)truth_of(tile, k);
        squares += wrong * wrong / RSV_RESTING_PIXELS;
        *mean += (double)shown[tile][k][1] / RSV_RESTING_PIXELS;
    }
    return squares;
}

/// The variance of samples is 4.5^2 * 3 on lines, an eighth of the tile, and 1/48 elsewhere.
static void corrections_reach_every_pixel(void **state)
{
    (void)state;
    const double variance = 4.5 * 4.5 * 3 / 8 + 7.0 / 8 / 48;
    const uint32_t frames[3] = { 64, 512, 4096 };
    for (int k = 0; k < 3; k++) {
        double mean, per_pixel = rest(frames[k]) / (double)(tile_count * RSV_RESTING_PIXELS);
        double wrong = error_of(0, &mean), equal = variance / per_pixel;
        print_message("    %u frames: error %.3g, of means of as many samples in each pixel %.3g, "
                      "mean %.4f\n",
            frames[k], wrong, equal, mean);
        assert_true(wrong < f_min((float)equal, 2)); // uncorrected, 1.75
        if (k > 0) assert_true(wrong < 0.6 * equal); // paths go where noise is
        double deviation = sqrt(equal / RSV_RESTING_PIXELS);
        assert_close(mean, 1, 5 * deviation);
        assert_true(error_of(1, &mean) < 0.003);
        assert_close(mean, 1, 5 * deviation / tile_count); // as the whole picture
    }
}

/// Paths may be spread unevenly; their result is not.
static void the_mean_is_that_of_pixels(void **state)
{
    (void)state;
    double sum = 0, mean;
    rest(1024);
    for (uint32_t t = 0; t < tile_count; t++) {
        error_of(t, &mean);
        sum += mean / tile_count;
    }
    assert_close(sum, 1, 0.02);
}

/// Where nothing may differ, nothing changes, and no path is taken.
static void what_is_known_stays(void **state)
{
    (void)state;
    float before[RSV_RESTING_PIXELS][4];
    rest(2);
    rsv_resting_begin(&tiles[0], 0);
    memcpy(before, shown[0], sizeof before);
    rsv_resting_correct(&tiles[0], shown[0]);
    assert_memory_equal(before, shown[0], sizeof before);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(corrections_reach_every_pixel),
        cmocka_unit_test(the_mean_is_that_of_pixels),
        cmocka_unit_test(what_is_known_stays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
