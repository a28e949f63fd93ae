/// Walks over the tags of an XML file and keeps only the values needed.
#include "collada_scan.h"

#include "../core/core.h"
#include "../core/number_text.h"
#include "collada_clean.h"
#include "collada_elements.h"
#include "file_source.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// Nodes that enclose another, at most, whose names are remembered.
#define DEEPEST 256
#define MOST_MISSING 8 ///< references to nothing that are named

typedef struct scanner {
    rsv_context *context;
    const char *path, *at, *end;
    rsv_collada *found;
    rsv_collada_object *open; ///< the camera or light that the tags lie in; NULL = none
    char node[DEEPEST][RSV_COLLADA_NAME_BYTES];
    size_t depth;   ///< nodes that are open
    size_t unnamed; ///< nodes without an id so far
    size_t
        foreign; ///< elements that are open, from the outermost one on whose content is not judged
    size_t wrong_counts, still_axes;
} scanner;

/// A tag between '<' and '>'.
typedef struct tag {
    const char *name, *rest, *end;
    size_t name_length;
    bool closes, is_empty; ///< </name>, <name/>
} tag;

static bool is_named(const tag *t, const char *name)
{
    return strlen(name) == t->name_length && strncmp(t->name, name, t->name_length) == 0;
}

static const char *find(const char *from, const char *end, const char *text)
{
    size_t left = (size_t)(end - from);
    return memmem(from, left, text, strlen(text));
}

/// The next tag; passes over comments, declarations and character data.
static bool next_tag(scanner *s, tag *t)
{
    static const char *const passed[][2] = { { "<!--", "-->" }, { "<![CDATA[", "]]>" },
        { "<?", "?>" }, { "<!", ">" } };
    for (;;) {
        const char *start = memchr(s->at, '<', (size_t)(s->end - s->at));
        if (!start) return false;
        const char *close = NULL;
        bool skip = false;
        for (size_t k = 0; k < sizeof passed / sizeof *passed && !skip; k++) {
            skip = strncmp(start, passed[k][0], strlen(passed[k][0])) == 0;
            if (skip) close = find(start, s->end, passed[k][1]);
        }
        if (!skip) close = memchr(start, '>', (size_t)(s->end - start));
        if (!close) return false;
        s->at = close + 1;
        if (skip) continue;
        t->closes = start[1] == '/';
        t->name = start + 1 + t->closes;
        t->end = close;
        t->is_empty = close[-1] == '/';
        t->name_length = strcspn(t->name, " \t\r\n/>");
        t->rest = t->name + t->name_length;
        return true;
    }
}

/// Copies text between quotes, cut to fit, its five entities resolved.
static void copy_text(const char *from, const char *end, char text[RSV_COLLADA_NAME_BYTES])
{
    static const char *const entity[][2] = { { "&amp;", "&" }, { "&lt;", "<" }, { "&gt;", ">" },
        { "&quot;", "\"" }, { "&apos;", "'" } };
    size_t length = 0;
    while (from < end && length < RSV_COLLADA_NAME_BYTES - 1) {
        char c = *from++;
        for (size_t k = 0; c == '&' && k < sizeof entity / sizeof *entity; k++)
            if (strncmp(from - 1, entity[k][0], strlen(entity[k][0])) == 0) {
                c = *entity[k][1];
                from += strlen(entity[k][0]) - 1;
                break;
            }
        text[length++] = c;
    }
    text[length] = '\0';
}

/// The value of an attribute; empty if there is none.
static void attribute(const tag *t, const char *name, char text[RSV_COLLADA_NAME_BYTES])
{
    size_t length = strlen(name);
    text[0] = '\0';
    for (const char *at = t->rest; at < t->end; at++) {
        const char *value = at + 1 + length;
        if (!strchr(" \t\r\n", *at) || value >= t->end || strncmp(at + 1, name, length) != 0)
            continue;
        value += strspn(value, " \t\r\n");
        if (*value++ != '=') continue;
        value += strspn(value, " \t\r\n");
        const char *close = value < t->end && (*value == '"' || *value == '\'')
                                ? memchr(value + 1, *value, (size_t)(t->end - value - 1))
                                : NULL;
        if (close) copy_text(value + 1, close, text);
        return;
    }
}

static rsv_status open_object(scanner *s, const tag *t, rsv_collada_kind kind)
{
    rsv_collada *found = s->found;
    rsv_status status = rsv_grow(s->context, (void **)&found->object, &found->object_capacity,
        found->object_count + 1, sizeof *found->object);
    if (status != RSV_OK || t->is_empty) return status;
    s->open = &found->object[found->object_count++];
    s->open->kind = kind;
    attribute(t, "id", s->open->id);
    for (int k = 0; k < RSV_COLLADA_VALUE_COUNT; k++)
        s->open->value[k] = NAN;
    return RSV_OK;
}

/// Names are those that Assimp gives.
static void open_node(scanner *s, const tag *t)
{
    char name[RSV_COLLADA_NAME_BYTES];
    attribute(t, "id", name);
    if (!*name) attribute(t, "sid", name);
    if (!*name) snprintf(name, sizeof name, "$ColladaAutoName$_%zu", s->unnamed++);
    if (s->depth < DEEPEST) memcpy(s->node[s->depth], name, sizeof name);
    s->depth++;
}

static rsv_status add_instance(scanner *s, const tag *t, rsv_collada_kind kind)
{
    char url[RSV_COLLADA_NAME_BYTES];
    rsv_collada *found = s->found;
    if (s->depth == 0 || s->depth > DEEPEST) return RSV_OK;
    rsv_status status = rsv_grow(s->context, (void **)&found->instance, &found->instance_capacity,
        found->instance_count + 1, sizeof *found->instance);
    if (status != RSV_OK) return status;
    rsv_collada_instance *added = &found->instance[found->instance_count++];
    added->kind = kind;
    attribute(t, "url", url);
    memcpy(added->node, s->node[s->depth - 1], sizeof added->node);
    memcpy(added->id, url + (*url == '#'), sizeof added->id - 1);
    added->id[sizeof added->id - 1] = '\0';
    return RSV_OK;
}

static void take_value(const scanner *s, const tag *t)
{
    static const char *const names[RSV_COLLADA_VALUE_COUNT] = { "xfov", "yfov", "aspect_ratio",
        "xmag", "ymag", "falloff_angle", "falloff_exponent", "outer_cone", "penumbra_angle",
        "shiftx", "shifty" };
    for (int k = 0; k < RSV_COLLADA_VALUE_COUNT; k++) {
        if (!is_named(t, names[k])) continue;
        char *end = NULL;
        double value = rsv_number_value(s->at, &end);
        if (end != s->at && isfinite(value)) s->open->value[k] = value;
    }
}

static bool is_one_of(const tag *t, const char *const *names)
{
    for (; *names; names++)
        if (is_named(t, *names)) return true;
    return false;
}

static void note_unused(rsv_collada *found, const char *name)
{
    size_t used = strlen(found->unused), length = strlen(name);
    for (const char *at = strstr(found->unused, name); at; at = strstr(at + 1, name))
        if ((at == found->unused || at[-1] == ' ') && (at[length] == ',' || !at[length])) return;
    if (used + length + 8 > sizeof found->unused) { // keep the list short
        if (strcmp(found->unused + used - 3, "...") != 0) strcat(found->unused, ", ...");
        return;
    }
    snprintf(found->unused + used, sizeof found->unused - used, "%s%s", used ? ", " : "", name);
}

/// Notes what is not used: geometry other than meshes, libraries of no use here, extensions by programs, and unknown
/// tags. Tags inside any of these are not named.
static void judge_tag(scanner *s, const tag *t)
{
    char profile[RSV_COLLADA_NAME_BYTES] = "", name[RSV_COLLADA_NAME_BYTES + 32] = "";
    int length = (int)(t->name_length < 40 ? t->name_length : 40);
    bool is_passed = rsv_collada_passes_over(t->name, t->name_length);
    bool is_known = rsv_collada_knows_element(t->name, t->name_length);
    if (is_named(t, "technique")) attribute(t, "profile", profile); // an effect's has none
    if (*profile)
        snprintf(name, sizeof name, "technique of profile '%s'", profile);
    else if (is_passed)
        snprintf(name, sizeof name, "%.*s", length, t->name);
    else if (!is_known && !s->foreign)
        snprintf(name, sizeof name, "element '%.*s'", length, t->name);
    for (char *c = name; *c; c++)
        if ((unsigned char)*c < ' ' || *c == ',') *c = '?';
    if (*name) note_unused(s->found, name);
    bool is_foreign = s->foreign || *name || is_named(t, "extra");
    if (is_foreign && !t->is_empty) s->foreign++;
}

static rsv_status add_name(scanner *s, rsv_collada_name **list, size_t *count, size_t *capacity,
    const char text[RSV_COLLADA_NAME_BYTES])
{
    if (!*text) return RSV_OK;
    rsv_status status = rsv_grow(s->context, (void **)list, capacity, *count + 1, sizeof **list);
    if (status == RSV_OK) memcpy((*list)[(*count)++].text, text, RSV_COLLADA_NAME_BYTES);
    return status;
}

/// Ids, and references to them.
static rsv_status take_names(scanner *s, const tag *t)
{
    static const char *const named[] = { "geometry", "controller", "camera", "light", "node",
        "material", "effect", "visual_scene", NULL };
    static const char *const referring[] = { "instance_geometry", "instance_controller",
        "instance_camera", "instance_light", "instance_node", "instance_material",
        "instance_effect", "instance_visual_scene", NULL };
    char text[RSV_COLLADA_NAME_BYTES];
    rsv_collada *f = s->found;
    if (is_one_of(t, named)) {
        attribute(t, "id", text);
        return add_name(s, &f->id, &f->id_count, &f->id_capacity, text);
    }
    if (!is_one_of(t, referring)) return RSV_OK;
    attribute(t, is_named(t, "instance_material") ? "target" : "url", text);
    if (*text == '#') memmove(text, text + 1, sizeof text - 1);
    return add_name(s, &f->reference, &f->reference_count, &f->reference_capacity, text);
}

static int compare_texts(const void *a, const void *b) { return strcmp(a, b); }

static void warn(const scanner *s)
{
    const rsv_context *context = s->context;
    const char *path = s->path;
    rsv_collada *f = s->found;
    if (s->still_axes)
        rsv_log(context, RSV_LOG_WARNING, "%s: %zu rotation%s about an axis of length 0 left out",
            path, s->still_axes, s->still_axes == 1 ? "" : "s");
    if (*f->unused) rsv_log(context, RSV_LOG_WARNING, "%s: not used: %s", path, f->unused);
    if (f->id_count) qsort(f->id, f->id_count, sizeof *f->id, compare_texts);
    if (f->reference_count)
        qsort(f->reference, f->reference_count, sizeof *f->reference, compare_texts);
    size_t named = 0;
    for (size_t k = 0; k < f->reference_count && named < MOST_MISSING; k++) {
        char *text = f->reference[k].text;
        if (k > 0 && strcmp(text, f->reference[k - 1].text) == 0) continue;
        if (f->id_count && bsearch(text, f->id, f->id_count, sizeof *f->id, compare_texts))
            continue;
        named++;
        rsv_log(
            context, RSV_LOG_WARNING, "%s: refers to '%s', which it does not contain", path, text);
    }
}

/// The importer takes a unit that is no number for a metre.
static void check_unit(const scanner *s, const tag *t)
{
    char meter[RSV_COLLADA_NAME_BYTES], *end = NULL;
    attribute(t, "meter", meter);
    rsv_number_value(meter, &end);
    if (end == meter && find(t->rest, t->end, "meter"))
        rsv_log(s->context, RSV_LOG_WARNING,
            "%s: its <unit> of '%s' is not a number of metres; 1 is used", s->path, meter);
}

/// Warns of an up axis that is not valid.
static void check_up_axis(const scanner *s)
{
    static const char *const axes[] = { "X_UP", "Y_UP", "Z_UP" };
    const char *at = s->at + strspn(s->at, " \t\r\n");
    for (size_t k = 0; k < sizeof axes / sizeof *axes; k++)
        if (strncmp(at, axes[k], 4) == 0) return;
    rsv_log(s->context, RSV_LOG_WARNING,
        "%s: its <up_axis> is not X_UP, Y_UP or Z_UP; Y_UP is used", s->path);
}

/// Counts what collada_clean.c mends before the importer sees it.
static void check_numbers(scanner *s, const tag *t)
{
    char count[RSV_COLLADA_NAME_BYTES], *end = NULL;
    double rotation[4];
    if (is_named(t, "rotate"))
        s->still_axes += rsv_collada_rotation(s->at, rotation) && rotation[3] == 0;
    if (!is_named(t, "float_array") || t->is_empty) return;
    size_t held = rsv_collada_count_values(s->at);
    attribute(t, "count", count);
    if (rsv_number_value(count, &end) == (double)held && end != count) return;
    if (s->wrong_counts++) return;
    for (char *c = count; *c; c++)
        if ((unsigned char)*c < ' ') *c = '?';
    rsv_log(s->context, RSV_LOG_WARNING,
        "%s: a float_array says count=\"%.20s\" and holds %zu values, which are used", s->path,
        count, held);
}

static rsv_status take_tag(scanner *s, const tag *t)
{
    bool is_node = is_named(t, "node") || is_named(t, "visual_scene");
    bool is_object = is_named(t, "camera") || is_named(t, "light");
    if (t->closes) {
        if (s->foreign) s->foreign--;
        if (is_object) s->open = NULL;
        if (is_node && s->depth) s->depth--;
        return RSV_OK;
    }
    judge_tag(s, t);
    check_numbers(s, t);
    if (is_named(t, "unit")) check_unit(s, t);
    if (is_named(t, "up_axis")) check_up_axis(s);
    rsv_status status = take_names(s, t);
    if (status != RSV_OK) return status;
    if (is_object)
        return open_object(s, t, *t->name == 'c' ? RSV_COLLADA_CAMERA : RSV_COLLADA_LIGHT);
    if (is_node && !t->is_empty) open_node(s, t);
    if (is_named(t, "instance_camera")) return add_instance(s, t, RSV_COLLADA_CAMERA);
    if (is_named(t, "instance_light")) return add_instance(s, t, RSV_COLLADA_LIGHT);
    if (s->open && !t->is_empty) take_value(s, t);
    return RSV_OK;
}

rsv_status rsv_collada_scan(
    rsv_context *context, const rsv_file_source *files, const char *path, rsv_collada *collada)
{
    rsv_status status;
    char *bytes = NULL;
    size_t size = 0;
    scanner *s = rsv_alloc(context, 1, sizeof *s);
    *collada = (rsv_collada){ 0 };
    if (!s) return RSV_ERROR_MEMORY;
    RSV_TRY(rsv_file_read(context, files, path, &bytes, &size));
    *s = (scanner){
        .context = context, .path = path, .at = bytes, .end = bytes + size, .found = collada
    };
    for (tag t; next_tag(s, &t);)
        RSV_TRY(take_tag(s, &t));
    warn(s);
cleanup:
    rsv_free(context, bytes);
    rsv_free(context, s);
    if (status != RSV_OK) rsv_collada_release(context, collada);
    return status;
}

void rsv_collada_release(rsv_context *context, rsv_collada *collada)
{
    rsv_free(context, collada->object);
    rsv_free(context, collada->instance);
    rsv_free(context, collada->id);
    rsv_free(context, collada->reference);
    *collada = (rsv_collada){ 0 };
}

const rsv_collada_object *rsv_collada_find(
    const rsv_collada *collada, rsv_collada_kind kind, const char *node, size_t order)
{
    const char *id = NULL;
    for (size_t k = 0; k < collada->instance_count && !id; k++) {
        const rsv_collada_instance *instance = &collada->instance[k];
        if (instance->kind == kind && strcmp(instance->node, node) == 0 && order-- == 0)
            id = instance->id;
    }
    for (size_t k = 0; id && k < collada->object_count; k++)
        if (collada->object[k].kind == kind && strcmp(collada->object[k].id, id) == 0)
            return &collada->object[k];
    return NULL;
}
