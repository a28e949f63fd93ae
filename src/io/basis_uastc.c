#include "basis_uastc.h"

#include <string.h>

#define TEXELS 16
#define MOST_VALUES 18 ///< of endpoints: three subsets with a pair of RGB colours each
#define SOLID_COLOR 8

// ---- modes --------------------------------------------------------------------------------------

/// What the endpoints of a mode have.
typedef enum channels { RGB, RGBA, LUMINANCE_ALPHA } channels;

static const uint32_t count_of[] = { [RGB] = 3, [RGBA] = 4, [LUMINANCE_ALPHA] = 2 };

/// Patterns of subsets.
typedef enum pattern { WHOLE, HALVES, TWO_OF_THREE, THIRDS } pattern;

/// How the bits of a block lie: a prefix that names the mode, hints for other formats, the pattern, the channel with
/// weights of its own, endpoints and weights.
typedef struct mode {
    uint8_t prefix, prefix_bits, hint_bits;
    pattern pattern;
    channels channels;
    uint8_t endpoint_bits; ///< of each value, besides its digit
    uint8_t digit;         ///< number of values of the digit: 3, 5, or 1 for none
    uint8_t weight_bits;
    bool names_channel,
        dual; ///< a field names the channel of the second weights; there are second weights
} mode;

/// By mode index; 8 is a solid colour.
static const mode modes[] = {
    { 0x01, 4, 15, WHOLE, RGB, 6, 3, 4, false, false },
    { 0x35, 6, 15, WHOLE, RGB, 8, 1, 2, false, false },
    { 0x1d, 5, 15, HALVES, RGB, 4, 1, 3, false, false },
    { 0x03, 5, 15, THIRDS, RGB, 2, 3, 2, false, false },
    { 0x13, 5, 15, HALVES, RGB, 3, 5, 2, false, false },
    { 0x0b, 5, 15, WHOLE, RGB, 8, 1, 3, false, false },
    { 0x1b, 5, 15, WHOLE, RGB, 5, 5, 2, true, true },
    { 0x07, 5, 15, TWO_OF_THREE, RGB, 3, 5, 2, false, false },
    { 0x17, 5, 0, WHOLE, RGBA, 8, 1, 0, false, false },
    { 0x0f, 5, 23, HALVES, RGBA, 4, 1, 2, false, false },
    { 0x02, 3, 17, WHOLE, RGBA, 4, 3, 4, false, false },
    { 0x00, 2, 17, WHOLE, RGBA, 4, 3, 2, true, true },
    { 0x06, 3, 17, WHOLE, RGBA, 6, 3, 3, false, false },
    { 0x1f, 5, 23, WHOLE, RGBA, 8, 1, 1, true, true },
    { 0x0d, 5, 23, WHOLE, RGBA, 8, 1, 2, false, false },
    { 0x05, 7, 23, WHOLE, LUMINANCE_ALPHA, 8, 1, 4, false, false },
    { 0x15, 6, 23, HALVES, LUMINANCE_ALPHA, 8, 1, 2, false, false },
    { 0x25, 6, 23, WHOLE, LUMINANCE_ALPHA, 8, 1, 2, false, true },
    { 0x09, 4, 15, WHOLE, RGB, 5, 1, 5, false, false },
};

/// Subset of each texel, the first in the lowest bits: one bit each, for thirds two.
static const uint32_t halves[] = { 0xcccc, 0x8888, 0x1111, 0xecc8, 0x377f, 0xfeec, 0x0137, 0x137f,
    0xc800, 0x0013, 0xfe80, 0x17ff, 0x0017, 0x00ff, 0xfff0, 0x0fff, 0xff71, 0x8eff, 0x08ce, 0x008c,
    0x7310, 0xceff, 0x7331, 0x088c, 0xceef, 0x6666, 0xf00f, 0x5555, 0x0f0f, 0x36c9 };
static const uint32_t two_of_three[] = { 0x00f0, 0x4444, 0x0133, 0xcc80, 0xf0ff, 0x2222, 0xffc8,
    0xccce, 0x3c03, 0x00ee, 0x7700, 0x3003, 0x00ce, 0xff80, 0x6fff, 0x1333, 0x11ff, 0x136c,
    0x00ef };
static const uint32_t thirds[] = { 0xa5a50000, 0xaa005555, 0xaa000055, 0x0000aa55, 0x25252525,
    0x94949494, 0x58585858, 0x56560202, 0x92929292, 0x55aa0055, 0xa05050a0 };

#define COUNT(array) ((uint32_t)(sizeof(array) / sizeof *(array)))

static const struct {
    const uint32_t *list;
    uint32_t count, bits, subsets;
} patterns[] = { [WHOLE] = { NULL, 0, 0, 1 },
    [HALVES] = { halves, COUNT(halves), 5, 2 },
    [TWO_OF_THREE] = { two_of_three, COUNT(two_of_three), 5, 2 },
    [THIRDS] = { thirds, COUNT(thirds), 4, 3 } };

// ---- reading ------------------------------------------------------------------------------------

typedef struct reader {
    const uint8_t *block;
    uint32_t at;
    const mode *mode;
    uint32_t subset[TEXELS];
    bool anchor[TEXELS];           ///< first texel of its subset, whose weights have one bit less
    uint8_t low[3][4], high[3][4]; ///< endpoints of each subset
    uint32_t own_channel;          ///< channel of the second weights
} reader;

/// @param count at most 8
static uint32_t take(reader *r, uint32_t count)
{
    uint32_t value = 0;
    for (uint32_t k = 0; k < count; k++, r->at++)
        if (r->at < 128) value |= (uint32_t)(r->block[r->at / 8] >> r->at % 8 & 1) << k;
    return value;
}

static const mode *find_mode(const uint8_t *block)
{
    for (uint32_t k = 0; k < COUNT(modes); k++)
        if ((*block & ((1u << modes[k].prefix_bits) - 1)) == modes[k].prefix) return &modes[k];
    return NULL;
}

static bool read_pattern(reader *r)
{
    pattern kind = r->mode->pattern;
    uint32_t number = take(r, patterns[kind].bits), bits = kind == THIRDS ? 2 : 1, seen = 0;
    if (kind != WHOLE && number >= patterns[kind].count) return false;
    for (uint32_t i = 0; i < TEXELS; i++) {
        if (kind != WHOLE)
            r->subset[i] = patterns[kind].list[number] >> bits * i & ((1u << bits) - 1);
        r->anchor[i] = !(seen >> r->subset[i] & 1);
        seen |= 1u << r->subset[i];
    }
    return true;
}

/// Digits come in groups of five of base 3, or three of base 5.
static void read_digits(reader *r, uint32_t count, uint8_t *digit)
{
    static const uint32_t bits_of_trits[] = { 0, 2, 4, 5, 7, 8 };
    uint32_t base = r->mode->digit, group = base == 3 ? 5 : 3;
    for (uint32_t first = 0; base > 1 && first < count; first += group) {
        uint32_t here = count - first < group ? count - first : group;
        uint32_t packed = take(r, base == 3 ? bits_of_trits[here] : 7);
        for (uint32_t k = 0; k < here; k++, packed /= base)
            digit[first + k] = (uint8_t)(packed % base);
    }
}

/// The 8 bits of an endpoint value, as ASTC defines them. Without a digit, bits repeat from the highest. With one, the
/// lowest bit mirrors the scale, and the digit is the finest part.
static uint8_t expand(const mode *m, uint32_t bits, uint32_t digit)
{
    uint32_t n = m->endpoint_bits, high = bits >> 1, mirror = bits & 1 ? 0x1ff : 0;
    if (m->digit == 1) return (uint8_t)(n >= 8 ? bits : bits << (8 - n) | bits >> (2 * n - 8));
    uint32_t scale, spread;
    if (m->digit == 3) {
        scale = n == 2 ? 93 : n == 4 ? 22 : 5;
        spread = n == 2 ? high * 0x116 : n == 4 ? high << 6 | high : high << 4 | high >> 4;
    } else {
        scale = n == 3 ? 26 : 6;
        spread = n == 3 ? high << 7 | high << 1 | high >> 1 : high << 5 | high >> 3;
    }
    uint32_t value = (digit * scale + spread) ^ mirror;
    return (uint8_t)((mirror & 0x80) | value >> 2);
}

static void set_endpoint(reader *r, uint32_t number, uint8_t value)
{
    uint32_t count = count_of[r->mode->channels], subset = number / (2 * count);
    uint32_t channel = number / 2 % count;
    uint8_t *color = number % 2 ? r->high[subset] : r->low[subset];
    if (r->mode->channels != LUMINANCE_ALPHA)
        color[channel] = value;
    else if (channel == 1)
        color[3] = value;
    else
        color[0] = color[1] = color[2] = value;
}

static void read_endpoints(reader *r)
{
    uint32_t count = 2 * count_of[r->mode->channels] * patterns[r->mode->pattern].subsets;
    uint8_t digit[MOST_VALUES] = { 0 };
    memset(r->low, 255, sizeof r->low);
    memset(r->high, 255, sizeof r->high);
    read_digits(r, count, digit);
    for (uint32_t k = 0; k < count; k++)
        set_endpoint(r, k, expand(r->mode, take(r, r->mode->endpoint_bits), digit[k]));
}

// ---- texels -------------------------------------------------------------------------------------

/// Of 64: bits repeated to six, with a step in the middle.
static uint32_t read_weight(reader *r, bool is_anchor)
{
    uint32_t n = r->mode->weight_bits, bits = take(r, is_anchor ? n - 1 : n), weight = 0;
    for (int shift = 6 - (int)n; shift > -(int)n; shift -= (int)n)
        weight |= shift >= 0 ? bits << shift : bits >> -shift;
    return weight > 32 ? weight + 1 : weight;
}

static uint8_t mix(uint32_t low, uint32_t high, uint32_t weight, bool srgb)
{
    low = low << 8 | (srgb ? 0x80 : low);
    high = high << 8 | (srgb ? 0x80 : high);
    return (uint8_t)((low * (64 - weight) + high * weight + 32) >> 6 >> 8);
}

static void read_texels(reader *r, bool srgb, uint8_t texel[16][4])
{
    for (uint32_t i = 0; i < TEXELS; i++) {
        uint32_t weight = read_weight(r, r->anchor[i]);
        uint32_t second = r->mode->dual ? read_weight(r, r->anchor[i]) : weight;
        const uint8_t *low = r->low[r->subset[i]], *high = r->high[r->subset[i]];
        for (uint32_t c = 0; c < 4; c++)
            texel[i][c] = mix(low[c], high[c], c == r->own_channel ? second : weight, srgb);
    }
}

static void fill(uint8_t texel[16][4], const uint8_t color[4])
{
    for (uint32_t i = 0; i < TEXELS; i++)
        memcpy(texel[i], color, 4);
}

void rsv_uastc_decode(const uint8_t block[RSV_UASTC_BLOCK_BYTES], bool srgb, uint8_t texel[16][4])
{
    static const uint8_t invalid[4] = { 255, 0, 255, 255 };
    reader r = { .block = block, .mode = find_mode(block), .own_channel = 3 };
    if (!r.mode) {
        fill(texel, invalid);
        return;
    }
    r.at = r.mode->prefix_bits;
    if (r.mode == &modes[SOLID_COLOR]) {
        uint8_t color[4];
        for (int c = 0; c < 4; c++)
            color[c] = (uint8_t)take(&r, 8);
        fill(texel, color);
        return;
    }
    r.at += r.mode->hint_bits;
    if (!read_pattern(&r)) {
        fill(texel, invalid);
        return;
    }
    if (r.mode->names_channel) r.own_channel = take(&r, 2);
    read_endpoints(&r);
    read_texels(&r, srgb, texel);
}
