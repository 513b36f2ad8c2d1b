// What rows have too much at one direction of a vertex, asked where chance has it.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "integrate/scattering.h"
#include "tress/base/random.h"

namespace tress::integrate {

inline std::uint64_t hash_of(float a, float b, std::uint64_t before) { return mix_bits(before + bits_of(a, b)); }

/// What the rows have too much at one direction of a vertex: traced at most once, where chance has it, for each use
/// that is made of it.
class ExcessAt {
 public:
  /// All references must outlive it.
  ExcessAt(const Scattering& scattering, const Vertex& vertex, const glm::vec3& direction)
      : scattering_(scattering), vertex_(vertex), direction_(direction) {
    if (!scattering.tells_excess() || vertex.hit.is_surface) return;
    // By the bits of the direction and of the event: no stream of numbers is used up.
    const fiber::FiberEvent& event = vertex.event;
    const std::uint64_t of_event = hash_of(event.xi1, event.xi2, hash_of(event.wr.theta, event.wr.phi, 0));
    const std::uint64_t hash = hash_of(direction.x, direction.y, of_event);
    u_ = static_cast<float>(hash >> 40) * 0x1p-24f;
    place_ = static_cast<float>(hash & 0xffffff) * 0x1p-24f;
  }
  /// In the mean over all chances, (0, 1], Scattering::excess().
  glm::vec3 by(float chance) {
    if (!(u_ < chance)) return glm::vec3(0.0f);
    if (!asked_) value_ = scattering_.excess(vertex_, direction_, place_);
    asked_ = true;
    return value_ / chance;
  }

 private:
  const Scattering& scattering_;
  const Vertex& vertex_;
  const glm::vec3& direction_;
  float u_ = 1, place_ = 0;
  bool asked_ = false;
  glm::vec3 value_{0.0f};
};

}  // namespace tress::integrate
