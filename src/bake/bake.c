/// Targets by name.
#include "../core/descriptor.h"
#include "bake_basis.h"
#include "bake_desc.h"
#include "bake_sky.h"
#include "bake_target.h"

#include <string.h>

#define RSV_BAKE_TARGET(name) extern const rsv_bake_target rsv_bake_target_##name;
#include "bake_targets.inc"
#undef RSV_BAKE_TARGET

static const struct {
    const char *name;
    const rsv_bake_target *target;
} targets[] = {
#define RSV_BAKE_TARGET(name) { #name, &rsv_bake_target_##name },
#include "bake_targets.inc"
#undef RSV_BAKE_TARGET
};

enum { TARGETS = sizeof targets / sizeof *targets };

const char *const *rsv_bake_target_names(void)
{
    static const char *const names[] = {
#define RSV_BAKE_TARGET(name) #name,
#include "bake_targets.inc"
#undef RSV_BAKE_TARGET
        NULL
    };
    return names;
}

static const rsv_bake_target *find_target(const char *name)
{
    for (size_t k = 0; k < TARGETS; k++)
        if (strcmp(targets[k].name, name) == 0) return targets[k].target;
    return NULL;
}

const char *rsv_bake_target_extension(const char *name)
{
    const rsv_bake_target *target = find_target(name);
    return target ? target->extension : NULL;
}

static bool ends_in(const char *text, const char *end)
{
    size_t length = strlen(text), least = strlen(end);
    return length > least && strcmp(text + length - least, end) == 0;
}

rsv_status rsv_bake(const rsv_light *solution, const char *name, const char *output,
    const rsv_bake_desc *desc, rsv_bake_report *report)
{
    const rsv_bake_target *target = find_target(name);
    rsv_bake_desc settings = rsv_default_bake_desc();
    rsv_bake_report unread;
    if (!report) report = &unread;
    *report = (rsv_bake_report){ 0 };
    if (!target) return rsv_fail(RSV_ERROR_ARGUMENT, "bake: there is no target '%s'", name);
    if (!ends_in(output, target->extension))
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "bake: '%s' does not end in %s", output, target->extension);
    rsv_status status;
    const rsv_light_view *light = rsv_light_get_view(solution);
    RSV_TRY(RSV_READ_DESC(rsv_bake_desc, &settings, desc));
    RSV_TRY(rsv_bake_check_desc(&settings));
    if (settings.sky) RSV_TRY(rsv_bake_check_sky(light));
    RSV_TRY(rsv_bake_check_lights(light, &settings));
    RSV_TRY(target->write(light, &settings, output, report));
    if (settings.sky && !settings.dry_run) RSV_TRY(rsv_bake_write_sky(light, output));
cleanup:
    return status;
}

rsv_status rsv_bake_vertices(const rsv_light *solution, const char *output,
    const rsv_bake_desc *desc, rsv_bake_report *report)
{
    return rsv_bake(solution, "vertex", output, desc, report);
}

rsv_status rsv_bake_lightmap(const rsv_light *solution, const char *output,
    const rsv_bake_desc *desc, rsv_bake_report *report)
{
    return rsv_bake(solution, "lightmap", output, desc, report);
}

rsv_status rsv_bake_probes(const rsv_light *solution, const char *output, const rsv_bake_desc *desc,
    rsv_bake_report *report)
{
    return rsv_bake(solution, "probes", output, desc, report);
}
