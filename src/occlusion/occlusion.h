/// The two forms of ambient occlusion.
#ifndef RSV_OCCLUSION_H
#define RSV_OCCLUSION_H

#include "occlusion_view.h"

rsv_status rsv_render_ray_occlusion(const rsv_occlusion_job *job);
rsv_status rsv_render_screen_occlusion(const rsv_occlusion_job *job);

rsv_status rsv_occlusion_screen_create(rsv_occlusion *occlusion);
void rsv_occlusion_screen_destroy(rsv_occlusion *occlusion);

#endif
