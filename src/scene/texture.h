/// Textures as the library keeps them: a pyramid of ever coarser versions in linear light.
///
/// Level 0 is the picture; every further one has half its size, rounded down, and each of its texels is the
/// mean of the area it covers, so that the mean of the whole is the same on all levels. Colours of a texture that also
/// says how much of a surface there is are means of what there is: nobody sees the paper that a leaf was cut from.
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
    bool whole;  ///< a material shows all of it, whatever alpha says: colours are not weighed
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
/// Tells of a material that shows the texture's colours: where alpha is opacity to it, coarser levels weigh them by that
/// from now on, unless to another material it is not. Nothing changes where there is no alpha.
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
