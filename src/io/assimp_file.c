#include "assimp_file.h"

#include "assimp_loss.h"
#include "collada_clean.h"
#include "fbx_scan.h"
#include "file_source.h"
#include "obj_scan.h"

#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define MAX_MISSING 8 ///< files a warning names
#define MAX_LIBRARIES 8
#define LARGEST_FILE ((int64_t)1 << 32)

/// The files that an import asked for: those it got, and those that were missing.
typedef struct file_access {
    const rsv_file_source *files;
    const char *path; ///< of the file itself
    char missing[MAX_MISSING][512];
    size_t missing_count;
    char library[MAX_LIBRARIES][512]; ///< of materials, that were read
    size_t library_count;
    rsv_obj_names used, defined; ///< materials of Wavefront files
    double origin[3];            ///< that was taken out of vertices
} file_access;

/// The state behind one of the importer's files.
typedef struct stream {
    FILE *file;
    char *text; ///< that `file` reads; NULL = the disk
    size_t size;
} stream;

static FILE *file_of(const struct aiFile *file) { return ((const stream *)file->UserData)->file; }

static size_t read_file(struct aiFile *file, char *buffer, size_t size, size_t count)
{
    return fread(buffer, size, count, file_of(file));
}

static size_t refuse_write(struct aiFile *file, const char *buffer, size_t size, size_t count)
{
    (void)file, (void)buffer, (void)size, (void)count;
    return 0;
}

static size_t tell_file(struct aiFile *file)
{
    long position = ftell(file_of(file));
    return position < 0 ? 0 : (size_t)position;
}

static size_t size_of_file(struct aiFile *file) { return ((const stream *)file->UserData)->size; }

static enum aiReturn seek_file(struct aiFile *file, size_t offset, enum aiOrigin origin)
{
    static const int whence[] = {
        [aiOrigin_SET] = SEEK_SET, [aiOrigin_CUR] = SEEK_CUR, [aiOrigin_END] = SEEK_END
    };
    if ((unsigned)origin > aiOrigin_END) return aiReturn_FAILURE;
    int failed = fseek(file_of(file), (long)offset, whence[origin]);
    return failed ? aiReturn_FAILURE : aiReturn_SUCCESS;
}

static void flush_nothing(struct aiFile *file) { (void)file; }

static const char *base_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/// Whether the importer made a name up, having found no library of materials under that which the file gives: it puts
/// folders before it, and takes the file's own.
static bool is_guess(const file_access *access, const char *path)
{
    const char *own = base_of(access->path), *name = base_of(path);
    size_t stem = strcspn(own, ".");
    if (access->missing_count == 0) return false;
    return strstr(path, "//") ||
           (strncmp(own, name, stem) == 0 && strcmp(name + stem, ".mtl") == 0);
}

static void remember_missing(file_access *access, const char *path)
{
    if (is_guess(access, path)) return;
    for (size_t i = 0; i < access->missing_count; i++)
        if (strcmp(base_of(access->missing[i]), base_of(path)) == 0) return;
    if (access->missing_count == MAX_MISSING) return;
    char *name = access->missing[access->missing_count++];
    snprintf(name, sizeof access->missing[0], "%s", path);
    for (; *name; name++)
        if (iscntrl((unsigned char)*name)) *name = '?';
}

static void remember_library(file_access *access, const char *path)
{
    const char *extension = strrchr(path, '.');
    if (!extension || strcasecmp(extension, ".mtl") != 0) return;
    for (size_t i = 0; i < access->library_count; i++)
        if (strcmp(access->library[i], path) == 0) return;
    if (access->library_count == MAX_LIBRARIES) return;
    snprintf(access->library[access->library_count++], sizeof access->library[0], "%s", path);
}

/// Devices and pipes, which might never end, and files beyond all measure count as absent.
static bool open_regular(const rsv_file_source *files, const char *path, stream *opened)
{
    int64_t size = rsv_file_size(files, path);
    if (size < 0 || size > LARGEST_FILE) return false;
    *opened = (stream){ .file = rsv_file_open(files, path), .size = (size_t)size };
    return opened->file != NULL;
}

/// Cleans the text before the importer sees it: statements of Wavefront files that it would mistake for others,
/// transforms in COLLADA that it ignores, and properties in FBX that make a model invisible.
static void clean(file_access *access, const char *path, stream *opened)
{
    const char *extension = strrchr(path, '.');
    bool is_library = extension && strcasecmp(extension, ".mtl") == 0;
    bool is_collada = extension && strcasecmp(extension, ".dae") == 0;
    bool is_fbx = extension && strcasecmp(extension, ".fbx") == 0;
    bool is_obj = is_library || (extension && strcasecmp(extension, ".obj") == 0);
    if (!is_collada && !is_fbx && !is_obj) return;
    size_t size;
    double origin[3] = { 0 };
    char *text = is_collada ? rsv_collada_clean(opened->file, &size)
                 : is_fbx   ? rsv_fbx_clean(opened->file, &size)
                            : rsv_obj_clean(opened->file, is_library, &size, origin);
    FILE *file = text && size ? fmemopen(text, size, "rb") : NULL;
    if (!file) {
        free(text);
        rewind(opened->file);
        return;
    }
    fclose(opened->file);
    *opened = (stream){ file, text, size };
    if (!is_obj) return;
    if (!is_library) memcpy(access->origin, origin, sizeof origin);
    rsv_obj_note_names(
        text, is_library ? "newmtl" : "usemtl", is_library ? &access->defined : &access->used);
}

static void close_stream(stream *opened)
{
    if (!opened) return;
    if (opened->file) fclose(opened->file);
    free(opened->text);
    free(opened);
}

static struct aiFile *open_file(struct aiFileIO *io, const char *path, const char *mode)
{
    file_access *access = (file_access *)io->UserData;
    stream *opened = calloc(1, sizeof *opened);
    struct aiFile *file = calloc(1, sizeof *file);
    if (!file || !opened || !strchr(mode, 'r') || !open_regular(access->files, path, opened)) {
        close_stream(opened);
        free(file);
        remember_missing(access, path);
        return NULL;
    }
    clean(access, path, opened);
    remember_library(access, path);
    *file = (struct aiFile){ .ReadProc = read_file,
        .WriteProc = refuse_write,
        .TellProc = tell_file,
        .FileSizeProc = size_of_file,
        .SeekProc = seek_file,
        .FlushProc = flush_nothing,
        .UserData = (aiUserData)opened };
    return file;
}

static void close_file(struct aiFileIO *io, struct aiFile *file)
{
    (void)io;
    if (!file) return;
    close_stream((stream *)(void *)file->UserData);
    free(file);
}

/// Checks what triangulation relies on. Assimp's own validation would refuse whole files for harmless reasons, such as
/// two lights of the same name.
static rsv_status check_mesh(const struct aiMesh *mesh)
{
    char name[RSV_NAME_BYTES];
    rsv_assimp_name(&mesh->mName, "unnamed", name);
    for (unsigned i = 0; i < mesh->mNumFaces; i++) {
        const struct aiFace *face = &mesh->mFaces[i];
        for (unsigned k = 0; k < face->mNumIndices; k++)
            if (face->mIndices[k] >= mesh->mNumVertices)
                return rsv_fail(RSV_ERROR_FORMAT,
                    "mesh '%s': face %u refers to vertex %u, but there are only %u", name, i,
                    face->mIndices[k], mesh->mNumVertices);
    }
    return RSV_OK;
}

/// Checks and triangulates. Meshes without faces stay as they are.
static rsv_status process(const struct aiScene *scene)
{
    size_t faces = 0;
    if (!scene->mRootNode) return rsv_fail(RSV_ERROR_FORMAT, "it holds no scene");
    for (unsigned i = 0; i < scene->mNumMeshes; i++) {
        struct aiMesh *mesh = scene->mMeshes[i];
        if (!mesh->mVertices || !mesh->mFaces) mesh->mNumFaces = 0;
        rsv_status status = check_mesh(mesh);
        if (status != RSV_OK) return status;
        faces += mesh->mNumFaces;
    }
    if (faces == 0)
        return rsv_fail(RSV_ERROR_FORMAT, "cannot be read: it holds no triangle or polygon");
    if (!aiApplyPostProcessing(scene, aiProcess_Triangulate))
        return rsv_fail(RSV_ERROR_FORMAT, "cannot be read: its polygons are malformed");
    return RSV_OK;
}

/// @return NULL if it cannot be read; aiGetErrorString says why
static const struct aiScene *import(
    const char *path, file_access *access, rsv_assimp_losses *losses)
{
    struct aiFileIO io = { open_file, close_file, (aiUserData)access };
    struct aiPropertyStore *properties = aiCreatePropertyStore();
    if (!properties) return NULL;
    aiSetImportPropertyInteger(properties, AI_CONFIG_IMPORT_NO_SKELETON_MESHES, 1);
    aiSetImportPropertyInteger(properties, AI_CONFIG_IMPORT_FBX_READ_ANIMATIONS, 0);
    const struct aiScene *scene = aiImportFileExWithProperties(path, 0, &io, properties);
    aiReleasePropertyStore(properties);
    // not shared until it is released
    if (scene) rsv_assimp_strip((struct aiScene *)(uintptr_t)scene, losses);
    return scene;
}

/// Translates the importer's messages for users: its own words are meant for its developers.
static const char *meaning_of(const char *message)
{
    static const char *const known[][2] = {
        { "too small", "it is empty or cut off" },
        { "malformed XML", "it is not well-formed XML, or cut off" },
        { "File came out empty", "it holds no scene: no <visual_scene> that its <scene> names" },
        { "index count in <p>", "a <p> element does not have as many indices as its parent says" },
        { "Invalid data index", "an index of a <p> element is past the end of its source" },
        { "Unable to resolve library", "it refers to a source or geometry that it does not "
                                       "contain" },
        { "old format version", "it is older than FBX 2011" },
        { "no Objects dictionary", "it holds no objects" },
        { "end of file", "it is empty, or cut off" },
        { "unexpected token", "its text is not in this format" },
        { "mNumMeshes is 0", "it holds no triangle or polygon" },
        { "contains no faces", "it holds no triangle or polygon" },
        { "No meshes remaining", "it holds no triangle or polygon, only lines or points" },
        { "index is out of range", "a face refers to a vertex that does not exist" },
        { "index out of range", "a face refers to a vertex that does not exist" },
        { "is out of range", "a face refers to a vertex that does not exist" },
        { "Invalid face index", "a face refers to a vertex that does not exist" },
        { "Cannot parse string", "there is a word where a number is expected" },
        { "No suitable reader", "its content does not match its name" },
        { "allocate", "it is damaged, or too large for memory" },
        { "std::", "it is damaged, or too large for memory" },
    };
    for (size_t k = 0; k < sizeof known / sizeof *known; k++)
        if (strstr(message, known[k][0])) return known[k][1];
    return *message ? "its content is damaged, or of a kind that is not supported"
                    : "it is damaged, or too large for memory";
}

/// Reports why a file was refused, where, and what to do.
static rsv_status fail_import(const rsv_file_source *files, const char *path, rsv_file_kind kind)
{
    char message[400], place[32] = "";
    unsigned line;
    snprintf(message, sizeof message, "%s", aiGetErrorString());
    if (kind == RSV_FILE_OBJ) {
        rsv_status status = rsv_obj_explain(files, path);
        if (status != RSV_OK) return status;
    }
    const char *at = strstr(message, "line ");
    if (at && sscanf(at, "line %u", &line) == 1)
        snprintf(place, sizeof place, "near line %u: ", line);
    return rsv_fail(RSV_ERROR_FORMAT,
        "cannot be read: %s%s; export it again, or convert it to glTF", place, meaning_of(message));
}

rsv_status rsv_assimp_import(rsv_context *context, const rsv_file_source *files, const char *path,
    rsv_file_kind kind, const struct aiScene **imported, double origin[3])
{
    file_access access = { .path = path, .files = files };
    rsv_assimp_losses losses = { 0 };
    *imported = import(path, &access, &losses);
    if (!*imported) return fail_import(files, path, kind);
    memcpy(origin, access.origin, sizeof access.origin);
    rsv_status status = process(*imported);
    if (status != RSV_OK) return status;
    for (size_t i = 0; i < access.missing_count; i++)
        rsv_log(context, RSV_LOG_WARNING, "%s: refers to '%s', which cannot be read", path,
            access.missing[i]);
    if (kind == RSV_FILE_OBJ) {
        losses.colored = 0; // named by the text, with their number
        rsv_obj_warn_of_unused(context, files, path, false);
        if (access.missing_count == 0)
            rsv_obj_warn_of_unknown(context, path, &access.used, &access.defined);
    }
    free(access.used.text);
    free(access.defined.text);
    for (size_t i = 0; i < access.library_count; i++)
        rsv_obj_warn_of_unused(context, files, access.library[i], true);
    if (kind == RSV_FILE_FBX && rsv_file_mentions(files, path, "AnimationCurve"))
        losses.animations = 1;
    rsv_assimp_warn_of_losses(context, path, *imported, &losses);
    return RSV_OK;
}

bool rsv_file_mentions(const rsv_file_source *files, const char *path, const char *word)
{
    enum { PIECE = 65536 };
    size_t length = strlen(word), kept = 0;
    FILE *file = rsv_file_open(files, path);
    char *piece = file ? malloc(PIECE) : NULL;
    bool found = false;
    while (piece && !found) {
        size_t count = fread(piece + kept, 1, PIECE - kept, file) + kept;
        found = memmem(piece, count, word, length) != NULL;
        if (count < PIECE) break;
        kept = length - 1;
        memmove(piece, piece + count - kept, kept);
    }
    free(piece);
    if (file) fclose(file);
    return found;
}

void rsv_assimp_name(const struct aiString *source, const char *fallback, char *name)
{
    size_t length = source->length < RSV_NAME_BYTES - 1 ? source->length : RSV_NAME_BYTES - 1;
    for (size_t i = 0; i < length; i++)
        name[i] = iscntrl((unsigned char)source->data[i]) ? '?' : source->data[i];
    name[length] = 0;
    if (!length) snprintf(name, RSV_NAME_BYTES, "%s", fallback);
}

double rsv_assimp_number(const struct aiMetadata *metadata, const char *key, double fallback)
{
    for (unsigned i = 0; metadata && i < metadata->mNumProperties; i++) {
        const struct aiMetadataEntry *entry = &metadata->mValues[i];
        if (!entry->mData || strcmp(metadata->mKeys[i].data, key) != 0) continue;
        if (entry->mType == AI_INT32) return *(const int32_t *)entry->mData;
        if (entry->mType == AI_FLOAT) return (double)*(const float *)entry->mData;
        if (entry->mType == AI_DOUBLE) return *(const double *)entry->mData;
    }
    return fallback;
}
