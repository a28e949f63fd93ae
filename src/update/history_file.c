#include "history_file.h"

#include "../core/key.h"
#include "element_keys.h"

#include <stdio.h>
#include <string.h>

/// Finds a table in memory. @return the position behind it
static uint8_t *place_table(
    rsv_history_table *table, uint64_t slots, size_t value_bytes, uint8_t *memory)
{
    table->slots = slots;
    table->value_bytes = value_bytes;
    table->key = (uint64_t *)memory;
    table->value = memory + slots * sizeof *table->key;
    return table->value + (slots * value_bytes + 7) / 8 * 8;
}

static uint8_t *place_cells(
    rsv_history_cells *cells, uint64_t face_count, uint64_t slot_count, uint8_t *memory)
{
    cells->face_count = face_count;
    cells->slot_count = slot_count;
    cells->face = (rsv_history_face *)memory;
    cells->slot = (uint32_t *)(cells->face + face_count);
    cells->openness = (uint8_t *)(cells->slot + slot_count);
    return memory + (face_count * sizeof *cells->face + slot_count * 5 + 7) / 8 * 8;
}

rsv_history_layout rsv_history_layout_of(const rsv_history_header *h)
{
    uint8_t *start = (uint8_t *)h, *at = start + sizeof *h;
    rsv_history_layout l = { .triangle = (rsv_history_triangle *)at };
    at += h->triangle_count * sizeof *l.triangle;
    for (int level = 0; level < RSV_HISTORY_LEVELS; level++) {
        size_t value =
            level == RSV_HISTORY_COARSE ? sizeof(rsv_history_node) : sizeof(rsv_history_light);
        at = place_cells(&l.cells[level], h->faces[level], h->slots[level], at);
        at = place_table(&l.nodes[level], h->nodes[level], value, at);
    }
    l.bytes = (size_t)(at - start);
    return l;
}

uint64_t rsv_history_checksum(const rsv_history_header *h, size_t bytes)
{
    rsv_history_header header = *h;
    header.checksum = 0;
    uint64_t sum = rsv_key_add_bytes(h->magic, &header, sizeof header);
    return rsv_key_add_bytes(sum, h + 1, bytes - sizeof header);
}

void rsv_history_name(uint64_t settings, char name[RSV_STORE_NAME_BYTES])
{
    snprintf(name, RSV_STORE_NAME_BYTES, "%016llx.history", (unsigned long long)settings);
}

static uint64_t add_numbers(uint64_t key, const float *number, size_t count)
{
    return rsv_key_add_bytes(key, number, count * sizeof *number);
}

static uint64_t add_color(uint64_t key, rsv_rgb c)
{
    return add_numbers(key, (const float[]){ c.r, c.g, c.b }, 3);
}

static uint64_t add_environment(uint64_t key, const rsv_environment *e)
{
    if (!e) return key;
    key = rsv_key_add(key, (uint64_t)e->width << 32 | e->height);
    key = add_numbers(key, &e->rotation, 1);
    return rsv_key_add_bytes(key, e->pixels, (size_t)e->width * e->height * sizeof *e->pixels);
}

/// Orientation and emission of a luminaire.
static uint64_t add_luminaire(
    uint64_t key, const rsv_scene_view *scene, const rsv_punctual_light *light)
{
    const rsv_luminaire *l = &scene->luminaire[light->luminaire];
    key = rsv_key_add_vector(rsv_key_add_vector(key, light->side), light->opening);
    key = rsv_key_add(rsv_key_add(key, (uint64_t)l->type), l->vertical_count);
    key = add_numbers(key, l->vertical, l->vertical_count);
    key = add_numbers(key, l->horizontal, l->horizontal_count);
    return add_numbers(key, l->intensity, (size_t)l->vertical_count * l->horizontal_count);
}

uint64_t rsv_history_lights_key(const rsv_lights *lights)
{
    uint64_t key = rsv_key_add(1, lights->sampled_count);
    for (size_t k = 0; k < lights->emitter_count; k++) {
        const rsv_emitter *e = &lights->emitter[k];
        if (e->varies) return RSV_HISTORY_NO_LIGHTS;
        for (int corner = 0; corner < 3; corner++)
            key = rsv_key_add_vector(key, e->corner[corner]);
        key = rsv_key_add(add_color(key, e->radiance), lights->group[e->group].gathered);
        key = rsv_key_add(key, e->double_sided);
    }
    for (size_t k = 0; k < lights->scene->light_count; k++) {
        const rsv_punctual_light *l = &lights->scene->light[k];
        key = rsv_key_add_vector(rsv_key_add(key, (uint64_t)l->kind), l->position);
        key = add_color(rsv_key_add_vector(key, l->direction), l->intensity);
        const float shape[] = { l->inner_cone_angle, l->outer_cone_angle, l->exponent };
        key = add_numbers(key, shape, 3);
        if (l->kind == RSV_PUNCTUAL_LUMINAIRE) key = add_luminaire(key, lights->scene, l);
    }
    return add_environment(key, lights->scene->environment);
}

void rsv_history_triangle_box(
    const rsv_scene_view *scene, uint32_t triangle, rsv_vec3 *low, rsv_vec3 *high)
{
    const uint32_t *corner = scene->triangle[triangle];
    *low = *high = scene->position[corner[0]];
    for (int k = 1; k < 3; k++) {
        *low = v3_min(*low, scene->position[corner[k]]);
        *high = v3_max(*high, scene->position[corner[k]]);
    }
}
