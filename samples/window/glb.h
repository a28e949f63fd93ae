/// As much of a baked glTF file as it takes to show its light: triangles, colours, where they are in the lightmap, one
/// camera.
#ifndef GLB_H
#define GLB_H

#include <stdint.h>

/// Triangles of one material.
typedef struct glb_part {
    const char *name;      ///< of the material
    float base_color[4];   ///< linear; the last one covers
    float cutoff;          ///< texels of less coverage are transparent
    float emission[3];     ///< radiance of a lamp, as baked
    int mapped;            ///< its light is in the lightmap
    uint32_t first, count; ///< into glb_scene.index
} glb_part;

/// With light in vertices, these come in the order of the receivers in the file's light basis; those without baked light
/// follow. With light in a map, receivers are its texels.
typedef struct glb_scene {
    char message[160]; ///< the last error
    unsigned char *bytes;
    struct cJSON *json;
    uint32_t receiver_count, vertex_count, index_count, part_count, node_count;
    uint32_t lit_count;             ///< vertices that carry baked light
    uint32_t map_width, map_height; ///< of the lightmap; 0 = light is in vertices
    float (*position)[3];           ///< [vertex_count] metres, in the world
    float (*color)[4]; ///< [vertex_count] that vertices had before the bake; white if none
    float (*place)[2]; ///< [vertex_count] in the lightmap
    uint32_t *index;   ///< [index_count] three of each triangle
    glb_part *part;
    float camera[16];        ///< camera to world, column by column
    float fov, aspect;       ///< vertical, radians; width over height
    float nearest, farthest; ///< metres that are shown
} glb_scene;

/// @param receivers of the light basis that was baked with it
/// @return 0, or -1 with scene->message; glb_free it in either case
int glb_load(glb_scene *scene, const char *path, uint32_t receivers);
void glb_free(glb_scene *scene);

#endif
