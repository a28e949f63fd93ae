/// Light in the vertices of a glTF file.
#include "../core/parallel.h"
#include "../core/sampling.h"
#include "../core/vec.h"
#include "bake_basis.h"
#include "bake_constants.h"
#include "bake_judge.h"
#include "bake_lattice.h"
#include "bake_mend.h"
#include "bake_open.h"
#include "bake_operator.h"
#include "bake_primitive.h"
#include "bake_relit.h"
#include "bake_smooth.h"
#include "bake_target.h"

#include <string.h>

#define PI_F 3.14159265f

typedef struct vertex_bake {
    const rsv_light_view *s;
    const rsv_bake_desc *desc;
    rsv_bake_document document;
    rsv_bake_parts parts;
    cJSON **primitive;   ///< [parts.count]
    rsv_bake_mesh *mesh; ///< [parts.count]; without vertices = carries no light
    rsv_bake_smooth smooth;
    rsv_bake_cover cover;
    float finest;  ///< metres: triangles are not divided below
    float **old;   ///< [parts.count] colours that vertices had; NULL = white
    size_t *width; ///< [parts.count] numbers in one of these
    rsv_bake_receiver
        *receiver;  ///< [vertex_count] of all parts, as written; where a basis or an operator is
    rsv_rgb *whole; ///< [vertex_count] light of all sources there
    size_t vertex_count;
} vertex_bake;

/// Lower limit of the light to which errors are relative, W/m2.
static float dark_of(const rsv_light_view *s) { return DARK * (float)s->report.mean_irradiance; }

/// Divides all parts. @param tessellator out, [parts.count]; NULL = carries no light
static rsv_status divide(vertex_bake *b, rsv_bake_tessellator **tessellator)
{
    rsv_status status = RSV_OK;
    const rsv_light_view *s = b->s;
    rsv_bake_tessellation desc = { .tolerance = b->desc->tolerance,
        .finest = b->finest,
        .accuracy = { f_min(b->desc->error, QUIET * b->desc->tolerance),
            LARGEST_DEVIATION * b->desc->error, dark_of(s), s->desc.seed } };
    for (size_t k = 0; k < b->parts.count; k++) {
        if (!rsv_bake_carries_light(s, &b->parts.part[k])) continue;
        desc.divide = rsv_bake_may_divide(b->primitive[k]);
        RSV_TRY(rsv_bake_tessellator_create(
            &b->smooth.view, &b->parts.part[k], &desc, &b->mesh[k], &tessellator[k]));
        RSV_TRY(rsv_progress(s->context, "bake", (double)(k + 1) / (double)b->parts.count));
    }
cleanup:
    return status;
}

/// Largest coordinate of the scene, which determines rounding.
static float extent_of(const rsv_scene_view *view)
{
    float largest = 0;
    for (size_t n = 0; n < view->vertex_count; n++)
        largest = f_max(largest, v3_max_abs(view->position[n]));
    return largest;
}

static rsv_status tessellate(vertex_bake *b)
{
    rsv_status status;
    rsv_bake_borders borders = { .context = b->s->context };
    float near = f_max(ON_EDGE * b->finest, ROUNDED * extent_of(b->s->scene.view));
    rsv_bake_tessellator **tessellator =
        rsv_alloc(b->s->context, b->parts.count, sizeof *tessellator);
    RSV_TRY(tessellator ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(divide(b, tessellator));
    for (size_t k = 0; k < b->parts.count; k++)
        if (tessellator[k]) RSV_TRY(rsv_bake_tessellator_border(tessellator[k], &borders));
    RSV_TRY(rsv_bake_borders_sort(&borders, near, 8 * b->finest));
    for (size_t k = 0; k < b->parts.count; k++)
        if (tessellator[k]) RSV_TRY(rsv_bake_tessellator_write(tessellator[k], &borders));
cleanup:
    for (size_t k = 0; tessellator && k < b->parts.count; k++)
        rsv_bake_tessellator_destroy(tessellator[k]);
    rsv_free(b->s->context, tessellator);
    rsv_bake_borders_destroy(&borders);
    return status;
}

/// A vertex's light, with corrected stored light. @param smooth the view from which its light was read
/// @param least luminance to which errors are relative
static rsv_rgb mended(const vertex_bake *b, const rsv_light_view *smooth,
    const rsv_bake_patch *patch, rsv_rgb light, float least)
{
    const rsv_surface_place *at = &patch->place[0];
    rsv_vec3 p =
        rsv_surface_point_at(b->s->scene.view, at->triangle, at->u, at->v, at->back).position;
    float total = f_max(rgb_luminance(light), least), step = b->finest / 16;
    uint32_t number = rsv_hash3(
        (uint32_t)lrintf(p.x / step), (uint32_t)lrintf(p.y / step), (uint32_t)lrintf(p.z / step));
    rsv_rgb change = rsv_bake_mend(smooth, patch, total, rsv_hash2(b->s->desc.seed, number));
    return rgb_positive(rgb_add(light, change));
}

typedef struct mend_job {
    const vertex_bake *bake;
    const rsv_bake_mesh *mesh;
} mend_job;

static void mend_vertices(void *job, rsv_span span)
{
    const vertex_bake *b = ((const mend_job *)job)->bake;
    const rsv_bake_mesh *mesh = ((const mend_job *)job)->mesh;
    for (size_t n = span.begin; n < span.end; n++) {
        rsv_bake_patch patch;
        if (mesh->receiver[n].triangle == RSV_NONE || rsv_cancelled(b->s->context)) continue;
        rsv_bake_vertex_patch(&b->smooth.view, &mesh->receiver[n], b->finest, &patch);
        if (rsv_bake_keep_open(&b->cover, &patch))
            mesh->light[n] = mended(b, &b->smooth.view, &patch, mesh->light[n], dark_of(b->s));
    }
}

/// Mends indirect light where elements do not show it well.
static rsv_status mend(const vertex_bake *b)
{
    rsv_context *context = b->s->context;
    for (size_t k = 0; k < b->parts.count; k++) {
        mend_job job = { b, &b->mesh[k] };
        rsv_parallel_for(context, b->mesh[k].vertex_count, 16, mend_vertices, &job);
    }
    return rsv_cancelled(context) ? RSV_ERROR_CANCELLED : RSV_OK;
}

/// The radiance of a white surface that 1 stands for, which colours of vertices may not exceed.
static float find_scale(const vertex_bake *b)
{
    float most = 0, white = UNLIT_WHITE * (float)b->s->report.mean_irradiance / PI_F;
    if (b->desc->light_scale > 0) return b->desc->light_scale;
    for (size_t k = 0; k < b->parts.count; k++)
        for (size_t n = 0; n < b->mesh[k].vertex_count; n++)
            most = f_max(most, rgb_max(b->mesh[k].light[n]) / PI_F);
    if (b->desc->unlit && white > 0) most = f_min(most, white);
    return most > 0 ? most : 1;
}

/// Share of the vertices that are brighter than 1.
static double find_saturated(const vertex_bake *b, float scale)
{
    size_t brighter = 0, all = 0;
    for (size_t k = 0; k < b->parts.count; k++)
        for (size_t n = 0; n < b->mesh[k].vertex_count; n++, all++)
            brighter += rgb_max(b->mesh[k].light[n]) > PI_F * scale * SAME;
    return all ? (double)brighter / (double)all : 0;
}

/// Vertices that keep the order of the file: those that no triangle uses stay dark.
static rsv_status restore_order(
    vertex_bake *b, size_t k, rsv_bake_receiver **receiver, rsv_rgb **light)
{
    const rsv_bake_mesh *mesh = &b->mesh[k];
    size_t count = mesh->changed ? mesh->vertex_count : b->parts.part[k].vertex_count;
    *receiver = rsv_alloc(b->s->context, count, sizeof **receiver);
    *light = rsv_alloc(b->s->context, count, sizeof **light);
    if (!*receiver || !*light) return RSV_ERROR_MEMORY;
    for (size_t n = 0; n < count; n++)
        (*receiver)[n].triangle = RSV_NONE;
    for (size_t n = 0; n < mesh->vertex_count; n++) {
        size_t to = mesh->changed ? n : mesh->attribute[n];
        (*receiver)[to] = mesh->receiver[n];
        (*light)[to] = mesh->light[n];
    }
    return RSV_OK;
}

/// Puts the light of a mesh in the order in which it is written.
static rsv_status settle(vertex_bake *b, size_t k)
{
    rsv_bake_mesh *mesh = &b->mesh[k];
    rsv_bake_receiver *receiver;
    rsv_rgb *light;
    rsv_status status = restore_order(b, k, &receiver, &light);
    rsv_free(b->s->context, mesh->receiver);
    rsv_free(b->s->context, mesh->light);
    mesh->receiver = receiver;
    mesh->light = light;
    if (!mesh->changed) mesh->vertex_count = b->parts.part[k].vertex_count;
    return status;
}

/// COLOR_0: light times the vertices' own colour, which stays in the file as _COLOR for relighting.
static rsv_status write_colors(vertex_bake *b, size_t k, float scale)
{
    const rsv_bake_mesh *mesh = &b->mesh[k];
    const float *old = b->old[k];
    size_t width = b->width[k];
    cJSON *attributes = cJSON_GetObjectItemCaseSensitive(b->primitive[k], "attributes");
    float *color = rsv_alloc(b->s->context, mesh->vertex_count, width * sizeof *color);
    if (!color) return RSV_ERROR_MEMORY;
    for (size_t n = 0; n < mesh->vertex_count; n++)
        for (size_t c = 0; c < width; c++) {
            float light = c < 3 ? f_min((&mesh->light[n].r)[c] / (PI_F * scale), 1) : 1;
            color[n * width + c] = old ? light * old[n * width + c] : light;
        }
    if (old && mesh->changed) // they are in the file already
        rsv_bake_number(&b->document, attributes, "_COLOR",
            cJSON_GetObjectItemCaseSensitive(attributes, "COLOR_0")->valuedouble);
    else if (old)
        rsv_bake_number(&b->document, attributes, "_COLOR",
            rsv_bake_add_floats(&b->document, old, mesh->vertex_count, (int)width, false));
    rsv_bake_number(&b->document, attributes, "COLOR_0",
        rsv_bake_add_floats(&b->document, color, mesh->vertex_count, (int)width, false));
    rsv_free(b->s->context, color);
    return RSV_OK;
}

/// Writes the vertices of a part, without their light.
static rsv_status write_part(vertex_bake *b, size_t k)
{
    rsv_status status;
    const rsv_bake_part *part = &b->parts.part[k];
    RSV_TRY(rsv_bake_read_colors(
        &b->document, b->primitive[k], part, &b->mesh[k], &b->old[k], &b->width[k]));
    if (b->mesh[k].changed)
        RSV_TRY(rsv_bake_replace_vertices(&b->document, b->primitive[k], part, &b->mesh[k]));
    RSV_TRY(settle(b, k));
cleanup:
    return status;
}

/// Removes other scattering models, which an unlit material may not have.
static void drop_models(cJSON *material)
{
    cJSON *extensions = cJSON_GetObjectItemCaseSensitive(material, "extensions");
    cJSON *next, *extension = extensions ? extensions->child : NULL;
    for (; extension; extension = next) {
        next = extension->next;
        if (strncmp(extension->string, "KHR_materials_", 14) == 0)
            cJSON_Delete(cJSON_DetachItemViaPointer(extensions, extension));
    }
}

static void mark_unlit(vertex_bake *b, const cJSON *primitive, const rsv_bake_part *part)
{
    const rsv_scene_view *view = b->s->scene.view;
    cJSON *material = rsv_bake_material(&b->document, primitive);
    const rsv_material *m = NULL;
    for (size_t t = 0; t < part->triangle_count && !m; t++)
        if (part->triangle[t] != RSV_NONE)
            m = &view->material[view->triangle_material[part->triangle[t]]];
    // emissive materials, and those that are not only diffuse, need their own material
    bool plain = m && rgb_is_black(m->emission) && m->metallic == 0 && m->transmission == 0;
    if (!material || !plain) return;
    drop_models(material);
    rsv_bake_extension(&b->document, material, "KHR_materials_unlit");
}

/// Writes the meaning of the file's numbers.
static void write_scale(rsv_bake_document *d, float scale)
{
    cJSON *own = rsv_bake_object(
        d, rsv_bake_object(d, rsv_bake_object(d, d->root, "asset"), "extras"), "resolvent");
    rsv_bake_string(d, own, "light", "COLOR_0 = irradiance / (pi light_scale)");
    rsv_bake_number(d, own, "light_scale", (double)scale);
}

/// Marks primitives that carry light, as opposed to those with their own colours, with their first receiver.
static void mark_lit(vertex_bake *b)
{
    static const char mark[] = "resolvent_first_receiver";
    size_t first = 0;
    for (size_t k = 0; k < b->parts.count; k++) {
        cJSON *primitive = b->primitive[k];
        if (b->mesh[k].vertex_count)
            rsv_bake_number(&b->document, rsv_bake_object(&b->document, primitive, "extras"), mark,
                (double)first);
        else // of an earlier bake
            cJSON_DeleteItemFromObjectCaseSensitive(
                cJSON_GetObjectItemCaseSensitive(primitive, "extras"), mark);
        first += b->mesh[k].vertex_count;
    }
}

static rsv_status write_parts(vertex_bake *b)
{
    rsv_status status;
    b->old = rsv_alloc(b->s->context, b->parts.count, sizeof *b->old);
    b->width = rsv_alloc(b->s->context, b->parts.count, sizeof *b->width);
    RSV_TRY(b->old && b->width ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t k = 0; k < b->parts.count; k++)
        if (b->mesh[k].vertex_count) RSV_TRY(write_part(b, k));
    mark_lit(b);
cleanup:
    return status;
}

static rsv_status write_light(vertex_bake *b, float scale)
{
    rsv_status status = RSV_OK;
    for (size_t k = 0; k < b->parts.count; k++) {
        if (!b->mesh[k].vertex_count) continue;
        RSV_TRY(write_colors(b, k, scale));
        if (b->desc->unlit) mark_unlit(b, b->primitive[k], &b->parts.part[k]);
    }
    write_scale(&b->document, scale);
cleanup:
    return status;
}

/// Lists the vertices one after the other, in the order of the file's nodes.
static rsv_status list_receivers(vertex_bake *b)
{
    size_t at = 0;
    for (size_t k = 0; k < b->parts.count; k++)
        b->vertex_count += b->mesh[k].vertex_count;
    b->receiver = rsv_alloc(b->s->context, b->vertex_count, sizeof *b->receiver);
    b->whole = rsv_alloc(b->s->context, b->vertex_count, sizeof *b->whole);
    if (!b->receiver || !b->whole) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < b->parts.count; k++) {
        const rsv_bake_mesh *mesh = &b->mesh[k];
        if (!mesh->vertex_count) continue;
        memcpy(b->receiver + at, mesh->receiver, mesh->vertex_count * sizeof *mesh->receiver);
        memcpy(b->whole + at, mesh->light, mesh->vertex_count * sizeof *mesh->light);
        at += mesh->vertex_count;
    }
    return RSV_OK;
}

/// Light of one source at all vertices.
typedef struct read_job {
    const vertex_bake *bake;
    rsv_bake_smooth smooth;
    rsv_bake_lamps lamps; ///< of the smooth view
    rsv_bake_cover cover;
    rsv_rgb *value; ///< [vertex_count] out
} read_job;

static rsv_rgb read_vertex(const read_job *job, size_t n)
{
    const vertex_bake *b = job->bake;
    const rsv_light_view *light = &job->smooth.view;
    rsv_bake_patch patch;
    if (b->receiver[n].triangle == RSV_NONE || rsv_cancelled(light->context)) return rgb_gray(0);
    rsv_bake_vertex_patch(light, &b->receiver[n], b->finest, &patch);
    bool open = rsv_bake_keep_open(&job->cover, &patch);
    float error = b->desc->error * dark_of(b->s) / DARK;
    rsv_rgb value =
        rsv_bake_light_patch(&job->lamps, &patch, error, rsv_hash2(b->s->desc.seed, (uint32_t)n));
    float least = f_max(PART_OF_WHOLE * rgb_luminance(b->whole[n]), dark_of(b->s));
    return open ? mended(b, light, &patch, value, least) : value;
}

static void read_span(void *data, rsv_span span)
{
    const read_job *job = data;
    for (size_t n = span.begin; n < span.end; n++)
        job->value[n] = read_vertex(job, n);
}

static rsv_status read_vertices(
    const rsv_bake_reader *reader, const rsv_light_view *light, rsv_rgb *value)
{
    rsv_status status;
    read_job job = { .bake = reader->receiver,
        .lamps = { .light = &job.smooth.view },
        .cover = rsv_bake_cover_of(light),
        .value = value };
    RSV_TRY(rsv_bake_smooth_create(light, &job.smooth));
    RSV_TRY(rsv_bake_sources_create(light->context, light->lights, &job.lamps.sources));
    rsv_parallel_for(light->context, job.bake->vertex_count, 64, read_span, &job);
cleanup:
    rsv_bake_sources_destroy(&job.lamps.sources);
    rsv_bake_smooth_destroy(&job.smooth);
    if (status == RSV_OK && rsv_cancelled(light->context)) status = RSV_ERROR_CANCELLED;
    return status;
}

/// Writes the contribution of each light; vertices become their sums.

static rsv_status write_basis(vertex_bake *b, const char *output, size_t *lights)
{
    rsv_bake_reader reader = rsv_bake_surface_reader("vertex", b, b->vertex_count, read_vertices);
    rsv_rgb *sum = rsv_alloc(b->s->context, b->vertex_count, sizeof *sum);
    if (!sum) return RSV_ERROR_MEMORY;
    reader.sum = sum;
    rsv_status status = rsv_bake_write_basis(b->s, &reader, b->desc, output, lights);
    size_t at = 0;
    for (size_t k = 0; k < b->parts.count && status == RSV_OK; k++) {
        if (!b->mesh[k].vertex_count) continue;
        memcpy(b->mesh[k].light, sum + at, b->mesh[k].vertex_count * sizeof *sum);
        at += b->mesh[k].vertex_count;
    }
    rsv_free(b->s->context, sum);
    return status;
}

/// The files for the runtime.
static rsv_status write_for_runtime(vertex_bake *b, const char *output, size_t *lights)
{
    rsv_status status;
    RSV_TRY(list_receivers(b));
    if (b->desc->basis) RSV_TRY(write_basis(b, output, lights));
    if (b->desc->operator_file)
        RSV_TRY(rsv_bake_write_operator(b->s, "vertex", b->receiver, b->vertex_count, output));
cleanup:
    return status;
}

static void show_vertex(const vertex_bake *b, const rsv_bake_visitor *visitor,
    const rsv_bake_receiver *receiver, rsv_bake_value value)
{
    rsv_bake_patch patch;
    rsv_bake_vertex_patch(b->s, receiver, b->finest, &patch);
    if (!rsv_bake_keep_open(&b->cover, &patch)) return;
    value.place = patch.place;
    value.place_count = patch.count;
    value.translucent = !rsv_bake_is_sampled(b->s, &patch.place[0]);
    visitor->take(visitor->user, &value);
}

/// Shows a visitor the vertices that triangles use.
static void show_vertices(const vertex_bake *b, const rsv_bake_visitor *visitor)
{
    uint32_t size[2] = { 0, 1 }, at[2] = { 0, 0 };
    for (size_t k = 0; k < b->parts.count; k++)
        size[0] += (uint32_t)b->mesh[k].vertex_count;
    for (size_t k = 0; k < b->parts.count; k++)
        for (size_t n = 0; n < b->mesh[k].vertex_count; n++, at[0]++) {
            const rsv_bake_receiver *receiver = &b->mesh[k].receiver[n];
            const rsv_bake_value value = { .at = { at[0], 0 }, .irradiance = b->mesh[k].light[n] };
            if (receiver->triangle != RSV_NONE && visitor->wants(visitor->user, at, size))
                show_vertex(b, visitor, receiver, value);
        }
}

static rsv_status judge(const vertex_bake *b, rsv_bake_report *report)
{
    rsv_bake_judge judge;
    rsv_status status = rsv_bake_judge_create(b->s, b->desc->judged, &judge);
    if (status == RSV_OK && judge.wanted) {
        show_vertices(b, &judge.visitor);
        status = rsv_bake_judge_finish(&judge, dark_of(b->s), report);
    }
    rsv_bake_judge_destroy(&judge);
    return status;
}

static void fill_report(const vertex_bake *b, float scale, rsv_bake_report *report)
{
    report->light_scale = scale;
    report->saturated = find_saturated(b, scale);
    for (size_t k = 0; k < b->parts.count; k++) {
        report->vertices += b->mesh[k].vertex_count;
        report->triangles += b->mesh[k].triangle_count;
        if (b->mesh[k].vertex_count) report->input_triangles += b->parts.part[k].triangle_count;
    }
}

static rsv_status open_document(vertex_bake *b)
{
    rsv_status status;
    RSV_TRY(rsv_bake_check_operator(b->s, b->desc));
    RSV_TRY(rsv_bake_document_open(b->s->scene.scene, &b->document));
    RSV_TRY(rsv_bake_parts_create(&b->document, b->s, &b->parts));
    RSV_TRY(rsv_bake_separate(&b->document, &b->parts, &b->primitive));
    RSV_TRY(rsv_bake_follow_relight(b->s, &b->parts, b->primitive, &b->document));
    RSV_TRY(rsv_bake_smooth_create(b->s, &b->smooth));
    b->mesh = rsv_alloc(b->s->context, b->parts.count, sizeof *b->mesh);
    RSV_TRY(b->mesh ? RSV_OK : RSV_ERROR_MEMORY);
cleanup:
    return status;
}

static void close_document(vertex_bake *b)
{
    rsv_context *context = b->s->context;
    for (size_t k = 0; b->mesh && k < b->parts.count; k++)
        if (b->mesh[k].context) rsv_bake_mesh_destroy(&b->mesh[k]);
    for (size_t k = 0; b->old && k < b->parts.count; k++)
        rsv_free(context, b->old[k]);
    rsv_free(context, b->mesh);
    rsv_free(context, b->old);
    rsv_free(context, b->width);
    rsv_free(context, b->receiver);
    rsv_free(context, b->whole);
    rsv_free(context, b->primitive);
    rsv_bake_smooth_destroy(&b->smooth);
    rsv_bake_parts_destroy(&b->parts);
    rsv_bake_document_close(&b->document);
}

static rsv_status write_vertices(const rsv_light_view *solution, const rsv_bake_desc *desc,
    const char *output, rsv_bake_report *report)
{
    rsv_status status;
    vertex_bake b = { .s = solution,
        .desc = desc,
        .cover = rsv_bake_cover_of(solution),
        .finest = solution->elements->spacing / (float)(1 << solution->desc.direct_levels) };
    RSV_TRY(open_document(&b));
    RSV_TRY(tessellate(&b));
    RSV_TRY(mend(&b));
    float scale = find_scale(&b);
    if (!desc->dry_run) {
        RSV_TRY(write_parts(&b));
        if (desc->basis || desc->operator_file)
            RSV_TRY(write_for_runtime(&b, output, &report->lights));
        scale = find_scale(&b);
        RSV_TRY(write_light(&b, scale));
    }
    fill_report(&b, scale, report);
    if (desc->visitor) show_vertices(&b, desc->visitor);
    RSV_TRY(judge(&b, report));
    if (!desc->dry_run) RSV_TRY(rsv_bake_document_write(&b.document, output));
cleanup:
    close_document(&b);
    return status;
}

const rsv_bake_target rsv_bake_target_vertex = { ".glb", write_vertices };
