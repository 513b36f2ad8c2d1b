// Models with their rows in every state, asked adversarial queries. For tests and the atlas (bench/atlas) alike.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <numbers>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "base/color.h"
#include "models/adversarial_points.h"
#include "models/query_checks.h"
#include "references/registry.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"

namespace tress::test {

/// What the rows that a model meets have become; `nothing`: it has no service.
enum class Taught { nothing, no_rows, open, converged };

struct Asked {
  const char* model = "elliptical";
  fiber::Estimator estimator = fiber::Estimator::exact;
  Taught taught = Taught::nothing;
  int points = 0;  ///< of quadrature
};

/// Some fibers in one model, with the rows they learned: all nodes of all slices; of slices of samples, which take some
/// hundredths of a second a row, those of corners, to an epsilon of 0.5.
class TaughtModel {
 public:
  TaughtModel(const Asked& what, std::span<const AdversarialFiber> fibers) : what_(what) {
    const fiber::ModelInfo& info = *references::find_model(what.model);
    if (what.taught != Taught::nothing) {
      adaptive::Options options;
      options.queries_before_creation = 1;
      options.memory_bytes = std::size_t{2} << 30;
      options.sampled_epsilon = 0.5;
      options.heard_share = 0;  // what is heard is drawn from the fiber, and evaluate() knows the row
      if (what.taught == Taught::converged) options.learner = &references::eager_learner;
      learned_ = fiber::make_service(info, options);
      service_ = learned_.service.get();
    }
    model_ = info.make({.estimator = what.estimator, .service = service_, .quadrature_points = what.points});
    for (const AdversarialFiber& fiber : fibers) ids_.push_back(model_->add_fiber(fiber.parameters));
    if (what.taught == Taught::open) teach(2);
    if (what.taught == Taught::converged) teach(8);
    if (service_ != nullptr) service_->set_learning(false);
  }
  const Asked& what() const { return what_; }
  const fiber::FiberModel& model() const { return *model_; }
  fiber::FiberId id(std::size_t fiber) const { return ids_[fiber]; }
  /// Rows of the slices, and those that have converged.
  std::uint64_t rows = 0, converged = 0;

 private:
  /// Where adversarial directions are: at the poles, across the fiber, along its axes.
  static bool is_corner(const adaptive::SliceDescription& slice, std::uint32_t a, std::uint32_t b) {
    const float theta = std::abs(slice.axis_a[a]);
    return (theta < 0.01f || a == 0 || a + 1 == slice.axis_a.size()) && (b == 0 || b + 1 == slice.axis_b.size());
  }

  void teach(int passes) {
    for (int pass = 0; pass <= passes; ++pass) {
      rows = converged = 0;
      for (adaptive::SliceId slice = 0; slice < service_->slice_count(); ++slice) {
        const adaptive::SliceDescription& nodes = service_->slice(slice);
        const auto width = static_cast<std::uint32_t>(nodes.axis_b.size());
        for (std::uint32_t node = 0; node < nodes.node_count(); ++node) {
          if (nodes.kind == adaptive::SliceKind::samples && !is_corner(nodes, node / width, node % width)) continue;
          ++rows;
          if (service_->look_up(slice, node / width, node % width).state == adaptive::RowState::converged) ++converged;
        }
      }
      if (converged == rows || pass == passes) return;
      service_->publish();
    }
  }

  Asked what_;
  fiber::ModelService learned_;
  adaptive::Service* service_ = nullptr;  ///< of learned_
  std::unique_ptr<fiber::FiberModel> model_;
  std::vector<fiber::FiberId> ids_;
};

inline bool is_ours(std::string_view model) { return model == "elliptical" || model == "rough"; }

inline WeightBound bound_of(const Asked& what, const AdversarialFiber& fiber) {
  const std::string_view model = what.model;
  if (model == "elliptical") return elliptical_bound(fiber, what.estimator, what.taught == Taught::converged);
  // Drawn exactly as they are; the others are not normalised, and 100 shows the worst.
  if (model == "chiang2016" || model == "deon2011" || model == "rough") return {1.01, 1.01};
  return {100, 100};
}

/// As light sampling finds a direction: through a vector of floats in the frame.
inline fiber::FiberDirection through_a_vector(const fiber::FiberDirection& wi) {
  const float cosine = std::max(0.0f, std::cos(wi.theta));
  const glm::vec3 direction =
      glm::normalize(glm::vec3(cosine * std::cos(wi.phi), cosine * std::sin(wi.phi), std::sin(wi.theta)));
  const float phi = std::atan2(direction.y, direction.x);
  return {std::asin(std::clamp(direction.z, -1.0f, 1.0f)), phi >= std::numbers::pi_v<float> ? -phi : phi};
}

inline constexpr int directions_per_event = 6, queries_per_event = directions_per_event + 2;

/// Asks one fiber event by event: a sample, the same direction again, that direction as light sampling has it, and
/// adversarial directions. One thread each.
class AdversarialQueries {
 public:
  AdversarialQueries(const TaughtModel& taught, const AdversarialFiber& fiber, std::size_t id)
      : taught_(taught),
        fiber_(fiber),
        id_(taught.id(id)),
        bound_(bound_of(taught.what(), fiber)),
        checks_(taught.model(), taught.what().estimator == fiber::Estimator::corrected) {
    for (const glm::vec3& gain : fiber.parameters.gain)
      largest_gain_ = std::max({largest_gain_, double{gain.x}, double{gain.y}, double{gain.z}});
  }
  const QueryChecks& checks() const { return checks_; }

  /// Calls check(event, direction, value, failures) for each query.
  template <class Check>
  void ask(RandomStream random, Check&& check) {
    const fiber::FiberModel& model = taught_.model();
    AdversarialEvent asked = adversarial_event(random, fiber_);
    const fiber::FiberEvent event = model.begin(id_, asked.wr, asked.xi1, asked.xi2, asked.h);
    to_edge_of_lobes(random, event, asked.u);
    float energy = 0;
    for (const glm::vec3& lobe : event.energy) energy += luminance(lobe);
    // What is not normalised is held to the bound under the largest gain.
    const double scale = bound_.of_r == 100 ? largest_gain_ : double{energy};
    // What can only be sampled weighs what one path brings.
    const WeightBound bound =
        model.evaluates(event) ? WeightBound{bound_.of_r * scale, bound_.of_rest * scale} : WeightBound{};
    const auto fail = [this](Failure failure) { failures_.push_back(failure); };
    const auto checked = [&](const fiber::FiberDirection& wi, const fiber::FiberValue& value) {
      check(std::as_const(asked), wi, value, std::as_const(failures_));
      failures_.clear();
    };
    const fiber::FiberSample sample = model.sample(event, asked.u);
    checks_.event(event, fail);
    checks_.direction(sample.wi, fail);
    checks_.value(sample.value, bound, fail);
    if (!(sample.value.pdf > 0)) fail(Failure::bad_density);
    checked(sample.wi, sample.value);
    if (!model.evaluates(event)) return;
    const fiber::FiberValue again = model.evaluate(event, sample.wi);
    checks_.agreement(sample.value, again, is_ours(taught_.what().model), fail);
    checked(sample.wi, again);
    for (int k = 0; k < directions_per_event; ++k) {
      const fiber::FiberDirection wi =
          k == 0 ? through_a_vector(sample.wi) : adversarial_direction(random, fiber_, asked.wr);
      const fiber::FiberValue value = model.evaluate(event, wi);
      checks_.value(value, bound, fail);
      checked(wi, value);
    }
  }

 private:
  const TaughtModel& taught_;
  const AdversarialFiber& fiber_;
  fiber::FiberId id_;
  WeightBound bound_;
  double largest_gain_ = 1;
  QueryChecks checks_;
  std::vector<Failure> failures_;
};

}  // namespace tress::test
