#include "sequence.h"

void cli_add_update(rsv_update_report *sum, const rsv_update_report *update)
{
    sum->rows += update->rows;
    sum->kept_rows += update->kept_rows;
    sum->row_rays += update->row_rays;
    sum->kept_row_rays += update->kept_row_rays;
    sum->seconds += update->seconds;
}

void cli_write_updates(cJSON *stats, const rsv_update_report *sum)
{
    cJSON_AddNumberToObject(stats, "rows_of_all_frames", (double)sum->rows);
    cJSON_AddNumberToObject(stats, "kept_rows_of_all_frames", (double)sum->kept_rows);
    cJSON_AddNumberToObject(stats, "row_rays_of_all_frames", (double)sum->row_rays);
    cJSON_AddNumberToObject(stats, "kept_row_rays_of_all_frames", (double)sum->kept_row_rays);
    cJSON_AddNumberToObject(stats, "update_seconds", sum->seconds);
}

rsv_status cli_follow_frame(
    rsv_light *light, const rsv_scene *scene, bool finished, rsv_update_report *sum)
{
    rsv_update_report update = { 0 };
    rsv_status status = rsv_light_follow(light, scene, &update);
    if (status == RSV_OK && finished)
        status = rsv_light_follow(light, scene, NULL); // as if it rested
    if (status == RSV_OK) cli_add_update(sum, &update);
    return status;
}

bool cli_run_frames(cli_session *session, const cli_sequence *s,
    bool (*run)(void *user, uint32_t frame), void *user)
{
    uint32_t count = s->last - s->first + 1;
    for (uint32_t k = 0; k < count; k++) {
        if (count > 1) cli_progress_part(&session->progress, "frame", k + 1, count);
        if (!run(user, s->first + k)) return false;
    }
    return true;
}
