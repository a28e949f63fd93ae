#include "collada_clean.h"

#include "file_source.h"

#include "../core/number_text.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846
#define BLANKS " \t\r\n"
#define EDIT_BYTES 640

/// Text that takes the place of [from, to).
typedef struct edit {
    const char *from, *to;
    char text[EDIT_BYTES];
} edit;

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

/// A skew adds sum * along * across^T to the identity: it turns `axis` by the angle towards `along`, and moves points
/// only in the direction of the latter (as RenderMan's Skew does). If the skew is impossible, the matrix is the
/// identity.
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

/// @return behind them; NULL = there are fewer
static const char *read_numbers(const char *text, int count, double *value)
{
    for (int k = 0; k < count; k++) {
        char *end = NULL;
        value[k] = rsv_number_value(text, &end);
        if (end == text) return NULL;
        text = end;
    }
    return text + strspn(text, BLANKS);
}

static void put_numbers(edit *e, const char *name, const double *value, int count)
{
    char number[RSV_NUMBER_BYTES];
    size_t used = (size_t)snprintf(e->text, sizeof e->text, "<%s>", name);
    for (int k = 0; k < count; k++) {
        rsv_number_text(number, 9, value[k]);
        used += (size_t)snprintf(e->text + used, sizeof e->text - used, "%s ", number);
    }
    snprintf(e->text + used, sizeof e->text - used, "</%s>", name);
}

static bool edit_skew(const char *tag, edit *e)
{
    double value[7], matrix[16];
    const char *at = strchr(tag, '>');
    if (at) at = read_numbers(at + 1, 7, value);
    if (!at || strncmp(at, "</skew>", strlen("</skew>")) != 0) return false;
    make_matrix(value, matrix);
    e->from = tag;
    e->to = at + strlen("</skew>");
    put_numbers(e, "matrix", matrix, 16);
    return true;
}

bool rsv_collada_rotation(const char *text, double rotation[4])
{
    double largest = 0, value[4];
    if (!read_numbers(text, 4, value)) return false;
    for (int k = 0; k < 3; k++)
        largest = fmax(largest, fabs(value[k]));
    for (int k = 0; k < 3; k++)
        rotation[k] = largest > 0 ? value[k] / largest : 0;
    double length = sqrt(dot(rotation, rotation));
    if (length > 0) normalise(rotation);
    rotation[3] = length * largest;
    return true;
}

static bool edit_rotate(const char *tag, edit *e)
{
    double value[4], rotation[4];
    const char *at = strchr(tag, '>');
    const char *end = at ? read_numbers(at + 1, 4, value) : NULL;
    if (!end || strncmp(end, "</rotate>", strlen("</rotate>")) != 0) return false;
    rsv_collada_rotation(at + 1, rotation);
    if (fabs(rotation[3] - 1) <= 1e-6 || !isfinite(rotation[3])) return false;
    e->from = tag;
    e->to = end + strlen("</rotate>");
    e->text[0] = '\0';
    bool turns = rotation[3] > 0;
    rotation[3] = value[3];
    if (turns) put_numbers(e, "rotate", rotation, 4);
    return true;
}

size_t rsv_collada_count_values(const char *text)
{
    size_t count = 0;
    for (;; count++) {
        text += strspn(text, BLANKS);
        if (!*text || *text == '<') return count;
        text += strcspn(text, BLANKS "<");
    }
}

/// The value of the attribute `count` in a tag; where there is none, empty at `close`.
static void find_count(const char *tag, const char *close, const char **from, const char **to)
{
    *from = *to = close;
    for (const char *at = tag; (at = memmem(at, (size_t)(close - at), "count", 5)); at++) {
        const char *value = at + strlen("count");
        value += strspn(value, BLANKS);
        if (!strchr(BLANKS, at[-1]) || *value != '=') continue;
        value += 1 + strspn(value + 1, BLANKS);
        const char *end = *value == '"' || *value == '\'' ? strchr(value + 1, *value) : NULL;
        if (!end || end > close) return;
        *from = value + 1;
        *to = end;
        return;
    }
}

static bool edit_count(const char *tag, edit *e)
{
    char *end = NULL;
    const char *close = strchr(tag, '>');
    if (!close || close[-1] == '/') return false;
    size_t count = rsv_collada_count_values(close + 1);
    find_count(tag, close, &e->from, &e->to);
    if (e->to > e->from && rsv_number_value(e->from, &end) == (double)count && end == e->to)
        return false;
    snprintf(e->text, sizeof e->text, e->from == close ? " count=\"%zu\"" : "%zu", count);
    return true;
}

static bool edit_tag(const char *tag, edit *e)
{
    static const struct {
        const char *name;
        bool (*edit)(const char *tag, edit *e);
    } known[] = { { "<skew", edit_skew }, { "<rotate", edit_rotate },
        { "<float_array", edit_count } };
    for (size_t k = 0; k < sizeof known / sizeof *known; k++) {
        size_t length = strlen(known[k].name);
        if (strncmp(tag, known[k].name, length) != 0) continue;
        return tag[length] && strchr(BLANKS ">", tag[length]) && known[k].edit(tag, e);
    }
    return false;
}

char *rsv_collada_clean(FILE *file, size_t *size)
{
    edit e;
    char *clean = NULL, *text = rsv_stream_read(file, size);
    FILE *to = NULL;
    const char *from = text;
    for (const char *at = text; at && (at = strchr(at, '<')); at++) {
        if (!edit_tag(at, &e)) continue;
        if (!to) to = open_memstream(&clean, size);
        if (!to) break;
        fwrite(from, 1, (size_t)(e.from - from), to);
        fputs(e.text, to);
        from = e.to;
        at = e.to - 1;
    }
    if (to) fputs(from, to);
    free(text);
    if (!to) return NULL;
    if (fclose(to) == 0) return clean;
    free(clean);
    return NULL;
}
