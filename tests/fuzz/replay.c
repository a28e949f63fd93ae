/// Reads files that are or once were a problem: `fuzz_replay FILE...`. `fuzz_replay --kept FOLDER` writes the files
/// that a solve keeps for the next one to FOLDER/history/room.history, and so on.
#include "kept_files.h"
#include "readers.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void replay(const char *path)
{
    enum { LARGEST = 1 << 24 };
    FILE *file = fopen(path, "rb");
    uint8_t *data = malloc(LARGEST);
    const char *extension = strrchr(path, '.');
    if (!file || !data || !extension) {
        fprintf(stderr, "cannot replay '%s'\n", path);
        exit(1);
    }
    size_t size = fread(data, 1, LARGEST, file);
    fclose(file);
    fuzz_read(extension, data, size);
    free(data);
}

static int copy_kept_files(const char *folder)
{
    static const char *const extension[] = { "history", "scene", "rows" };
    for (int k = 0; k < 3; k++) {
        char path[4096], dotted[16];
        snprintf(path, sizeof path, "%.2000s/%s/room.%s", folder, extension[k], extension[k]);
        snprintf(dotted, sizeof dotted, ".%s", extension[k]);
        fuzz_copy_kept_file(dotted, path);
    }
    return 0;
}

int main(int argc, char **argv)
{
    if (argc == 3 && strcmp(argv[1], "--kept") == 0) return copy_kept_files(argv[2]);
    for (int k = 1; k < argc; k++) {
        printf("%s\n", argv[k]);
        fflush(stdout); // names the culprit if the reader does not come back
        replay(argv[k]);
    }
    return 0;
}
