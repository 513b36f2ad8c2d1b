// How a hit on a fiber begins: from a row, or from where the ray met the fiber.
#pragma once

namespace tress::integrate {

/// no: FiberModel::begin(). drawn: begin_drawn_near(). all: begin_near().
enum class NearHit { no, drawn, all };

}  // namespace tress::integrate
