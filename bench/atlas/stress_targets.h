// Rows that are hard to learn, as targets that are nothing but lists of rays.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "accuracy/random_rows.h"
#include "fiber/elliptical_target.h"
#include "fiber/row_axes.h"
#include "tress/adaptive/target.h"
#include "tress/adaptive/traced_nodes.h"
#include "tress/base/random.h"

namespace tress::bench {

struct StressRow {
  std::vector<adaptive::TracedRay> rays;
  float blur_rad = 0.2f;
};

/// Rows by their number: slice i has one node, row i. Thread-safe.
class ListedTarget final : public adaptive::Target {
 public:
  explicit ListedTarget(std::vector<StressRow> rows) : rows_(std::move(rows)) {}

  void trace(const adaptive::SliceDescription& slice, float, float,
             std::vector<adaptive::TracedRay>& out) const override {
    const StressRow& row = rows_[slice.key.lobe];
    out.insert(out.end(), row.rays.begin(), row.rays.end());
  }
  std::string model_name() const override { return "listed-1"; }

  std::size_t size() const { return rows_.size(); }
  adaptive::SliceDescription slice(std::size_t i) const {
    adaptive::SliceDescription slice;
    slice.key.lobe = static_cast<std::uint32_t>(i);
    slice.axis_a = slice.axis_b = {0.0f};
    slice.blur_rad = rows_[i].blur_rad;
    return slice;
  }
  adaptive::TracedNodes nodes(std::size_t i) const { return {rows_[i].rays, rows_[i].blur_rad}; }

 private:
  std::vector<StressRow> rows_;
};

/// What rows are made of. Of fibers: wide, hard and whole as RandomRows has them; degree, sigma 1 degree; tir, rows
/// that total internal reflection cuts (a tenth to nine tenths of their rays come out; e 0.5 to 0.8, sigma 1 to 10).
/// Made up: flat; zero, of no light or 1e-30 to 1e-3 of it; spike, one direction blurred by 0.1 to 2 degrees; comb, 2
/// to 20 directions of Pareto masses (index 1) blurred by 1 degree; hidden, a flat row with a thousandth to a tenth of
/// its light in one direction blurred by 1 degree; two hidden, in two directions; neighbours, one direction blurred by
/// 1 degree with a hundredth to a third of its light 2 to 10 blurs beside it. In phase with the gap fill of an empty
/// sketch, so that it sees next to nothing of them: phase, a lobe and 4 to 44 bumps midway between two
/// points, of 0.5 to 2.5 hundredths of the variation in all, blurred by 0.6 to 6 degrees; fine phase, by 0.6 degrees.
class StressTargets {
 public:
  StressTargets(std::uint64_t seed, std::string family)
      : random_(seed, 3000), family_(std::move(family)), fibers_(seed, family_, false) {}

  StressRow next() {
    if (family_ == "degree" || family_ == "tir") return fiber_row();
    if (family_ == "flat") return rays_over_circle(std::pow(10.0, between(-3, 0)), 0, float(between(1, 25)) * degree);
    if (family_ == "zero") {
      return rays_over_circle(random_.next() < 0.2f ? 0 : std::pow(10.0, between(-30, -3)), between(0, 1), 5 * degree);
    }
    if (family_ == "spike") return rays_over_circle(std::pow(10.0, between(-1, 0)), 1, float(between(0.1, 2)) * degree);
    if (family_ == "hidden") return rays_over_circle(between(0.1, 1), std::pow(10.0, between(-3, -1)), degree);
    if (family_ == "comb") return comb();
    if (family_ == "two hidden") return two_hidden();
    if (family_ == "neighbours") return neighbours();
    if (family_ == "phase") return in_phase(float(0.6 * std::pow(10.0, between(0, 1))) * degree);
    if (family_ == "fine phase") return in_phase(0.6f * degree);
    RandomRows::Row row = fibers_.next(target_);
    return {std::move(row.rays), row.description.blur_rad};
  }

 private:
  static constexpr float degree = std::numbers::pi_v<float> / 180;

  double between(double low, double high) { return low + (high - low) * static_cast<double>(random_.next()); }
  float anywhere() { return static_cast<float>(between(-std::numbers::pi, std::numbers::pi)); }

  /// `lit` of the energy in one direction, the rest from everywhere.
  StressRow rays_over_circle(double energy, double lit, float blur_rad) {
    StressRow row{{{anywhere(), static_cast<float>(energy * lit), 1.0f}}, blur_rad};
    const auto many = static_cast<int>(std::ceil(4 * std::numbers::pi / static_cast<double>(blur_rad)));
    for (int i = 0; i < many && lit < 1; ++i) {
      const auto x = static_cast<float>((2.0 * i / many - 1) * std::numbers::pi);
      row.rays.push_back({x, static_cast<float>(energy * (1 - lit) / many), 1.0f});
    }
    return row;
  }

  StressRow comb() {
    StressRow row{{}, degree};
    const int teeth = 2 + static_cast<int>(between(0, 19));
    double sum = 0;
    std::vector<double> mass;
    for (int i = 0; i < teeth; ++i) sum += mass.emplace_back(1 / std::max(between(0, 1), 1e-3));
    for (const double m : mass) row.rays.push_back({anywhere(), static_cast<float>(m / sum), 1.0f});
    return row;
  }

  StressRow two_hidden() {
    StressRow row = rays_over_circle(between(0.1, 1), std::pow(10.0, between(-3, -1)), degree);
    row.rays.push_back({anywhere(), row.rays[0].weight * static_cast<float>(std::pow(10.0, between(-1, 1))), 1.0f});
    return row;
  }

  StressRow neighbours() {
    StressRow row = rays_over_circle(between(0.1, 1), 1, degree);
    const float away = degree * static_cast<float>(between(2, 10));
    row.rays.push_back(
        {row.rays[0].azimuth + away, row.rays[0].weight * static_cast<float>(std::pow(10.0, between(-2, -0.5))), 1.0f});
    return row;
  }

  /// Bumps as far apart as the points that fill an empty sketch, each between two of them.
  StressRow in_phase(float blur_rad) {
    StressRow row{{}, blur_rad};
    const auto points = static_cast<int>(std::ceil(2 * std::numbers::pi / (2.5 * static_cast<double>(blur_rad))));
    const double apart = 2 * std::numbers::pi / points;
    const float centre = anywhere(), half_width = static_cast<float>(between(0.1, 1));
    for (int i = -16; i <= 16; ++i) {
      row.rays.push_back({centre + half_width * static_cast<float>(i) / 16, 1.0f / 33, 1.0f});
    }
    const double variation = 0.5 / static_cast<double>(half_width) - 0.5 / std::numbers::pi;
    const int bumps = 4 + static_cast<int>(between(0, 0.4) * std::min(points, 100));
    const double of_one = between(0.005, 0.025) * variation / bumps;
    const double mass = std::sqrt(of_one * 2 * std::sqrt(std::numbers::pi) * static_cast<double>(blur_rad));
    for (int i = 0; i < bumps; ++i) {
      const auto gap = std::floor(between(0, points));
      row.rays.push_back({static_cast<float>(apart * (gap + 0.5) - std::numbers::pi), static_cast<float>(mass), 1.0f});
    }
    return row;
  }

  StressRow fiber_row() {
    const bool cut = family_ == "tir";
    for (;;) {
      const auto sigma = static_cast<float>(cut ? between(1, 10) : 1) * degree;
      const auto e = static_cast<float>(cut ? between(0.5, 0.8) : between(0.7, 1));
      adaptive::SliceDescription slice = fiber::elliptical_slice(1 + static_cast<int>(between(0, 3)), 1.55f, e, sigma);
      const float a = slice.axis_a[static_cast<std::size_t>(between(0, static_cast<double>(slice.axis_a.size())))];
      const float b = slice.axis_b[static_cast<std::size_t>(between(0, static_cast<double>(slice.axis_b.size())))];
      StressRow row{{}, sigma};
      target_.trace(slice, a, b, row.rays);
      double energy = 0;
      for (const adaptive::TracedRay& ray : row.rays) energy += static_cast<double>(ray.weight);
      const double all = fiber::traced_node_count(sigma) * (energy < 0.05 ? 4.0 : 1.0);
      const double out = static_cast<double>(row.rays.size()) / all;
      if (energy >= 1e-3 && (!cut || (out > 0.1 && out < 0.9))) return row;
    }
  }

  RandomStream random_;
  std::string family_;
  RandomRows fibers_;
  fiber::EllipticalTarget target_;
};

}  // namespace tress::bench
