/// Chains of specular events that start at a light, in double precision.
#ifndef RSV_CONNECT_INTERNAL_H
#define RSV_CONNECT_INTERNAL_H

#include "../sources/double3.h"
#include "../sources/punctual_light.h"
#include "connect.h"

#define RSV_CHAIN_EVENTS 12 ///< at most

typedef enum rsv_chain_kind {
    RSV_CHAIN_MIRRORS,
    RSV_CHAIN_PASSES,
    RSV_CHAIN_REFRACTS
} rsv_chain_kind;

typedef struct rsv_chain_event {
    uint32_t triangle;
    uint8_t kind; ///< rsv_chain_kind
    bool back;    ///< light arrives at the back
} rsv_chain_event;

/// A place that light comes from: a punctual light, or a part of a luminaire's opening.
typedef struct rsv_connect_source {
    const rsv_punctual_light *light;
    rsv_vec3 place;    ///< of distant ones: a point outside the scene
    rsv_medium medium; ///< around it
    float share;       ///< of the light
} rsv_connect_source;

typedef struct rsv_double_ray {
    rsv_double3 origin, direction; ///< unit
} rsv_double_ray;

/// Rays of a source around a given one: for a point light by direction, for a directional light by origin.
typedef struct rsv_chain_seed {
    rsv_double_ray ray;
    bool distant;
} rsv_chain_seed;

typedef struct rsv_chain {
    uint32_t source;
    uint32_t first, count; ///< events
    rsv_channel channel;
    rsv_chain_seed seed;
} rsv_chain;

/// Where the seed's ray leaves a chain, with its derivatives by u and v, which tell whether neighbouring rays approach
/// a point.
typedef struct rsv_chain_beam {
    rsv_vec3 origin, direction, origin_u, origin_v, direction_u, direction_v;
    float extent; ///< range of u and v; INFINITY = unknown
} rsv_chain_beam;

/// Chains that were found from a source.
typedef struct rsv_chain_list {
    rsv_chain *chain;     ///< [count]
    rsv_chain_beam *beam; ///< [count]
    rsv_chain_event *event;
    size_t count, capacity, beam_capacity, event_count, event_capacity;
} rsv_chain_list;

struct rsv_connections {
    rsv_context *context;
    rsv_transport_scene scene;
    const rsv_lights *lights;
    rsv_connect_source *source; ///< [source_count]
    rsv_chain_list *list;       ///< [source_count]
    size_t source_count;
    double radius; ///< of the scene
    bool disperses;
};

/// Where a chain's ray meets an event's plane.
typedef struct rsv_chain_hit {
    rsv_double3 position, direction; ///< as it leaves
    double u, v;                     ///< barycentric, also outside of the triangle
} rsv_chain_hit;

uint8_t rsv_chain_kind_of(const rsv_transport_scene *scene, uint32_t triangle, bool transmit);

/// The ray at u, v from the seed.
rsv_double_ray rsv_chain_start(const rsv_chain_seed *seed, double u, double v);

/// Follows a ray by the planes of the events. @param hit [count] out @return whether it gets to the end
bool rsv_chain_follow(const rsv_connections *c, const rsv_chain *chain,
    const rsv_chain_event *event, rsv_double_ray *ray, rsv_chain_hit *hit);

/// How the ray at u, v leaves, and its derivatives.
bool rsv_chain_differentiate(const rsv_connections *c, const rsv_chain *chain,
    const rsv_chain_event *event, const double at[2], rsv_double_ray end[3]);

/// Lists the chains of all sources.
rsv_status rsv_chains_find(rsv_connections *c);

/// Extent of the first triangle around the seed.

double rsv_chain_extent(const rsv_connections *c, const rsv_chain_seed *seed, uint32_t triangle);

/// A ray as it leaves a source. @param path out, at the first surface @return whether it meets one
bool rsv_chain_set_out(const rsv_connections *c, const rsv_connect_source *source,
    const rsv_double_ray *ray, rsv_channel channel, rsv_specular_path *path);

#endif
