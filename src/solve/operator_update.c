/// Updates in memory: each solve reads the results of the previous one, and stores its own separately until it is done.
#include "../core/descriptor.h"
#include "builder.h"
#include "resolvent/update.h"

struct rsv_update_store {
    rsv_context *context;
    rsv_store *kept; ///< of the last solve that was finished; NULL = there was none
};

rsv_status rsv_update_store_create(rsv_context *context, rsv_update_store **store)
{
    rsv_update_store *s = rsv_alloc(context, 1, sizeof *s);
    if (!s) return RSV_ERROR_MEMORY;
    s->context = context;
    *store = s;
    return RSV_OK;
}

void rsv_update_store_destroy(rsv_update_store *s)
{
    if (!s) return;
    rsv_store_destroy(s->kept);
    rsv_free(s->context, s);
}

void rsv_update_store_clear(rsv_update_store *s)
{
    rsv_store_destroy(s->kept);
    s->kept = NULL;
}

size_t rsv_update_store_bytes(const rsv_update_store *s)
{
    return s->kept ? s->kept->table->bytes(s->kept) : 0;
}

static void fill_report(const rsv_light *light, double seconds, rsv_update_report *report)
{
    const rsv_solve_report *r = &light->report;
    *report = light->update;
    report->rows = r->rows;
    report->row_rays = r->row_rays;
    report->kept_row_rays = r->kept_row_rays;
    report->spared_seconds = r->kept_row_rays ? r->spared_seconds : 0;
    report->seconds = seconds;
}

static rsv_status check(const rsv_scene *scene, const rsv_solve_desc *desc)
{
    if (desc->checkpoint || desc->earlier)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "update: the settings name a folder (checkpoint or earlier); an update keeps its "
            "results in its store: leave both NULL");
    return rsv_check_settings(scene, desc);
}

rsv_status rsv_operator_update(const rsv_scene *scene, const rsv_solve_desc *desc,
    rsv_update_store *store, rsv_light **solution, rsv_update_report *report)
{
    rsv_solve_desc settings = rsv_default_solve_desc(RSV_QUALITY_MEDIUM);
    double start = rsv_seconds();
    rsv_store *next = NULL;
    rsv_status status;
    RSV_TRY(RSV_READ_DESC(rsv_solve_desc, &settings, desc));
    RSV_TRY(check(scene, &settings));
    RSV_TRY(rsv_store_memory(store->context, &next));
    RSV_TRY(rsv_light_build(scene, &settings, next, store->kept, solution));
    rsv_store_destroy(store->kept);
    store->kept = next;
    next = NULL;
    if (report) fill_report(*solution, rsv_seconds() - start, report);
cleanup:
    rsv_store_destroy(next);
    return status;
}
