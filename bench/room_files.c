#include "room_files.h"

#include <cJSON.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/// Files in the folder of assets, and their surroundings.
static const struct {
    const char *name, *file, *environment;
} rooms[] = {
    { "modern_hall", "interiors/modern_hall.glb", NULL },
    { "fireplace_room", "interiors/fireplace_room.glb", "env/fireplace_room_sky_1k.hdr" },
    { "white_room", "interiors/white_room.glb", NULL },
    { "wooden_staircase", "interiors/wooden_staircase.glb", NULL },
    { "japanese_classroom", "interiors/japanese_classroom.glb", NULL },
    { "studio", "interiors/studio.glb", NULL },
    { "head", "head/lee_perry_smith.glb", "env/uffizi_1200x600.hdr" },
    { "SheenChair", "gltf/SheenChair/SheenChair.gltf", "env/uffizi_1200x600.hdr" },
    { "MetalRoughSpheres", "gltf/MetalRoughSpheresNoTextures.glb", "env/uffizi_1200x600.hdr" },
    { "TransmissionRoughness", "gltf/TransmissionRoughnessTest.glb", "env/uffizi_1200x600.hdr" },
    { "ClearCoat", "gltf/ClearCoatTest.glb", "env/uffizi_1200x600.hdr" },
};

enum { room_count = sizeof rooms / sizeof rooms[0] };

/// The last part of a path, without its extension.
static void name_file(const char *path, char name[64])
{
    const char *slash = strrchr(path, '/');
    snprintf(name, 64, "%s", slash ? slash + 1 : path);
    char *point = strrchr(name, '.');
    if (point && point != name) *point = '\0';
}

static void describe_own(const cli_bench_task *bench, cli_room_files *room)
{
    name_file(bench->scene, room->name);
    snprintf(room->scene, sizeof room->scene, "%s", bench->scene);
    if (bench->environment.path)
        snprintf(room->environment, sizeof room->environment, "%s", bench->environment.path);
}

bool cli_find_room(const cli_bench_task *bench, const char *benchmark, cli_room_files *room)
{
    size_t k = 0;
    *room = (cli_room_files){ .name = "" };
    while (k < room_count && strcmp(rooms[k].name, bench->scene) != 0)
        k++;
    if (k == room_count) {
        describe_own(bench, room);
        return true;
    }
    if (!bench->assets) {
        cli_error(
            "bench %s: '%s' is not part of this repository: give its folder with --assets FOLDER or "
            "RSV_ASSETS (docs/benchmarks.md)",
            benchmark, bench->scene);
        return false;
    }
    room->is_asset = true;
    snprintf(room->name, sizeof room->name, "%s", rooms[k].name);
    snprintf(room->scene, sizeof room->scene, "%s/%s", bench->assets, rooms[k].file);
    if (rooms[k].environment)
        snprintf(room->environment, sizeof room->environment, "%s/%s", bench->assets,
            rooms[k].environment);
    return true;
}

bool cli_room_is_missing(const cli_room_files *room, cJSON *result)
{
    bool missing = room->is_asset && access(room->scene, F_OK) != 0;
    if (missing) cJSON_AddStringToObject(result, "skipped", "the file is not there");
    return missing;
}
