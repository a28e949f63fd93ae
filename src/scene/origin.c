/// Scenes far from their origin, such as maps, where single precision leaves few digits. A common origin is subtracted
/// once, before anything is converted to float; rsv_scene_view.origin keeps it for code that writes coordinates.
#include "../core/vec.h"
#include "far_box.h"
#include "scene.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

/// Sizes of the scene between its centre and the origin from which on this is done. There a float has lost six of its
/// 24 binary digits.
#define FAR_SIZES 64
/// Numbers of single precision lie apart by this part of their size at most.
#define SPACING 0x1p-23
/// Smallest detail relative to the size of a scene that must look right.
#define FEW_DIGITS (1e3 * SPACING)

rsv_far_box rsv_far_nothing(void)
{
    return (rsv_far_box){ { DBL_MAX, DBL_MAX, DBL_MAX }, { -DBL_MAX, -DBL_MAX, -DBL_MAX } };
}

void rsv_far_enclose(rsv_far_box *box, const double point[3])
{
    for (int axis = 0; axis < 3; axis++) {
        box->low[axis] = fmin(box->low[axis], point[axis]);
        box->high[axis] = fmax(box->high[axis], point[axis]);
    }
}

static double size_of(const rsv_far_box *box)
{
    double size = 0;
    for (int axis = 0; axis < 3; axis++)
        size = fmax(size, box->high[axis] - box->low[axis]);
    return size;
}

bool rsv_is_far(const rsv_far_box *box)
{
    double size = size_of(box), distance = 0;
    for (int axis = 0; axis < 3; axis++)
        distance = fmax(distance, fabs(0.5 * (box->low[axis] + box->high[axis])));
    return size > 0 && distance > FAR_SIZES * size && distance <= (double)RSV_FARTHEST;
}

void rsv_far_origin(const rsv_far_box *box, double origin[3])
{
    bool far = rsv_is_far(box);
    double step = far ? pow(10, ceil(log10(size_of(box)))) : 1;
    for (int axis = 0; axis < 3; axis++)
        origin[axis] = far ? step * rint(0.5 * (box->low[axis] + box->high[axis]) / step) : 0;
}

/// Bounds of a mesh's triangles, in its own space.
static rsv_far_box mesh_bounds(const rsv_mesh *mesh)
{
    rsv_far_box b = rsv_far_nothing();
    for (size_t k = 0; k < 3 * mesh->triangle_count; k++) {
        rsv_vec3 p = mesh->position[mesh->index[k]];
        rsv_far_enclose(&b, (const double[3]){ (double)p.x, (double)p.y, (double)p.z });
    }
    return b;
}

/// Adds the corners of a mesh's bounds, as an instance places them. Non-finite values are refused later.
static void add_instance(const rsv_far_box *mesh, const double m[16], rsv_far_box *all)
{
    for (int corner = 0; corner < 8; corner++) {
        double p[3];
        for (int row = 0; row < 3; row++) {
            p[row] = m[12 + row];
            for (int axis = 0; axis < 3; axis++)
                p[row] +=
                    m[4 * axis + row] * (corner >> axis & 1 ? mesh->high[axis] : mesh->low[axis]);
        }
        if (isfinite(p[0] + p[1] + p[2])) rsv_far_enclose(all, p);
    }
}

/// The longest column of a transform's linear part.
static double scale_of(const double m[16])
{
    double square = 0;
    for (int column = 0; column < 3; column++) {
        const double *c = &m[4 * column];
        square = fmax(square, c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
    }
    return sqrt(square);
}

static double farthest_of(const rsv_far_box *box)
{
    double farthest = 0;
    for (int axis = 0; axis < 3; axis++)
        farthest = fmax(farthest, fmax(fabs(box->low[axis]), fabs(box->high[axis])));
    return farthest;
}

/// Where an instance is.
typedef struct placed_box {
    rsv_far_box box;
    double centre[3], weight; ///< the area of the box
    double distance;          ///< of the centre, from where most are
    size_t order;             ///< in the scene
    const char *name;
} placed_box;

static placed_box placed(const rsv_far_box *box, const char *name)
{
    placed_box p = { .box = *box, .name = name };
    double size[3];
    for (int axis = 0; axis < 3; axis++) {
        p.centre[axis] = 0.5 * (box->low[axis] + box->high[axis]);
        size[axis] = box->high[axis] - box->low[axis];
    }
    p.weight = size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
    return p;
}

/// @param place out: [instance_count], as many as there are @param grain out: metres between neighbours of the coarsest
/// numbers among their places, as far as the file has these in single precision
static rsv_status find_places(
    const rsv_scene *scene, placed_box *place, size_t *count, double *grain)
{
    rsv_far_box *mesh = rsv_alloc(scene->context, scene->mesh_count, sizeof *mesh);
    if (!mesh) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < scene->mesh_count; k++)
        mesh[k] = mesh_bounds(&scene->mesh[k]);
    *count = 0;
    *grain = scene->grain;
    for (size_t k = 0; k < scene->instance_count; k++) {
        const rsv_instance *instance = &scene->instance[k];
        const rsv_far_box *own = &mesh[instance->mesh];
        rsv_far_box box = rsv_far_nothing();
        if (!scene->mesh[instance->mesh].triangle_count) continue;
        add_instance(own, instance->transform, &box);
        if (box.low[0] > box.high[0]) continue;
        place[*count] = placed(&box, instance->name);
        place[*count].order = *count;
        (*count)++;
        *grain = fmax(*grain, SPACING * farthest_of(own) * scale_of(instance->transform));
    }
    rsv_free(scene->context, mesh);
    return RSV_OK;
}

static int compare_distances(const void *left, const void *right)
{
    const placed_box *a = left, *b = right;
    if (a->distance != b->distance) return a->distance < b->distance ? -1 : 1;
    return (a->order > b->order) - (a->order < b->order);
}

/// The coordinate along an axis that divides the weight into halves. Reorders the places.
static double median(placed_box *place, size_t count, int axis, double weight)
{
    double sum = 0;
    size_t k = 0;
    for (size_t n = 0; n < count; n++)
        place[n].distance = place[n].centre[axis];
    qsort(place, count, sizeof *place, compare_distances);
    while (k + 1 < count && (sum += place[k].weight) < 0.5 * weight)
        k++;
    return place[k].distance;
}

/// Bounds of the parts that are far away: of everything, or of most if something was left at the origin (the default
/// cube of a modelling program).
/// @param place out: those within the bounds first
/// @return how many these are; 0 = nothing is far away
static size_t find_far(placed_box *place, size_t count, rsv_far_box *far)
{
    rsv_far_box all = rsv_far_nothing();
    double weight = 0, sum = 0, middle[3];
    size_t within = 0;
    for (size_t k = 0; k < count; k++)
        weight += place[k].weight;
    for (int axis = 0; axis < 3 && count; axis++)
        middle[axis] = median(place, count, axis, weight);
    for (size_t k = 0; k < count; k++) {
        const double *c = place[k].centre;
        place[k].distance =
            fmax(fabs(c[0] - middle[0]), fmax(fabs(c[1] - middle[1]), fabs(c[2] - middle[2])));
    }
    if (count) qsort(place, count, sizeof *place, compare_distances);
    for (size_t k = 0; k < count; k++) {
        rsv_far_enclose(&all, place[k].box.low);
        rsv_far_enclose(&all, place[k].box.high);
        sum += place[k].weight;
        if ((sum <= 0.5 * weight && k + 1 < count) || !rsv_is_far(&all)) continue;
        *far = all;
        within = k + 1;
    }
    return within;
}

void rsv_scene_note_single(rsv_scene *scene, double farthest)
{
    scene->grain = fmax(scene->grain, SPACING * farthest);
}

/// @param far bounds of the parts that are far away @param place [count] the parts left behind
static void warn_of_strays(
    const rsv_scene *scene, const rsv_far_box *far, const placed_box *place, size_t count)
{
    if (!count) return;
    double distance = fmax(place->distance, 0.5 * size_of(far));
    rsv_log(scene->context, RSV_LOG_WARNING,
        "object '%s'%s %.3g m away from the rest of the scene, where positions are accurate to %.2g m: delete "
        "what you do not need",
        place->name, count > 1 ? " and others lie" : " lies", distance, SPACING * distance);
}

static void shift(const rsv_scene *scene, const rsv_fixture *fixture, rsv_vec3 *position)
{
    *position = v3((float)(fixture->position[0] - scene->origin[0]),
        (float)(fixture->position[1] - scene->origin[1]),
        (float)(fixture->position[2] - scene->origin[2]));
}

static void shift_fixtures(rsv_scene *scene)
{
    for (size_t k = 0; k < scene->light_count; k++)
        shift(scene, &scene->light_fixture[k], &scene->light[k].position);
    for (size_t k = 0; k < scene->camera_count; k++)
        shift(scene, &scene->camera_fixture[k], &scene->camera[k].position);
}

rsv_status rsv_scene_take_origin(rsv_scene *scene)
{
    rsv_far_box all;
    double grain;
    size_t count;
    if (scene->rest) {
        memcpy(scene->origin, scene->rest->origin, sizeof scene->origin);
        if (rsv_scene_is_far(scene)) shift_fixtures(scene);
        return RSV_OK;
    }
    if (!scene->in_double) return RSV_OK;
    placed_box *place = rsv_reserve(scene->context, scene->instance_count + 1, sizeof *place);
    rsv_status status = place ? find_places(scene, place, &count, &grain) : RSV_ERROR_MEMORY;
    size_t within = status == RSV_OK ? find_far(place, count, &all) : 0;
    if (within) warn_of_strays(scene, &all, place + within, count - within);
    rsv_free(scene->context, place);
    if (!within) return status;
    rsv_far_origin(&all, scene->origin);
    shift_fixtures(scene);
    rsv_log(scene->context, RSV_LOG_INFO,
        "the scene lies far from its origin: (%.15g, %.15g, %.15g) m is subtracted from its "
        "coordinates internally, and added again in all output",
        scene->origin[0], scene->origin[1], scene->origin[2]);
    if (grain > FEW_DIGITS * size_of(&all))
        rsv_log(scene->context, RSV_LOG_WARNING,
            "the file stores these positions in single precision, which resolves %.2g m there: "
            "finer details of the scene (%.3g m across) are lost; export it closer to the origin, "
            "or as "
            "glTF with that distance in the translation of a node",
            grain, size_of(&all));
    return RSV_OK;
}
