/// Sixteen specular paths at smooth surfaces, included by packet_kernels_body.h.

/// Corners of the triangles that a packet met.
typedef struct corner_lanes {
    rsv_lanes3 position[3], normal[3];
    float extent[LANES]; ///< see rsv_twins_extent
} corner_lanes;

static inline void gather_corners(const rsv_scene_view *restrict view,
    const uint32_t *restrict triangle, corner_lanes *restrict to)
{
    for (uint32_t k = 0; k < LANES; k++) {
        uint32_t met = triangle[k] == RSV_NONE ? 0 : triangle[k];
        const uint32_t *corner = view->triangle[met];
        to->extent[k] = rsv_twins_extent(view, met);
        for (int c = 0; c < 3; c++) {
            rsv_set_lane_vector(to->position[c], k, view->position[corner[c]]);
            rsv_set_lane_vector(to->normal[c], k, view->normal[corner[c]]);
        }
    }
}

/// Surface points with the normals for smooth lobes.
typedef struct point_lanes {
    rsv_lanes3 position, geometric, normal;
    float extent[LANES];
} point_lanes;

/// rsv_surface_point_at and rsv_specular_bsdf_normal, all lanes at once.
static inline void find_points(const corner_lanes *restrict corners,
    const rsv_ray_packet *restrict p, const int *restrict back, point_lanes *restrict to)
{
    for (uint32_t k = 0; k < LANES; k++) {
        rsv_vec3 corner[3] = { rsv_lane_vector(corners->position[0], k),
            rsv_lane_vector(corners->position[1], k), rsv_lane_vector(corners->position[2], k) };
        rsv_vec3 at[3] = { rsv_lane_vector(corners->normal[0], k),
            rsv_lane_vector(corners->normal[1], k), rsv_lane_vector(corners->normal[2], k) };
        rsv_surface_point point = rsv_surface_point_of(corner, at, p->u[k], p->v[k], back[k] != 0);
        rsv_vec3 wo = v3(-p->direction_x[k], -p->direction_y[k], -p->direction_z[k]);
        rsv_vec3 normal = v3_dot(point.normal, wo) <= 0 ? point.geometric : point.normal;
        normal = rsv_bsdf_specular_normal(normal, point.geometric, wo);
        rsv_set_lane_vector(to->position, k, point.position);
        rsv_set_lane_vector(to->geometric, k, point.geometric);
        rsv_set_lane_vector(to->normal, k, normal);
        to->extent[k] = f_max(point.extent, corners->extent[k]);
    }
}

/// Constants of a smooth surface.
typedef struct smooth_surface {
    rsv_rgb tint, base_color; ///< specular_tint and base_color of rsv_bsdf
    float largest_tint, metallic, transmission, ior;
} smooth_surface;

/// rsv_fresnel_dielectric without branches.
static inline float fresnel(float cos_i, float eta, float *cos_t)
{
    float sin2_t = (1 - cos_i * cos_i) / (eta * eta), cos = sqrtf(f_max(1 - sin2_t, 0));
    float perpendicular = (cos_i - eta * cos) / (cos_i + eta * cos);
    float parallel = (eta * cos_i - cos) / (eta * cos_i + cos);
    float partial = 0.5f * (perpendicular * perpendicular + parallel * parallel);
    *cos_t = eta == 1 ? cos_i : sin2_t >= 1 ? 0 : cos;
    return eta == 1 ? 0 : sin2_t >= 1 ? 1 : partial;
}

/// rsv_set_ideal_branches, all lanes at once; compiled for bodies and for others.
static inline __attribute__((always_inline)) void evaluate_branches(bool solid, smooth_surface s,
    const rsv_ray_packet *restrict p, const int *restrict back, const point_lanes *restrict points,
    rsv_branch_lanes *restrict reflected, rsv_branch_lanes *restrict transmitted)
{
    float inside = solid ? 1 / s.ior : s.ior, dielectric = 1 - s.metallic;
    for (uint32_t k = 0; k < LANES; k++) {
        rsv_vec3 wo = v3(-p->direction_x[k], -p->direction_y[k], -p->direction_z[k]);
        rsv_vec3 n = rsv_lane_vector(points->normal, k);
        float cos_o = f_min(f_max(v3_dot(n, wo), 0), 1), cos_t;
        float eta = back[k] ? inside : s.ior, reflectance = fresnel(cos_o, eta, &cos_t);
        bool total = (reflectance >= 1) & solid;
        rsv_rgb tint = rgb(total ? 1 : s.tint.r, total ? 1 : s.tint.g, total ? 1 : s.tint.b);
        float largest = total ? 1 : s.largest_tint, chance = largest * reflectance;
        rsv_rgb passed = rgb_scale(rsv_one_minus(rgb_scale(tint, reflectance)), 1 / (1 - chance));
        float passing = chance < 1 ? dielectric * s.transmission * (1 - chance) : 0;
        passed.r = chance < 1 ? passed.r : 0;
        passed.g = chance < 1 ? passed.g : 0;
        passed.b = chance < 1 ? passed.b : 0;
        rsv_rgb mirror = rgb_scale(rgb_scale(tint, 1 / largest), dielectric * chance);
        mirror = rgb_mad(mirror, s.metallic, rsv_fresnel_schlick(s.base_color, cos_o));
        rsv_vec3 through = rsv_refracted(wo, n, eta, cos_o, cos_t);
        rsv_set_lane_vector(reflected->direction, k, rsv_mirrored(wo, n));
        rsv_set_lane_color(reflected->weight, k, mirror);
        rsv_set_lane_vector(transmitted->direction, k, solid ? through : v3_neg(wo));
        rsv_set_lane_color(
            transmitted->weight, k, rgb_scale(rgb_mul(passed, s.base_color), passing));
    }
}

/// Clearances on the sides that branches leave to.
typedef struct clear_lanes {
    float reach[LANES], cosine[2][LANES]; ///< reflected, transmitted
} clear_lanes;

static inline void gather_clearances(const rsv_clearances *restrict from,
    const rsv_ray_packet *restrict p, const int *restrict back, clear_lanes *restrict to)
{
    for (uint32_t k = 0; k < LANES; k++) {
        const rsv_clearance *c = rsv_clearance_of(from, p->triangle[k]);
        to->reach[k] = c->reach;
        to->cosine[0][k] = c->cosine[back[k] != 0];
        to->cosine[1][k] = c->cosine[back[k] == 0];
    }
}

/// Starts branches, all reflected or all transmitted: rsv_specular_depart, rsv_branch_survives and
/// rsv_specular_set_out. Their weights come in as those of the branches alone.
static inline __attribute__((always_inline)) void depart(bool transmit,
    const rsv_specular_lanes *restrict c, const point_lanes *restrict points,
    const clear_lanes *restrict clear, rsv_branch_lanes *restrict b)
{
    for (uint32_t k = 0; k < LANES; k++) {
        rsv_vec3 direction = rsv_lane_vector(b->direction, k);
        rsv_vec3 leave = rsv_lane_vector(points->geometric, k);
        if (transmit) leave = v3_neg(leave);
        rsv_rgb carried = rsv_lane_color(c->weight, k), weight = rsv_lane_color(b->weight, k);
        bool survives = rsv_weight_survives(carried, c->trail[k], transmit, &weight);
        rsv_set_lane_vector(b->origin, k,
            rsv_moved_off(rsv_lane_vector(points->position, k), leave, points->extent[k]));
        rsv_set_lane_color(b->weight, k, rgb_mul(carried, weight));
        b->trail[k] = rsv_branch_trail(c->trail[k], transmit);
        b->kind[k] = rsv_branch_kind(c->back[k] != 0, transmit, direction);
        float cosine = v3_dot(direction, leave);
        b->alive[k] = (survives ? 1 : 0) & (cosine > 0 ? 1 : 0);
        b->t_min[k] = cosine > clear->cosine[transmit][k] ? clear->reach[k] : 0;
    }
}

static void leave_smooth_packet(const rsv_scene_view *restrict view, const rsv_bsdf *restrict bsdf,
    const rsv_clearances *restrict clearances, const rsv_ray_packet *restrict p,
    const rsv_specular_lanes *restrict c, rsv_branch_lanes *restrict branch)
{
    rsv_branch_lanes *reflected = &branch[0], *transmitted = &branch[1];
    corner_lanes corners;
    point_lanes points;
    clear_lanes clear;
    const smooth_surface s = { bsdf->specular_tint, bsdf->base_color,
        f_max(rgb_max(bsdf->specular_tint), 1e-6f), bsdf->metallic, bsdf->transmission, bsdf->ior };
    gather_corners(view, p->triangle, &corners);
    gather_clearances(clearances, p, c->back, &clear);
    find_points(&corners, p, c->back, &points);
    if (bsdf->solid)
        evaluate_branches(true, s, p, c->back, &points, reflected, transmitted);
    else
        evaluate_branches(false, s, p, c->back, &points, reflected, transmitted);
    depart(false, c, &points, &clear, reflected);
    depart(true, c, &points, &clear, transmitted);
}
