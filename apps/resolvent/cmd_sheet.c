#include "command.h"
#include "options.h"
#include "session.h"
#include "sheet.h"

#include "resolvent/image.h"

#include <math.h>

static const char help[] =
    "usage: resolvent sheet IN... -o SHEET.{png,hdr,exr} [options]\n"
    "\n"
    "Arranges pictures of the same size (.exr, .hdr, .png, .jpg) side by side, in reading order.\n"
    "\n"
    "  -o FILE            the sheet\n"
    "  --columns N        pictures per row (default 3)\n"
    "  --exposure STOPS   brighten by 2^STOPS (default 0)\n"
    "\n"
    "examples:\n"
    "  resolvent compare judge.exr ours.exr -o difference.exr\n"
    "  resolvent sheet judge.exr ours.exr difference.exr -o sheet.png\n"
    "  resolvent sheet day-000.png day-012.png day-024.png day-036.png -o day.png --columns 2\n";

enum { max_count = 64 };

typedef struct settings {
    const char *input[max_count], *output;
    uint32_t columns;
    float exposure;
} settings;

static uint32_t input_count(const settings *s)
{
    uint32_t count = 0;
    while (count < max_count && s->input[count])
        count++;
    return count;
}

/// Reads one picture and pastes it; the first one makes the sheet.
static rsv_status add_picture(
    rsv_context *context, const settings *s, uint32_t place, rsv_image **sheet, rsv_image **first)
{
    rsv_image *image = NULL;
    rsv_status status = rsv_image_read(context, s->input[place], &image);
    if (status != RSV_OK) return status;
    if (place == 0) {
        *first = image;
        status = cli_sheet_create(context, image, input_count(s), s->columns, sheet);
    }
    bool fits = rsv_image_width(image) == rsv_image_width(*first) &&
                rsv_image_height(image) == rsv_image_height(*first);
    if (status == RSV_OK && fits) cli_sheet_paste(*sheet, image, 0, 1, place, s->columns);
    if (status == RSV_OK && !fits) {
        cli_error("%s: is %u x %u pixels, not %u x %u as %s", s->input[place],
            rsv_image_width(image), rsv_image_height(image), rsv_image_width(*first),
            rsv_image_height(*first), s->input[0]);
        status = RSV_ERROR_ARGUMENT;
    }
    if (place > 0) rsv_image_destroy(image);
    return status;
}

static int run(cli_session *session, const settings *s)
{
    rsv_image *sheet = NULL, *first = NULL;
    rsv_status status = RSV_OK;
    for (uint32_t i = 0; i < input_count(s) && status == RSV_OK; i++)
        status = add_picture(session->context, s, i, &sheet, &first);
    if (status == RSV_OK) status = rsv_image_write(sheet, s->output, s->exposure);
    if (status != RSV_OK && status != RSV_ERROR_ARGUMENT) cli_report_failure(session, status);
    rsv_image_destroy(first);
    rsv_image_destroy(sheet);
    return status == RSV_OK ? CLI_SUCCESS : CLI_FAILURE;
}

int cli_sheet(int argc, char **argv)
{
    settings s = { .columns = 3 };
    const cli_option options[] = {
        { .name = "-o", .kind = CLI_TEXT, .value = &s.output },
        { .name = "--columns", .kind = CLI_COUNT, .value = &s.columns, .min = 1, .max = 64 },
        { .name = "--exposure", .kind = CLI_REAL, .value = &s.exposure, .min = -64, .max = 64 },
        { .name = NULL },
    };
    const cli_usage usage = { "sheet", help, options, "IN", 1, max_count, NULL };
    int exit_status;
    if (!cli_parse(&usage, argc, argv, s.input, &exit_status)) return exit_status;
    if (!s.output) return cli_usage_error("sheet", "-o SHEET.{png,hdr,exr} is missing");
    if (s.columns > input_count(&s)) s.columns = input_count(&s);
    if (rsv_image_check_output(s.output) != RSV_OK) {
        cli_error("%s", rsv_last_error());
        return CLI_FAILURE;
    }
    cli_session session;
    if (!cli_session_begin(&session, 0)) return CLI_FAILURE;
    exit_status = run(&session, &s);
    cli_session_end(&session);
    return exit_status;
}
