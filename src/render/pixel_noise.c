#include "pixel_noise.h"

typedef struct noise_map {
    const rsv_rgb *pixel;
    const rsv_pixel_noise *noise;
    uint32_t width, height;
} noise_map;

/// Sum of squared deviations of the luminance of camera rays. Stratification makes their mean better than this says.
static float spread_of(const rsv_pixel_noise *n)
{
    float direct = n->direct_squares - n->direct_sum * n->direct_sum / (float)n->count;
    return rsv_pixel_noise_spread(n) + f_max(direct, 0);
}

static double mean_luminance(const noise_map *map)
{
    size_t count = (size_t)map->width * map->height;
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += (double)rgb_luminance(map->pixel[i]);
    return sum / (double)count;
}

/// Means over the up to eight neighbours of a pixel.
static void look_around(
    const noise_map *map, uint32_t x, uint32_t y, float *luminance, float *spread)
{
    float count = 0;
    *luminance = *spread = 0;
    for (uint32_t j = y ? y - 1 : 0; j <= y + 1 && j < map->height; j++) {
        for (uint32_t i = x ? x - 1 : 0; i <= x + 1 && i < map->width; i++) {
            if (i == x && j == y) continue;
            size_t k = (size_t)j * map->width + i;
            *luminance += rgb_luminance(map->pixel[k]);
            *spread += spread_of(&map->noise[k]);
            count++;
        }
    }
    *luminance /= f_max(count, 1);
    *spread /= f_max(count, 1);
}

void rsv_plan_samples(const rsv_image *image, const rsv_pixel_noise *noise, uint32_t samples,
    float wanted, uint32_t *extra)
{
    noise_map map = { rsv_image_const_pixels(image, 0), noise, rsv_image_width(image),
        rsv_image_height(image) };
    float floor = 0.01f * (float)(mean_luminance(&map) * mean_luminance(&map));
    for (uint32_t y = 0; y < map.height; y++) {
        for (uint32_t x = 0; x < map.width; x++) {
            float luminance, spread;
            look_around(&map, x, y, &luminance, &spread);
            float square = wanted * wanted * (luminance * luminance + floor);
            float of_one = samples > 1 ? spread / (float)(samples - 1) : 0;
            float most = (float)samples * RSV_MOST_SAMPLES;
            // where nothing is seen, nothing is divided by nothing
            float needed = of_one > 0 ? f_min(of_one / square, most) : 0;
            extra[(size_t)y * map.width + x] =
                needed > (float)samples ? (uint32_t)(needed - (float)samples) : 0;
        }
    }
}
