#include "color_scale.h"

#include <math.h>

void cli_scale_color(double t, double srgb[3])
{
    static const unsigned char at[9][3] = { { 68, 1, 84 }, { 71, 44, 122 }, { 59, 81, 139 },
        { 44, 113, 142 }, { 33, 144, 141 }, { 39, 173, 129 }, { 92, 200, 99 }, { 170, 220, 50 },
        { 253, 231, 37 } };
    double place = 8 * fmin(fmax(t, 0), 1);
    int k = place >= 8 ? 7 : (int)place;
    for (int c = 0; c < 3; c++)
        srgb[c] = at[k][c] + (place - k) * (at[k + 1][c] - at[k][c]);
}
