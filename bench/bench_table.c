#include "benchmarks.h"
#include "output_file.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

bool cli_write_columns(
    const char *path, const cJSON *rows, const char *const *columns, size_t column_count)
{
    char *text = NULL;
    size_t length = 0;
    FILE *csv = open_memstream(&text, &length);
    if (!csv) return false;
    fputs("scene", csv);
    for (size_t i = 0; i < column_count; i++)
        fprintf(csv, ",%s", columns[i]);
    const cJSON *row;
    cJSON_ArrayForEach(row, rows)
    {
        fprintf(csv, "\n%s", cJSON_GetStringValue(cJSON_GetObjectItem(row, "scene")));
        for (size_t i = 0; i < column_count; i++)
            if (isfinite(cli_json_number(row, columns[i])))
                fprintf(csv, ",%.6g", cli_json_number(row, columns[i]));
            else
                fputc(',', csv); // not measured
    }
    fputc('\n', csv);
    bool written = fclose(csv) == 0 && cli_write_file(path, text, length);
    free(text);
    return written;
}
