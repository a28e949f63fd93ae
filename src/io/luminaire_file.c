/// Measured luminaires from files, in place of lights.
#include "../core/core.h"
#include "../scene/scene.h"
#include "resolvent/io.h"

rsv_status rsv_scene_load_luminaires(
    rsv_scene *scene, const rsv_load_luminaire *wanted, size_t count)
{
    rsv_status status = RSV_OK;
    for (size_t k = 0; k < count && status == RSV_OK; k++) {
        rsv_luminaire luminaire;
        status = rsv_luminaire_read(scene->context, wanted[k].path, &luminaire);
        if (status == RSV_OK) status = rsv_scene_place_luminaire(scene, wanted[k].name, &luminaire);
        rsv_luminaire_free(scene->context, &luminaire);
    }
    return status;
}
