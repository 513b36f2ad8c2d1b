// Absorbed rows outside of a table, for tests and benches of what they answer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "models/elliptical/absorbed_row.h"

namespace tress::inline v0_2::fiber {

/// Owns its rows until it is destroyed. One thread.
class AbsorbedRowPool {
 public:
  template <class Fit>
  const AbsorbedRow* make(const Fit& fit, float objective, const glm::vec3& sigma_a) {
    bytes_ += absorbed_bytes(fit);
    blocks_.push_back(std::make_unique<Line[]>(absorbed_bytes(fit) / sizeof(Line)));
    return put_absorbed(fit, objective, sigma_a, blocks_.back().get());
  }
  std::size_t bytes() const { return bytes_; }

 private:
  struct alignas(64) Line {
    std::byte bytes[64];
  };
  std::vector<std::unique_ptr<Line[]>> blocks_;
  std::size_t bytes_ = 0;
};

}  // namespace tress::inline v0_2::fiber
