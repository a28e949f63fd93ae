#include "case_file.h"

#include <stdio.h>
#include <stdlib.h>

static char *read_text(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file) return NULL;
    size_t size = 0, capacity = 1 << 20, count;
    char *content = malloc(capacity + 1);
    while (content && (count = fread(content + size, 1, capacity - size, file)) > 0) {
        size += count;
        if (size == capacity) content = realloc(content, (capacity *= 2) + 1);
    }
    fclose(file);
    if (content) content[size] = 0;
    return content;
}

cJSON *case_file_read(void)
{
    const char *path = getenv("RSV_VALIDATION");
    if (!path) path = RSV_VALIDATION_DEFAULT;
    char *content = read_text(path);
    cJSON *json = cJSON_Parse(content);
    free(content);
    if (json) return json;
    printf("%s: %s\n", path, content ? "not JSON" : "cannot be read");
    exit(EXIT_FAILURE);
}
