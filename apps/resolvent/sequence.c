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

static void scale_pixels(rsv_image *image, float factor)
{
    size_t count = (size_t)rsv_image_width(image) * rsv_image_height(image);
    for (uint32_t layer = 0; layer < rsv_image_layer_count(image); layer++) {
        rsv_rgb *p = rsv_image_pixels(image, layer);
        for (size_t k = 0; k < count; k++)
            p[k] = (rsv_rgb){ factor * p[k].r, factor * p[k].g, factor * p[k].b };
    }
}

static void add_pixels(const rsv_image *image, rsv_image *sum)
{
    size_t count = (size_t)rsv_image_width(sum) * rsv_image_height(sum);
    for (uint32_t layer = 0; layer < rsv_image_layer_count(sum); layer++) {
        const rsv_rgb *p = rsv_image_const_pixels(image, layer);
        rsv_rgb *q = rsv_image_pixels(sum, layer);
        for (size_t k = 0; k < count; k++)
            q[k] = (rsv_rgb){ q[k].r + p[k].r, q[k].g + p[k].g, q[k].b + p[k].b };
    }
}

void cli_add_moment(const cli_sequence *s, rsv_image *image, rsv_image **mean)
{
    uint32_t moments = cli_moments_of_frame(s);
    if (moments > 1) scale_pixels(image, 1.0f / (float)moments);
    if (!*mean) {
        *mean = image;
        return;
    }
    add_pixels(image, *mean);
    rsv_image_destroy(image);
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
