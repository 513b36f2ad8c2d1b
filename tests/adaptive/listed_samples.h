// Targets of samples that are hard to test: mixtures of lobes over a cylinder, whose density is known as well.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "tress/adaptive/mixture.h"
#include "tress/adaptive/sampled_target.h"
#include "tress/base/random.h"

namespace tress::testing {

/// Normal in azimuth, wrapped, and in height.
struct CylinderLobe {
  std::uint32_t part;
  double mass, azimuth, height, sd_azimuth, sd_height;
};

struct SampledRowOf {
  std::uint32_t parts = 1;
  std::vector<CylinderLobe> lobes;
  /// A path carries light with this probability, and then so much more of it: the variance of a weight.
  double seldom = 1;
};

/// Slice i has one node, row i. Thread-safe.
class ListedSamples final : public adaptive::SampledTarget {
 public:
  explicit ListedSamples(std::vector<SampledRowOf> rows) : rows_(std::move(rows)) {}

  std::uint32_t parts(const adaptive::SliceDescription& slice) const override { return rows_[slice.key.lobe].parts; }
  void draw(const adaptive::SliceDescription& slice, float, float, std::uint64_t stream, std::uint32_t first,
            std::uint32_t count, std::vector<adaptive::SampledExit>& out) const override {
    const SampledRowOf& row = rows_[slice.key.lobe];
    const double mass = mass_of(row);
    for (std::uint32_t i = first; i < first + count; ++i) {
      RandomStream random(slice.key.lobe, stream, i);
      double left = mass * uniform(random);
      const CylinderLobe* lobe = &row.lobes.front();
      for (const CylinderLobe& one : row.lobes) {
        lobe = &one;
        left -= one.mass;
        if (left < 0) break;
      }
      const double r = std::sqrt(-2 * std::log1p(-uniform(random))), turn = 2 * std::numbers::pi * uniform(random);
      const bool carries = row.seldom >= 1 || uniform(random) < row.seldom;
      if (!carries) continue;
      const double x = std::remainder(lobe->azimuth + lobe->sd_azimuth * r * std::cos(turn), 2 * std::numbers::pi);
      out.push_back({static_cast<float>(x), static_cast<float>(lobe->height + lobe->sd_height * r * std::sin(turn)),
                     lobe->part, static_cast<float>(mass / row.seldom), 0});
    }
  }
  std::string model_name() const override { return "listed-samples-1"; }

  std::size_t size() const { return rows_.size(); }
  static adaptive::SliceDescription slice(std::size_t i) {
    adaptive::SliceDescription slice;
    slice.key.lobe = static_cast<std::uint32_t>(i);
    slice.kind = adaptive::SliceKind::samples;
    slice.axis_a = slice.axis_b = {0.0f};
    return slice;
  }

  /// What leaves in the part, per radian and unit of height.
  double density(std::size_t i, std::uint32_t part, double x, double t) const {
    double sum = 0;
    for (const CylinderLobe& lobe : rows_[i].lobes) {
      const double v = (t - lobe.height) / lobe.sd_height;
      if (lobe.part != part || std::abs(v) > 9) continue;
      double around = 0;
      for (int turn = -2; turn <= 2; ++turn) {
        const double u = (x - lobe.azimuth + 2 * std::numbers::pi * turn) / lobe.sd_azimuth;
        around += std::exp(-0.5 * u * u);
      }
      sum += lobe.mass * around * std::exp(-0.5 * v * v) / (2 * std::numbers::pi * lobe.sd_azimuth * lobe.sd_height);
    }
    return sum;
  }

 private:
  static double uniform(RandomStream& random) { return static_cast<double>(random.next_bits() >> 11) * 0x1p-53; }
  static double mass_of(const SampledRowOf& row) {
    double mass = 0;
    for (const CylinderLobe& lobe : row.lobes) mass += lobe.mass;
    return mass;
  }

  std::vector<SampledRowOf> rows_;
};

/// Rows of a family, by their number.
///   wide: 1 to 4 parts of 1 to 3 lobes, standard deviations of 0.05 to 0.6.
///   rare: the same, and a part or lobe with a thousandth of the light, 0.02 to 0.1 wide, elsewhere.
///   spike: a wide row with 0.003 to 0.1 of its light in one place, 0.005 to 0.02 wide.
///   comb: 4 to 16 lobes 0.02 to 0.05 wide around the cylinder, of Pareto masses.
///   ring: light all around at one height, 0.01 to 0.05 wide, that moves along.
///   double: two heights at the same azimuths, of masses alike.
///   heavy: wide, one path in 3 to 100 carries all the light.
inline std::vector<SampledRowOf> sampled_stress(const std::string& family, std::size_t count, std::uint64_t seed) {
  std::vector<SampledRowOf> rows;
  for (std::size_t i = 0; i < count; ++i) {
    RandomStream random(seed, i, 1);
    const auto between = [&](double a, double b) { return a + (b - a) * static_cast<double>(random.next()); };
    const auto log_between = [&](double a, double b) {
      return a * std::pow(b / a, static_cast<double>(random.next()));
    };
    const auto anywhere = [&] { return between(-std::numbers::pi, std::numbers::pi); };
    SampledRowOf row;
    const auto wide = [&] {
      row.parts = 1 + static_cast<std::uint32_t>(between(0, 3.999));
      for (std::uint32_t p = 0; p < row.parts; ++p) {
        const double mass = log_between(0.03, 1);
        const int lobes = 1 + static_cast<int>(between(0, 2.999));
        for (int k = 0; k < lobes; ++k) {
          row.lobes.push_back(
              {p, mass / lobes, anywhere(), between(-1, 1), log_between(0.05, 0.6), log_between(0.05, 0.6)});
        }
      }
    };
    const auto mass = [&] {
      double sum = 0;
      for (const CylinderLobe& lobe : row.lobes) sum += lobe.mass;
      return sum;
    };
    if (family == "comb") {
      const int teeth = 4 + static_cast<int>(between(0, 12.999));
      const double sd = log_between(0.02, 0.05);
      for (int k = 0; k < teeth; ++k)
        row.lobes.push_back({0, 1 / between(0.05, 1), anywhere(), between(-0.5, 0.5), sd, log_between(0.05, 0.3)});
    } else if (family == "ring") {
      const double sd = log_between(0.01, 0.05), swing = between(0, 1), turn = anywhere();
      for (int k = 0; k < 64; ++k) {
        const double x = 2 * std::numbers::pi * k / 64;
        row.lobes.push_back({0, 1.0 / 64, x, swing * std::cos(x + turn), 0.1, sd});
      }
    } else if (family == "double") {
      const double x = anywhere(), apart = between(0.3, 2), sd = log_between(0.1, 0.5);
      row.lobes = {{0, 1, x, 0, sd, 0.1}, {0, between(0.3, 1), x, apart, sd, log_between(0.05, 0.2)}};
    } else {
      wide();
    }
    if (family == "rare") {
      const std::uint32_t part = random.next() < 0.5f && row.parts < 4 ? row.parts++ : 0;
      const double sd = log_between(0.02, 0.1);
      row.lobes.push_back({part, 1e-3 * mass(), anywhere(), between(-2, 2), sd, sd});
    }
    if (family == "spike") {
      const double share = log_between(0.003, 0.1), sd = log_between(0.005, 0.02);
      row.lobes.push_back({0, share * mass() / (1 - share), anywhere(), between(-1, 1), sd, sd});
    }
    if (family == "heavy") row.seldom = 1 / log_between(3, 100);
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace tress::testing
