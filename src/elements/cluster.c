#include "cluster.h"

#include "../core/parallel.h"
#include "elements_constants.h"
#include "elements_internal.h"

#include <string.h>

/// Leaders that reach a node, the nearest ones.
typedef struct leaders {
    uint32_t node[RSV_PARENTS]; ///< by distance; RSV_NONE = free
    float distance[RSV_PARENTS];
} leaders;

/// A node on the way out from a leader.
typedef struct front_node {
    float distance;
    uint32_t node;
} front_node;

typedef struct clustering {
    rsv_elements *e;
    float *radius;            ///< [node_count]
    rsv_vec3 *place, *normal; ///< [node_count]
    uint8_t *fine;            ///< [node_count] may follow
    leaders *led;             ///< [node_count]
    float *distance;          ///< [node_count] from the leader in hand
    float reach;              ///< of that leader
    front_node *front;        ///< binary heap, nearest first
    size_t front_count, front_capacity;
    uint32_t *visited; ///< nodes whose distance is set
    size_t visited_count, visited_capacity;
} clustering;

static void set_up_node(clustering *c, uint32_t node)
{
    rsv_elements *e = c->e;
    uint32_t begin = e->support_begin[node], end = e->support_begin[node + 1];
    bool fine = begin < end && e->node_hanging[node] == RSV_NONE;
    for (uint32_t s = begin; s < end; s++)
        fine = fine && e->cell[e->support[s] / 4].level == 0;
    c->fine[node] = fine;
    c->radius[node] = e->cluster_radius;
    for (uint32_t s = begin; s < end; s++)
        c->radius[node] = f_min(c->radius[node], rsv_cluster_radius_at(e, e->support[s] / 4));
    c->distance[node] = INFINITY;
    for (int p = 0; p < RSV_PARENTS; p++) {
        c->led[node].node[p] = RSV_NONE;
        c->led[node].distance[p] = INFINITY;
    }
    if (begin == end) return;
    const rsv_cell *cell = &e->cell[e->support[begin] / 4];
    float u, v;
    rsv_cell_corner(cell, (int)(e->support[begin] & 3), &u, &v);
    rsv_surface_point point = rsv_surface_point_at(
        e->scene, e->face_triangle[cell->face], u, v, e->face_back[cell->face]);
    c->place[node] = point.position;
    c->normal[node] = point.normal;
}

static rsv_status push(clustering *c, uint32_t node, float distance)
{
    rsv_status status = rsv_grow(c->e->context, (void **)&c->front, &c->front_capacity,
        c->front_count + 1, sizeof *c->front);
    if (status != RSV_OK) return status;
    size_t at = c->front_count++;
    for (; at > 0 && c->front[(at - 1) / 2].distance > distance; at = (at - 1) / 2)
        c->front[at] = c->front[(at - 1) / 2];
    c->front[at] = (front_node){ distance, node };
    return RSV_OK;
}

static front_node pop(clustering *c)
{
    front_node nearest = c->front[0], last = c->front[--c->front_count];
    size_t at = 0;
    for (size_t child = 1; child < c->front_count; child = 2 * at + 1) {
        if (child + 1 < c->front_count && c->front[child + 1].distance < c->front[child].distance)
            child++;
        if (c->front[child].distance >= last.distance) break;
        c->front[at] = c->front[child];
        at = child;
    }
    c->front[at] = last;
    return nearest;
}

static rsv_status reach(clustering *c, uint32_t node, float distance)
{
    if (distance >= c->distance[node] || distance >= c->reach) return RSV_OK;
    if (c->distance[node] == INFINITY) {
        rsv_status status = rsv_grow(c->e->context, (void **)&c->visited, &c->visited_capacity,
            c->visited_count + 1, sizeof *c->visited);
        if (status != RSV_OK) return status;
        c->visited[c->visited_count++] = node;
    }
    c->distance[node] = distance;
    return push(c, node, distance);
}

static float way(const clustering *c, uint32_t from, uint32_t to)
{
    // 2 asin(chord / 2), to 1 % below a right angle
    float chord = v3_length(v3_sub(c->normal[to], c->normal[from]));
    float turn = chord * (1 + chord * chord / 24);
    return v3_length(v3_sub(c->place[to], c->place[from])) +
           c->e->cluster_radius * turn / TURN_PER_RADIUS;
}

static rsv_status reach_neighbours(clustering *c, uint32_t node, float distance)
{
    const rsv_elements *e = c->e;
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++) {
        const uint32_t *corner = e->cell_node[e->support[s] / 4];
        for (int k = 0; k < 3; k++) {
            if (corner[k] == node) continue;
            rsv_status status = reach(c, corner[k], distance + way(c, node, corner[k]));
            if (status != RSV_OK) return status;
        }
    }
    return RSV_OK;
}

static void add_leader(leaders *led, uint32_t leader, float distance)
{
    if (distance >= led->distance[RSV_PARENTS - 1]) return;
    int p = RSV_PARENTS - 1;
    for (; p > 0 && led->distance[p - 1] > distance; p--) {
        led->node[p] = led->node[p - 1];
        led->distance[p] = led->distance[p - 1];
    }
    led->node[p] = leader;
    led->distance[p] = distance;
}

/// Registers the leader at all nodes within its reach (Dijkstra's algorithm).
static rsv_status lead(clustering *c, uint32_t leader)
{
    c->visited_count = c->front_count = 0;
    c->reach = REACH * c->radius[leader];
    rsv_status status = reach(c, leader, 0);
    while (status == RSV_OK && c->front_count > 0) {
        front_node here = pop(c);
        if (here.distance > c->distance[here.node]) continue; // a shorter way was found since
        // a node with nearer leaders passes those on to its neighbours
        if (here.distance >= c->led[here.node].distance[RSV_PARENTS - 1]) continue;
        add_leader(&c->led[here.node], leader, here.distance);
        status = reach_neighbours(c, here.node, here.distance);
    }
    for (size_t k = 0; k < c->visited_count; k++)
        c->distance[c->visited[k]] = INFINITY;
    return status;
}

static bool touches_fine_node(const clustering *c, uint32_t node)
{
    const rsv_elements *e = c->e;
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++)
        for (int k = 0; k < 3; k++)
            if (c->fine[e->cell_node[e->support[s] / 4][k]]) return true;
    return false;
}

/// Nodes that may not follow lead where they touch those that may; of the others, each that no leader is near.
static rsv_status choose_leaders(clustering *c)
{
    rsv_status status = RSV_OK;
    const rsv_elements *e = c->e;
    for (uint32_t n = 0; n < e->node_count && status == RSV_OK; n++)
        if (!c->fine[n] && e->node_hanging[n] == RSV_NONE && touches_fine_node(c, n))
            status = lead(c, n);
    for (uint32_t n = 0; n < e->node_count && status == RSV_OK; n++) {
        if (!c->fine[n] || c->led[n].distance[0] < c->radius[n]) continue;
        c->fine[n] = 0;
        status = lead(c, n);
    }
    return status;
}

static rsv_hanging follower_of(const clustering *c, uint32_t node)
{
    const leaders *led = &c->led[node];
    rsv_hanging follower = { .node = node };
    float sum = 0;
    for (int p = 0; p < RSV_PARENTS; p++) {
        float closeness = f_max(0, 1 - led->distance[p] / (REACH * c->radius[node]));
        follower.parent[p] = led->node[p] == RSV_NONE ? led->node[0] : led->node[p];
        follower.weight[p] = closeness * closeness;
        sum += follower.weight[p];
    }
    for (int p = 0; p < RSV_PARENTS; p++)
        follower.weight[p] /= sum;
    return follower;
}

/// Lists the followers of each leader: the leader receives the mean of the light that arrives at them.
static rsv_status list_followers(rsv_elements *e)
{
    e->led_begin = rsv_alloc(e->context, e->node_count + 1, sizeof *e->led_begin);
    e->led = rsv_alloc(e->context, e->follower_count * RSV_PARENTS, sizeof *e->led);
    if (!e->led_begin || !e->led) return RSV_ERROR_MEMORY;
    for (size_t h = 0; h < e->follower_count; h++)
        for (int p = 0; p < RSV_PARENTS; p++)
            if (e->hanging[h].weight[p] > 0) e->led_begin[e->hanging[h].parent[p]]++;
    for (size_t n = 0; n < e->node_count; n++)
        e->led_begin[n + 1] += e->led_begin[n];
    for (size_t h = e->follower_count; h-- > 0;) {
        const rsv_hanging *follower = &e->hanging[h];
        for (int p = 0; p < RSV_PARENTS; p++) {
            if (!(follower->weight[p] > 0)) continue;
            // filled from the back, so that led_begin ends up where each list starts
            e->led[--e->led_begin[follower->parent[p]]] =
                (rsv_led){ follower->node, follower->weight[p] };
        }
    }
    return RSV_OK;
}

/// Followers precede the nodes that hang on them: parents come before children.
static rsv_status add_followers(clustering *c)
{
    rsv_elements *e = c->e;
    size_t followers = 0;
    for (size_t n = 0; n < e->node_count; n++)
        followers += c->fine[n];
    if (followers == 0) return RSV_OK;
    size_t count = followers + e->hanging_count, next = 0;
    rsv_hanging *hanging = rsv_alloc(e->context, count, sizeof *hanging);
    if (!hanging) return RSV_ERROR_MEMORY;
    for (uint32_t n = 0; n < e->node_count; n++)
        if (c->fine[n]) hanging[next++] = follower_of(c, n);
    if (e->hanging_count) memcpy(hanging + next, e->hanging, e->hanging_count * sizeof *hanging);
    rsv_free(e->context, e->hanging);
    e->hanging = hanging;
    e->hanging_count = count;
    e->follower_count = followers;
    for (size_t h = 0; h < count; h++)
        e->node_hanging[hanging[h].node] = (uint32_t)h;
    rsv_status status = rsv_elements_renumber(e, e->node_count);
    return status == RSV_OK ? list_followers(e) : status;
}

static void set_up_nodes(void *user, rsv_span span)
{
    for (size_t n = span.begin; n < span.end; n++)
        set_up_node(user, (uint32_t)n);
}

rsv_status rsv_elements_cluster(rsv_elements *e, float radius)
{
    rsv_status status = RSV_ERROR_MEMORY;
    clustering c = { .e = e };
    e->cluster_radius = radius;
    c.radius = rsv_alloc(e->context, e->node_count, sizeof *c.radius);
    c.place = rsv_alloc(e->context, e->node_count, sizeof *c.place);
    c.normal = rsv_alloc(e->context, e->node_count, sizeof *c.normal);
    c.fine = rsv_alloc(e->context, e->node_count, sizeof *c.fine);
    c.led = rsv_alloc(e->context, e->node_count, sizeof *c.led);
    c.distance = rsv_alloc(e->context, e->node_count, sizeof *c.distance);
    if (!c.radius || !c.place || !c.normal || !c.fine || !c.led || !c.distance) goto cleanup;
    rsv_parallel_for(e->context, e->node_count, 0, set_up_nodes, &c);
    RSV_TRY(choose_leaders(&c));
    RSV_TRY(add_followers(&c));
cleanup:
    rsv_free(e->context, c.radius);
    rsv_free(e->context, c.place);
    rsv_free(e->context, c.normal);
    rsv_free(e->context, c.fine);
    rsv_free(e->context, c.led);
    rsv_free(e->context, c.distance);
    rsv_free(e->context, c.front);
    rsv_free(e->context, c.visited);
    return status;
}
