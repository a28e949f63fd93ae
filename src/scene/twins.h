/// Duplicate faces (faces in the same place), and which of them a ray sees.
///
/// Modelling programs and exporters often write a surface twice, once for each side, as two single-sided faces of
/// opposite winding. A ray that hits such a surface hits both at once. One rule decides which face it sees,
/// independently of the order in which they are found and of how they are divided into triangles: 1. an opaque face
/// hides one that transmits light, 2. a front hides a back, 3. a lamp hides a face that does not emit, 4. a
/// double-sided face hides a single-sided one, 5. a later face hides an earlier one. Faces of glass bodies have no
/// front in this sense: the surface between inside and outside is one surface. Of two opposite faces of such bodies,
/// the one whose front is outside hides the other, as seen from either side (twin_body.h).
///
/// Faces with the same orientation are in the same place if they are so up to rounding; otherwise the nearer one is
/// seen, as usual. Opposite faces may be a small distance apart: a back in front of a front is an inexact copy of it.
/// The limit depends on the size of the triangles and their position, so that a landscape around a house does not
/// affect its doors.
///
/// Commit finds duplicate faces (twins.c). Scenes without any have no rsv_twins, and no extra cost.
#ifndef RSV_TWINS_H
#define RSV_TWINS_H

#include "material_at.h"
#include "resolvent/trace.h"

/// Flags of a triangle.
#define RSV_TWIN_OVER_FRONT 1  ///< what meets its front may see another face
#define RSV_TWIN_OVER_BACK 2   ///< likewise
#define RSV_TWIN_HIDDEN 4      ///< others hide all of it: it gives no light
#define RSV_TWIN_BACK_HIDDEN 8 ///< likewise of its back, if it is double-sided
#define RSV_TWIN_OPPOSITE 16   ///< some face at the same place turns the other way
#define RSV_TWIN_LAST 32       ///< of several that are alike in all respects
#define RSV_TWIN_INSIDE_OUT 64 ///< of a body: its front looks into it
#define RSV_TWIN_PARTLY 128    ///< of a lamp: others hide a part of a side that shines
/// All of a face that is not the last of several
#define RSV_TWIN_COPY (RSV_TWIN_OVER_FRONT | RSV_TWIN_OVER_BACK | RSV_TWIN_HIDDEN)
/// Places are the same to this part of their largest coordinate.
#define RSV_TWIN_ROUNDING 0x1p-21f
/// Other faces that are listed for a triangle at most: where there are more, hits look all around.
#define RSV_TWIN_RIVALS 4
/// Faces at one place that are looked at: more are a heap.
#define RSV_TWIN_MOST 256
/// Hits whose barycentric coordinates are all larger lie well inside their triangle.
#define RSV_TWIN_INSET 0x1p-6f

/// A box around triangles. Nodes are stored in the order of a traversal: the first child of an inner node follows it,
/// and a ray that misses the box continues at `next`. A leaf has no children.
typedef struct rsv_twin_node {
    rsv_vec3 low;
    uint32_t next;
    rsv_vec3 high;
    uint32_t first; ///< of its triangles in `face`; those of the node at `next` follow
} rsv_twin_node;

/// Plain arrays, which can be copied to any memory.
typedef struct rsv_twins {
    const uint8_t *flags;        ///< [triangle_count]
    const rsv_twin_node *node;   ///< [node_count + 1], the last without a box
    const uint32_t *face;        ///< [face_count] triangles with a flag that are not copies
    const uint32_t *first_rival; ///< [triangle_count + 1] in `rival`; NULL = hits look all around
    const uint32_t
        *rival; ///< other faces that hits well inside a triangle may be on; RSV_NONE = too many
    uint32_t node_count, face_count;
    float reach;    ///< metres that opposite faces at the same place may lie apart, of any size
    float rounding; ///< metres within which positions count as equal
    float extent;   ///< rays leave faces with flags as if their corners were this many times farther out
                    ///< far as their copies may lie off: past all of these; 0 = all are exact
} rsv_twins;

/// Whether a material lets nothing through, but where it is cut out.
RSV_INLINE bool rsv_twin_is_opaque(const rsv_scene_view *scene, uint32_t material)
{
    const rsv_material *m = &scene->material[material];
    if (m->transmission > 0) return false;
    if (m->alpha_cutoff > 0) return true;
    for (size_t i = 0; i < m->texture_count; i++)
        if (m->textures[i].role == RSV_TEXTURE_OPACITY) return false;
    bool varies =
        scene->material_varies && (scene->material_varies[material] & RSV_VARIES_BY_OPACITY);
    return m->opacity >= 1 && !varies;
}

/// How much a face counts at its place. @param scene with twins @param back which side the ray meets
RSV_INLINE uint32_t rsv_twin_rank(const rsv_scene_view *scene, uint32_t triangle, bool back)
{
    uint32_t material = scene->triangle_material[triangle];
    const rsv_material *m = &scene->material[material];
    bool body = m->transmission > 0 && m->thickness > 0;
    bool shines = !rgb_is_black(m->emission) && !m->unlit && (!back || m->double_sided);
    bool turned = scene->twins->flags[triangle] & RSV_TWIN_INSIDE_OUT;
    return (rsv_twin_is_opaque(scene, material) ? 16u : 0u) | (!back && !body ? 8u : 0u) |
           (body && !turned ? 4u : 0u) | (shines ? 2u : 0u) | (m->double_sided ? 1u : 0u);
}

/// A triangle as seen from its first corner, its longer edge from there being 1: products stay within float.
typedef struct rsv_twin_plane {
    rsv_vec3 corner, edge1, edge2;
    rsv_vec3 normal; ///< cross product of the edges
    float scale;     ///< 1/m
} rsv_twin_plane;

RSV_INLINE rsv_twin_plane rsv_twin_plane_of(const rsv_scene_view *scene, uint32_t triangle)
{
    const uint32_t *corner = scene->triangle[triangle];
    rsv_twin_plane p;
    p.corner = scene->position[corner[0]];
    p.edge1 = v3_sub(scene->position[corner[1]], p.corner);
    p.edge2 = v3_sub(scene->position[corner[2]], p.corner);
    p.scale = 1 / f_max(v3_max_abs(p.edge1), v3_max_abs(p.edge2));
    p.edge1 = v3_scale(p.edge1, p.scale);
    p.edge2 = v3_scale(p.edge2, p.scale);
    p.normal = v3_cross(p.edge1, p.edge2);
    return p;
}

/// Metres within which positions on a triangle count as equal: the difference of two hits by one ray. @param most of
/// any triangle
RSV_INLINE float rsv_twin_rounding(const rsv_twin_plane *p, float most)
{
    float size = 1 / p->scale;
    return f_min(most, RSV_TWIN_ROUNDING * (v3_max_abs(p->corner) + size) + 0x1p-12f * size);
}

/// Metres that a triangle may lie apart from an opposite one in the same place. @param most of any triangle
RSV_INLINE float rsv_twin_reach(const rsv_twin_plane *p, float rounding, float most)
{
    return f_min(most, f_max(0x1p-10f / p->scale, 4 * rounding));
}

/// How far from a triangle places still count as on it, metres: rsv_twin_rounding and rsv_twin_reach.
typedef struct rsv_twin_margin {
    float rounding, reach;
} rsv_twin_margin;

/// @param rounding, reach most of any triangle
RSV_INLINE rsv_twin_margin rsv_twin_margin_of(const rsv_twin_plane *p, float rounding, float reach)
{
    rsv_twin_margin m;
    m.rounding = rsv_twin_rounding(p, rounding);
    m.reach = rsv_twin_reach(p, m.rounding, reach);
    return m;
}

/// How far two triangles may lie apart that are in the same place.
RSV_INLINE rsv_twin_margin rsv_twin_margin_between(rsv_twin_margin a, rsv_twin_margin b)
{
    rsv_twin_margin m;
    m.rounding = f_max(a.rounding, b.rounding);
    m.reach = f_max(f_min(a.reach, b.reach), m.rounding);
    return m;
}

RSV_INLINE rsv_vec3 rsv_twin_point(const rsv_twin_plane *p, float u, float v)
{
    return v3_mad(p->corner, 1 / p->scale, v3_mad(v3_scale(p->edge1, u), v, p->edge2));
}

/// How far from a triangle's plane and edges a place may be that is still on it.
typedef struct rsv_twin_limits {
    float height;                    ///< in units of the plane's normal
    float least_u, least_v, least_w; ///< barycentric coordinates
    float square;                    ///< of the normal's length
} rsv_twin_limits;

/// @param height, slack metres out of the plane, and beyond the edges
RSV_INLINE rsv_twin_limits rsv_twin_limits_of(const rsv_twin_plane *p, float height, float slack)
{
    float square = v3_dot(p->normal, p->normal), length = sqrtf(square);
    // a weight falls by edge / normal for each unit beyond that edge
    float fall = slack * p->scale / length;
    rsv_twin_limits limits;
    limits.height = height * p->scale * length;
    limits.least_u = -fall * v3_length(p->edge2);
    limits.least_v = -fall * v3_length(p->edge1);
    limits.least_w = -fall * v3_length(v3_sub(p->edge2, p->edge1));
    limits.square = square;
    return limits;
}

/// Whether the triangle covers the foot of a point in its plane, or misses it by no more than the limits.
/// @param u, v out: of the foot
RSV_INLINE bool rsv_twin_covers(
    const rsv_twin_plane *p, const rsv_twin_limits *limits, rsv_vec3 point, float *u, float *v)
{
    rsv_vec3 to = v3_scale(v3_sub(point, p->corner), p->scale);
    float along_u = v3_dot(v3_cross(to, p->edge2), p->normal) / limits->square;
    float along_v = v3_dot(v3_cross(p->edge1, to), p->normal) / limits->square;
    bool near = fabsf(v3_dot(p->normal, to)) <= limits->height;
    bool within = (along_u >= limits->least_u) & (along_v >= limits->least_v) &
                  (1 - along_u - along_v >= limits->least_w);
    along_u = f_min(f_max(along_u, 0), 1);
    *u = along_u;
    *v = f_min(f_max(along_v, 0), 1 - along_u);
    return near & within;
}

RSV_INLINE bool rsv_twin_boxes_meet(const rsv_twin_node *a, const rsv_twin_node *b, float reach)
{
    return a->low.x <= b->high.x + reach && b->low.x <= a->high.x + reach &&
           a->low.y <= b->high.y + reach && b->low.y <= a->high.y + reach &&
           a->low.z <= b->high.z + reach && b->low.z <= a->high.z + reach;
}

RSV_INLINE bool rsv_twin_misses(const rsv_twin_node *node, rsv_vec3 point, float reach)
{
    return point.x < node->low.x - reach || point.x > node->high.x + reach ||
           point.y < node->low.y - reach || point.y > node->high.y + reach ||
           point.z < node->low.z - reach || point.z > node->high.z + reach;
}

/// A place on a face, and the face that is seen there so far.
typedef struct rsv_twin_search {
    rsv_vec3 point, direction; ///< of the ray
    rsv_vec3 normal;           ///< of the face that was met
    rsv_twin_margin margin;    ///< of that face
    uint32_t met, rank;
    uint32_t found; ///< faces there
    bool opposite;  ///< whether one of them turns the other way than the one that was met
    rsv_hit *hit;
} rsv_twin_search;

RSV_INLINE void rsv_twin_try(const rsv_scene_view *scene, uint32_t triangle, rsv_twin_search *s)
{
    const rsv_twins *twins = scene->twins;
    rsv_twin_plane plane = rsv_twin_plane_of(scene, triangle);
    bool opposite = v3_dot(plane.normal, s->normal) < 0;
    rsv_twin_margin m = rsv_twin_margin_of(&plane, twins->rounding, twins->reach);
    m = rsv_twin_margin_between(m, s->margin);
    rsv_twin_limits limits =
        rsv_twin_limits_of(&plane, opposite ? m.reach : m.rounding, m.rounding);
    float u, v;
    if (triangle == s->met || !rsv_twin_covers(&plane, &limits, s->point, &u, &v)) return;
    if (rsv_is_cut_out(scene, triangle, u, v)) return;
    s->found++;
    s->opposite = s->opposite || opposite;
    uint32_t rank = rsv_twin_rank(scene, triangle, v3_dot(plane.normal, s->direction) > 0);
    if (rank < s->rank || (rank == s->rank && triangle < s->hit->triangle)) return;
    s->rank = rank;
    s->hit->triangle = triangle;
    s->hit->u = u;
    s->hit->v = v;
}

/// Other faces that a hit may be on. @param rival out @return how many; RSV_NONE = it must look all around
RSV_INLINE uint32_t rsv_twin_rivals(
    const rsv_twins *twins, const rsv_hit *hit, const uint32_t **rival)
{
    float least = f_min(f_min(hit->u, hit->v), 1 - hit->u - hit->v);
    if (!twins->first_rival || !(least > RSV_TWIN_INSET)) return RSV_NONE;
    uint32_t first = twins->first_rival[hit->triangle];
    uint32_t count = twins->first_rival[hit->triangle + 1] - first;
    *rival = twins->rival + first;
    return count == 1 && **rival == RSV_NONE ? RSV_NONE : count;
}

/// Searches the duplicate faces at a hit. @param hit in: the face that was hit; out: the face that is seen
/// @return whether one of the faces has the opposite orientation
RSV_INLINE bool rsv_twins_search(const rsv_scene_view *scene, rsv_vec3 direction, rsv_hit *hit)
{
    const rsv_twins *twins = scene->twins;
    rsv_twin_plane plane = rsv_twin_plane_of(scene, hit->triangle);
    rsv_twin_search s;
    s.point = rsv_twin_point(&plane, hit->u, hit->v);
    s.direction = direction;
    s.normal = plane.normal;
    s.margin = rsv_twin_margin_of(&plane, twins->rounding, twins->reach);
    s.met = hit->triangle;
    s.rank = rsv_twin_rank(scene, hit->triangle, v3_dot(plane.normal, direction) > 0);
    s.found = 0;
    s.opposite = false;
    s.hit = hit;
    float reach = twins->reach + twins->rounding;
    const uint32_t *rival = NULL;
    uint32_t rivals = rsv_twin_rivals(twins, hit, &rival);
    uint32_t count = rivals == RSV_NONE ? twins->node_count : 0;
    for (uint32_t k = 0; rivals != RSV_NONE && k < rivals; k++)
        rsv_twin_try(scene, rival[k], &s);
    for (uint32_t n = 0; n < count && s.found < RSV_TWIN_MOST;) {
        const rsv_twin_node *node = &twins->node[n];
        bool misses = rsv_twin_misses(node, s.point, reach);
        if (!misses && node->next == n + 1)
            for (uint32_t k = node->first; k < node[1].first; k++)
                rsv_twin_try(scene, twins->face[k], &s);
        n = misses ? node->next : n + 1;
    }
    return s.opposite;
}

/// The face that a ray sees where it hits a triangle. @param scene with duplicate faces @param hit in and out
RSV_INLINE void rsv_twins_settle(const rsv_scene_view *scene, rsv_vec3 direction, rsv_hit *hit)
{
    uint32_t over = scene->twins->flags[hit->triangle] & (RSV_TWIN_OVER_FRONT | RSV_TWIN_OVER_BACK);
    if (!over) return;
    rsv_twin_plane plane = rsv_twin_plane_of(scene, hit->triangle);
    bool back = v3_dot(plane.normal, direction) > 0;
    if (over & (back ? RSV_TWIN_OVER_BACK : RSV_TWIN_OVER_FRONT))
        rsv_twins_search(scene, direction, hit);
}

/// Whether two faces that turn opposite ways lie at the place of a hit.
RSV_INLINE bool rsv_twins_meet(const rsv_scene_view *scene, rsv_vec3 direction, rsv_hit hit)
{
    if (!scene->twins || !(scene->twins->flags[hit.triangle] & RSV_TWIN_OPPOSITE)) return false;
    return rsv_twins_search(scene, direction, &hit);
}

/// The least extent with which rays leave a triangle (rsv_offset_origin): copies of it may lie a little off it, on
/// either side. 0 = any will do.
RSV_INLINE float rsv_twins_extent(const rsv_scene_view *scene, uint32_t triangle)
{
    const rsv_twins *twins = scene->twins;
    if (!twins || !twins->flags[triangle] || twins->extent == 0) return 0;
    rsv_twin_plane plane = rsv_twin_plane_of(scene, triangle);
    return twins->extent * rsv_twin_margin_of(&plane, twins->rounding, twins->reach).reach;
}

/// Whether others hide all of a triangle, or all of its back.
RSV_INLINE bool rsv_twins_hide(const rsv_scene_view *scene, uint32_t triangle, bool back)
{
    uint8_t hidden = back ? RSV_TWIN_HIDDEN | RSV_TWIN_BACK_HIDDEN : RSV_TWIN_HIDDEN;
    return scene->twins && (scene->twins->flags[triangle] & hidden);
}

/// Whether others hide a part of one side of a lamp.
RSV_INLINE bool rsv_twins_hide_part(const rsv_scene_view *scene, uint32_t triangle)
{
    return scene->twins && (scene->twins->flags[triangle] & RSV_TWIN_PARTLY);
}

/// Whether others hide a place on a side of a lamp: it gives no light there.
RSV_INLINE bool rsv_twins_hide_place(
    const rsv_scene_view *scene, uint32_t triangle, bool back, float u, float v)
{
    if (!rsv_twins_hide_part(scene, triangle)) return false;
    rsv_hit hit = { triangle, 0, u, v };
    rsv_vec3 normal = rsv_twin_plane_of(scene, triangle).normal;
    rsv_twins_search(scene, back ? normal : v3_neg(normal), &hit);
    return hit.triangle != triangle;
}

#endif
