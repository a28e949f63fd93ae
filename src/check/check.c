/// The scene as a whole.
#include "check_internal.h"

#include "../core/vec.h"
#include "../scene/scene.h"

#include <stdarg.h>
#include <stdio.h>

enum { MOST_OF_A_KIND = 8 };

#define TINY 0.05f ///< metres of a scene's diagonal
#define VAST 2e4f  ///< likewise

const char *rsv_mistake_name(rsv_mistake mistake)
{
    static const char *const names[RSV_MISTAKES] = { "scale", "no_light", "backs", "flipped_faces",
        "doubled_faces", "open_seams", "leaks" };
    return (unsigned)mistake < RSV_MISTAKES ? names[mistake] : "unknown";
}

rsv_status rsv_check_tell(
    rsv_checker *c, const rsv_finding *finding, const char *where, const char *format, ...)
{
    rsv_status status;
    va_list arguments;
    if (c->told[finding->mistake]++ >= MOST_OF_A_KIND) return RSV_OK;
    RSV_TRY(
        rsv_grow(c->context, (void **)&c->finding, &c->capacity, c->count + 1, sizeof *c->finding));
    rsv_finding *added = &c->finding[c->count++];
    *added = *finding;
    snprintf(added->where, sizeof added->where, "%s", where);
    va_start(arguments, format);
    vsnprintf(added->text, sizeof added->text, format, arguments);
    va_end(arguments);
cleanup:
    return status;
}

static rsv_status check_scale(rsv_checker *c)
{
    float size = v3_length(v3_sub(c->view->bounds_max, c->view->bounds_min));
    const rsv_finding found = { .mistake = RSV_MISTAKE_SCALE, .amount = (double)size };
    if (c->view->triangle_count == 0 || (size >= TINY && size <= VAST)) return RSV_OK;
    return rsv_check_tell(c, &found, "",
        "the scene is %.3g m from corner to corner: is the unit of the file right? its lights "
        "assume metres",
        (double)size);
}

static rsv_status check_light(rsv_checker *c)
{
    const rsv_finding found = { .mistake = RSV_MISTAKE_NO_LIGHT };
    if (rsv_scene_shines(c->view)) return RSV_OK;
    return rsv_check_tell(c, &found, "",
        "there is no light: no lamp, no emission, no environment; export lights, or use --env sky");
}

rsv_status rsv_scene_check(const rsv_scene *scene, rsv_finding **findings, size_t *count)
{
    rsv_status status;
    rsv_checker c = {
        .context = rsv_scene_get_context(scene), .scene = scene, .view = rsv_scene_get_view(scene)
    };
    *findings = NULL;
    *count = 0;
    RSV_TRY(rsv_scene_require_committed(scene));
    RSV_TRY(check_scale(&c));
    RSV_TRY(check_light(&c));
    RSV_TRY(rsv_check_views(&c));
    RSV_TRY(rsv_check_edges(&c));
    RSV_TRY(rsv_check_doubled(&c));
    *findings = c.finding;
    *count = c.count;
    c.finding = NULL;
cleanup:
    rsv_free(c.context, c.finding);
    return status;
}

void rsv_findings_release(const rsv_scene *scene, rsv_finding *findings)
{
    rsv_free(rsv_scene_get_context(scene), findings);
}
