#include "collada_clean.h"

#include "../core/number_text.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void normalise(double a[3])
{
    double length = sqrt(dot(a, a));
    for (int axis = 0; axis < 3; axis++)
        a[axis] /= length;
}

/// What a skew adds to the identity is sum * along * across^T: it turns `axis` by the angle towards `along`, and moves points
/// along the latter alone (as RenderMan's Skew does). Where that cannot be, nothing moves.
/// @param skew angle in degrees, axis, along
static void make_matrix(const double skew[7], double matrix[16])
{
    double angle = skew[0] * PI / 180, along[3], across[3];
    memcpy(along, skew + 4, sizeof along);
    normalise(along);
    double share = dot(skew + 1, along);
    for (int axis = 0; axis < 3; axis++)
        across[axis] = skew[1 + axis] - share * along[axis];
    normalise(across);
    double height = dot(skew + 1, across);
    double x = height * cos(angle) - share * sin(angle);
    double sum = (height * sin(angle) + share * cos(angle)) / x - share / height;
    bool bends = x > 1e-6 * sqrt(dot(skew + 1, skew + 1)) && isfinite(sum);
    for (int k = 0; k < 16; k++) {
        int row = k / 4, column = k % 4;
        matrix[k] = row == column;
        if (bends && row < 3 && column < 3) matrix[k] += sum * along[row] * across[column];
    }
}

/// Reads what stands in a tag. @return behind the tag that closes it; NULL = it is no skew
static const char *read_skew(const char *tag, double matrix[16])
{
    double value[7];
    const char *at = strchr(tag, '>');
    if (!at) return NULL;
    at++;
    for (int k = 0; k < 7; k++) {
        char *end = NULL;
        value[k] = rsv_number_value(at, &end);
        if (end == at) return NULL;
        at = end;
    }
    at += strspn(at, " \t\r\n");
    if (strncmp(at, "</skew>", strlen("</skew>")) != 0) return NULL;
    make_matrix(value, matrix);
    return at + strlen("</skew>");
}

static void write_matrix(FILE *to, const double matrix[16])
{
    char text[RSV_NUMBER_BYTES];
    fputs("<matrix>", to);
    for (int k = 0; k < 16; k++) {
        rsv_number_text(text, 9, matrix[k]);
        fprintf(to, "%s ", text);
    }
    fputs("</matrix>", to);
}

static char *read_all(FILE *file, size_t *size)
{
    long bytes = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    char *text = bytes > 0 ? malloc((size_t)bytes + 1) : NULL;
    rewind(file);
    if (!text) return NULL;
    *size = fread(text, 1, (size_t)bytes, file);
    text[*size] = '\0';
    return text;
}

char *rsv_collada_clean(FILE *file, size_t *size)
{
    double matrix[16];
    char *clean = NULL, *text = read_all(file, size);
    if (!text || !strstr(text, "<skew")) {
        free(text);
        return NULL;
    }
    FILE *to = open_memstream(&clean, size);
    const char *from = text;
    for (const char *at = text; to && (at = strstr(at, "<skew"));) {
        const char *end = read_skew(at, matrix);
        if (end) {
            fwrite(from, 1, (size_t)(at - from), to);
            write_matrix(to, matrix);
            from = end;
        }
        at = end ? end : at + 1;
    }
    if (to) fputs(from, to);
    free(text);
    if (!to || fclose(to) == 0) return clean;
    free(clean);
    return NULL;
}
