#include "data_uri.h"

#include <stdio.h>
#include <string.h>

char *rsv_data_uri(rsv_context *context, const char *type, const void *data, size_t bytes)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const uint8_t *from = data;
    size_t head = strlen("data:;base64,") + strlen(type);
    char *uri = rsv_alloc(context, head + 4 * ((bytes + 2) / 3) + 1, 1);
    if (!uri) return NULL;
    snprintf(uri, head + 1, "data:%s;base64,", type);
    char *to = uri + head;
    for (size_t k = 0; k < bytes; k += 3) {
        uint32_t three = 0;
        for (size_t i = 0; i < 3; i++)
            three = three << 8 | (k + i < bytes ? from[k + i] : 0);
        for (size_t i = 0; i < 4; i++)
            *to++ = k + i < bytes + 1 ? digit[three >> (18 - 6 * i) & 63] : '=';
    }
    *to = 0;
    return uri;
}
