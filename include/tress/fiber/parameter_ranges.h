// The ranges that FiberParameters states.
#pragma once

#include "tress/fiber/parameters.h"

namespace tress::fiber {

/// Null if the parameters are a fiber that every model takes; else the name of a member of FiberParameters that is out
/// of its range or not finite. Ends of ranges may be off by 1e-5 of themselves, as degrees turned into radians are. Any
/// thread.
const char* out_of_range(const FiberParameters& parameters);

}  // namespace tress::fiber
