/// Textures as mip pyramids in linear light.
///
/// Level 0 is the image. Each further level has half the size, rounded down, and each of its texels is the mean of the
/// area that it covers, so all levels have the same mean. If the alpha of a texture is opacity, its colours are
/// averaged with that weight: the colour of invisible texels does not matter.
#ifndef RSV_TEXTURE_H
#define RSV_TEXTURE_H

#include "../core/core.h"
#include "../core/vec.h"
#include "resolvent/scene.h"

#define RSV_TEXTURE_MAX_LEVELS 15 ///< of the largest side

typedef struct rsv_texture_level {
    uint32_t width, height;
    size_t first; ///< texel of the texture's arrays
} rsv_texture_level;

typedef struct rsv_texture {
    char *name;
    uint32_t channel_count, level_count;
    rsv_texture_level level[RSV_TEXTURE_MAX_LEVELS];
    uint16_t
        *unorm;   ///< [texels of all levels * channel_count + 1] 0..65535 for 0..1, linear, and one
                  ///< code more, so that three can be read as four; or
    float *value; ///< the same as floats; the other is NULL
    rsv_wrap wrap_u, wrap_v;
    bool nearest;
    bool covers; ///< alpha weighs colours, on the coarser levels and between texels
    bool whole;  ///< a material shows all of it, independently of alpha, so colours are not weighted
} rsv_texture;

/// A texel: red, green, blue, alpha. Grey textures repeat their value; alpha is 1 where there is none.
typedef struct rsv_texel {
    float r, g, b, a;
} rsv_texel;

rsv_status rsv_texture_create(
    rsv_context *context, const rsv_texture_desc *desc, rsv_texture *texture);
/// The same from linear codes, as `unorm` of a texture holds them.
/// @param desc without codes and values @param linear [height * width * channel_count]
rsv_status rsv_texture_create_linear(rsv_context *context, const rsv_texture_desc *desc,
    const uint16_t *linear, rsv_texture *texture);
/// Registers a material that shows the texture's colours. If alpha is opacity for this material, coarser levels weight
/// colours by it from now on, unless it is not for another material. Nothing changes without alpha.
void rsv_texture_add_use(rsv_context *context, rsv_texture *texture, bool alpha_is_opacity);
void rsv_texture_release(rsv_context *context, rsv_texture *texture);

/// Trilinear lookup. @param level of the pyramid, with fraction; below 0 counts as 0, beyond the last as the last
RSV_SHARED rsv_texel rsv_texture_lookup(const rsv_texture *texture, float u, float v, float level);

/// Mean of the whole texture.
RSV_SHARED rsv_texel rsv_texture_mean(const rsv_texture *texture);

#if defined(RSV_DEVICE_CODE)
#include "texture_body.h"
#endif

#endif
