#include "checkpoint.h"

#include "../core/team.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#define MAGIC 0x31776f72u // "row1"
#define PATH_BYTES 4096
#define KEY_DIGITS 16

/// What a file holds of each row: this, columns, tinted columns and weights, then the same of escapes.
typedef struct record {
    uint32_t magic, node;
    uint32_t count, tinted_count, escape_count, tinted_escape_count;
    rsv_rgb emission;
    uint32_t unused; // the next is aligned
    uint64_t rays;
    uint64_t checksum; ///< of the record with 0 here
} record;

/// A file of an earlier run.
typedef struct mapped_file {
    uint8_t *byte;
    size_t count;
} mapped_file;

struct rsv_checkpoint {
    rsv_context *context;
    size_t node_count;
    uint32_t rays;
    char key[KEY_DIGITS + 1];
    const uint8_t **known; ///< [node_count] records by node; NULL = none
    mapped_file *file;
    size_t file_count, file_capacity;
    int descriptor;  ///< of the file that grows; -1 = given up
    size_t own_size; ///< bytes of sound records that it had
    char path[PATH_BYTES];
};

/// FNV-1a by words of eight bytes: guards against cut-off writes, not against malice.
static uint64_t hash_bytes(uint64_t hash, const void *data, size_t bytes)
{
    const uint8_t *next = data;
    for (; bytes >= 8; bytes -= 8, next += 8) {
        uint64_t word;
        memcpy(&word, next, 8);
        hash = (hash ^ word) * 0x100000001b3ull;
        hash ^= hash >> 32;
    }
    for (; bytes; bytes--)
        hash = (hash ^ *next++) * 0x100000001b3ull;
    return hash;
}

static uint64_t key_of(const rsv_row_tracer *t)
{
    const rsv_elements *e = t->elements;
    const uint64_t numbers[4] = { e->node_count, e->cell_count, t->directions.count, t->seed };
    uint64_t hash = hash_bytes(0xcbf29ce484222325ull, numbers, sizeof numbers);
    for (size_t c = 0; c < e->cell_count; c++) {
        const rsv_cell *cell = &e->cell[c];
        const uint32_t place[5] = { cell->face, cell->i, cell->j, cell->level, cell->flipped };
        hash = hash_bytes(hash, place, sizeof place);
    }
    hash = hash_bytes(hash, e->cell_node, e->cell_count * sizeof *e->cell_node);
    return hash_bytes(hash, t->valid_points, e->node_count * sizeof *t->valid_points);
}

// ---- records -------------------------------------------------------------------------------------

static size_t record_bytes(const record *r)
{
    size_t tinted = sizeof(uint32_t) + sizeof(rsv_rgb),
           tinted_bin = sizeof(uint16_t) + sizeof(rsv_rgb);
    return sizeof *r + r->count * sizeof(uint32_t) + r->tinted_count * tinted +
           r->escape_count * sizeof(uint16_t) + r->tinted_escape_count * tinted_bin;
}

static uint64_t record_checksum(const uint8_t *bytes, size_t count)
{
    record header;
    memcpy(&header, bytes, sizeof header);
    header.checksum = 0;
    uint64_t hash = hash_bytes(MAGIC, &header, sizeof header);
    return hash_bytes(hash, bytes + sizeof header, count - sizeof header);
}

/// Whether nodes and bins exist: what is not aligned is copied first.
static bool indices_fit(const rsv_checkpoint *c, const record *r, const uint8_t *bytes)
{
    size_t bins = sizeof(uint16_t), bin_start;
    for (uint32_t k = 0; k < r->count + r->tinted_count; k++) {
        uint32_t node;
        memcpy(&node, bytes + sizeof *r + k * sizeof node, sizeof node);
        if (node >= c->node_count) return false;
    }
    bin_start = sizeof *r + (r->count + r->tinted_count) * sizeof(uint32_t) +
                r->tinted_count * sizeof(rsv_rgb);
    for (uint32_t k = 0; k < r->escape_count + r->tinted_escape_count; k++) {
        uint16_t bin;
        memcpy(&bin, bytes + bin_start + k * bins, bins);
        if (bin >= RSV_ESCAPE_BINS) return false;
    }
    return true;
}

/// Whether a whole record starts here, and one that fits these rows.
static bool is_sound(const rsv_checkpoint *c, const uint8_t *bytes, size_t left, record *header)
{
    if (left < sizeof *header) return false;
    memcpy(header, bytes, sizeof *header);
    const uint32_t counts[] = { header->count, header->tinted_count, header->escape_count,
        header->tinted_escape_count };
    for (size_t k = 0; k < 4; k++)
        if (counts[k] > c->rays) return false;
    return header->magic == MAGIC && header->node < c->node_count && record_bytes(header) <= left &&
           header->checksum == record_checksum(bytes, record_bytes(header)) &&
           indices_fit(c, header, bytes);
}

/// Notes the records of a file. @return bytes up to the first that is not sound
static size_t index_records(rsv_checkpoint *c, const mapped_file *file)
{
    record header;
    size_t at = 0;
    while (is_sound(c, file->byte + at, file->count - at, &header)) {
        c->known[header.node] = file->byte + at;
        at += record_bytes(&header);
    }
    return at;
}

static const uint8_t *take_array(const uint8_t *from, void *array, size_t count, size_t bytes)
{
    if (count) memcpy(array, from, count * bytes);
    return from + count * bytes;
}

bool rsv_checkpoint_take(const rsv_checkpoint *c, uint32_t node, rsv_row_scratch *s)
{
    if (!c || !c->known[node]) return false;
    record r;
    memcpy(&r, c->known[node], sizeof r);
    const uint8_t *next = c->known[node] + sizeof r;
    memset(s->column, 0xff, c->rays * sizeof *s->column);
    next = take_array(next, s->column, r.count, sizeof *s->column);
    next = take_array(next, s->tinted_column, r.tinted_count, sizeof *s->tinted_column);
    next = take_array(next, s->tinted_weight, r.tinted_count, sizeof *s->tinted_weight);
    next = take_array(next, s->escapes.bin, r.escape_count, sizeof *s->escapes.bin);
    next = take_array(
        next, s->escapes.tinted_bin, r.tinted_escape_count, sizeof *s->escapes.tinted_bin);
    take_array(
        next, s->escapes.tinted_weight, r.tinted_escape_count, sizeof *s->escapes.tinted_weight);
    s->tinted_count = r.tinted_count;
    s->escapes.count = r.escape_count;
    s->escapes.tinted_count = r.tinted_escape_count;
    s->emission = r.emission;
    s->rays += r.rays;
    return true;
}

static void put(rsv_checkpoint_block *b, const void *array, size_t bytes)
{
    if (bytes) memcpy(b->byte + b->count, array, bytes);
    b->count += bytes;
}

rsv_status rsv_checkpoint_keep(rsv_checkpoint *c, uint32_t node, const rsv_row_scratch *s,
    uint64_t rays, rsv_checkpoint_block *b)
{
    const rsv_escape_row *e = &s->escapes;
    record r = { .magic = MAGIC,
        .node = node,
        .tinted_count = s->tinted_count,
        .escape_count = e->count,
        .tinted_escape_count = e->tinted_count,
        .emission = s->emission,
        .rays = rays };
    for (uint32_t ray = 0; ray < c->rays; ray++)
        r.count += s->column[ray] != RSV_NONE;
    size_t start = b->count;
    rsv_status status = rsv_grow(
        c->context, (void **)&b->byte, &b->capacity, start + record_bytes(&r), sizeof *b->byte);
    if (status != RSV_OK) return status;
    put(b, &r, sizeof r);
    for (uint32_t ray = 0; ray < c->rays; ray++)
        if (s->column[ray] != RSV_NONE) put(b, &s->column[ray], sizeof *s->column);
    put(b, s->tinted_column, r.tinted_count * sizeof *s->tinted_column);
    put(b, s->tinted_weight, r.tinted_count * sizeof *s->tinted_weight);
    put(b, e->bin, r.escape_count * sizeof *e->bin);
    put(b, e->tinted_bin, r.tinted_escape_count * sizeof *e->tinted_bin);
    put(b, e->tinted_weight, r.tinted_escape_count * sizeof *e->tinted_weight);
    r.checksum = record_checksum(b->byte + start, b->count - start);
    memcpy(b->byte + start, &r, sizeof r);
    return RSV_OK;
}

// ---- files ---------------------------------------------------------------------------------------

static void give_up(rsv_checkpoint *c)
{
    rsv_log(c->context, RSV_LOG_WARNING,
        "checkpoint: cannot write '%s': %s; going on without, so that a restart will trace again "
        "what follows",
        c->path, strerror(errno));
    close(c->descriptor);
    c->descriptor = -1;
}

void rsv_checkpoint_write(rsv_checkpoint *c, rsv_checkpoint_block *b)
{
    if (!c) return;
#pragma omp critical(rsv_checkpoint)
    for (size_t done = 0; c->descriptor >= 0 && done < b->count;) {
        ssize_t written = write(c->descriptor, b->byte + done, b->count - done);
        if (written >= 0)
            done += (size_t)written;
        else if (errno != EINTR)
            give_up(c);
    }
    b->count = 0;
}

static rsv_status map_file(rsv_checkpoint *c, const char *path, mapped_file *file)
{
    struct stat info;
    *file = (mapped_file){ 0 };
    int descriptor = open(path, O_RDONLY | O_CLOEXEC);
    if (descriptor < 0 || fstat(descriptor, &info) != 0 || info.st_size == 0) {
        if (descriptor >= 0) close(descriptor);
        return RSV_OK; // nothing to learn from it
    }
    void *byte = mmap(NULL, (size_t)info.st_size, PROT_READ, MAP_PRIVATE, descriptor, 0);
    close(descriptor);
    if (byte == MAP_FAILED)
        return rsv_fail(RSV_ERROR_IO, "checkpoint: cannot read '%s': %s", path, strerror(errno));
    rsv_status status = rsv_grow(
        c->context, (void **)&c->file, &c->file_capacity, c->file_count + 1, sizeof *c->file);
    *file = (mapped_file){ byte, (size_t)info.st_size };
    if (status == RSV_OK)
        c->file[c->file_count++] = *file;
    else
        munmap(byte, file->count);
    return status;
}

static rsv_status read_files(rsv_checkpoint *c, const char *folder)
{
    rsv_status status = RSV_OK;
    char path[PATH_BYTES];
    DIR *directory = opendir(folder);
    if (!directory)
        return rsv_fail(
            RSV_ERROR_IO, "checkpoint: cannot open the folder '%s': %s", folder, strerror(errno));
    for (struct dirent *entry; status == RSV_OK && (entry = readdir(directory));) {
        mapped_file file;
        if (strncmp(entry->d_name, c->key, KEY_DIGITS) != 0) continue;
        if (snprintf(path, sizeof path, "%s/%s", folder, entry->d_name) >= (int)sizeof path)
            continue;
        status = map_file(c, path, &file);
        size_t sound = status == RSV_OK && file.byte ? index_records(c, &file) : 0;
        if (strcmp(path, c->path) == 0) c->own_size = sound;
    }
    closedir(directory);
    return status;
}

/// Goes on behind the last sound record.
static rsv_status open_own(rsv_checkpoint *c)
{
    c->descriptor = open(c->path, O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
    if (c->descriptor < 0 || ftruncate(c->descriptor, (off_t)c->own_size) != 0 ||
        lseek(c->descriptor, 0, SEEK_END) < 0)
        return rsv_fail(
            RSV_ERROR_IO, "checkpoint: cannot write '%s': %s", c->path, strerror(errno));
    return RSV_OK;
}

static void report(const rsv_checkpoint *c)
{
    size_t known = 0;
    for (size_t n = 0; n < c->node_count; n++)
        known += c->known[n] != NULL;
    if (known)
        rsv_log(c->context, RSV_LOG_INFO, "checkpoint: %zu rows of %u rays are known already",
            known, c->rays);
}

rsv_status rsv_checkpoint_open(const rsv_row_tracer *tracer, rsv_checkpoint **checkpoint)
{
    rsv_status status;
    rsv_context *context = tracer->elements->context;
    const char *folder = tracer->scene->checkpoint;
    *checkpoint = NULL;
    if (!folder) return RSV_OK;
    rsv_checkpoint *c = rsv_alloc(context, 1, sizeof *c);
    if (!c) return RSV_ERROR_MEMORY;
    c->context = context;
    c->descriptor = -1;
    c->node_count = tracer->elements->node_count;
    c->rays = tracer->directions.count;
    c->known = rsv_alloc(context, c->node_count, sizeof *c->known);
    RSV_TRY(c->known ? RSV_OK : RSV_ERROR_MEMORY);
    snprintf(c->key, sizeof c->key, "%016llx", (unsigned long long)key_of(tracer));
    int length = snprintf(
        c->path, sizeof c->path, "%s/%s-%u.rows", folder, c->key, rsv_team_place_of(context).rank);
    RSV_TRY(length < (int)sizeof c->path
                ? RSV_OK
                : rsv_fail(RSV_ERROR_IO, "checkpoint: the name of the folder is too long"));
    RSV_TRY(rsv_team_meet(context, read_files(c, folder)));
    RSV_TRY(open_own(c)); // after all have read it
    report(c);
    *checkpoint = c;
    c = NULL;
cleanup:
    rsv_checkpoint_close(c);
    return status;
}

void rsv_checkpoint_close(rsv_checkpoint *c)
{
    if (!c) return;
    for (size_t k = 0; k < c->file_count; k++)
        munmap(c->file[k].byte, c->file[k].count);
    if (c->descriptor >= 0) close(c->descriptor);
    rsv_free(c->context, c->file);
    rsv_free(c->context, c->known);
    rsv_free(c->context, c);
}
