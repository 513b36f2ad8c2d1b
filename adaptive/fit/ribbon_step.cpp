#include "fit/ribbon_step.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fit/band_matrix.h"

namespace tress::adaptive {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double largest_mode_step = 1, largest_scale_step = 0.7;  // in scales, of ln scale
constexpr double no_light = 1e-12;  // of the layer's largest density: kept so that light may return

/// Numbers that describe a law (E9): what a Fisher information is made of.
struct LawInformation {
  double mode, cross, scale;
};
LawInformation information_of(HeightLaw law) {
  if (law == HeightLaw::normal) return {1, 2 * std::sqrt(2 / pi), 3};
  return {1.0 / 3, (1 + 2 * std::numbers::ln2) / 3, 1 + (3 + pi * pi) / 9};
}

/// The prior strength/2 (apart/unit)^2 of two neighbours whose numbers move by `a` and `b` units.
void couple(BandMatrix& matrix, BandSteps& step, std::size_t i, std::size_t j, bool wraps, double strength,
            double apart, double a, double b, double per_unit) {
  step[i] -= strength * apart * per_unit * a;
  step[j] += strength * apart * per_unit * b;
  matrix.at(i, i) += strength * a * a * (wraps ? 2 : 1);
  matrix.at(j, j) += strength * b * b * (wraps ? 2 : 1);
  if (!wraps) matrix.at(j, i) -= strength * a * b;
}

/// The light of each knot's hat, with the prior that its density is the mean of its neighbours'.
template <std::size_t count>
void move_densities(RibbonLayer<count>& layer, const std::array<SegmentSums, count>& sums, double exits, double prior) {
  std::array<double, count> next;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t b = layer.before(k);
    const double light = layer.density[k] * (sums[b].light[1] + sums[k].light[0]);
    const double to_before = layer.width(b), to_after = layer.width(k);
    const double between =
        (layer.density[b] * to_after + layer.density[layer.after(k)] * to_before) / (to_before + to_after);
    const double expected = exits * layer.hat(k) * between;
    const double known = 0.5 * (light + expected);  // exits that tell it
    next[k] = (known * light + prior * expected) / (known + prior) / (exits * layer.hat(k));
  }
  const double largest = *std::max_element(next.begin(), next.end());
  for (std::size_t k = 0; k < count; ++k) layer.density[k] = std::max(next[k], no_light * largest);
}

/// A step of Fisher scoring for modes and scales: knots in units of their scales, neighbours coupled by the hats.
template <std::size_t count>
void move_shapes(RibbonLayer<count>& layer, HeightLaw law, const std::array<SegmentSums, count>& sums,
                 const RibbonFitRule& rule) {
  const LawInformation known = information_of(law);
  BandMatrix matrix(3 * count);
  BandSteps step{};
  std::array<std::array<double, 3>, count> unit;
  for (std::size_t k = 0; k < count; ++k) {
    unit[k] = {std::sqrt(layer.scale_below[k] * layer.scale_above[k]), layer.scale_below[k], layer.scale_above[k]};
  }
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t next = layer.after(k);
    const SegmentSums& s = sums[k];
    const std::array<std::size_t, 2> ends{k, next};
    for (std::size_t e = 0; e < 2; ++e) {
      step[3 * ends[e]] += s.mode[e] * unit[ends[e]][0];
      step[3 * ends[e] + 1] += s.scale_below[e] * unit[ends[e]][1];
      step[3 * ends[e] + 2] += s.scale_above[e] * unit[ends[e]][2];
    }
    const double below = layer.scale_below[k] + layer.scale_below[next],
                 above = layer.scale_above[k] + layer.scale_above[next];
    const double p = below / (below + above), q = 1 - p;
    const double fisher[3][3] = {{known.mode, -known.cross * q, known.cross * p},
                                 {-known.cross * q, (known.scale - p) * q, -p * q},
                                 {known.cross * p, -p * q, (known.scale - q) * p}};
    const bool wraps = next < k;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        if (j <= i) {
          matrix.at(3 * k + i, 3 * k + j) += s.information[0] * fisher[i][j] * unit[k][i] * unit[k][j];
          matrix.at(3 * next + i, 3 * next + j) += s.information[2] * fisher[i][j] * unit[next][i] * unit[next][j];
        }
        if (!wraps) {
          matrix.at(3 * next + i, 3 * k + j) += s.information[1] * fisher[i][j] * unit[next][i] * unit[k][j];
        }
      }
    }
    const double scales[2] = {unit[k][0], unit[next][0]};
    const double apart = layer.mode[k] - layer.mode[next], between = scales[0] * scales[1];
    couple(matrix, step, 3 * k, 3 * next, wraps, rule.mode_prior, apart, scales[0] / std::sqrt(between),
           scales[1] / std::sqrt(between), 1 / std::sqrt(between));
    couple(matrix, step, 3 * k + 1, 3 * next + 1, wraps, rule.scale_prior,
           std::log(layer.scale_below[k] / layer.scale_below[next]), 1, 1, 1);
    couple(matrix, step, 3 * k + 2, 3 * next + 2, wraps, rule.scale_prior,
           std::log(layer.scale_above[k] / layer.scale_above[next]), 1, 1, 1);
  }
  for (std::size_t i = 0; i < 3 * count; ++i) matrix.at(i, i) = matrix.at(i, i) * 1.001 + 1e-3;
  matrix.solve(step);
  for (std::size_t k = 0; k < count; ++k) {
    const double mode = layer.mode[k] + unit[k][0] * std::clamp(step[3 * k], -largest_mode_step, largest_mode_step);
    layer.mode[k] = std::clamp(mode, -double{Ribbon::largest_mode}, double{Ribbon::largest_mode});
    const auto move = [&](double scale, double by) {
      return std::clamp(scale * std::exp(std::clamp(by, -largest_scale_step, largest_scale_step)), layer.least_scale,
                        double{Ribbon::largest_scale});
    };
    layer.scale_below[k] = move(layer.scale_below[k], step[3 * k + 1]);
    layer.scale_above[k] = move(layer.scale_above[k], step[3 * k + 2]);
  }
}

}  // namespace

void move_layer(MainLayer& layer, HeightLaw law, const std::array<SegmentSums, Ribbon::main_knots>& sums, double exits,
                const RibbonFitRule& rule) {
  move_shapes(layer, law, sums, rule);
  move_densities(layer, sums, exits, rule.density_prior);
}

void move_layer(BroadLayer& layer, HeightLaw law, const std::array<SegmentSums, Ribbon::broad_knots>& sums,
                double exits, const RibbonFitRule& rule) {
  move_shapes(layer, law, sums, rule);
  move_densities(layer, sums, exits, rule.density_prior);
}

}  // namespace tress::adaptive
