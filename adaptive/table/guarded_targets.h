// Wraps the targets of a host. Where one throws or is not as its interface says, no row is learned from what it gave.
#pragma once

#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tress/adaptive/sampled_target.h"
#include "tress/adaptive/target.h"
#include "tress/adaptive/to_string.h"
#include "tress/adaptive/traced_nodes.h"
#include "tress/base/error.h"

namespace tress::inline v0_2::adaptive {

/// Makes the call and passes anything that it throws to `report`. Returns false if it threw. Thread-safe.
template <class Call>
bool calls_without_throwing(const char* what, const std::function<void(Error)>& report, Call&& call) {
  try {
    call();
    return true;
  } catch (const std::exception& thrown) {
    report({"", what, "no exception", thrown.what()});
  } catch (...) {
    report({"", what, "no exception", "one that is no std::exception"});
  }
  return false;
}

class GuardedTarget {
 public:
  /// target: must outlive this object. report: takes the errors, from any thread.
  GuardedTarget(const Target& target, std::function<void(Error)> report)
      : target_(target), report_(std::move(report)) {}
  /// Traces the node at (a, b). Returns null and reports it if the target throws or gives rays that TracedRay does not
  /// allow. Thread-safe.
  std::unique_ptr<const TracedNodes> trace(const SliceDescription& slice, float a, float b) const {
    std::vector<TracedRay> rays;
    if (!calls_without_throwing("Target::trace", report_, [&] { target_.trace(slice, a, b, rays); })) return nullptr;
    const auto is_ray = [](const TracedRay& ray) {
      return std::isfinite(ray.azimuth) && ray.weight >= 0 && ray.weight <= largest_weight &&
             std::isfinite(ray.attribute) && ray.attribute >= 0;
    };
    if (std::ranges::all_of(rays, is_ray)) return std::make_unique<const TracedNodes>(rays, slice.blur_rad);
    report_({"", "Target::trace", "rays that are finite, of a weight of 0 to 1e30 and an attribute of 0 or more",
             "another at (" + std::to_string(a) + ", " + std::to_string(b) + ") of slice " + to_string(slice.key)});
    return nullptr;
  }
  std::string model_name() const { return target_.model_name(); }

 private:
  const Target& target_;
  std::function<void(Error)> report_;
};

class GuardedSamples final : public SampledTarget {
 public:
  /// target: must outlive this object. report: takes the errors, from any thread.
  GuardedSamples(const SampledTarget& target, std::function<void(Error)> report)
      : target_(target), report_(std::move(report)) {}
  std::uint32_t parts(const SliceDescription& slice) const override {
    std::uint32_t parts = 0;
    calls_without_throwing("SampledTarget::parts", report_, [&] { parts = target_.parts(slice); });
    return parts;
  }
  void draw(const SliceDescription& slice, float a, float b, std::uint64_t stream, std::uint32_t first,
            std::uint32_t count, std::vector<SampledExit>& out) const override {
    if (!calls_without_throwing("SampledTarget::draw", report_,
                                [&] { target_.draw(slice, a, b, stream, first, count, out); }))
      out.assign(1, none);
  }
  void draw_sets(const SliceDescription& slice, float a, float b, std::uint64_t stream, std::uint32_t first,
                 std::uint32_t count, std::array<std::vector<SampledExit>, 4>& out) const override {
    if (!calls_without_throwing("SampledTarget::draw_sets", report_,
                                [&] { target_.draw_sets(slice, a, b, stream, first, count, out); }))
      out.fill({none});
  }
  std::string model_name() const override { return target_.model_name(); }

 private:
  /// An exit that SampledTarget does not allow.
  static constexpr SampledExit none{0, 0, 0, std::numeric_limits<float>::quiet_NaN(), 0};

  const SampledTarget& target_;
  std::function<void(Error)> report_;
};

}  // namespace tress::inline v0_2::adaptive
