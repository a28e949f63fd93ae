#include "sky.h"

/// rsv_sky_visit looks at least this often along the equator.
#define VISIT_COLUMNS 1024
#define VISIT_ROWS 512

rsv_sky rsv_sky_from_environment(const rsv_environment *environment)
{
    double turns = (double)environment->rotation / 360;
    return (rsv_sky){ environment->pixels, environment->width, environment->height,
        (float)(turns - floor(turns)) };
}

static rsv_vec3 direction_at(double turn, double u, double v)
{
    double phi = 2 * M_PI * (u - 0.5 - turn), theta = M_PI * v;
    return v3((float)(sin(theta) * cos(phi)), (float)cos(theta), (float)(sin(theta) * sin(phi)));
}

/// 2 pi (cos(pi v0) - cos(pi v1)) for a band of the sphere.
static double band_solid_angle(double v0, double v1)
{
    return 4 * M_PI * sin(0.5 * M_PI * (v1 - v0)) * sin(0.5 * M_PI * (v1 + v0));
}

double rsv_sky_pixel_solid_angle(const rsv_sky *sky, uint32_t row)
{
    double height = sky->height;
    return band_solid_angle(row / height, (row + 1) / height) / sky->width;
}

rsv_vec3 rsv_sky_pixel_direction(const rsv_sky *sky, uint32_t column, uint32_t row)
{
    return direction_at(sky->turn, (column + 0.5) / sky->width, (row + 0.5) / sky->height);
}

void rsv_sky_visit(const rsv_sky *sky, rsv_sky_visitor visitor, void *user)
{
    if (!sky->pixel) return;
    size_t columns = (size_t)sky->width * ((VISIT_COLUMNS + sky->width - 1) / sky->width);
    size_t rows = (size_t)sky->height * ((VISIT_ROWS + sky->height - 1) / sky->height);
    for (size_t j = 0; j < rows; j++) {
        double v0 = (double)j / (double)rows, v1 = (double)(j + 1) / (double)rows;
        double solid_angle = band_solid_angle(v0, v1) / (double)columns;
        for (size_t i = 0; i < columns; i++) {
            rsv_vec3 direction =
                direction_at(sky->turn, ((double)i + 0.5) / (double)columns, 0.5 * (v0 + v1));
            visitor(user, direction, solid_angle, rsv_sky_radiance(sky, direction));
        }
    }
}

static void add_flux(void *user, rsv_vec3 direction, double solid_angle, rsv_rgb radiance)
{
    (void)direction;
    double *sum = user;
    sum[0] += solid_angle * radiance.r;
    sum[1] += solid_angle * radiance.g;
    sum[2] += solid_angle * radiance.b;
}

rsv_rgb rsv_sky_flux(const rsv_sky *sky)
{
    double sum[3] = { 0 };
    rsv_sky_visit(sky, add_flux, sum);
    return rgb((float)sum[0], (float)sum[1], (float)sum[2]);
}
