/// Materials for packets of specular paths: which surfaces are smooth, and the media between them by number.
///
/// A medium is the list of bodies that a point is in (surface/medium.h). A scene has few of them, so they are listed,
/// together with the medium that follows at the surface of each body.
#ifndef RSV_SPECULAR_MEDIA_H
#define RSV_SPECULAR_MEDIA_H

#include "../specular/specular_walk.h"
#include "packet_kernels.h"
#include "resolvent/frame.h"

/// Media and bodies in the list at most; specular paths among others are followed one by one.
#define RSV_MEDIA 253
#define RSV_MEDIA_BODIES 64

/// A medium that is not in the list. Numbers between are those of eyes in such media.
#define RSV_MEDIUM_UNLISTED 255

typedef struct rsv_material_traits {
    uint8_t body; ///< row of the tables below
    bool smooth;  ///< the same everywhere, and nothing but ideal mirror or glass
} rsv_material_traits;

/// Rows of the tables: bodies, then surfaces that are not those of bodies, and bodies left out.
typedef uint8_t rsv_medium_table[RSV_MEDIA_BODIES + 2][RSV_MEDIUM_UNLISTED + 1];

typedef struct rsv_specular_media {
    rsv_context *context;
    const rsv_transport_scene *scene;
    rsv_material_traits *material; ///< [material_count]
    rsv_medium medium[RSV_MEDIUM_UNLISTED + 1];
    float ior[RSV_MEDIUM_UNLISTED + 1];
    bool absorbs[RSV_MEDIUM_UNLISTED + 1];
    uint32_t count;
    rsv_medium_table inside;   ///< once a specular path has arrived at the body's back
    rsv_medium_table cross[2]; ///< beyond its surface, arriving at its front or back
} rsv_specular_media;

/// Hits of a packet's rays, and their specular paths.
typedef struct rsv_arrival {
    const rsv_ray_packet *rays;
    const rsv_packet_places *places;
    uint32_t left; ///< lanes whose ends are not in the table
    rsv_specular_lanes *paths;
} rsv_arrival;

rsv_status rsv_specular_media_create(
    rsv_context *context, const rsv_transport_scene *scene, rsv_specular_media *media);
void rsv_specular_media_destroy(rsv_specular_media *media);

/// Updates the materials; bodies stay bodies.
void rsv_specular_media_refresh(rsv_specular_media *media);

/// Number of an eye's medium, for this frame.
uint8_t rsv_specular_media_of_eye(
    rsv_specular_media *media, uint32_t eye, const rsv_medium *medium);

/// rsv_specular_end_segment for lanes that have hit a surface, and the throughput of all. Ends of rays at surfaces that
/// are not in the table know their material; those in the table are not bodies.
/// @param lanes that have hit one @param spread of all specular paths
/// @return lanes in a medium that is not listed, which are unchanged
uint32_t rsv_specular_media_arrive(
    const rsv_specular_media *media, const rsv_arrival *arrival, uint32_t lanes, float spread);

/// Number of the medium into which a specular path at a surface is transmitted.
RSV_INLINE uint8_t rsv_specular_media_beyond(
    const rsv_specular_media *media, const rsv_specular_lanes *paths, uint32_t lane)
{
    uint8_t body = media->material[paths->material[lane]].body;
    return media->cross[paths->back[lane]][body][paths->medium[lane]];
}

#endif
