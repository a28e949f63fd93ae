#include "document.h"

#include "scene.h"

rsv_status rsv_scene_set_document(rsv_scene *scene, const char *name, uint8_t *bytes, size_t count)
{
    char *copy = rsv_copy_string(scene->context, name);
    if (!copy) {
        rsv_free(scene->context, bytes);
        return RSV_ERROR_MEMORY;
    }
    rsv_scene_drop_document(scene);
    scene->document = (rsv_scene_document){ copy, bytes, count };
    return RSV_OK;
}

const rsv_scene_document *rsv_scene_find_document(const rsv_scene *scene)
{
    while (scene->base)
        scene = scene->base;
    return scene->document.bytes ? &scene->document : NULL;
}

bool rsv_scene_has_document(const rsv_scene *scene)
{
    return rsv_scene_find_document(scene) != NULL;
}

void rsv_scene_drop_document(rsv_scene *scene)
{
    if (scene->base) return; // a variant's is its base's
    rsv_free(scene->context, scene->document.name);
    rsv_free(scene->context, scene->document.bytes);
    scene->document = (rsv_scene_document){ 0 };
}
