/// @file resolvent.h
/// All of Resolvent's public interface.
#ifndef RESOLVENT_H
#define RESOLVENT_H

#include "resolvent/animation.h"
#include "resolvent/bake.h"
#include "resolvent/certify.h"
#include "resolvent/check.h"
#include "resolvent/core.h"
#include "resolvent/daylight.h"
#include "resolvent/edit.h"
#include "resolvent/fit.h"
#include "resolvent/frame.h"
#include "resolvent/image.h"
#include "resolvent/io.h"
#include "resolvent/lightmix.h"
#include "resolvent/luminaire.h"
#include "resolvent/mover.h"
#include "resolvent/operator.h"
#include "resolvent/opfile.h"
#include "resolvent/plan.h"
#include "resolvent/relight.h"
#include "resolvent/render.h"
#include "resolvent/scene.h"
#include "resolvent/sky.h"
#include "resolvent/solve.h"
#include "resolvent/team.h"
#include "resolvent/trace.h"
#include "resolvent/update.h"

#endif
