#include "gltf_luminaire.h"
#include "gltf_texture.h"

#include "../core/vec.h"

rsv_status rsv_gltf_read_luminaire(
    rsv_context *context, const rsv_gltf_document *document, int index, rsv_luminaire *luminaire)
{
    *luminaire = (rsv_luminaire){ 0 };
    if (index < 0 || (size_t)index >= document->luminaire_count)
        return rsv_fail(RSV_ERROR_FORMAT, "luminaire %d does not exist", index);
    rsv_image_file file;
    const rsv_gltf_image *image = &document->luminaire[index];
    const char *problem = rsv_gltf_find_bytes(document, image, &file);
    if (problem)
        return rsv_fail(RSV_ERROR_FORMAT, "cannot read luminaire '%s': %s", image->name, problem);
    return rsv_luminaire_parse(
        context, image->name, (const char *)file.bytes, file.size, luminaire);
}

static rsv_vec3 axis_of(const double m[16], int axis)
{
    rsv_vec3 v = v3((float)m[4 * axis], (float)m[4 * axis + 1], (float)m[4 * axis + 2]);
    return v3_length(v) > 0 ? v3_normalize(v) : v;
}

bool rsv_gltf_luminaire_light(const rsv_gltf_node *node, const double world[16],
    const rsv_luminaire *luminaire, rsv_punctual_light *light)
{
    rsv_vec3 direction = v3_neg(axis_of(world, 2)), side = axis_of(world, 0);
    *light = rsv_luminaire_light(luminaire, 0);
    light->name = node->name;
    light->direction = direction;
    light->side = v3_normalize(v3_mad(side, -v3_dot(side, direction), direction));
    light->intensity = rgb_mul(light->intensity, node->luminaire_scale);
    light->opening = node->opening; // a point by that extension
    return v3_length(direction) > 0 && v3_length(light->side) > 0.5f;
}
