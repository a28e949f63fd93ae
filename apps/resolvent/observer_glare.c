#include "observer_glare.h"

#include "glare.h"
#include "photometry.h"

#include "resolvent/solve.h"
#include "resolvent/trace.h"

#include <math.h>
#include <stdlib.h>

#define VISIBILITY_RAYS 16 ///< to each luminaire
#define NEAREST 1e-3f      ///< of the way to a source that is left out on both ends

static rsv_vec3 minus(rsv_vec3 a, rsv_vec3 b)
{
    return (rsv_vec3){ a.x - b.x, a.y - b.y, a.z - b.z };
}

static rsv_vec3 along(rsv_vec3 a, float t, rsv_vec3 b)
{
    return (rsv_vec3){ a.x + t * b.x, a.y + t * b.y, a.z + t * b.z };
}

static double dot(rsv_vec3 a, rsv_vec3 b)
{
    return (double)a.x * (double)b.x + (double)a.y * (double)b.y + (double)a.z * (double)b.z;
}

static rsv_vec3 cross(rsv_vec3 a, rsv_vec3 b)
{
    return (rsv_vec3){ a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x };
}

static rsv_vec3 unit(rsv_vec3 a)
{
    float length = (float)sqrt(dot(a, a));
    return length > 0 ? along((rsv_vec3){ 0, 0, 0 }, 1 / length, a) : a;
}

/// An observer's position and the glare found there.
typedef struct eye {
    const rsv_scene_view *scene;
    const rsv_tracer *tracer;
    rsv_vec3 place, right, up, ahead;
    double sum;    ///< L^2 w / P^2
    double direct; ///< lux of glare sources
    uint32_t sources;
} eye;

static eye eye_of(const rsv_scene_view *scene, const rsv_tracer *tracer, const rsv_probe *probe)
{
    const rsv_vec3 up = { 0, 1, 0 }, other = { 0, 0, -1 };
    eye e = { .scene = scene, .tracer = tracer, .place = probe->position };
    e.ahead = unit(probe->normal);
    rsv_vec3 right = cross(e.ahead, fabsf(e.ahead.y) < 0.999f ? up : other);
    e.right = unit(right);
    e.up = cross(e.right, e.ahead);
    return e;
}

static bool sees(const eye *e, rsv_vec3 place)
{
    rsv_vec3 way = minus(place, e->place);
    rsv_ray ray = { along(e->place, NEAREST, way), way, 1 - 2 * NEAREST };
    return !rsv_tracer_occluded(e->tracer, &ray);
}

/// A source by its luminance squared times its solid angle, and its illuminance before the eye, both as far as it is
/// seen.
static void add_source(eye *e, rsv_vec3 towards, double square, double illuminance)
{
    const double direction[3] = { dot(towards, e->right), dot(towards, e->up),
        dot(towards, e->ahead) };
    if (!(direction[2] > 0) || !(square > 0)) return;
    double position = cli_position_index(direction);
    e->sum += square / (position * position);
    e->direct += illuminance * direction[2];
    e->sources++;
}

// ---- luminaires -------------------------------------------------------------------------------------

/// cd in a direction (unit, from the luminaire).
static double intensity_of(const eye *e, const rsv_punctual_light *l, rsv_vec3 d)
{
    rsv_vec3 up = cross(l->side, l->direction);
    rsv_vec3 own = { (float)dot(d, l->side), (float)dot(d, up), (float)-dot(d, l->direction) };
    return cli_luminous(l->intensity) *
           rsv_luminaire_intensity(&e->scene->luminaire[l->luminaire], own);
}

/// m2 of an opening as it is seen along a direction.
static double projected_area(const rsv_punctual_light *l, rsv_vec3 d)
{
    rsv_vec3 up = cross(l->side, l->direction);
    double x = fabs((double)l->opening.x), y = fabs((double)l->opening.y),
           z = fabs((double)l->opening.z);
    double round = l->opening.x < 0 ? M_PI / 4 : 1;
    double turned = fabs(dot(d, l->direction));
    if (l->opening.x < 0) // a cylinder's wall
        return round * x * y * turned + 0.5 * (x + y) * z * sqrt(fmax(1 - turned * turned, 0));
    return x * y * turned + y * z * fabs(dot(d, l->side)) + x * z * fabs(dot(d, up));
}

/// Share of the opening that is seen.
static double seen_share(const eye *e, const rsv_punctual_light *l)
{
    rsv_vec3 up = cross(l->side, l->direction);
    int seen = 0;
    for (int k = 0; k < VISIBILITY_RAYS; k++) {
        float u = ((float)(k % 4) + 0.5f) / 4 - 0.5f, v = ((float)(k / 4) + 0.5f) / 4 - 0.5f;
        if (l->opening.x < 0) u *= 0.7f, v *= 0.7f; // within the ellipse
        rsv_vec3 place = along(l->position, u * l->opening.x, l->side);
        seen += sees(e, along(place, v * l->opening.y, up));
    }
    return (double)seen / VISIBILITY_RAYS;
}

static void add_luminaire(eye *e, const rsv_punctual_light *l)
{
    rsv_vec3 way = minus(l->position, e->place), towards = unit(way);
    rsv_vec3 back = { -towards.x, -towards.y, -towards.z };
    double square = dot(way, way), intensity = intensity_of(e, l, back);
    double area = projected_area(l, back);
    if (!(intensity > 0) || !(area > 0) || !(square > 0) || !(dot(towards, e->ahead) > 0)) return;
    double share = seen_share(e, l);
    add_source(
        e, towards, share * intensity * intensity / (area * square), share * intensity / square);
}

// ---- lamps ------------------------------------------------------------------------------------------

/// Van Oosterom and Strackee (1983).
static double solid_angle_of(rsv_vec3 a, rsv_vec3 b, rsv_vec3 c)
{
    double la = sqrt(dot(a, a)), lb = sqrt(dot(b, b)), lc = sqrt(dot(c, c));
    double below = la * lb * lc + dot(a, b) * lc + dot(a, c) * lb + dot(b, c) * la;
    return 2 * atan2(dot(a, cross(b, c)), below);
}

static void add_lamp(eye *e, uint32_t triangle)
{
    const rsv_scene_view *s = e->scene;
    const rsv_material *m = &s->material[s->triangle_material[triangle]];
    double luminance = cli_luminous(m->emission);
    if (!(luminance > 0) || m->unlit) return;
    rsv_vec3 corner[3], centre = { 0, 0, 0 };
    for (int k = 0; k < 3; k++) {
        rsv_vec3 place = s->position[s->triangle[triangle][k]];
        centre = along(centre, 1.0f / 3, place);
        corner[k] = minus(place, e->place);
    }
    double solid_angle = -solid_angle_of(corner[0], corner[1], corner[2]); // above 0 in front
    if (m->double_sided) solid_angle = fabs(solid_angle);
    if (!(solid_angle > 0) || !sees(e, centre)) return;
    add_source(e, unit(minus(centre, e->place)), luminance * luminance * solid_angle,
        luminance * solid_angle);
}

static cli_observer rate(eye *e, double vertical)
{
    for (size_t k = 0; k < e->scene->light_count; k++) {
        const rsv_punctual_light *l = &e->scene->light[k];
        if (l->kind == RSV_PUNCTUAL_LUMINAIRE) add_luminaire(e, l);
    }
    for (uint32_t t = 0; t < e->scene->triangle_count; t++)
        add_lamp(e, t);
    cli_observer o = { .vertical = vertical, .sources = e->sources, .ugr = -INFINITY };
    o.background = fmax(vertical - e->direct, 0) / M_PI;
    if (e->sum > 0) o.ugr = 8 * log10(0.25 / fmax(o.background, 1e-6) * e->sum);
    return o;
}

rsv_status cli_rate_observers(const rsv_light *light, const rsv_probe *probe, size_t count,
    uint32_t samples, cli_observer *observer)
{
    const rsv_scene *scene = rsv_light_scene(light);
    rsv_tracer *tracer = NULL;
    rsv_probe_desc desc = rsv_default_probe_desc();
    rsv_probe_reading *reading = calloc(count, sizeof *reading);
    desc.samples = samples;
    rsv_status status = reading ? rsv_tracer_create(scene, &tracer) : RSV_ERROR_MEMORY;
    if (status == RSV_OK) status = rsv_probe_irradiance(light, &desc, probe, count, reading);
    for (size_t k = 0; status == RSV_OK && k < count; k++) {
        eye e = eye_of(rsv_scene_get_view(scene), tracer, &probe[k]);
        observer[k] = rate(&e, cli_luminous(reading[k].irradiance));
    }
    rsv_tracer_destroy(tracer);
    free(reading);
    return status;
}
