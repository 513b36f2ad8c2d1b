// Targets for tests that can only be drawn from.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tress/adaptive/ribbon.h"
#include "tress/adaptive/sampled_target.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {

/// One call a path: appends its exits.
class PathTarget : public SampledTarget {
 public:
  using Path = std::function<void(RandomStream&, std::vector<SampledExit>&)>;
  PathTarget(std::uint32_t parts, Path path) : parts_(parts), path_(std::move(path)) {}

  std::uint32_t parts(const SliceDescription&) const override { return parts_; }
  void draw(const SliceDescription&, float a, float b, std::uint64_t stream, std::uint32_t first, std::uint32_t count,
            std::vector<SampledExit>& out) const override {
    for (std::uint32_t i = first; i < first + count; ++i) {
      RandomStream random(stream + static_cast<std::uint64_t>(1000 * a + b), i, 4711);
      path_(random, out);
    }
  }
  std::string model_name() const override { return "paths"; }

 private:
  std::uint32_t parts_;
  Path path_;
};

/// Paths that leave by a ribbon each, all of `mass`.
inline PathTarget target_of(const Ribbon& ribbon, float mass = 1) {
  return {1, [ribbon, mass](RandomStream& random, std::vector<SampledExit>& out) {
            const float u = random.next();
            const auto [x, t] = ribbon.sample(u, random.next());
            out.push_back({x, t, 0, mass, 2});
          }};
}

}  // namespace tress::inline v0_2::adaptive
