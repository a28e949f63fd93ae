/// Walks over the segments of a JPEG file (ITU-T T.81, annex B), more strictly than the decoder does. It refuses
/// anything between segments, so that the decoder meets no table that was not checked here, and scans whose tables are
/// missing, for which the decoder would use uninitialised memory.
#include "image_internal.h"

#define STUFFED_ZERO 0x00 // after an 0xFF that is data
#define FILL 0xFF
#define SOF0 0xC0 // the first marker that may stand outside a scan
#define DHT 0xC4
#define RST0 0xD0
#define SOI 0xD8
#define EOI 0xD9
#define SOS 0xDA

/// Classes of Huffman tables.
enum { OF_DC, OF_AC, CLASSES };

typedef struct walker {
    const rsv_image_file *file;
    size_t position;
    unsigned huffman[CLASSES]; ///< tables met so far, a bit each
} walker;

static rsv_status fail_format(const walker *at, const char *problem)
{
    return rsv_fail(RSV_ERROR_FORMAT, "cannot read '%s': %s at byte %zu", at->file->path, problem,
        at->position);
}

static size_t bytes_left(const walker *at) { return at->file->size - at->position; }

static bool is_restart(uint8_t marker) { return marker >= RST0 && marker < SOI; }

static rsv_status read_marker(walker *at, uint8_t *marker)
{
    const uint8_t *bytes = at->file->bytes;
    if (bytes_left(at) < 2) return fail_format(at, "the file is truncated");
    if (bytes[at->position] != FILL) return fail_format(at, "no JPEG marker");
    while (bytes_left(at) > 1 && bytes[at->position] == FILL)
        at->position++;
    *marker = bytes[at->position];
    if (*marker < SOF0 || is_restart(*marker) || *marker == SOI || *marker == FILL)
        return fail_format(at, "misplaced JPEG marker");
    at->position++;
    return RSV_OK;
}

/// One segment may hold several tables: class and id, 16 counts of codes by length, the symbols.
static rsv_status check_huffman_tables(walker *at, size_t end)
{
    const size_t head = 1 + 16;
    while (at->position < end) {
        const uint8_t *table = at->file->bytes + at->position;
        size_t left = end - at->position, symbols = 0;
        if (left < head) return fail_format(at, "Huffman table cut short");
        if (table[0] >> 4 >= CLASSES || (table[0] & 15) > 3)
            return fail_format(at, "Huffman table of no known class");
        at->huffman[table[0] >> 4] |= 1u << (table[0] & 15);
        for (int length = 1; length <= 16; length++)
            symbols += table[length];
        if (symbols > 256 || symbols > left - head) return fail_format(at, "invalid Huffman table");
        at->position += head + symbols;
    }
    return RSV_OK;
}

static bool has_table(const walker *at, int class, unsigned id)
{
    return at->huffman[class] >> id & 1;
}

/// The header of a scan: count, then id and tables of each component, then the band of frequencies and how it is
/// refined.
static rsv_status check_scan(walker *at, size_t end)
{
    const uint8_t *header = at->file->bytes + at->position;
    size_t left = end - at->position, count = left ? header[0] : 0;
    if (count == 0 || count > 4 || left < 4 + 2 * count) return fail_format(at, "invalid scan");
    const uint8_t *band = header + 1 + 2 * count;
    bool codes_dc = band[0] == 0 && band[2] >> 4 == 0, codes_ac = band[1] > 0;
    for (size_t k = 0; k < count; k++) {
        unsigned dc = header[2 + 2 * k] >> 4, ac = header[2 + 2 * k] & 15;
        if ((codes_dc && !has_table(at, OF_DC, dc)) || (codes_ac && !has_table(at, OF_AC, ac)))
            return fail_format(at, "a scan names a Huffman table that the file does not have");
    }
    return RSV_OK;
}

/// Moves to the next marker that is not part of a scan's entropy-coded data.
static void skip_entropy_coded_data(walker *at)
{
    const uint8_t *bytes = at->file->bytes;
    for (; bytes_left(at) > 1; at->position++) {
        uint8_t next = bytes[at->position + 1];
        if (bytes[at->position] == FILL && next != STUFFED_ZERO && !is_restart(next)) return;
    }
}

static rsv_status check_segment(walker *at, uint8_t marker)
{
    const uint8_t *length = at->file->bytes + at->position;
    if (bytes_left(at) < 2) return fail_format(at, "the file is truncated");
    size_t bytes = (size_t)(length[0] << 8 | length[1]);
    if (bytes < 2 || bytes > bytes_left(at)) return fail_format(at, "invalid segment length");
    size_t end = at->position + bytes;
    at->position += 2;
    rsv_status status = marker == DHT   ? check_huffman_tables(at, end)
                        : marker == SOS ? check_scan(at, end)
                                        : RSV_OK;
    if (status != RSV_OK) return status;
    at->position = end;
    if (marker == SOS) skip_entropy_coded_data(at);
    return RSV_OK;
}

rsv_status rsv_image_check_jpeg(const rsv_image_file *file)
{
    rsv_status status = RSV_OK;
    walker at = { .file = file };
    uint8_t marker = 0;
    if (file->size == 0 || file->bytes[0] != FILL) return RSV_OK; // another format
    if (file->size < 2 || file->bytes[1] != SOI) return fail_format(&at, "no start of image");
    at.position = 2;
    do {
        RSV_TRY(read_marker(&at, &marker));
        if (marker != EOI) RSV_TRY(check_segment(&at, marker));
    } while (marker != EOI);
cleanup:
    return status;
}
