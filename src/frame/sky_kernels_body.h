/// The sky behind sixteen pixels, included by packet_kernels_body.h: rsv_sky_radiance, except for the rounding of angles.

/// atan2f within 2e-7, in a form that vectorises.
static inline float flat_atan2(float y, float x)
{
    float ax = fabsf(x), ay = fabsf(y);
    float less = ax < ay ? ax : ay, more = ax < ay ? ay : ax;
    float q = less / (more > 1e-30f ? more : 1e-30f), s = q * q;
    float sum = 0.00283406442f; // Chebyshev interpolant of atan(sqrt(s)) / sqrt(s) on [0, 1]
    sum = sum * s - 0.0160050299f;
    sum = sum * s + 0.0425876081f;
    sum = sum * s - 0.0749544576f;
    sum = sum * s + 0.106367543f;
    sum = sum * s - 0.142025709f;
    sum = sum * s + 0.199924842f;
    sum = sum * s - 0.333330661f;
    float angle = q + q * s * sum;
    angle = ay > ax ? 0.5f * RSV_PI - angle : angle;
    angle = x < 0 ? RSV_PI - angle : angle;
    return y < 0 ? -angle : angle;
}

/// Pixels of the sky around the lanes' directions: columns, rows, and the shares of the second of each.
typedef struct sky_lanes {
    int column[2][LANES], row[2][LANES];
    float across[LANES], down[LANES];
} __attribute__((aligned(64))) sky_lanes;

static inline void find_sky_pixels(
    const rsv_sky *sky, const rsv_ray_packet *restrict p, sky_lanes *restrict to)
{
    float width = (float)sky->width, height = (float)sky->height, turn = 0.5f + sky->turn;
    int columns = (int)sky->width, rows = (int)sky->height;
    for (int k = 0; k < LANES; k++) {
        float dx = p->direction_x[k], dy = p->direction_y[k], dz = p->direction_z[k];
        float u = flat_atan2(dz, dx) * (0.5f / RSV_PI) + turn; // 0..2
        float v = flat_atan2(sqrtf(dx * dx + dz * dz), dy) / RSV_PI;
        float x = (u < 1 ? u : u - 1) * width - 0.5f, y = v * height - 0.5f;
        int left = (int)(x + 1) - 1, top = (int)(y + 1) - 1; // floors: both are at least -0.5
        to->across[k] = x - (float)left;
        to->down[k] = y - (float)top;
        int right = left + 1, bottom = top + 1;
        to->column[0][k] = left < 0 ? columns - 1 : left < columns ? left : 0;
        to->column[1][k] = right < columns ? right : 0;
        to->row[0][k] = top < 0 ? 0 : top < rows ? top : rows - 1;
        to->row[1][k] = bottom < rows ? bottom : rows - 1;
    }
}

static inline rsv_rgb sky_between(const rsv_rgb *row, const sky_lanes *restrict at, uint32_t k)
{
    return rgb_mad(
        rgb_scale(row[at->column[0][k]], 1 - at->across[k]), at->across[k], row[at->column[1][k]]);
}

static void show_sky_packet(const rsv_sky *sky, const rsv_ray_packet *restrict p, uint32_t lanes,
    float (*restrict radiance)[4])
{
    sky_lanes at;
    find_sky_pixels(sky, p, &at);
    for (; lanes; lanes &= lanes - 1) {
        uint32_t k = (uint32_t)__builtin_ctz(lanes);
        rsv_rgb above = sky_between(sky->pixel + (size_t)at.row[0][k] * sky->width, &at, k);
        rsv_rgb below = sky_between(sky->pixel + (size_t)at.row[1][k] * sky->width, &at, k);
        rsv_rgb shown = rgb_mad(rgb_scale(above, 1 - at.down[k]), at.down[k], below);
        float *to = radiance[k / RSV_BLOCK * RSV_TILE + k % RSV_BLOCK];
        to[0] = shown.r, to[1] = shown.g, to[2] = shown.b, to[3] = 0;
    }
}
