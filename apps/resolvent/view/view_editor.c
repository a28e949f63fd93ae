#include "view_editor.h"

#include "view_camera.h"
#include "view_items.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// Frames without an edit after which the light is finished.
#define FRAMES_TO_SETTLE 4
/// A copy appears beside its original, this many times its extent away.
#define COPY_DISTANCE 1.1f

static const float identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };

static bool fail(char *problem, const char *text)
{
    snprintf(problem, CLI_VIEW_TEXT_LENGTH, "%.250s", text);
    return false;
}

// ---- editions -------------------------------------------------------------------------------------

static void free_edition(cli_edition *e)
{
    free(e->object);
    free(e->material);
    *e = (cli_edition){ .selected = SIZE_MAX };
}

/// With room for one more object and one more material.
static bool copy_edition(const cli_edition *from, cli_edition *to)
{
    *to = *from;
    to->object = calloc(from->object_count + 1, sizeof *to->object);
    to->material = calloc(from->material_count + 1, sizeof *to->material);
    if (!to->object || !to->material) {
        free_edition(to);
        return false;
    }
    if (from->object_count)
        memcpy(to->object, from->object, from->object_count * sizeof *to->object);
    if (from->material_count)
        memcpy(to->material, from->material, from->material_count * sizeof *to->material);
    return true;
}

/// Before a change.
static bool remember(cli_view_editor *e, char *problem)
{
    cli_edition copy;
    cli_edition *past = realloc(e->past, (e->past_count + 1) * sizeof *past);
    if (past) e->past = past;
    if (!past || !copy_edition(&e->now, &copy)) return fail(problem, "out of memory");
    e->past[e->past_count++] = e->now; // the copy has room for more
    e->now = copy;
    e->changed = true;
    return true;
}

static bool undo(cli_view_editor *e, char *problem)
{
    if (!e->past_count) return fail(problem, "there is nothing to undo");
    free_edition(&e->now);
    e->now = e->past[--e->past_count];
    e->changed = true;
    return true;
}

static bool begin_edition(cli_view_editor *e, char *problem)
{
    const rsv_scene_view *view = rsv_scene_get_view(e->original);
    if (e->now.object) return true;
    e->now = (cli_edition){ .selected = SIZE_MAX };
    e->now.object = calloc(view->object_count + 1, sizeof *e->now.object);
    if (!e->now.object) return fail(problem, "out of memory");
    for (; e->now.object_count < view->object_count; e->now.object_count++) {
        cli_edited_object *object = &e->now.object[e->now.object_count];
        object->source = (uint32_t)e->now.object_count;
        memcpy(object->matrix, identity, sizeof identity);
    }
    if (copy_edition(&e->now, &e->built)) return true;
    free_edition(&e->now);
    return fail(problem, "out of memory");
}

void cli_view_editor_begin(
    cli_view_editor *e, const rsv_scene *original, const rsv_solve_desc *solve)
{
    *e = (cli_view_editor){ .original = original, .solve = *solve, .settled = true };
    e->now.selected = e->built.selected = SIZE_MAX;
}

void cli_view_editor_end(cli_view_editor *e)
{
    rsv_tracer_destroy(e->tracer);
    rsv_scene_destroy(e->version);
    rsv_scene_destroy(e->lit);
    rsv_scene_destroy(e->parts);
    rsv_update_store_destroy(e->store);
    for (size_t k = 0; k < e->past_count; k++)
        free_edition(&e->past[k]);
    free(e->past);
    free_edition(&e->now);
    free_edition(&e->built);
    *e = (cli_view_editor){ .settled = true };
}

// ---- objects --------------------------------------------------------------------------------------

static const rsv_scene *shown_scene(const cli_view_editor *e)
{
    return e->version ? e->version : e->lit ? e->lit : e->original;
}

static rsv_vec3 moved(const float m[16], rsv_vec3 p)
{
    return (rsv_vec3){ m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12],
        m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
        m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14] };
}

typedef struct box {
    rsv_vec3 low, high;
} box;

/// Around an object where it is.
static box box_around(const cli_view_editor *e, const cli_edited_object *object)
{
    const rsv_scene_view *v = rsv_scene_get_view(e->original);
    box b = { { INFINITY, INFINITY, INFINITY }, { -INFINITY, -INFINITY, -INFINITY } };
    for (size_t t = 0; t < v->triangle_count; t++)
        for (int k = 0; k < 3 && v->triangle_object[t] == object->source; k++) {
            rsv_vec3 p = moved(object->matrix, v->position[v->triangle[t][k]]);
            b.low = (rsv_vec3){ fminf(b.low.x, p.x), fminf(b.low.y, p.y), fminf(b.low.z, p.z) };
            b.high = (rsv_vec3){ fmaxf(b.high.x, p.x), fmaxf(b.high.y, p.y), fmaxf(b.high.z, p.z) };
        }
    return b;
}

static rsv_vec3 middle_of(const box *b)
{
    return (rsv_vec3){ 0.5f * (b->low.x + b->high.x), 0.5f * (b->low.y + b->high.y),
        0.5f * (b->low.z + b->high.z) };
}

static cli_edited_object *selection(cli_view_editor *e, char *problem)
{
    if (e->now.selected < e->now.object_count) return &e->now.object[e->now.selected];
    fail(problem, "no object is selected; choose one with Ctrl+click, or `object NAME`");
    return NULL;
}

static bool select_object(cli_view_editor *e, const char *name, char *problem)
{
    const rsv_scene_view *v = rsv_scene_get_view(e->original);
    size_t k = 0;
    while (k < e->now.object_count && strcmp(v->object_name[e->now.object[k].source], name) != 0)
        k++;
    bool none = strcmp(name, "none") == 0;
    if (k == e->now.object_count && !none)
        return cli_view_fail(
            problem, "there is no object '%.120s'; `resolvent info` lists them", name);
    e->now.selected = none ? SIZE_MAX : k;
    return true;
}

/// The direction of a ray of the camera, and where it begins.
static rsv_ray aim(const cli_view_state *s, float x, float y)
{
    const rsv_camera *c = &s->camera;
    float up = c->vertical_fov > 0 ? tanf(0.5f * c->vertical_fov) : c->vertical_extent;
    float right = up * s->aspect, a = (2 * x - 1) * right, b = (1 - 2 * y) * up;
    rsv_vec3 across = { a * c->right.x + b * c->up.x, a * c->right.y + b * c->up.y,
        a * c->right.z + b * c->up.z };
    const rsv_vec3 *p = &c->position, *f = &c->forward;
    if (c->vertical_fov > 0)
        return (rsv_ray){ *p, { f->x + across.x, f->y + across.y, f->z + across.z }, INFINITY };
    return (rsv_ray){ { p->x + across.x, p->y + across.y, p->z + across.z }, *f, INFINITY };
}

/// Selects the object that is seen at a place in the picture.
static bool grasp(cli_view_editor *e, const cli_view_state *s, const float place[2], char *problem)
{
    const rsv_scene *scene = shown_scene(e);
    rsv_hit hit;
    if (!e->tracer && rsv_tracer_create(scene, &e->tracer) != RSV_OK)
        return fail(problem, rsv_last_error());
    rsv_ray ray = aim(s, place[0], place[1]);
    e->now.selected = SIZE_MAX;
    if (!rsv_tracer_closest(e->tracer, &ray, &hit)) return true;
    uint32_t object = rsv_scene_get_view(scene)->triangle_object[hit.triangle], shown = 0;
    for (size_t k = 0; k < e->now.object_count; k++)
        if (!e->now.object[k].hidden && shown++ == object) e->now.selected = k;
    return true;
}

// ---- changes --------------------------------------------------------------------------------------

/// Scales about a point and turns about the vertical through it, then moves.
typedef struct change {
    rsv_vec3 about, by;
    float turn, scale; ///< degrees, factor
} change;

static void apply_change(const change *c, float m[16])
{
    float angle = c->turn * 0.017453292519943f, cosine = cosf(angle) * c->scale,
          sine = sinf(angle) * c->scale;
    for (int column = 0; column < 4; column++) {
        float *v = m + 4 * column, w = column == 3 ? 1 : 0;
        float x = v[0] - w * c->about.x, y = v[1] - w * c->about.y, z = v[2] - w * c->about.z;
        v[0] = cosine * x + sine * z + w * (c->about.x + c->by.x);
        v[1] = c->scale * y + w * (c->about.y + c->by.y);
        v[2] = cosine * z - sine * x + w * (c->about.z + c->by.z);
    }
}

static bool change_place(cli_view_editor *e, change c, char *problem)
{
    const cli_edited_object *object = selection(e, problem);
    if (!object) return false;
    if (!(c.scale > 0)) return fail(problem, "resize: the factor must be above 0");
    box b = box_around(e, object);
    c.about = middle_of(&b);
    if (c.scale != 1) c.about.y = b.low.y; // what stands on the floor stays there
    if (!remember(e, problem)) return false;
    apply_change(&c, e->now.object[e->now.selected].matrix);
    return true;
}

/// Drags go back as one.
static bool haul(cli_view_editor *e, const cli_view_state *s, const float by[2], char *problem)
{
    const cli_edited_object *object = selection(e, problem);
    float place[2];
    if (!object) return false;
    box b = box_around(e, object);
    float depth = cli_camera_project(&s->camera, s->aspect, middle_of(&b), place);
    if (depth <= 0) return true;
    if (!e->hauls && !remember(e, problem)) return false;
    change c = { .scale = 1, .by = cli_camera_drag(&s->camera, s->aspect, depth, by[0], by[1]) };
    apply_change(&c, e->now.object[e->now.selected].matrix);
    e->hauls = e->changed = true;
    return true;
}

static bool hide(cli_view_editor *e, char *problem)
{
    if (!selection(e, problem) || !remember(e, problem)) return false;
    cli_edited_object *object = &e->now.object[e->now.selected];
    object->hidden = !object->hidden;
    return true;
}

static bool duplicate(cli_view_editor *e, char *problem)
{
    const cli_edited_object *object = selection(e, problem);
    if (!object) return false;
    box b = box_around(e, object);
    change c = { .scale = 1, .by = { COPY_DISTANCE * (b.high.x - b.low.x), 0, 0 } };
    if (c.by.x == 0) c.by.z = COPY_DISTANCE * (b.high.z - b.low.z);
    if (!remember(e, problem)) return false;
    cli_edition *now = &e->now;
    now->object[now->object_count] = now->object[now->selected];
    now->selected = now->object_count++;
    now->object[now->selected].hidden = false;
    apply_change(&c, now->object[now->selected].matrix);
    return true;
}

static bool delete_object(cli_view_editor *e, char *problem)
{
    if (!selection(e, problem) || !remember(e, problem)) return false;
    cli_edition *now = &e->now;
    size_t behind = --now->object_count - now->selected;
    memmove(
        now->object + now->selected, now->object + now->selected + 1, behind * sizeof *now->object);
    now->selected = SIZE_MAX;
    return true;
}

/// The material of the selection, to be changed.
static rsv_material_edit *change_material(cli_view_editor *e, char *problem)
{
    const rsv_scene_view *v = rsv_scene_get_view(e->original);
    if (!selection(e, problem) || !remember(e, problem)) return NULL;
    cli_edition *now = &e->now;
    size_t t = 0, k = 0;
    while (v->triangle_object[t] != now->object[now->selected].source)
        t++;
    uint32_t index = v->triangle_material[t];
    while (k < now->material_count && now->material[k].material != index)
        k++;
    if (k == now->material_count) {
        const rsv_material *m = &v->material[index];
        now->material[now->material_count++] =
            (rsv_material_edit){ index, m->base_color, m->roughness, m->metallic };
    }
    return &now->material[k];
}

static bool are_shares(const float *n, int count, char *problem)
{
    for (int k = 0; k < count; k++)
        if (!(n[k] >= 0 && n[k] <= 1))
            return fail(problem, "colour, roughness and metalness must be from 0 to 1");
    return true;
}

static bool paint(cli_view_editor *e, const float *n, char *problem)
{
    rsv_material_edit *m = are_shares(n, 3, problem) ? change_material(e, problem) : NULL;
    if (m) m->base_color = (rsv_rgb){ n[0], n[1], n[2] };
    return m != NULL;
}

static bool set_surface(cli_view_editor *e, const float *n, char *problem)
{
    rsv_material_edit *m = are_shares(n, 2, problem) ? change_material(e, problem) : NULL;
    if (m) m->roughness = n[0], m->metallic = n[1];
    return m != NULL;
}

static bool save(cli_view_editor *e, const char *path, char *problem)
{
    const char *end = strrchr(path, '.');
    if (!end || strcmp(end, ".glb") != 0)
        return cli_view_fail(problem, "save: '%.120s' does not end in .glb", path);
    snprintf(e->save, sizeof e->save, "%s", path);
    return true;
}

bool cli_view_editor_apply(
    cli_view_editor *e, const cli_view_state *s, const cli_view_command *c, char *problem)
{
    const float *n = c->number;
    if (e->played) return fail(problem, "objects cannot be edited after the animation was played");
    if (!begin_edition(e, problem)) return false;
    if (c->verb != CLI_VIEW_HAUL) e->hauls = false;
    switch (c->verb) {
    case CLI_VIEW_CHOOSE:
        return select_object(e, c->text, problem);
    case CLI_VIEW_GRASP:
        return grasp(e, s, n, problem);
    case CLI_VIEW_HAUL:
        return haul(e, s, n, problem);
    case CLI_VIEW_SHIFT:
        return change_place(e, (change){ .scale = 1, .by = { n[0], n[1], n[2] } }, problem);
    case CLI_VIEW_SPIN:
        return change_place(e, (change){ .scale = 1, .turn = n[0] }, problem);
    case CLI_VIEW_RESIZE:
        return change_place(e, (change){ .scale = n[0] }, problem);
    case CLI_VIEW_HIDE:
        return hide(e, problem);
    case CLI_VIEW_DUPLICATE:
        return duplicate(e, problem);
    case CLI_VIEW_DELETE:
        return delete_object(e, problem);
    case CLI_VIEW_PAINT:
        return paint(e, n, problem);
    case CLI_VIEW_SURFACE:
        return set_surface(e, n, problem);
    case CLI_VIEW_SAVE:
        return save(e, c->text, problem);
    default:
        return undo(e, problem);
    }
}

// ---- light ----------------------------------------------------------------------------------------

/// The visible object at or behind index k.
static size_t next_shown(const cli_edition *e, size_t k)
{
    while (k < e->object_count && e->object[k].hidden)
        k++;
    return k;
}

/// Whether two editions differ at most in places.
static bool has_same_parts(const cli_edition *a, const cli_edition *b)
{
    size_t i = next_shown(a, 0), k = next_shown(b, 0);
    for (; i < a->object_count && k < b->object_count;
         i = next_shown(a, i + 1), k = next_shown(b, k + 1))
        if (a->object[i].source != b->object[k].source) return false;
    size_t bytes = a->material_count * sizeof *a->material;
    return i == a->object_count && k == b->object_count && a->material_count == b->material_count &&
           (!bytes || memcmp(a->material, b->material, bytes) == 0);
}

/// Scenes are built from lists of numbers. @param parts out: what is shown, in its original places
static rsv_status build_parts(const cli_view_editor *e, rsv_scene **parts)
{
    const cli_edition *now = &e->now;
    rsv_scene_edit edit = rsv_default_scene_edit();
    uint32_t *object = calloc(now->object_count + 1, sizeof *object);
    if (!object) return RSV_ERROR_MEMORY;
    for (size_t k = next_shown(now, 0); k < now->object_count; k = next_shown(now, k + 1))
        object[edit.object_count++] = now->object[k].source;
    edit.object = object;
    edit.material = now->material;
    edit.material_count = now->material_count;
    rsv_status status = rsv_scene_apply_edit(e->original, &edit, parts);
    free(object);
    return status;
}

static bool is_moved(const cli_edited_object *object)
{
    bool moves = false;
    for (int k = 0; k < 16; k++)
        moves = moves || object->matrix[k] != identity[k];
    return moves;
}

/// @param version out: the parts where they are now
static rsv_status place_parts(const cli_view_editor *e, const rsv_scene *parts, rsv_scene **version)
{
    const cli_edition *now = &e->now;
    rsv_motion *motion = calloc(now->object_count + 1, sizeof *motion);
    size_t count = 0;
    uint32_t object = 0;
    if (!motion) return RSV_ERROR_MEMORY;
    for (size_t k = next_shown(now, 0); k < now->object_count; k = next_shown(now, k + 1)) {
        motion[count].object = object++;
        memcpy(motion[count].matrix, now->object[k].matrix, sizeof identity);
        count += is_moved(&now->object[k]);
    }
    rsv_status status = rsv_scene_move(parts, motion, count, version);
    free(motion);
    return status;
}

static void take_version(cli_view_editor *e, rsv_scene *version)
{
    rsv_tracer_destroy(e->tracer);
    e->tracer = NULL;
    rsv_scene_destroy(e->version);
    e->version = version;
}

/// The same parts elsewhere.
static rsv_status follow(cli_view_editor *e, cli_view_show *show, cli_view_state *state)
{
    rsv_scene *version = NULL;
    rsv_status status = place_parts(e, e->parts ? e->parts : e->original, &version);
    if (status == RSV_OK) status = cli_show_follow(show, state, version, 0);
    if (status != RSV_OK) {
        rsv_scene_destroy(version);
        return status;
    }
    take_version(e, version);
    e->settled = false;
    return RSV_OK;
}

/// Takes over a light and the scenes that it was made for.
static rsv_status take_light(cli_view_editor *e, cli_view_show *show, cli_view_state *state,
    rsv_light *light, rsv_scene *parts, rsv_scene *lit)
{
    cli_edition built;
    if (!copy_edition(&e->now, &built)) {
        rsv_light_destroy(light);
        rsv_scene_destroy(lit);
        rsv_scene_destroy(parts);
        return RSV_ERROR_MEMORY;
    }
    rsv_status status =
        cli_show_replace(show, state, light); // the light before refers to what is freed now
    take_version(e, NULL);
    rsv_scene_destroy(e->lit);
    rsv_scene_destroy(e->parts);
    free_edition(&e->built);
    e->lit = lit;
    e->parts = parts;
    e->built = built;
    e->settled = true;
    return status;
}

/// Other parts, or other materials.
static rsv_status solve(cli_view_editor *e, cli_view_show *show, cli_view_state *state)
{
    rsv_scene *parts = NULL, *lit = NULL;
    rsv_light *light = NULL;
    rsv_context *context = rsv_scene_get_context(e->original);
    rsv_status status = RSV_OK;
    if (!e->store) status = rsv_update_store_create(context, &e->store);
    if (status == RSV_OK) status = build_parts(e, &parts);
    if (status == RSV_OK) status = place_parts(e, parts, &lit);
    if (status == RSV_OK) status = rsv_operator_update(lit, &e->solve, e->store, &light, NULL);
    if (status == RSV_OK) return take_light(e, show, state, light, parts, lit);
    rsv_scene_destroy(lit);
    rsv_scene_destroy(parts);
    return status;
}

/// What moved has rested for some frames.
static rsv_status settle(cli_view_editor *e, cli_view_show *show, cli_view_state *state)
{
    if (e->settled || !e->version || ++e->quiet_frames < FRAMES_TO_SETTLE) return RSV_OK;
    e->settled = true;
    return cli_show_follow(show, state, e->version, 0);
}

static bool save_wanted(cli_view_editor *e, char *problem)
{
    if (!e->save[0]) return true;
    bool saved = rsv_scene_save(shown_scene(e), e->save) == RSV_OK;
    e->save[0] = '\0';
    return saved || fail(problem, rsv_last_error());
}

bool cli_view_edit(
    cli_view_editor *e, cli_view_show *show, cli_view_state *state, double *lag_ms, char *problem)
{
    double start = cli_seconds();
    rsv_status status = RSV_OK;
    bool changed = e->changed;
    if (!e->now.object || !cli_show_is_complete(show)) return true;
    if (changed) {
        bool moves = has_same_parts(&e->now, &e->built);
        status = moves ? follow(e, show, state) : RSV_ERROR_UNSUPPORTED;
        if (status == RSV_ERROR_UNSUPPORTED) status = solve(e, show, state);
        e->quiet_frames = 0;
        *lag_ms = 1e3 * (cli_seconds() - start);
    } else {
        status = settle(e, show, state);
    }
    e->changed = false;
    if (status == RSV_OK) return save_wanted(e, problem);
    fail(problem, rsv_last_error());
    char ignored[CLI_VIEW_TEXT_LENGTH];
    if (changed && undo(e, ignored))
        e->changed = e->hauls; // else the light is still that of before
    e->hauls = false;
    return false;
}

void cli_view_editor_say(const cli_view_editor *e, char *text)
{
    text[0] = '\0';
    if (e->now.selected >= e->now.object_count) return;
    const cli_edited_object *object = &e->now.object[e->now.selected];
    snprintf(text, CLI_VIEW_TEXT_LENGTH, "%.100s%s",
        rsv_scene_get_view(e->original)->object_name[object->source],
        object->hidden ? " (hidden)" : "");
}
