#include "local_lights_body.h"
