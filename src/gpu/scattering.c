#include "scattering.h"

#include <stdlib.h>

rsv_status rsv_gpu_scattering_create(size_t count, rsv_gpu_scattering *s, char *message)
{
    *s = (rsv_gpu_scattering){ .count = count };
    s->host = rsv_gpu_new((count + 1) * sizeof *s->host, message);
    return s->host ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_gpu_scattering_destroy(rsv_gpu_scattering *s)
{
    free(s->host);
    *s = (rsv_gpu_scattering){ .count = 0 };
}

void rsv_gpu_scattering_place(rsv_gpu_scattering *s, rsv_gpu_block *b)
{
    s->bsdf = rsv_gpu_place(b, s->count, sizeof *s->bsdf);
    s->tables = rsv_gpu_place(b, 1, sizeof *s->tables);
}

void rsv_gpu_scattering_upload(const rsv_gpu_scattering *s, const rsv_bsdf *bsdf, rsv_gpu *gpu)
{
    if (s->count == 0) return;
    for (size_t m = 0; m < s->count; m++) {
        s->host[m] = bsdf[m];
        s->host[m].tables = s->tables;
    }
    rsv_gpu_upload(gpu, s->tables, bsdf->tables, sizeof *s->tables); // all share them
    rsv_gpu_upload(gpu, s->bsdf, s->host, s->count * sizeof *s->bsdf);
}
