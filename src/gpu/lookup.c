#include "lookup.h"

void rsv_gpu_lookup_place(rsv_gpu_lookup *l, size_t triangle_count, rsv_gpu_block *b)
{
    const rsv_elements *e = l->host;
    rsv_elements *to = &l->elements;
    l->there = rsv_gpu_place(b, 1, sizeof *l->there);
    to->face_level = rsv_gpu_place(b, e->face_count, sizeof *e->face_level);
    to->face_slot = rsv_gpu_place(b, e->face_count, sizeof *e->face_slot);
    to->slot = rsv_gpu_place(b, e->slot_count, sizeof *e->slot);
    to->cell_node = rsv_gpu_place(b, e->cell_count, sizeof *e->cell_node);
    to->cell_cut = e->cell_cut ? rsv_gpu_place(b, e->cell_count, sizeof *e->cell_cut) : NULL;
    to->cut_side = e->cell_cut ? rsv_gpu_place(b, e->cut_count, sizeof *e->cut_side) : NULL;
    for (int back = 0; back < 2; back++)
        to->face_of[back] = rsv_gpu_place(b, triangle_count, sizeof *e->face_of[back]);
}

void rsv_gpu_lookup_upload(const rsv_gpu_lookup *l, size_t triangle_count, rsv_gpu *gpu)
{
    const rsv_elements *e = l->host, *to = &l->elements;
    const rsv_gpu_array array[] = { { l->there, to, 1, sizeof *to },
        { to->face_level, e->face_level, e->face_count, sizeof *e->face_level },
        { to->face_slot, e->face_slot, e->face_count, sizeof *e->face_slot },
        { to->slot, e->slot, e->slot_count, sizeof *e->slot },
        { to->cell_node, e->cell_node, e->cell_count, sizeof *e->cell_node },
        { to->face_of[0], e->face_of[0], triangle_count, sizeof *e->face_of[0] },
        { to->face_of[1], e->face_of[1], triangle_count, sizeof *e->face_of[1] } };
    const rsv_gpu_array cuts[] = { { to->cell_cut, e->cell_cut, e->cell_count,
                                       sizeof *e->cell_cut },
        { to->cut_side, e->cut_side, e->cut_count, sizeof *e->cut_side } };
    rsv_gpu_upload_all(gpu, array, sizeof array / sizeof array[0]);
    if (e->cell_cut) rsv_gpu_upload_all(gpu, cuts, sizeof cuts / sizeof cuts[0]);
}
