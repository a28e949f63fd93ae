/// Cancels a solve half-way and starts it again, as a program does while its user drags a slider.
#include <resolvent/resolvent.h>

#include <stdio.h>
#include <string.h>

typedef struct patience {
    bool short_of_it; ///< stops at a third of the rows
    int reports;
} patience;

static bool look(void *user, const char *phase, double fraction)
{
    patience *p = (patience *)user;
    p->reports++;
    return !(p->short_of_it && strcmp(phase, "assemble") == 0 && fraction > 0.33);
}

int main(void)
{
    patience p = { true, 0 };
    rsv_context *context = NULL;
    rsv_scene *scene = NULL;
    rsv_light *light = NULL;
    rsv_context_desc own = rsv_default_context_desc();
    own.progress = look;
    own.user = &p;
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_status status = rsv_context_create(&own, &context);
    if (status == RSV_OK) status = rsv_scene_builtin(context, "cornell-blocks", &scene);
    if (status == RSV_OK) status = rsv_light_create(scene, &solve, &light);
    bool stopped = status == RSV_ERROR_CANCELLED;
    if (stopped) {
        printf("stopped after %d reports: %s\n", p.reports, rsv_last_error());
        p.short_of_it = false;
        status = rsv_context_reset_cancel(context);
        if (status == RSV_OK) status = rsv_light_create(scene, &solve, &light);
    }
    if (status == RSV_OK)
        printf("solved: %zu elements\n", rsv_light_report(light)->elements);
    else
        fprintf(stderr, "error: %s\n", rsv_last_error());
    rsv_light_destroy(light);
    rsv_scene_destroy(scene);
    rsv_context_destroy(context);
    return status != RSV_OK || !stopped;
}
