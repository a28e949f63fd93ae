/// Ambient occlusion in screen space, for CPUs and devices, as games do it (after Mittring 2007 and later variants).
/// Points in the hemisphere above a pixel's surface count as occluded if the depth buffer has something nearer at their
/// position in the picture. The points are rotated from pixel to pixel in a 4x4 pattern, and a 4x4 blur hides the
/// pattern. Nothing outside the picture or behind the front surface is seen: this is the baseline, not a measurement.
#ifndef RSV_OCCLUSION_SCREEN_H
#define RSV_OCCLUSION_SCREEN_H

#include "occlusion_setting.h"

#define RSV_SCREEN_TILE 4
#define RSV_SCREEN_BIAS 0.02f ///< of the reach: what is nearer by less is the surface itself

/// Buffers, and the pattern. On a device, all it points to lies there.
typedef struct rsv_occlusion_screen {
    rsv_seen_surface *seen; ///< [height * width]
    float *depth;           ///< [height * width] along the view; INFINITY = nothing
    float *openness;        ///< [height * width] before the blur
    rsv_vec3 *kernel; ///< [samples] points of the unit hemisphere about +z, denser at its centre
    /// Cosine and sine by which each pixel of a tile turns the kernel.
    float turn[RSV_SCREEN_TILE * RSV_SCREEN_TILE][2];
} rsv_occlusion_screen;

/// One picture in the making.
typedef struct rsv_screen_picture {
    const rsv_occlusion_setting *setting;
    const rsv_occlusion_screen *buffer;
    rsv_lens lens;
} rsv_screen_picture;

/// Pixel that shows a point, and its depth; false if it lies outside the picture or behind the camera.
RSV_INLINE bool rsv_screen_project(
    const rsv_screen_picture *s, rsv_vec3 point, size_t *pixel, float *depth)
{
    const rsv_lens *lens = &s->lens;
    const rsv_camera *camera = &lens->camera;
    rsv_vec3 d = v3_sub(point, camera->position);
    bool orthographic = camera->vertical_fov == 0;
    *depth = v3_dot(d, camera->forward);
    if (!orthographic && *depth <= 0) return false;
    float scale = 1 / (orthographic ? lens->pixel_size : *depth * lens->pixel_size);
    float x = lens->half_width + scale * v3_dot(d, camera->right);
    float y = lens->half_height - scale * v3_dot(d, camera->up);
    if (!(x >= 0 && y >= 0 && x < 2 * lens->half_width && y < 2 * lens->half_height)) return false;
    *pixel = (size_t)y * s->setting->width + (size_t)x;
    return true;
}

/// How much the stored surface at a scattered point takes away: 1 if it lies before it, less where it is
/// farther than the reach from the pixel's own surface (the range check).
RSV_INLINE float rsv_screen_occlusion(const rsv_screen_picture *s, rsv_vec3 point, float own_depth)
{
    size_t pixel;
    float depth, reach = s->setting->distance;
    if (!rsv_screen_project(s, point, &pixel, &depth)) return 0;
    float stored = s->buffer->depth[pixel];
    if (!(stored < depth - RSV_SCREEN_BIAS * reach)) return 0;
    float t = f_min(reach / f_max(fabsf(own_depth - stored), 1e-20f), 1);
    return t * t * (3 - 2 * t);
}

/// Stores the depth and normal of a pixel.
RSV_INLINE void rsv_screen_note(
    const rsv_screen_picture *s, size_t pixel, const rsv_seen_surface *seen)
{
    const rsv_camera *camera = &s->lens.camera;
    rsv_vec3 d = v3_sub(seen->point.position, camera->position);
    s->buffer->seen[pixel] = *seen;
    s->buffer->depth[pixel] = seen->hit ? v3_dot(d, camera->forward) : INFINITY;
}

/// Computes the openness of a pixel, after all pixels have stored theirs.
RSV_INLINE void rsv_screen_open(const rsv_screen_picture *s, uint32_t column, uint32_t row)
{
    size_t pixel = (size_t)row * s->setting->width + column;
    const rsv_surface_point *p = &s->buffer->seen[pixel].point;
    const float *turn =
        s->buffer->turn[row % RSV_SCREEN_TILE * RSV_SCREEN_TILE + column % RSV_SCREEN_TILE];
    float c = turn[0], sn = turn[1], occluded = 0;
    rsv_vec3 t, b;
    if (!s->buffer->seen[pixel].hit) return;
    v3_frame(p->normal, &t, &b);
    for (uint32_t i = 0; i < s->setting->samples; i++) {
        rsv_vec3 k = s->buffer->kernel[i];
        rsv_vec3 offset = v3_scale(t, c * k.x - sn * k.y);
        offset = v3_mad(v3_mad(offset, sn * k.x + c * k.y, b), k.z, p->normal);
        occluded += rsv_screen_occlusion(
            s, v3_mad(p->position, s->setting->distance, offset), s->buffer->depth[pixel]);
    }
    s->buffer->openness[pixel] = 1 - occluded / (float)s->setting->samples;
}

/// Mean over one 4x4 tile of pixels about this one, of those that show something.
RSV_INLINE float rsv_screen_blur(const rsv_screen_picture *s, uint32_t column, uint32_t row)
{
    int width = (int)s->setting->width, height = (int)s->setting->height, count = 0;
    int half = RSV_SCREEN_TILE / 2;
    float sum = 0;
    for (int y = (int)row - half; y < (int)row + half; y++)
        for (int x = (int)column - half; x < (int)column + half; x++) {
            if (x < 0 || y < 0 || x >= width || y >= height) continue;
            size_t pixel = (size_t)y * (size_t)width + (size_t)x;
            if (!s->buffer->seen[pixel].hit) continue;
            sum += s->buffer->openness[pixel];
            count++;
        }
    return sum / (float)count;
}

/// Colour of a pixel, after the openness of all has been computed.
RSV_INLINE rsv_rgb rsv_screen_shade(const rsv_screen_picture *s, uint32_t column, uint32_t row)
{
    const rsv_seen_surface *seen = &s->buffer->seen[(size_t)row * s->setting->width + column];
    return rgb_mad(seen->emission, seen->hit ? rsv_screen_blur(s, column, row) : 0, seen->ambient);
}

#endif
