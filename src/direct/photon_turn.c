#include "photon_turn_body.h"
