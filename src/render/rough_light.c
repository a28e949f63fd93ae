#include "rough_light_body.h"
