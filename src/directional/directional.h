/// Light by direction: the radiance that arrives at each receiver, as a small map of its hemisphere, for glossy lobes.
///
/// A row of G knows from where each share of its light comes: ray k of a row has a direction of its own. Added up by
/// direction instead of all together, the exitance at the ends of the rays makes a map of incoming radiance, in one pass
/// over the rows. Like irradiance, maps are linear in the light.
///
/// They hold indirect light: what diffuse surfaces send, straight or by way of mirrors and glass. What comes from
/// sources - lamps, surroundings, and both in mirrors - is left out: whoever draws highlights has closed forms for it.
#ifndef RSV_DIRECTIONAL_H
#define RSV_DIRECTIONAL_H

#include "../elements/elements.h"
#include "../operator/transport.h"

typedef struct rsv_directional rsv_directional;

/// Black maps for the receivers of an operator. Both must outlive them.
rsv_status rsv_directional_create(
    const rsv_elements *elements, const rsv_transport *transport, rsv_directional **directional);
void rsv_directional_destroy(rsv_directional *directional); ///< NULL is allowed

/// Fills the maps with the light that surfaces send now.
/// @param exitance [node_count] K E, those of hanging nodes too (rsv_light_view_exitance)
rsv_status rsv_directional_refresh(rsv_directional *directional, const rsv_rgb *exitance);

/// Memory of all maps, and receivers that have one.
size_t rsv_directional_bytes(const rsv_directional *directional);
size_t rsv_directional_count(const rsv_directional *directional);

/// A place where light is looked up, between three nodes as irradiance is (rsv_elements_locate).
typedef struct rsv_directional_place {
    uint32_t node[3];
    float weight[3]; ///< sum 1
    rsv_vec3
        normal; ///< unit; the smooth normal of the surface on the side of the nodes, not bent by a normal map
} rsv_directional_place;

/// A GGX lobe of reflection.
typedef struct rsv_directional_lobe {
    rsv_vec3 normal;   ///< unit; of the microsurface, bent by a normal map or not
    rsv_vec3 outgoing; ///< unit; towards the eye
    float alpha;       ///< width, roughness^2
} rsv_directional_lobe;

/// Mean of the radiance over the lobe: that of D G cos, what a white microsurface without Fresnel's factor reflects
/// divided by what it would reflect of an even radiance of 1. What lies below the surface is black. The caller scales by
/// the lobe's albedo.
rsv_rgb rsv_directional_look_up(const rsv_directional *directional,
    const rsv_directional_place *place, const rsv_directional_lobe *lobe);

#define RSV_DIRECTIONAL_LANES 16

/// Sixteen lookups side by side, 64-byte aligned. Lanes that are not in use hold any nodes, and finite numbers.
typedef struct rsv_directional_packet {
    uint32_t node[3][16];
    float weight[3][16];
    float surface_x[16], surface_y[16], surface_z[16];    ///< as rsv_directional_place.normal
    float normal_x[16], normal_y[16], normal_z[16];       ///< as rsv_directional_lobe
    float outgoing_x[16], outgoing_y[16], outgoing_z[16]; ///< likewise
    float alpha[16];
    float red[16], green[16], blue[16]; ///< out
} __attribute__((aligned(64))) rsv_directional_packet;

/// The same as sixteen times rsv_directional_look_up, but for rounding.
void rsv_directional_look_up_packet(
    const rsv_directional *directional, rsv_directional_packet *packet);

#endif
