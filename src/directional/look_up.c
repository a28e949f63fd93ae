#include "../core/instructions.h"
#include "look_up_kernels.h"

const rsv_look_up_kernels *rsv_look_up_kernels_best(void)
{
#if defined(__x86_64__)
    if (rsv_cpu_has_avx512()) return &rsv_look_up_kernels_avx512;
    if (rsv_cpu_has_avx2()) return &rsv_look_up_kernels_avx2;
#endif
    return &rsv_look_up_kernels_portable;
}

void rsv_directional_look_up_packet(const rsv_directional *d, rsv_directional_packet *p)
{
    d->kernels->look_up(d, RSV_DIRECTIONAL_LANES, p);
}

rsv_rgb rsv_directional_look_up(
    const rsv_directional *d, const rsv_directional_place *place, const rsv_directional_lobe *lobe)
{
    rsv_directional_packet p = { 0 };
    for (int k = 0; k < 3; k++)
        p.node[k][0] = place->node[k], p.weight[k][0] = place->weight[k];
    p.surface_x[0] = place->normal.x, p.surface_y[0] = place->normal.y;
    p.surface_z[0] = place->normal.z;
    p.normal_x[0] = lobe->normal.x, p.normal_y[0] = lobe->normal.y, p.normal_z[0] = lobe->normal.z;
    p.outgoing_x[0] = lobe->outgoing.x, p.outgoing_y[0] = lobe->outgoing.y;
    p.outgoing_z[0] = lobe->outgoing.z;
    p.alpha[0] = lobe->alpha;
    d->kernels->look_up(d, 1, &p);
    return rgb(p.red[0], p.green[0], p.blue[0]);
}
