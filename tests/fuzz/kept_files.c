#include "kept_files.h"

#include "core/key.h"
#include "unit/file_fixture.h"
#include "unit/light_fixture.h"
#include "update/history_file.h"
#include "update/row_catalogue.h"
#include "update/row_reader.h"
#include "update/row_record_head.h"

#include "resolvent/solve.h"

/// The room and the files left by its first solve. It lives as long as the program, as every input is tried on it.
typedef struct kept_room {
    world *before, *after;
    folder left, next; ///< files of the first solve; files of the next one
    uint8_t *file[3];  ///< as they were left
    size_t bytes[3];
    char name[3][64];
} kept_room;

static const char *const extensions[3] = { ".history", ".scene", ".rows" };

static world *build(float box_at)
{
    world *w = world_begin(1);
    uint32_t walls = world_lambert(w, 0.5f, 0), lamp = world_lambert(w, 0, 5);
    world_room(w, walls, v3(0, 0, 0), v3(3, 2, 2));
    world_box(w, walls, v3(box_at, 1e-4f, 0.5f), v3(box_at + 0.3f, 0.4f, 0.8f));
    world_box(w, lamp, v3(1, 1.9f, 0.8f), v3(1.3f, 1.95f, 1.1f));
    world_commit(w);
    return w;
}

/// @param rays out: number of traced rays; NULL = not needed
static rsv_status solve(const world *w, const char *rows, const char *earlier, uint64_t *rays)
{
    rsv_light *solution = NULL;
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 20;
    desc.rays_per_element = 64;
    desc.refinements = 1;
    desc.direct_levels = 1;
    desc.photon_count = 0;
    desc.max_elements = 2000;
    desc.checkpoint = rows;
    desc.earlier = earlier;
    rsv_status status = rsv_light_create(w->scene, &desc, &solution);
    if (rays && solution) {
        const rsv_solve_report *report = rsv_light_report(solution);
        *rays = report->rays - report->kept_row_rays;
    }
    rsv_light_destroy(solution);
    return status;
}

/// Takes the largest file of a kind: smaller ones are of pilots. @param key its name begins with; "" = any
static void take_largest(kept_room *room, int kind, const char *key)
{
    DIR *directory = opendir(room->left.path);
    for (struct dirent *entry; directory && (entry = readdir(directory));) {
        char name[64];
        snprintf(name, sizeof name, "%.60s", entry->d_name);
        const char *dot = strrchr(name, '.');
        size_t bytes;
        if (!dot || strcmp(dot, extensions[kind]) != 0 || strncmp(name, key, strlen(key)) != 0)
            continue;
        uint8_t *data = read_bytes(path_in(&room->left, name), &bytes);
        if (bytes <= room->bytes[kind]) {
            free(data);
            continue;
        }
        free(room->file[kind]);
        room->file[kind] = data;
        room->bytes[kind] = bytes;
        memcpy(room->name[kind], name, sizeof name);
    }
    if (directory) closedir(directory);
}

/// Rows are those of the catalogue: pilots have more rays, and may have larger files.
static void take_files(kept_room *room)
{
    char key[RSV_ROW_KEY_DIGITS + 1] = { 0 };
    take_largest(room, 0, "");
    take_largest(room, 1, "");
    memcpy(key, room->name[1], RSV_ROW_KEY_DIGITS);
    take_largest(room, 2, key);
}

/// Rays that the edited room takes.
static uint64_t count_rays(kept_room *room)
{
    uint64_t rays = 0;
    room->next = new_folder();
    if (solve(room->after, room->next.path, room->left.path, &rays) != RSV_OK) abort();
    remove_folder(room->next.path);
    return rays;
}

/// Each file saves rays when it is intact: this ensures that the readers under test do read it.
static void check_use(kept_room *room, int kind)
{
    uint64_t with = count_rays(room);
    const char *path = path_in(&room->left, room->name[kind]);
    write_bytes(path, room->file[kind], 0);
    if (with >= count_rays(room)) abort();
    write_bytes(path, room->file[kind], room->bytes[kind]);
}

static kept_room *the_room(void);

static void remove_room(void)
{
    kept_room *room = the_room();
    remove_folder(room->left.path);
    world_end(room->before);
    world_end(room->after);
    for (int k = 0; k < 3; k++)
        free(room->file[k]);
    free(room);
}

static kept_room *the_room(void)
{
    static kept_room *room;
    if (room) return room;
    room = calloc(1, sizeof *room);
    if (!room || atexit(remove_room) != 0) abort();
    room->left = new_folder();
    room->before = build(0.5f);
    room->after = build(0.8f);
    if (solve(room->before, room->left.path, NULL, NULL) != RSV_OK) abort();
    take_files(room);
    for (int kind = 0; kind < 3; kind++)
        check_use(room, kind);
    return room;
}

static void mend_past(const kept_room *room, uint8_t *data, size_t size)
{
    rsv_history_header *h = (rsv_history_header *)(void *)data;
    if (size < sizeof *h) return;
    h->magic = RSV_HISTORY_MAGIC;
    h->settings = ((const rsv_history_header *)(const void *)room->file[0])->settings;
    h->checksum = rsv_history_checksum(h, size);
}

static void mend_catalogue(uint8_t *data, size_t size)
{
    rsv_row_catalogue_header h;
    if (size < sizeof h) return;
    memcpy(&h, data, sizeof h);
    h.checksum = 0;
    uint64_t sum = rsv_key_add_bytes(h.magic, &h, sizeof h);
    h.checksum = rsv_key_add_bytes(sum, data + sizeof h, size - sizeof h);
    memcpy(data, &h, sizeof h);
}

static void mend_rows(uint8_t *data, size_t size)
{
    rsv_row_record_head head;
    for (size_t at = 0, bytes; size - at >= sizeof head; at += bytes) {
        memcpy(&head, data + at, sizeof head);
        if (head.count > 4096 || head.tinted_count > 4096 || head.escape_count > 4096 ||
            head.tinted_escape_count > 4096 || head.ray_count > 4096)
            return;
        bytes = rsv_row_record_layout_of(&head).begin[RSV_ROW_PARTS];
        if (bytes > size - at) return;
        head.checksum = rsv_row_record_checksum(data + at, bytes);
        memcpy(data + at, &head, sizeof head);
    }
}

static void try_files(kept_room *room, int kind, const uint8_t *data, size_t size)
{
    write_bytes(path_in(&room->left, room->name[kind]), data, size);
    room->next = new_folder();
    solve(room->after, room->next.path, room->left.path, NULL);
    remove_folder(room->next.path);
    if (kind == 2) solve(room->before, room->left.path, NULL, NULL);
    write_bytes(path_in(&room->left, room->name[kind]), room->file[kind], room->bytes[kind]);
}

static int kind_of(const char *extension)
{
    for (int k = 0; k < 3; k++)
        if (strcmp(extension, extensions[k]) == 0) return k;
    abort();
}

void fuzz_kept_file(const char *extension, uint8_t *data, size_t size)
{
    kept_room *room = the_room();
    int kind = kind_of(extension);
    if (kind == 0) mend_past(room, data, size);
    if (kind == 1) mend_catalogue(data, size);
    if (kind == 2) mend_rows(data, size);
    try_files(room, kind, data, size);
}

void fuzz_copy_kept_file(const char *extension, const char *path)
{
    kept_room *room = the_room();
    int kind = kind_of(extension);
    write_bytes(path, room->file[kind], room->bytes[kind]);
    try_files(room, kind, room->file[kind], room->bytes[kind]);
}
