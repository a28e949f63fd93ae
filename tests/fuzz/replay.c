/// Reads files that are or once were trouble: `fuzz_replay FILE...`.
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

int main(int argc, char **argv)
{
    for (int k = 1; k < argc; k++) {
        printf("%s\n", argv[k]);
        fflush(stdout); // names the culprit if the reader does not come back
        replay(argv[k]);
    }
    return 0;
}
