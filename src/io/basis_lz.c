#include "basis_lz.h"

#include "little_endian.h"

#include <string.h>

#define HEADER_BYTES 20
#define IMAGE_BYTES 20

// ---- bits ---------------------------------------------------------------------------------------

/// A stream of bits, the lowest of each byte first. Beyond the end there are zeros.
typedef struct bits {
    const uint8_t *bytes;
    size_t size, at; ///< at: of bits
    bool bad;        ///< damaged, or read beyond the end
} bits;

static uint32_t take(bits *in, uint32_t count)
{
    uint32_t value = 0;
    for (uint32_t k = 0; k < count; k++, in->at++) {
        if (in->at / 8 >= in->size) {
            in->bad = true;
            return 0;
        }
        value |= (uint32_t)(in->bytes[in->at / 8] >> in->at % 8 & 1) << k;
    }
    return value;
}

/// A number in chunks, each of `chunk` bits and one that says whether another follows.
static uint32_t take_chunks(bits *in, uint32_t chunk)
{
    uint32_t value = 0, piece;
    for (uint32_t shift = 0; shift < 32; shift += chunk) {
        piece = take(in, chunk + 1);
        value |= (piece & ((1u << chunk) - 1)) << shift;
        if (!(piece >> chunk)) return value;
    }
    in->bad = true;
    return 0;
}

// ---- Huffman codes ------------------------------------------------------------------------------

#define LONGEST_CODE 16
#define MOST_SYMBOLS 16384
#define LENGTH_SYMBOLS 21

/// A canonical code, as in Deflate.
typedef struct code {
    uint16_t count[LONGEST_CODE + 1]; ///< of symbols with codes of each length
    uint16_t symbol[MOST_SYMBOLS];    ///< in the order of their codes
} code;

/// @return false if there are more codes than fit
static bool build_code(const uint8_t *length, uint32_t symbols, code *c)
{
    uint32_t next[LONGEST_CODE + 2] = { 0 }, used = 0;
    memset(c->count, 0, sizeof c->count);
    for (uint32_t k = 0; k < symbols; k++)
        c->count[length[k]]++;
    c->count[0] = 0;
    for (uint32_t l = 1; l <= LONGEST_CODE; l++) {
        next[l + 1] = next[l] + c->count[l];
        used += (uint32_t)c->count[l] << (LONGEST_CODE - l);
    }
    for (uint32_t k = 0; k < symbols; k++)
        if (length[k]) c->symbol[next[length[k]]++] = (uint16_t)k;
    return used <= 1u << LONGEST_CODE;
}

static uint32_t decode(bits *in, const code *c)
{
    uint32_t value = 0, first = 0, index = 0;
    for (uint32_t length = 1; length <= LONGEST_CODE && !in->bad; length++) {
        value |= take(in, 1);
        if (value - first < c->count[length]) return c->symbol[index + value - first];
        index += c->count[length];
        first = (first + c->count[length]) << 1;
        value <<= 1;
    }
    in->bad = true;
    return 0;
}

/// Lengths of the code that the lengths of a table are written in.
static bool read_length_code(bits *in, code *c)
{
    static const uint8_t order[LENGTH_SYMBOLS] = { 17, 18, 19, 20, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12,
        3, 13, 2, 14, 1, 15, 16 };
    uint8_t length[LENGTH_SYMBOLS] = { 0 };
    uint32_t count = take(in, 5);
    if (count > LENGTH_SYMBOLS) return false;
    for (uint32_t k = 0; k < count; k++)
        length[order[k]] = (uint8_t)take(in, 3);
    return build_code(length, LENGTH_SYMBOLS, c);
}

/// Reads the length of one symbol or a run of equal ones. @return how many
static uint32_t read_run(bits *in, const code *lengths, uint8_t before, uint8_t *length)
{
    static const struct {
        uint8_t bits, least;
    } run[] = { { 3, 3 }, { 7, 11 }, { 2, 3 }, { 7, 7 } };
    uint32_t symbol = decode(in, lengths);
    if (symbol <= LONGEST_CODE) {
        *length = (uint8_t)symbol;
        return 1;
    }
    uint32_t kind = symbol - LONGEST_CODE - 1;
    bool repeats = kind >= 2;
    if (repeats && before == 0) in->bad = true;
    *length = repeats ? before : 0;
    return run[kind].least + take(in, run[kind].bits);
}

/// A table of no symbols is fine as long as it is not used.
static void read_code(bits *in, code *c)
{
    uint8_t length[MOST_SYMBOLS] = { 0 };
    uint32_t symbols = take(in, 14), known = 0;
    code *lengths = c; // is replaced when it has done its work
    memset(c->count, 0, sizeof c->count);
    if (in->bad || symbols == 0) return;
    if (!read_length_code(in, lengths)) in->bad = true;
    while (known < symbols && !in->bad) {
        uint8_t value = 0;
        uint32_t count = read_run(in, lengths, known ? length[known - 1] : 0, &value);
        if (count > symbols - known) in->bad = true;
        for (uint32_t k = 0; k < count && !in->bad; k++)
            length[known++] = value;
    }
    if (!in->bad && !build_code(length, symbols, c)) in->bad = true;
}

// ---- codebooks ----------------------------------------------------------------------------------

typedef struct endpoint {
    uint8_t color[3]; ///< of 5 bits
    uint8_t intensity;
} endpoint;

/// Rows of a block, 2 bits for each texel, the first in the lowest bits.
typedef struct selector {
    uint8_t row[4];
} selector;

typedef struct codebooks {
    rsv_context *context;
    endpoint *endpoints;
    selector *selectors;
    uint32_t endpoint_count, selector_count, history_size;
    code *codes; ///< [CODES]
} codebooks;

/// Codes of slices; those of codebooks use the same memory before.
enum { PREDICTION, ENDPOINT_DELTA, SELECTOR, SELECTOR_RUN, CODES };
enum { COLOR_LOW, COLOR_MIDDLE, COLOR_HIGH, INTENSITY };

static uint8_t next_color(bits *in, const code *codes, uint8_t before)
{
    const code *c = &codes[before <= 9 ? COLOR_LOW : before <= 21 ? COLOR_MIDDLE : COLOR_HIGH];
    return (uint8_t)((before + decode(in, c)) & 31);
}

static void read_endpoints(bits *in, codebooks *b)
{
    endpoint e = { { 16, 16, 16 }, 0 };
    for (int k = 0; k < CODES; k++)
        read_code(in, &b->codes[k]);
    bool gray = take(in, 1);
    for (uint32_t k = 0; k < b->endpoint_count && !in->bad; k++) {
        e.intensity = (uint8_t)((e.intensity + decode(in, &b->codes[INTENSITY])) & 7);
        for (int c = 0; c < 3; c++)
            e.color[c] = gray && c > 0 ? e.color[0] : next_color(in, b->codes, e.color[c]);
        b->endpoints[k] = e;
    }
}

static void read_selectors(bits *in, codebooks *b)
{
    if (take(in, 2) != 0) in->bad = true;
    bool plain = take(in, 1);
    if (!plain) read_code(in, &b->codes[0]);
    for (uint32_t k = 0; k < b->selector_count && !in->bad; k++)
        for (int row = 0; row < 4; row++)
            b->selectors[k].row[row] =
                plain || k == 0
                    ? (uint8_t)take(in, 8)
                    : (uint8_t)(decode(in, &b->codes[0]) ^ b->selectors[k - 1].row[row]);
}

static void read_slice_codes(bits *in, codebooks *b)
{
    for (int k = 0; k < CODES; k++)
        read_code(in, &b->codes[k]);
    b->history_size = take(in, 13);
}

// ---- slices -------------------------------------------------------------------------------------

#define REPEAT_PREDICTION 256
#define LEAST_REPEATS 3
#define LEAST_RUN 3
#define LONG_RUN 63

/// Channels of the picture that a slice goes to.
typedef enum target { TO_COLOR, TO_GREEN, TO_ALPHA } target;

/// A slice being read, block by block in rows.
typedef struct slice {
    const codebooks *books;
    const rsv_basis_lz *source;
    target to;
    uint8_t *rgba; ///< of the picture
    bits in;
    uint32_t blocks_x, blocks_y;
    uint16_t *above;       ///< [2 * blocks_x] endpoints of this row and of the one before
    uint8_t *pairs;        ///< [(blocks_x + 1) / 2] predictions for the second row of two
    uint16_t *history;     ///< [history_size] selectors
    uint32_t rover;        ///< where the next one goes in the history
    uint32_t prediction;   ///< two bits per block
    uint32_t last_group;   ///< predictions of four blocks, read last
    uint32_t repeats;      ///< groups that are still like that
    uint32_t endpoint;     ///< of the block before
    uint32_t selector_run; ///< blocks with the first selector of the history that are left
} slice;

/// Predictions are read for 2 x 2 blocks together.
static void read_prediction(slice *s, uint32_t x, uint32_t y)
{
    if (y % 2) {
        s->prediction = s->pairs[x / 2];
        return;
    }
    if (s->repeats > 0) {
        s->repeats--;
    } else {
        uint32_t group = decode(&s->in, &s->books->codes[PREDICTION]);
        if (group == REPEAT_PREDICTION)
            s->repeats = take_chunks(&s->in, 4) + LEAST_REPEATS - 1;
        else
            s->last_group = group;
    }
    s->prediction = s->last_group & 15;
    s->pairs[x / 2] = (uint8_t)(s->last_group >> 4);
}

static uint32_t read_endpoint(slice *s, uint32_t x, uint32_t y)
{
    const uint16_t *before = s->above + (size_t)(y + 1) % 2 * s->blocks_x;
    uint32_t count = s->books->endpoint_count, prediction = s->prediction & 3;
    s->prediction >>= 2;
    if ((x == 0 && prediction % 2 == 0) || (y == 0 && (prediction == 1 || prediction == 2)))
        s->in.bad = true;
    else if (prediction == 1)
        s->endpoint = before[x];
    else if (prediction == 2)
        s->endpoint = before[x - 1];
    else if (prediction == 3)
        s->endpoint += decode(&s->in, &s->books->codes[ENDPOINT_DELTA]);
    if (s->endpoint >= count) s->endpoint -= count;
    if (s->endpoint >= count) {
        s->in.bad = true;
        s->endpoint = 0;
    }
    s->above[(size_t)y % 2 * s->blocks_x + x] = (uint16_t)s->endpoint;
    return s->endpoint;
}

/// Number of a selector, or that of the history's first plus a place in it.
static uint32_t read_selector_symbol(slice *s)
{
    uint32_t history = s->books->selector_count, run = history + s->books->history_size;
    if (s->selector_run > 0) {
        s->selector_run--;
        return history;
    }
    uint32_t symbol = decode(&s->in, &s->books->codes[SELECTOR]);
    if (symbol != run) return symbol;
    uint32_t length = decode(&s->in, &s->books->codes[SELECTOR_RUN]);
    if (length == LONG_RUN) length = take_chunks(&s->in, 7);
    s->selector_run = length + LEAST_RUN - 1;
    return history;
}

/// What is used moves halfway to the front of the history; what is new starts in its middle.
static uint32_t read_selector(slice *s)
{
    uint32_t symbol = read_selector_symbol(s), size = s->books->history_size;
    if (symbol < s->books->selector_count) {
        if (size == 0) return symbol;
        s->history[s->rover++] = (uint16_t)symbol;
        if (s->rover == size) s->rover = size / 2;
        return symbol;
    }
    uint32_t place = symbol - s->books->selector_count;
    if (place >= size) {
        s->in.bad = true;
        return 0;
    }
    uint16_t found = s->history[place];
    s->history[place] = s->history[place / 2];
    s->history[place / 2] = found;
    return found;
}

static uint8_t shade(uint32_t color, int change)
{
    int value = (int)(color << 3 | color >> 2) + change;
    return (uint8_t)(value < 0 ? 0 : value > 255 ? 255 : value);
}

/// Four colours of a block: its own, darker and brighter.
static void find_colors(const endpoint *e, uint8_t color[4][3])
{
    static const uint8_t near[8] = { 2, 5, 9, 13, 18, 24, 33, 47 };
    static const uint8_t far[8] = { 8, 17, 29, 42, 60, 80, 106, 183 };
    const int change[4] = { -far[e->intensity], -near[e->intensity], near[e->intensity],
        far[e->intensity] };
    for (int k = 0; k < 4; k++)
        for (int c = 0; c < 3; c++)
            color[k][c] = shade(e->color[c], change[k]);
}

static void set_texel(uint8_t rgba[4], const uint8_t color[3], target to)
{
    if (to != TO_COLOR) {
        rgba[to == TO_GREEN ? 1 : 3] = color[1];
        return;
    }
    memcpy(rgba, color, 3);
    rgba[3] = 255;
}

static void write_block(const slice *s, uint32_t x, uint32_t y, const selector *chosen)
{
    uint8_t color[4][3];
    find_colors(&s->books->endpoints[s->endpoint], color);
    uint32_t width = s->source->width, height = s->source->height;
    for (uint32_t j = 0; j < 4 && 4 * y + j < height; j++)
        for (uint32_t i = 0; i < 4 && 4 * x + i < width; i++) {
            size_t at = (size_t)(4 * y + j) * width + 4 * x + i;
            set_texel(s->rgba + 4 * at, color[chosen->row[j] >> 2 * i & 3], s->to);
        }
}

static void read_blocks(slice *s)
{
    for (uint32_t y = 0; y < s->blocks_y; y++)
        for (uint32_t x = 0; x < s->blocks_x && !s->in.bad; x++) {
            if (x % 2 == 0) read_prediction(s, x, y);
            read_endpoint(s, x, y);
            uint32_t number = read_selector(s);
            if (!s->in.bad) write_block(s, x, y, &s->books->selectors[number]);
        }
}

static rsv_status read_slice(
    const codebooks *b, const rsv_basis_lz *source, bits in, target to, uint8_t *rgba)
{
    rsv_context *context = b->context;
    slice s = { .books = b,
        .source = source,
        .to = to,
        .rgba = rgba,
        .in = in,
        .blocks_x = (source->width + 3) / 4,
        .blocks_y = (source->height + 3) / 4,
        .rover = b->history_size / 2 };
    s.above = rsv_alloc(context, 2 * (size_t)s.blocks_x, sizeof *s.above);
    s.pairs = rsv_alloc(context, (s.blocks_x + 1) / 2, sizeof *s.pairs);
    s.history = rsv_alloc(context, b->history_size + 1, sizeof *s.history);
    rsv_status status = RSV_ERROR_MEMORY;
    if (s.above && s.pairs && s.history) {
        read_blocks(&s);
        status = s.in.bad ? RSV_ERROR_FORMAT : RSV_OK;
    }
    rsv_free(context, s.above);
    rsv_free(context, s.pairs);
    rsv_free(context, s.history);
    return status;
}

// ---- all of it ----------------------------------------------------------------------------------

typedef struct bytes {
    const uint8_t *data;
    size_t size;
} bytes;

/// Part of some bytes. @param at where; moves past it
static bool part_of(bytes whole, size_t *at, size_t length, bits *part)
{
    if (*at > whole.size || length > whole.size - *at) return false;
    *part = (bits){ .bytes = whole.data + *at, .size = length };
    *at += length;
    return true;
}

static rsv_status read_books(codebooks *b, const rsv_basis_lz *source)
{
    const uint8_t *head = source->global;
    const bytes global = { head, source->global_size };
    size_t at = HEADER_BYTES + IMAGE_BYTES * (size_t)source->level_count;
    bits endpoints, selectors, codes;
    b->endpoint_count = rsv_read_u32(head) & 0xffff;
    b->selector_count = rsv_read_u32(head) >> 16;
    if (!part_of(global, &at, rsv_read_u32(head + 4), &endpoints) ||
        !part_of(global, &at, rsv_read_u32(head + 8), &selectors) ||
        !part_of(global, &at, rsv_read_u32(head + 12), &codes))
        return RSV_ERROR_FORMAT;
    b->endpoints = rsv_alloc(b->context, b->endpoint_count + 1, sizeof *b->endpoints);
    b->selectors = rsv_alloc(b->context, b->selector_count + 1, sizeof *b->selectors);
    b->codes = rsv_alloc(b->context, CODES, sizeof *b->codes);
    if (!b->endpoints || !b->selectors || !b->codes) return RSV_ERROR_MEMORY;
    read_endpoints(&endpoints, b);
    read_selectors(&selectors, b);
    read_slice_codes(&codes, b);
    return endpoints.bad || selectors.bad || codes.bad ? RSV_ERROR_FORMAT : RSV_OK;
}

/// Slice of the first picture. @param image describes it: place and length of both slices
static rsv_status read_slice_of(
    const codebooks *b, const rsv_basis_lz *source, const uint8_t *image, target to, uint8_t *rgba)
{
    const uint8_t *words = image + (to == TO_COLOR ? 4 : 12);
    size_t at = rsv_read_u32(words);
    bits in;
    if (!part_of((bytes){ source->level, source->level_size }, &at, rsv_read_u32(words + 4), &in))
        return RSV_ERROR_FORMAT;
    return read_slice(b, source, in, to, rgba);
}

rsv_status rsv_basis_lz_decode(
    rsv_context *context, const rsv_basis_lz *source, rsv_basis_second second, uint8_t *rgba)
{
    codebooks b = { .context = context };
    const uint8_t *image = source->global + HEADER_BYTES;
    if (source->global_size < HEADER_BYTES + IMAGE_BYTES) return RSV_ERROR_FORMAT;
    rsv_status status = read_books(&b, source);
    if (status == RSV_OK) status = read_slice_of(&b, source, image, TO_COLOR, rgba);
    if (status == RSV_OK && second != RSV_BASIS_NONE && rsv_read_u32(image + 16) > 0)
        status =
            read_slice_of(&b, source, image, second == RSV_BASIS_ALPHA ? TO_ALPHA : TO_GREEN, rgba);
    rsv_free(context, b.endpoints);
    rsv_free(context, b.selectors);
    rsv_free(context, b.codes);
    return status;
}
