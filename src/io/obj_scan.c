#include "obj_scan.h"

#include "../core/core.h"
#include "../core/number_text.h"
#include "../scene/far_box.h"
#include "file_source.h"

#include <ctype.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define MOST_WORDS 8 ///< that a warning names
#define WORD_BYTES 32

typedef struct unused {
    char word[MOST_WORDS][WORD_BYTES];
    size_t line[MOST_WORDS];
    size_t count;
    bool more;
    size_t colored; ///< vertices with a colour
} unused;

/// Statements that the importer and assimp_material.c take in, or that say nothing here: names, smoothing groups, which
/// normals or creases overrule, and points and lines, which are counted elsewhere.
static const char *const object_words[] = { "v", "vn", "vt", "f", "g", "o", "s", "usemtl", "mtllib",
    "l", "p", NULL };
static const char *const library_words[] = { "newmtl", "Ka", "Kd", "Ks", "Ke", "Ns", "Ni", "d",
    "Tr", "Tf", "illum", "Pr", "Pm", "Ps", "Pc", "Pcr", "bump", "disp", "norm", "map_Kd", "map_Ka",
    "map_Ks", "map_Ke", "map_emissive", "map_d", "map_bump", "map_Kn", "map_disp", "map_Ns",
    "map_Pr", "map_Pm", "map_Ps", "map_refl", NULL };
static const char *const color_words[] = { "Ka", "Kd", "Ks", "Ke", "Tf", NULL };
static const char *const naming_words[] = { "usemtl", "newmtl", "mtllib", "o", "g", NULL };

/// The word of a list that is meant, whether or not its letters are capitals as they should be; NULL = none.
static const char *meant_word(const char *word, const char *const *list)
{
    for (; *list; list++)
        if (strcasecmp(word, *list) == 0) return *list;
    return NULL;
}

static bool is_number(const char *text)
{
    char *end = NULL;
    rsv_number_value(text, &end);
    return end != text;
}

/// The effect of a statement, as importers see it; NULL = it has none. Colours given as spectra or CIE XYZ are not
/// read.
/// @param arguments the text after the word
static const char *meaning_of(const char *word, const char *arguments, bool is_library)
{
    const char *meant = meant_word(word, is_library ? library_words : object_words);
    if (!is_library && strcasecmp(word, "fo") == 0) return "f"; // of old versions
    if (meant && is_library && meant_word(meant, color_words) && !is_number(arguments)) return NULL;
    return meant;
}

static void note(unused *u, const char *word, size_t line)
{
    for (size_t k = 0; k < u->count; k++)
        if (strcmp(u->word[k], word) == 0) return;
    u->more = u->count == MOST_WORDS;
    if (u->more) return;
    snprintf(u->word[u->count], WORD_BYTES, "%s", word);
    u->line[u->count++] = line;
}

/// Copies the word at `text`, cut to fit, without control characters.
static void copy_word(const char *text, char word[WORD_BYTES])
{
    size_t length = 0;
    for (; *text && !isspace((unsigned char)*text) && length < WORD_BYTES - 1; text++)
        word[length++] = iscntrl((unsigned char)*text) ? '?' : *text;
    word[length] = '\0';
}

static size_t count_words(const char *text)
{
    size_t count = 0;
    for (; *text && *text != '#'; count++) {
        text += strspn(text, " \t\r\n");
        if (!*text || *text == '#') break;
        text += strcspn(text, " \t\r\n");
    }
    return count;
}

/// Whether the line goes on in the next.
static bool goes_on(const char *text, size_t length)
{
    while (length && (text[length - 1] == '\n' || text[length - 1] == '\r'))
        length--;
    return length && text[length - 1] == '\\';
}

void rsv_obj_warn_of_unused(
    const rsv_context *context, const rsv_file_source *files, const char *path, bool is_library)
{
    unused u = { .count = 0 };
    char *text = NULL, list[400] = "";
    size_t capacity = 0, number = 0;
    FILE *file = rsv_file_open(files, path);
    bool continued = false;
    for (ssize_t length; file && (length = getline(&text, &capacity, file)) > 0;) {
        char word[WORD_BYTES];
        const char *start = text + strspn(text, " \t\r\n");
        if (++number == 1 && strncmp(start, "\xef\xbb\xbf", 3) == 0) start += 3;
        bool inside = continued;
        continued = goes_on(text, (size_t)length);
        if (inside || !*start || *start == '#') continue;
        copy_word(start, word);
        if (!meaning_of(word, start + strlen(word), is_library)) note(&u, word, number);
        if (!is_library && strcmp(word, "v") == 0 && count_words(start) >= 7) u.colored++;
    }
    free(text);
    if (file) fclose(file);
    for (size_t k = 0; k < u.count; k++)
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s'%s' (line %zu)",
            k ? ", " : "", u.word[k], u.line[k]);
    if (u.count)
        rsv_log(context, RSV_LOG_WARNING, "%s: statements that are not used: %s%s", path, list,
            u.more ? ", ..." : "");
    if (u.colored)
        rsv_log(context, RSV_LOG_WARNING, "%s: the colours of its %zu vertices are not used", path,
            u.colored);
}

// ---- the text for the importer ----------------------------------------------------------------------

/// Strips blanks around each line, ends each with one '\n', and joins continued lines.
/// @return the new size
static size_t join_lines(char *text, size_t size)
{
    size_t kept = 0;
    if (strncmp(text, "\xef\xbb\xbf", 3) == 0) memset(text, ' ', 3);
    for (size_t i = 0; i < size; i++) {
        char c = text[i] == '\r' && text[i + 1] != '\n' ? '\n' : text[i];
        if (c == '\0') c = ' ';
        bool is_blank = c == ' ' || c == '\t' || c == '\r';
        if (is_blank && (kept == 0 || text[kept - 1] == '\n')) continue;
        if (c == '\n')
            while (kept && strchr(" \t\r", text[kept - 1]))
                kept--;
        if (c == '\n' && kept && text[kept - 1] == '\\')
            text[kept - 1] = ' ';
        else
            text[kept++] = c;
    }
    text[kept] = '\0';
    return kept;
}

/// A name without the comment behind it and the quotes around it; several libraries become several statements.
static void put_name(FILE *to, const char *word, char *name)
{
    bool is_library = strcmp(word, "mtllib") == 0;
    char *comment = strstr(name, " #"), *next = name;
    if (comment) *comment = '\0';
    for (size_t length = strlen(name); length && isspace((unsigned char)name[length - 1]); length--)
        name[length - 1] = '\0';
    for (char *c = name; *c && is_library; c++)
        if (*c == '\\') *c = '/';
    while (is_library && (next = strcasestr(name, ".mtl ")) != NULL) {
        next[strlen(".mtl")] = '\0';
        fprintf(to, "%s %s\n", word, name);
        name = next + strlen(".mtl ");
        name += strspn(name, " \t");
    }
    size_t length = strlen(name);
    bool quoted = length > 2 && name[0] == '"' && name[length - 1] == '"';
    fprintf(to, "%s %.*s\n", word, (int)(length - (quoted ? 2 : 0)), name + quoted);
}

/// One number stands for three.
static void put_color(FILE *to, const char *word, const char *arguments)
{
    char *end = NULL;
    rsv_number_value(arguments, &end);
    bool alone = (!*end || isspace((unsigned char)*end)) && !is_number(end);
    int length = (int)(alone ? end - arguments : (ptrdiff_t)strlen(arguments));
    fprintf(to, "%s", word);
    for (int k = 0; k < (alone ? 3 : 1); k++)
        fprintf(to, " %.*s", length, arguments);
    fputc('\n', to);
}

/// Puts a zero before numbers that begin with a point: the importer does not recognise those.
static void put_numbers(FILE *to, const char *word, const char *arguments)
{
    fprintf(to, "%s ", word);
    if (*arguments != '.' && !strstr(arguments, " .") && !strstr(arguments, "\t.")) {
        fprintf(to, "%s\n", arguments);
        return;
    }
    for (const char *c = arguments; *c; c++) {
        if (*c == '.' && (c == arguments || isspace((unsigned char)c[-1]))) fputc('0', to);
        fputc(*c, to);
    }
    fputc('\n', to);
}

/// The position of a vertex. @return the text after it; NULL = not three numbers, or six with a colour
static const char *read_vertex(const char *arguments, double place[3])
{
    char *end = NULL;
    for (int k = 0; k < 3; k++, arguments = end) {
        place[k] = rsv_number_value(arguments, &end);
        if (end == arguments || !isfinite(place[k])) return NULL;
    }
    size_t rest = count_words(arguments);
    return rest == 0 || rest == 3 ? arguments : NULL;
}

/// The common offset of all vertices, if they lie far from the origin. Most files rule that out with their first
/// vertices.
/// @param text each line ends in '\n'
static void find_origin(char *text, double origin[3])
{
    rsv_far_box bounds = rsv_far_nothing();
    bool known = true;
    memset(origin, 0, 3 * sizeof *origin);
    for (size_t count = 1; text && known; count++) {
        char *end = strchr(text, '\n');
        double place[3];
        if ((*text == 'v' || *text == 'V') && (text[1] == ' ' || text[1] == '\t')) {
            if (end) *end = '\0';
            known = read_vertex(text + 2, place) != NULL;
            if (end) *end = '\n';
            if (known) rsv_far_enclose(&bounds, place);
        }
        if (count % 1024 == 0 && bounds.high[0] > bounds.low[0]) known &= rsv_is_far(&bounds);
        text = end ? end + 1 : NULL;
    }
    if (known) rsv_far_origin(&bounds, origin);
}

static void put_near_vertex(FILE *to, const char *arguments, const double origin[3])
{
    double place[3];
    const char *rest = read_vertex(arguments, place);
    fputc('v', to);
    for (int k = 0; k < 3; k++) {
        char text[RSV_NUMBER_BYTES];
        rsv_number_text(text, 10, place[k] - origin[k]);
        fprintf(to, " %s", text);
    }
    fprintf(to, "%s\n", rest ? rest : "");
}

/// Colours of a material in a library that were given.
typedef struct given_colors {
    bool diffuse, specular;
} given_colors;

/// Of a texture without the colour that it multiplies, this is white; importers make up another.
static void put_missing_color(FILE *to, const char *word, given_colors *given)
{
    if (strcasecmp(word, "newmtl") == 0) *given = (given_colors){ false, false };
    if (strcasecmp(word, "Kd") == 0) given->diffuse = true;
    if (strcasecmp(word, "Ks") == 0) given->specular = true;
    if (strcasecmp(word, "map_Kd") == 0 && !given->diffuse) fputs("Kd 1 1 1\n", to);
    if (strcasecmp(word, "map_Ks") == 0 && !given->specular) fputs("Ks 1 1 1\n", to);
}

static void put_statement(FILE *to, char *line, bool is_library, const double origin[3])
{
    char word[WORD_BYTES];
    copy_word(line, word);
    char *arguments = line + strcspn(line, " \t");
    arguments += strspn(arguments, " \t");
    const char *meant = *line == '#' || !*line ? NULL : meaning_of(word, arguments, is_library);
    if (!meant) return;
    if (meant_word(meant, naming_words))
        put_name(to, meant, arguments);
    else if (is_library && meant_word(meant, color_words))
        put_color(to, meant, arguments);
    else if (strcmp(meant, "map_refl") == 0) // of Blender alone, and not known to the importer
        fprintf(to, "map_Pm %s\n", arguments);
    else if (is_library && strcmp(meant, "d") == 0 && strncmp(arguments, "-halo", 5) == 0)
        fprintf(to, "d %s\n", arguments + 5);
    else if (strcmp(meant, "v") == 0 && (origin[0] != 0 || origin[1] != 0 || origin[2] != 0))
        put_near_vertex(to, arguments, origin);
    else if (!is_library && *meant == 'v')
        put_numbers(to, meant, arguments);
    else
        fprintf(to, "%s %s\n", meant, arguments);
}

char *rsv_obj_clean(FILE *file, bool is_library, size_t *size, double origin[3])
{
    char *cleaned = NULL, *text = rsv_stream_read(file, size);
    FILE *to = text ? open_memstream(&cleaned, size) : NULL;
    if (to) {
        join_lines(text, *size);
        find_origin(is_library ? NULL : text, origin);
        given_colors given = { false, false };
        for (char *line = text, *next; line; line = next) {
            char word[WORD_BYTES];
            next = strchr(line, '\n');
            if (next) *next++ = '\0';
            copy_word(line, word);
            if (is_library) put_missing_color(to, word, &given);
            put_statement(to, line, is_library, origin);
        }
        if (fclose(to) != 0) {
            free(cleaned);
            cleaned = NULL;
        }
    }
    free(text);
    return cleaned;
}

// ---- materials that do not exist --------------------------------------------------------------------

#define MOST_NAME_BYTES (1 << 18) ///< of names that are remembered

/// @param name [length] with a '\n' before and behind it
static bool knows(const rsv_obj_names *names, const char *name, size_t length)
{
    return names->text && memmem(names->text, names->size, name, length);
}

static void add_name(rsv_obj_names *names, const char *name, size_t length)
{
    if (knows(names, name, length) || names->size + length > MOST_NAME_BYTES) return;
    if (names->size + length > names->capacity) {
        char *grown = realloc(names->text, names->capacity = 2 * (names->size + length));
        if (!grown) {
            names->capacity = 0;
            return;
        }
        names->text = grown;
    }
    memcpy(names->text + names->size, name, length);
    names->size += length;
}

void rsv_obj_note_names(const char *text, const char *word, rsv_obj_names *names)
{
    char name[512] = "\n", last[512] = "";
    size_t length = strlen(word);
    for (const char *at = strstr(text, word); at; at = strstr(at + length, word)) {
        const char *from = at + length, *end = strchr(from, '\n');
        if ((at > text && at[-1] != '\n') || !isspace((unsigned char)*from) || !end) continue;
        from += strspn(from, " \t");
        if (from >= end || (size_t)(end - from) >= sizeof name - 2) continue;
        size_t size = (size_t)(end - from) + 2;
        memcpy(name + 1, from, size - 1);
        name[size] = '\0';
        if (strcmp(name, last) == 0) continue;
        memcpy(last, name, size + 1);
        add_name(names, name, size);
    }
}

void rsv_obj_warn_of_unknown(const rsv_context *context, const char *path,
    const rsv_obj_names *used, const rsv_obj_names *defined)
{
    char list[400] = "";
    size_t count = 0;
    for (size_t k = 0; k < used->size;) {
        const char *name = used->text + k, *end = memchr(name + 1, '\n', used->size - k - 1);
        size_t length = (size_t)(end - name) + 1;
        k += length;
        if (knows(defined, name, length) || count++ >= MOST_WORDS) continue;
        char word[64];
        snprintf(word, sizeof word, "%.*s", (int)(length - 2), name + 1);
        for (char *c = word; *c; c++)
            if (iscntrl((unsigned char)*c)) *c = '?';
        size_t at = strlen(list);
        snprintf(list + at, sizeof list - at, "%s'%s'", at ? ", " : "", word);
    }
    if (count)
        rsv_log(context, RSV_LOG_WARNING,
            "%s: uses materials that none of its libraries defines: %s%s; they are grey", path,
            list, count > MOST_WORDS ? ", ..." : "");
}

// ---- what is wrong ----------------------------------------------------------------------------------

typedef struct checker {
    size_t line;
    long long count[3]; ///< vertices, texture coordinates and normals so far
} checker;

static rsv_status check_numbers(const checker *c, const char *text)
{
    for (int k = 0; k < 3; k++) {
        char *end = NULL, word[WORD_BYTES];
        double value = rsv_number_value(text, &end);
        copy_word(text + strspn(text, " \t\r\n"), word);
        if (end == text || (*end && !isspace((unsigned char)*end)))
            return rsv_fail(RSV_ERROR_FORMAT,
                "line %zu: a vertex needs three numbers with decimal points, not '%s'", c->line,
                word);
        if (!isfinite(value))
            return rsv_fail(
                RSV_ERROR_FORMAT, "line %zu: a coordinate is not finite: '%s'", c->line, word);
        text = end;
    }
    return RSV_OK;
}

/// One corner, "v", "v/t", "v//n" or "v/t/n", of a face.
static rsv_status check_corner(const checker *c, const char *text, const char *end)
{
    static const char *const names[] = { "vertex", "texture coordinate", "normal" };
    for (int k = 0; k < 3 && text < end; k++) {
        char *after = NULL;
        long long index = strtoll(text, &after, 10);
        bool given = after != text && after <= end;
        if (!given && (k != 1 || *text != '/'))
            return rsv_fail(RSV_ERROR_FORMAT, "line %zu: a face has '%.*s' for a corner", c->line,
                (int)(end - text < WORD_BYTES ? end - text : WORD_BYTES), text);
        if (given && (index == 0 || index > c->count[k] || -index > c->count[k]))
            return rsv_fail(RSV_ERROR_FORMAT,
                "line %zu: a face refers to %s %lld (index out of range): there are %lld", c->line,
                names[k], index, c->count[k]);
        text = given ? after : text;
        if (text < end && *text != '/')
            return rsv_fail(RSV_ERROR_FORMAT, "line %zu: a face has '%.*s' for a corner", c->line,
                (int)(end - text < WORD_BYTES ? end - text : WORD_BYTES), text);
        text++;
    }
    return RSV_OK;
}

static rsv_status check_face(const checker *c, const char *text)
{
    for (;;) {
        text += strspn(text, " \t\r\n\\");
        if (!*text || *text == '#') return RSV_OK;
        const char *end = text + strcspn(text, " \t\r\n");
        rsv_status status = check_corner(c, text, end);
        if (status != RSV_OK) return status;
        text = end;
    }
}

static rsv_status check_line(checker *c, const char *text, bool is_first)
{
    static const char *const counted[] = { "v", "vt", "vn" };
    char word[WORD_BYTES];
    copy_word(text, word);
    for (int k = 0; k < 3; k++)
        c->count[k] += is_first && strcmp(word, counted[k]) == 0;
    if (is_first || strcmp(word, "v") != 0) return RSV_OK;
    return check_numbers(c, text + 1);
}

/// Counts vertices first: a face may refer to a vertex further down.
static rsv_status check_file(FILE *file, checker *c, bool is_first)
{
    rsv_status status = RSV_OK;
    char *text = NULL;
    size_t capacity = 0;
    c->line = 0;
    rewind(file);
    while (status == RSV_OK && getline(&text, &capacity, file) > 0) {
        const char *start = text + strspn(text, " \t\r\n");
        c->line++;
        status = check_line(c, start, is_first);
        if (status == RSV_OK && !is_first && *start == 'f' && isspace((unsigned char)start[1]))
            status = check_face(c, start + 1);
    }
    free(text);
    return status;
}

rsv_status rsv_obj_explain(const rsv_file_source *files, const char *path)
{
    checker c = { .line = 0 };
    FILE *file = rsv_file_open(files, path);
    if (!file) return RSV_OK;
    int first = fgetc(file), second = fgetc(file);
    rsv_status status = (first == 0xff && second == 0xfe) || (first == 0xfe && second == 0xff)
                            ? rsv_fail(RSV_ERROR_FORMAT, "is UTF-16; save it as UTF-8 or ASCII")
                            : check_file(file, &c, true);
    if (status == RSV_OK) status = check_file(file, &c, false);
    fclose(file);
    return status;
}
