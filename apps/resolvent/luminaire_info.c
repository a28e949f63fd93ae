#include "luminaire_info.h"

#include "output_file.h"

#include "resolvent/luminaire.h"

#include <cJSON.h>
#include <stdio.h>

bool cli_is_luminaire(const char *path)
{
    return cli_ends_in(path, ".ies") || cli_ends_in(path, ".ldt");
}

static const char *type_name(const rsv_luminaire *l)
{
    return l->type == RSV_PHOTOMETRY_C ? "C" : l->type == RSV_PHOTOMETRY_B ? "B" : "A";
}

static void print_text(const char *path, const rsv_luminaire *l)
{
    double flux = rsv_luminaire_flux(l);
    printf("%s: luminaire%s%s, photometry of type %s\n", path, l->name[0] ? " " : "", l->name,
        type_name(l));
    printf("angles     %u vertical (%g to %g), %u horizontal (%g to %g)\n", l->vertical_count,
        (double)l->vertical[0], (double)l->vertical[l->vertical_count - 1], l->horizontal_count,
        (double)l->horizontal[0], (double)l->horizontal[l->horizontal_count - 1]);
    printf("flux       %.6g lm, integrated over the sphere\n", flux);
    if (l->lamp_lumens > 0)
        printf("lamps      %.6g lm, of which %.4g %% leave\n", l->lamp_lumens,
            100 * flux / l->lamp_lumens);
    else
        printf("lamps      absolute photometry\n");
    printf("peak       %.6g cd\n", rsv_luminaire_peak(l));
    if (l->watts > 0) printf("power      %.6g W, %.4g lm/W\n", l->watts, flux / l->watts);
    printf("opening    %g x %g x %g m (width, length, height)\n", l->width, l->length, l->height);
}

static bool print_json(const char *path, const rsv_luminaire *l)
{
    cJSON *root = cJSON_CreateObject();
    cJSON_AddStringToObject(root, "luminaire", path);
    cJSON_AddStringToObject(root, "name", l->name);
    cJSON_AddStringToObject(root, "type", type_name(l));
    cJSON_AddNumberToObject(root, "vertical_angles", l->vertical_count);
    cJSON_AddNumberToObject(root, "horizontal_angles", l->horizontal_count);
    cJSON_AddNumberToObject(root, "flux", rsv_luminaire_flux(l));
    cJSON_AddNumberToObject(root, "lamp_flux", l->lamp_lumens);
    cJSON_AddNumberToObject(root, "peak", rsv_luminaire_peak(l));
    cJSON_AddNumberToObject(root, "watts", l->watts);
    const double size[3] = { l->width, l->length, l->height };
    cJSON_AddItemToObject(root, "opening", cJSON_CreateDoubleArray(size, 3));
    bool written = root && cli_write_json(NULL, root);
    cJSON_Delete(root);
    return written;
}

bool cli_print_luminaire(cli_session *session, const char *path, bool json)
{
    rsv_luminaire luminaire;
    rsv_status status = rsv_luminaire_read(session->context, path, &luminaire);
    bool printed = status == RSV_OK;
    if (!printed)
        cli_report_failure(session, status);
    else if (json)
        printed = print_json(path, &luminaire);
    else
        print_text(path, &luminaire);
    rsv_luminaire_free(session->context, &luminaire);
    return printed;
}
