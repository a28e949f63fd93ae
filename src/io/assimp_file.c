#include "assimp_file.h"

#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define MAX_MISSING 8 ///< files a warning names
#define LARGEST_FILE ((off_t)1 << 32)

/// The files an import asked for in vain.
typedef struct file_access {
    char missing[MAX_MISSING][512];
    size_t missing_count;
} file_access;

static size_t read_file(struct aiFile *file, char *buffer, size_t size, size_t count)
{
    return fread(buffer, size, count, (FILE *)file->UserData);
}

static size_t refuse_write(struct aiFile *file, const char *buffer, size_t size, size_t count)
{
    (void)file, (void)buffer, (void)size, (void)count;
    return 0;
}

static size_t tell_file(struct aiFile *file)
{
    long position = ftell((FILE *)file->UserData);
    return position < 0 ? 0 : (size_t)position;
}

static size_t size_of_file(struct aiFile *file)
{
    struct stat info;
    if (fstat(fileno((FILE *)file->UserData), &info) != 0) return 0;
    return (size_t)info.st_size;
}

static enum aiReturn seek_file(struct aiFile *file, size_t offset, enum aiOrigin origin)
{
    static const int whence[] = {
        [aiOrigin_SET] = SEEK_SET, [aiOrigin_CUR] = SEEK_CUR, [aiOrigin_END] = SEEK_END
    };
    if ((unsigned)origin > aiOrigin_END) return aiReturn_FAILURE;
    int failed = fseek((FILE *)file->UserData, (long)offset, whence[origin]);
    return failed ? aiReturn_FAILURE : aiReturn_SUCCESS;
}

static void flush_nothing(struct aiFile *file) { (void)file; }

static void remember_missing(file_access *access, const char *path)
{
    for (size_t i = 0; i < access->missing_count; i++)
        if (strcmp(access->missing[i], path) == 0) return;
    if (access->missing_count == MAX_MISSING) return;
    char *name = access->missing[access->missing_count++];
    snprintf(name, sizeof access->missing[0], "%s", path);
    for (; *name; name++)
        if (iscntrl((unsigned char)*name)) *name = '?';
}

/// Devices and pipes, which might never end, and files beyond all measure count as absent.
static FILE *open_regular(const char *path)
{
    struct stat info;
    if (stat(path, &info) != 0 || !S_ISREG(info.st_mode) || info.st_size > LARGEST_FILE)
        return NULL;
    return fopen(path, "rb");
}

static struct aiFile *open_file(struct aiFileIO *io, const char *path, const char *mode)
{
    FILE *stream = strchr(mode, 'r') ? open_regular(path) : NULL;
    struct aiFile *file = stream ? malloc(sizeof *file) : NULL;
    if (!file) {
        if (stream) fclose(stream);
        remember_missing((file_access *)io->UserData, path);
        return NULL;
    }
    *file = (struct aiFile){ .ReadProc = read_file,
        .WriteProc = refuse_write,
        .TellProc = tell_file,
        .FileSizeProc = size_of_file,
        .SeekProc = seek_file,
        .FlushProc = flush_nothing,
        .UserData = (aiUserData)stream };
    return file;
}

static void close_file(struct aiFileIO *io, struct aiFile *file)
{
    (void)io;
    if (!file) return;
    fclose((FILE *)file->UserData);
    free(file);
}

/// @return NULL if it cannot be read; aiGetErrorString says why
static const struct aiScene *import(const char *path, file_access *access)
{
    // validation first: the later steps trust the indices of what was read
    static const unsigned steps =
        aiProcess_ValidateDataStructure | aiProcess_Triangulate | aiProcess_SortByPType;
    struct aiFileIO io = { open_file, close_file, (aiUserData)access };
    struct aiPropertyStore *properties = aiCreatePropertyStore();
    if (!properties) return NULL;
    aiSetImportPropertyInteger(
        properties, AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    aiSetImportPropertyInteger(properties, AI_CONFIG_IMPORT_NO_SKELETON_MESHES, 1);
    aiSetImportPropertyInteger(properties, AI_CONFIG_IMPORT_FBX_READ_ANIMATIONS, 0);
    const struct aiScene *scene = aiImportFileExWithProperties(path, steps, &io, properties);
    aiReleasePropertyStore(properties);
    return scene;
}

/// The importer's message as part of one line.
static rsv_status fail_import(void)
{
    char message[400];
    size_t length = 0;
    for (const char *c = aiGetErrorString(); *c && length < sizeof message - 1; c++)
        message[length++] = iscntrl((unsigned char)*c) ? ' ' : *c;
    while (length && (message[length - 1] == ' ' || message[length - 1] == '.'))
        length--;
    message[length] = 0;
    if (length == 0 || strstr(message, "std::"))
        return rsv_fail(RSV_ERROR_FORMAT,
            "cannot be read: its content is malformed, or is more than memory holds");
    return rsv_fail(RSV_ERROR_FORMAT, "cannot be read: %s", message);
}

rsv_status rsv_assimp_import(
    rsv_context *context, const char *path, const struct aiScene **imported)
{
    file_access access = { .missing_count = 0 };
    *imported = import(path, &access);
    if (!*imported) return fail_import();
    for (size_t i = 0; i < access.missing_count; i++)
        rsv_log(context, RSV_LOG_WARNING, "%s: refers to '%s', which cannot be read", path,
            access.missing[i]);
    return RSV_OK;
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
