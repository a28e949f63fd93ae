#include "light_units.h"

#include "../scene/punctual.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FOUR_PI 12.566370614359172
#define FIRST_PHOTOMETRIC 3004 ///< the version of Blender whose exporter began to write candela

int rsv_blender_version(const char *generator)
{
    const char *at = strstr(generator, "Blender");
    if (!at) return -1;
    at += strcspn(at, "0123456789");
    char *end;
    long major = strtol(at, &end, 10);
    long minor = *end == '.' && isdigit((unsigned char)end[1]) ? strtol(end + 1, NULL, 10) : 0;
    return major < 0 || major > 999 || minor > 999 ? 0 : (int)(1000 * major + minor);
}

/// How Blender's exporter converted a lamp's watts.
typedef enum way { WAY_CANDELA, WAY_WATT_PER_SR, WAY_WATT, WAYS } way;

static const rsv_light_scale scale_of_way[WAYS] = {
    [WAY_CANDELA] = { 1 / RSV_LUMENS_PER_WATT, 1 / RSV_LUMENS_PER_WATT, 1,
        "lights are in candela and lux, as Blender exports them: divided by 683 lm/W; "
        "--light-units watt reads their numbers as W/sr and W/m2" },
    [WAY_WATT_PER_SR] = { 1, 1, 1,
        "lights are in W/sr and W/m2, as Blender exports them without units; --light-units "
        "photometric reads them as candela and lux" },
    [WAY_WATT] = { 1 / FOUR_PI, 1, 1,
        "lights are in watts, as Blender exports them raw: divided by 4 pi; --light-units watt "
        "reads their numbers as W/sr" },
};

/// Whether a number has at most four digits, apart from rounding to a float.
static bool is_typed(double number)
{
    if (!(number > 0) || !isfinite(number)) return false;
    double unit = pow(10, floor(log10(number)) - 3), digits = number / unit;
    return fabs(digits - round(digits)) < 1e-7 * digits;
}

/// @return WAYS = cannot be told from the number
static way way_of(const rsv_gltf_light *light)
{
    bool distant = rsv_punctual_is_distant(&light->value);
    double watts = distant ? light->strength : FOUR_PI * light->strength;
    if (!light->known) return WAYS;
    if (is_typed(watts / RSV_LUMENS_PER_WATT)) return WAY_CANDELA;
    if (is_typed(watts)) return WAY_WATT_PER_SR;
    return is_typed(light->strength) ? WAY_WATT : WAYS;
}

/// The way that most lights point to; if none does, the default of that version of Blender.
static way find_way(const rsv_gltf_document *document, int version)
{
    size_t votes[WAYS + 1] = { 0 };
    way best = version > 0 && version < FIRST_PHOTOMETRIC ? WAY_WATT : WAY_CANDELA;
    for (size_t k = 0; k < document->light_count; k++) {
        way voted = way_of(&document->light[k]);
        votes[voted]++;
        bool is_either =
            voted == WAY_WATT_PER_SR && rsv_punctual_is_distant(&document->light[k].value);
        if (is_either) votes[WAY_WATT]++;
    }
    for (way k = 0; k < WAYS; k++)
        if (votes[k] > votes[best]) best = k;
    return best;
}

rsv_light_scale rsv_gltf_light_scale(const rsv_gltf_document *document, rsv_light_units wanted)
{
    rsv_light_scale scale = { 1, 1, 1, NULL };
    int version = rsv_blender_version(document->generator);
    if (wanted == RSV_LIGHT_UNITS_PHOTOMETRIC) {
        scale.local = scale.distant = 1 / RSV_LUMENS_PER_WATT;
        // Blender's exporter converts lights only
        scale.emission = version < 0 ? 1 / RSV_LUMENS_PER_WATT : 1;
    }
    if (wanted != RSV_LIGHT_UNITS_AUTO || document->light_count == 0) return scale;
    if (version >= 0) return scale_of_way[find_way(document, version)];
    if (strncmp(document->generator, "Resolvent", 9) == 0) return scale;
    scale.said =
        "lights are assumed to be in W/sr and W/m2, because the file does not say that it is in "
        "candela and lux; --light-units photometric divides them by 683 lm/W";
    return scale;
}
