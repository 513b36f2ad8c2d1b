// The excess of rows at one direction of a vertex, evaluated by chance.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "integrate/scattering.h"
#include "tress/base/random.h"

namespace tress::integrate {

inline std::uint64_t hash_of(float a, float b, std::uint64_t before) { return mix_bits(before + bits_of(a, b)); }

/// The excess of the rows at one direction of a vertex. Each use evaluates it by chance; it is traced at most once.
class ExcessAt {
 public:
  /// All references must outlive this object.
  ExcessAt(const Scattering& scattering, const Vertex& vertex, const glm::vec3& direction)
      : scattering_(scattering), vertex_(vertex), direction_(direction) {
    if (!scattering.tells_excess() || vertex.hit.is_surface) return;
    // The random numbers come from the bits of the direction and of the event, so no stream is used up.
    const fiber::FiberEvent& event = vertex.event;
    const std::uint64_t of_event = hash_of(event.xi1, event.xi2, hash_of(event.wr.theta, event.wr.phi, 0));
    const std::uint64_t hash = hash_of(direction.x, direction.y, of_event);
    u_ = static_cast<float>(hash >> 40) * 0x1p-24f;
    place_ = static_cast<float>(hash & 0xffffff) * 0x1p-24f;
  }
  /// An estimate whose mean is Scattering::excess(). chance: of evaluating it, in (0, 1].
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
