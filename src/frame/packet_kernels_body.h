/// Included once per instruction set, with RSV_KERNELS the name of its table.
#include "packet_kernels.h"

#define LANES RSV_PACKET_WIDTH

static void aim_packet(
    const rsv_frame_aim *restrict a, uint32_t column, uint32_t row, rsv_ray_packet *restrict p)
{
    const rsv_camera *c = &a->camera;
    bool orthographic = c->vertical_fov == 0;
    for (int k = 0; k < LANES; k++) {
        // the arithmetic of rsv_camera_ray
        int i = (int)column + k % RSV_BLOCK, j = (int)row + k / RSV_BLOCK;
        float across = ((float)i + a->place_x - a->half_width) * a->pixel_size;
        float upwards = (a->half_height - ((float)j + a->place_y)) * a->pixel_size;
        float x = c->right.x * across + upwards * c->up.x;
        float y = c->right.y * across + upwards * c->up.y;
        float z = c->right.z * across + upwards * c->up.z;
        float dx = c->forward.x + x, dy = c->forward.y + y, dz = c->forward.z + z;
        float scale = 1 / sqrtf(dx * dx + dy * dy + dz * dz);
        p->origin_x[k] = orthographic ? c->position.x + x : c->position.x;
        p->origin_y[k] = orthographic ? c->position.y + y : c->position.y;
        p->origin_z[k] = orthographic ? c->position.z + z : c->position.z;
        p->direction_x[k] = orthographic ? c->forward.x : dx * scale;
        p->direction_y[k] = orthographic ? c->forward.y : dy * scale;
        p->direction_z[k] = orthographic ? c->forward.z : dz * scale;
        bool inside = (i < (int)a->width) & (j < (int)a->height);
        p->t_max[k] = inside ? INFINITY : -1;
    }
}

static uint32_t look_up_packet(const rsv_light_table *restrict table,
    const rsv_ray_packet *restrict p, float (*restrict radiance)[4])
{
    _Alignas(64) rsv_shown_side side[LANES];
    _Alignas(64) rsv_grid_place place[LANES];
    uint32_t left = 0;
    for (int k = 0; k < LANES; k++) {
        float cos = p->normal_x[k] * p->direction_x[k] + p->normal_y[k] * p->direction_y[k] +
                    p->normal_z[k] * p->direction_z[k];
        side[k] = *rsv_shown_side_of(table, p->triangle[k], cos > 0);
        left |= (uint32_t)(side[k].kind != RSV_SHOWN_STORED) << k;
    }
    for (int k = 0; k < LANES; k++)
        place[k] = rsv_place_in_grid(side[k], p->u[k], p->v[k]);
    for (int k = 0; k < LANES; k++) {
        rsv_float4 *out = (rsv_float4 *)radiance[k / RSV_BLOCK * RSV_TILE + k % RSV_BLOCK];
        *out = rsv_light_at(table->cell, place[k]);
    }
    return left;
}

/// The sRGB curve over [0, 1] times 255: a polynomial in x^(1/4), off by 0.013 codes at most.
static inline float srgb_code(float x)
{
    float q = sqrtf(sqrtf(x));
    float curve = 0.0764924974571757f;
    curve = curve * q - 0.3234316818625122f;
    curve = curve * q + 1.1120896146387176f;
    curve = curve * q + 0.1999536208759521f;
    curve = curve * q - 0.06508130912720766f;
    return 255 * (x <= 0.0031308f ? 12.92f * x : curve);
}

static void display_row(const rsv_frame_tone *tone, uint32_t count,
    const float (*restrict radiance)[4], float (*restrict sum)[4], uint8_t (*restrict pixel)[4])
{
    const float *restrict in = radiance[0];
    float *restrict total = sum[0];
    uint8_t *restrict out = pixel[0];
    float kept = tone->first ? 0.0f : 1.0f, scale = tone->scale;
    bool soft = tone->soft;
    for (uint32_t k = 0; k < 4 * count; k++) {
        total[k] = kept * total[k] + in[k];
        float x = f_max(total[k] * scale, 0);
        x = soft ? x * (1 + x * (1.0f / 16)) / (1 + x) : x;
        out[k] = (uint8_t)(int)(srgb_code(f_min(x, 1)) + 0.5f);
    }
    for (uint32_t k = 0; k < count; k++)
        pixel[k][3] = 255;
}

const rsv_packet_kernels RSV_KERNELS = { aim_packet, look_up_packet, display_row };
