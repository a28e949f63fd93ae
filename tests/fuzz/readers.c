#include "readers.h"

#include "io/texture_image.h"
#include "kept_files.h"
#include "light_script.h"
#include "opfile/sha256.h"
#include "opfile/tensor_file.h"
#include "points_csv.h"
#include "resolvent/animation.h"
#include "resolvent/image.h"
#include "resolvent/io.h"
#include "resolvent/luminaire.h"
#include "resolvent/opfile.h"
#include "resolvent/sky.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/// The middle of all animations at once.
static void play(rsv_context *context, const char *path)
{
    rsv_animation *animation = NULL;
    rsv_scene *scene = NULL;
    if (rsv_animation_open(context, path, NULL, &animation) != RSV_OK) return;
    const rsv_clip *clip = rsv_animation_clip(animation, 0);
    if (clip &&
        rsv_animation_scene(animation, RSV_NONE, 0.5 * (clip->start + clip->end), &scene) == RSV_OK)
        rsv_scene_destroy(scene);
    rsv_animation_destroy(animation);
}

static void read_scene(const char *path)
{
    rsv_context *context = NULL;
    rsv_scene *scene = NULL;
    if (rsv_context_create(NULL, &context) != RSV_OK) abort();
    if (rsv_scene_load(context, path, &scene) == RSV_OK) rsv_scene_destroy(scene);
    play(context, path);
    rsv_context_destroy(context);
}

static void read_image(const char *path)
{
    rsv_context *context = NULL;
    rsv_image *image = NULL;
    if (rsv_context_create(NULL, &context) != RSV_OK) abort();
    if (rsv_image_read(context, path, &image) == RSV_OK) rsv_image_destroy(image);
    rsv_context_destroy(context);
}

/// Where the digits of the checksum stand; NULL if nowhere.
static char *find_checksum(char *bytes, size_t size)
{
    static const char key[] = "\"" RSV_CHECKSUM_NOTE "\":\"";
    char *found = memmem(bytes, size, key, sizeof key - 1);
    if (!found) return NULL;
    char *digits = found + sizeof key - 1;
    return (size_t)(bytes + size - digits) >= RSV_SHA256_DIGITS ? digits : NULL;
}

/// Corrects the checksum. Otherwise it would reveal every change, and the code behind it would not be tested.
static void mend_checksum(char *bytes, size_t size)
{
    char *place = find_checksum(bytes, size), digits[RSV_SHA256_DIGITS + 1];
    if (!place) return;
    memset(place, '0', RSV_SHA256_DIGITS);
    rsv_sha256 hash = rsv_sha256_begin();
    rsv_sha256_add(&hash, bytes, size);
    rsv_sha256_end(&hash, digits);
    memcpy(place, digits, RSV_SHA256_DIGITS);
}

/// Reads the file as a texture, for formats that only textures use.
static void read_texture(const char *path)
{
    rsv_context *context = NULL;
    rsv_scene *scene = NULL;
    rsv_texture_source source = { .srgb = true };
    uint32_t id;
    if (rsv_context_create(NULL, &context) != RSV_OK) abort();
    if (rsv_scene_create(context, &scene) != RSV_OK) abort();
    if (rsv_image_file_read(context, NULL, path, &source.file) == RSV_OK)
        rsv_texture_load(scene, &source, &id);
    rsv_free(context, (void *)(uintptr_t)source.file.bytes);
    rsv_scene_destroy(scene);
    rsv_context_destroy(context);
}

static void read_operator(const char *path)
{
    rsv_context *context = NULL;
    rsv_scene *scene = NULL;
    rsv_light *solution = NULL;
    if (rsv_context_create(NULL, &context) != RSV_OK) abort();
    if (rsv_light_load(context, path, &scene, &solution) == RSV_OK) {
        rsv_light_destroy(solution);
        rsv_scene_destroy(scene);
    }
    rsv_context_destroy(context);
}

static void read_points(const char *path)
{
    cli_points points = { 0 };
    cli_read_points(path, &points);
    cli_free_points(&points);
}

static void read_script(const char *path)
{
    cli_light_script script;
    cli_read_light_script(path, &script);
    cli_free_light_script(&script);
}

/// Whatever the file says, its skies must be finite.
static void read_weather(const char *path)
{
    rsv_context *context = NULL;
    rsv_weather weather;
    if (rsv_context_create(NULL, &context) != RSV_OK) abort();
    if (rsv_weather_read(context, path, &weather) == RSV_OK)
        for (size_t k = 0; k < weather.count && k < 100; k++) {
            rsv_perez_sky sky = rsv_weather_sky(&weather, k, NULL);
            if (!(sky.diffuse_illuminance >= 0 && sky.direct_illuminance >= 0)) abort();
        }
    rsv_weather_free(context, &weather);
    rsv_context_destroy(context);
}

/// Whatever the file says, its light must be finite.
static void read_luminaire(const char *path)
{
    rsv_context *context = NULL;
    rsv_luminaire luminaire;
    if (rsv_context_create(NULL, &context) != RSV_OK) abort();
    if (rsv_luminaire_read(context, path, &luminaire) == RSV_OK) {
        double up = rsv_luminaire_intensity(&luminaire, (rsv_vec3){ 0.6f, -0.48f, 0.64f });
        if (!(up >= 0 && rsv_luminaire_flux(&luminaire) >= -1e-3 * rsv_luminaire_peak(&luminaire)))
            abort();
    }
    rsv_luminaire_free(context, &luminaire);
    rsv_context_destroy(context);
}

typedef struct reader {
    const char *extension;
    void (*read)(const char *path);
} reader;

static const reader readers[] = { { ".glb", read_scene }, { ".gltf", read_scene },
    { ".obj", read_scene }, { ".ply", read_scene }, { ".stl", read_scene }, { ".dae", read_scene },
    { ".fbx", read_scene }, { ".exr", read_image }, { ".hdr", read_image }, { ".png", read_image },
    { ".jpg", read_image }, { ".webp", read_image }, { ".tga", read_texture },
    { ".bmp", read_texture }, { ".gif", read_texture }, { ".ktx2", read_texture },
    { ".safetensors", read_operator }, { ".csv", read_points }, { ".epw", read_weather },
    { ".wea", read_weather }, { ".ies", read_luminaire }, { ".ldt", read_luminaire },
    { ".txt", read_script } };

static const reader *reader_of(const char *extension)
{
    for (size_t k = 0; k < sizeof readers / sizeof *readers; k++)
        if (strcmp(extension, readers[k].extension) == 0) return &readers[k];
    fprintf(stderr, "no reader for '%s'\n", extension);
    abort();
}

static bool is_kept_file(const char *extension)
{
    return strcmp(extension, ".history") == 0 || strcmp(extension, ".scene") == 0 ||
           strcmp(extension, ".rows") == 0;
}

/// A copy, because its checksum is corrected.
static void read_kept_file(const char *extension, const uint8_t *data, size_t size)
{
    uint8_t *bytes = malloc(size + 1);
    if (!bytes) abort();
    memcpy(bytes, data, size);
    fuzz_kept_file(extension, bytes, size);
    free(bytes);
}

void fuzz_read(const char *extension, const uint8_t *data, size_t size)
{
    if (is_kept_file(extension)) {
        read_kept_file(extension, data, size);
        return;
    }
    const reader *chosen = reader_of(extension);
    char path[4096], *bytes = malloc(size + 1);
    const char *folder = getenv("TMPDIR");
    snprintf(path, sizeof path, "%s/resolvent-fuzz-%ld%s", folder ? folder : "/tmp", (long)getpid(),
        extension);
    FILE *file = fopen(path, "wb");
    if (!file || !bytes) abort();
    memcpy(bytes, data, size);
    if (chosen->read == read_operator) mend_checksum(bytes, size);
    if (fwrite(bytes, 1, size, file) != size || fclose(file) != 0) abort();
    free(bytes);
    chosen->read(path);
    unlink(path);
}
