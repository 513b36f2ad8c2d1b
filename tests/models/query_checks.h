// What every answer of a fiber model is held to, whatever it was asked. For tests and the atlas (bench/atlas) alike.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>

#include "base/color.h"
#include "fiber/energy_table.h"
#include "fiber/longitudinal.h"
#include "models/adversarial_points.h"
#include "models/registry.h"

namespace tress::test {

enum class Failure {
  not_finite,     ///< NaN or infinity in S
  negative,       ///< S < 0, where the estimator is not `corrected`
  bad_density,    ///< pdf NaN, infinite, negative, or 0 where sample() drew
  no_density,     ///< pdf at its floor where there is light
  disagreement,   ///< sample() and evaluate() at its direction, or evaluate() asked twice
  bad_direction,  ///< out of range, or not of unit length in the world
  heavy_weight,   ///< S/Q above the bound
  bad_event,      ///< energies or selections of begin()
};
inline constexpr std::array<const char*, 8> failure_names{"not finite",        "negative S",         "bad pdf",
                                                          "light without pdf", "sample != evaluate", "bad direction",
                                                          "weight over bound", "bad event"};
inline constexpr std::size_t failure_kinds = failure_names.size();

/// Largest luminance of S/Q that a model owes, by lobes: R is drawn by its own closed form, the rest by rows.
struct WeightBound {
  double of_r = std::numeric_limits<double>::infinity(), of_rest = std::numeric_limits<double>::infinity();
};

/// Times the luminance of all lobes. `elliptical`: rows that answer propose (1 - u) of what they answer, so 1/(1 - u);
/// what answers by g and proposes by something else has u of a uniform density, so peak of g over u/2pi; `corrected`
/// adds 16 times the difference of two such. R: F cos/(E ((1 - g) cos + g/2 sqrt(1 + |h|))), g = (1 - E)^2/2, at most
/// 10 for a round fiber of eta 1.05 seen across, 17 for one of e = 0.5 on its broad side, and less for all else.
inline WeightBound elliptical_bound(const AdversarialFiber& fiber, fiber::Estimator estimator,
                                    bool rows_have_converged) {
  constexpr double of_r = 20, u_converged = 0.02, u_open = 0.05;
  if (estimator == fiber::Estimator::exact) return {of_r, 1 / (1 - u_open)};
  double narrowest = 1;
  for (const float sigma : fiber::azimuthal_sigmas(fiber.parameters)) narrowest = std::min(narrowest, double{sigma});
  // Of shapes of mass 1: the Gaussian's peak, and what images of it add at 45 degrees.
  const double peak = 0.3989423 / narrowest + 0.16, u = rows_have_converged ? u_converged : u_open;
  double of_rest = 1 / (1 - u_converged);
  if (!rows_have_converged || fiber.is_narrow) of_rest = std::max(2 * std::numbers::pi * peak / u, of_rest);
  if (estimator == fiber::Estimator::corrected) of_rest = 15 * of_rest + 16 * 2 * std::numbers::pi * peak / u;
  return {of_r, of_rest};
}

/// What is wrong with the answers to one event, passed to `fail(failure, query, event, value)`.
class QueryChecks {
 public:
  QueryChecks(const fiber::FiberModel& model, bool may_be_negative)
      : model_(model), may_be_negative_(may_be_negative) {}

  static bool is_finite(const fiber::FiberValue& value) {
    float sum = 0;  // any NaN or infinity stays one, or becomes NaN
    for (const glm::vec3& s : value.s) sum += s.x * 0 + s.y * 0 + s.z * 0;
    return sum == 0;
  }

  template <class Fail>
  void event(const fiber::FiberEvent& event, Fail&& fail) const {
    float sum = 0;
    bool sound = true;
    for (std::size_t p = 0; p < fiber::lobe_count; ++p) {
      sum += event.selection[p];
      sound = sound && event.selection[p] >= 0;
      for (int c = 0; c < 3; ++c) sound = sound && event.energy[p][c] >= 0 && std::isfinite(event.energy[p][c]);
    }
    if (!sound || !(std::abs(sum - 1) < 1e-5f)) fail(Failure::bad_event);
  }

  /// bound: times the luminance of the event's energies, already.
  template <class Fail>
  void value(const fiber::FiberValue& value, const WeightBound& bound, Fail&& fail) {
    if (!is_finite(value)) return fail(Failure::not_finite);
    if (!(value.pdf >= 0 && std::isfinite(value.pdf))) return fail(Failure::bad_density);
    if (!may_be_negative_) {
      for (const glm::vec3& s : value.s) {
        if (s.x < 0 || s.y < 0 || s.z < 0) return fail(Failure::negative);
      }
    }
    if (!model_.evaluates()) return;
    const double pdf = value.pdf, of_r = luminance(value.s[0]), all = luminance(value.total());
    if (pdf <= 1.1e-30 && std::abs(all) > 1e-24) return fail(Failure::no_density);
    // Below, densities have lost their digits.
    if (pdf < 1e-28) return;
    largest_weight = std::max(largest_weight, std::abs(all) / pdf);
    largest_of_r = std::max(largest_of_r, of_r / pdf);
    constexpr double rounding = 1.001, of_denormals = 1e-37;
    if (of_r > bound.of_r * pdf * rounding + of_denormals ||
        std::abs(all - of_r) > bound.of_rest * pdf * rounding + of_denormals)
      fail(Failure::heavy_weight);
  }

  template <class Fail>
  void direction(const fiber::FiberDirection& wi, Fail&& fail) const {
    constexpr float pi = std::numbers::pi_v<float>;
    if (!(std::abs(wi.theta) <= pole && wi.phi >= -pi && wi.phi < pi)) return fail(Failure::bad_direction);
    const float cosine = std::max(0.0f, std::cos(wi.theta)), x = cosine * std::cos(wi.phi),
                y = cosine * std::sin(wi.phi), z = std::sin(wi.theta);
    if (!(std::abs(x * x + y * y + z * z - 1) < 1e-5f)) fail(Failure::bad_direction);
  }

  /// sample() and evaluate() owe each other the same answer: ours to the bit, others to 1e-4 of the density.
  template <class Fail>
  void agreement(const fiber::FiberValue& first, const fiber::FiberValue& second, bool to_the_bit, Fail&& fail) const {
    if (to_the_bit) {
      if (first.s != second.s || first.pdf != second.pdf) fail(Failure::disagreement);
      return;
    }
    const float tolerance = 1e-4f * std::max(first.pdf, second.pdf);
    bool agree = std::abs(first.pdf - second.pdf) <= tolerance;
    for (std::size_t p = 0; p < fiber::lobe_count; ++p) {
      for (int c = 0; c < 3; ++c) {
        agree =
            agree && std::abs(first.s[p][c] - second.s[p][c]) <= std::max(tolerance, 1e-4f * std::abs(first.s[p][c]));
      }
    }
    if (!agree) fail(Failure::disagreement);
  }

  double largest_weight = 0, largest_of_r = 0;

 private:
  const fiber::FiberModel& model_;
  bool may_be_negative_;
};

}  // namespace tress::test
