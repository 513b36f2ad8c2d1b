#include "fit/ribbon_tilt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>

#include "base/pi.h"
#include "fit/layer_step.h"

// foreach_target compiles this once for every instruction set; the first call chooses the machine's.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit/ribbon_tilt.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "base/exp_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace tress::inline v0_2::adaptive {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Doubles = hn::CappedTag<double, 8>;
using D = hn::Vec<Doubles>;

void AddTilted(const TiltedKnots& knots, const RowHarmonics& harmonics, const MeanDirections& lambda, TiltSums& sums) {
  const Doubles d;
  for (std::size_t g = 0; g < fit_lanes; g += hn::Lanes(d)) {
    const auto load = [&](const std::array<double, fit_lanes>& from) HWY_ATTR { return hn::LoadU(d, from.data() + g); };
    D mass = hn::Zero(d), of_hat[tilt_harmonics], by_knot[tilt_harmonics], slopes[tilt_harmonics][tilt_harmonics];
    for (std::size_t j = 0; j < tilt_harmonics; ++j) {
      of_hat[j] = by_knot[j] = hn::Zero(d);
      for (D& slope : slopes[j]) slope = hn::Zero(d);
    }
    for (std::size_t k = 0; k < knots.size(); ++k) {
      const KnotHarmonics& harmonic = harmonics.knots[k];
      D exponent = hn::Zero(d);
      for (std::size_t j = 0; j < tilt_harmonics; ++j)
        exponent = hn::MulAdd(load(lambda[j]), load(harmonic.at[j]), exponent);
      const D density = hn::Mul(load(knots[k].density), tress::HWY_NAMESPACE::Exp(exponent));
      const D light = hn::Mul(density, load(knots[k].hat));
      mass = hn::Add(mass, light);
      for (std::size_t j = 0; j < tilt_harmonics; ++j) {
        const D moved = hn::Mul(density, load(harmonic.of_hat[j]));
        of_hat[j] = hn::Add(of_hat[j], moved);
        by_knot[j] = hn::MulAdd(light, load(harmonic.at[j]), by_knot[j]);
        for (std::size_t i = 0; i < tilt_harmonics; ++i)
          slopes[j][i] = hn::MulAdd(moved, load(harmonic.at[i]), slopes[j][i]);
      }
    }
    hn::StoreU(mass, d, sums.mass.data() + g);
    for (std::size_t j = 0; j < tilt_harmonics; ++j) {
      hn::StoreU(of_hat[j], d, sums.of_hat[j].data() + g);
      hn::StoreU(by_knot[j], d, sums.by_knot[j].data() + g);
      for (std::size_t i = 0; i < tilt_harmonics; ++i) hn::StoreU(slopes[j][i], d, sums.slopes[j][i].data() + g);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tress::inline v0_2::adaptive
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tress::inline v0_2::adaptive {

HWY_EXPORT(AddTilted);

namespace {

constexpr int most_tilt_steps = 6;
constexpr double largest_tilt_step = 0.5, largest_tilt = 2;  // change of the logarithm of a density
constexpr double near_enough = 1e-6;                         // the standard error of a mean of 1e12 exits

using Vector = std::array<double, tilt_harmonics>;
using Matrix = std::array<Vector, tilt_harmonics>;

/// The integrals of (1 - s/width) e^(i order s) over s from 0 to `width`, by order and by width in bins.
struct HalfHats {
  std::array<std::array<std::complex<double>, RowExits::bins + 1>, RowExits::orders> of;
  std::array<std::complex<double>, RowExits::bins> directions;
  HalfHats() {
    for (std::size_t order = 1; order <= RowExits::orders; ++order) {
      of[order - 1][0] = 0;
      for (std::size_t bins = 1; bins <= RowExits::bins; ++bins) {
        const double n = static_cast<double>(order);
        const double width = two_pi * static_cast<double>(bins) / RowExits::bins;
        of[order - 1][bins] =
            std::complex<double>(0, 1 / n) + (1.0 - std::exp(std::complex<double>(0, n * width))) / (n * n * width);
      }
    }
    for (std::uint32_t bin = 0; bin < RowExits::bins; ++bin) {
      directions[bin] = std::exp(std::complex<double>(0, RowExits::azimuth(bin)));
    }
  }
};

template <std::size_t count>
void place(const LayerLanes<count>& layer, const HalfHats& hats, KnotHarmonics* out) {
  for (std::size_t p = 0; p < RowExits::most_parts; ++p) {
    const auto& bin = layer.bin[p];
    const auto bins_after = [&](std::size_t k) {
      return k + 1 < count ? bin[k + 1] - bin[k] : bin[0] + RowExits::bins - bin[k];
    };
    for (std::size_t k = 0; k < count; ++k) {
      const std::complex<double> direction = hats.directions[bin[k]];
      std::complex<double> at = 1;
      for (std::size_t order = 0; order < RowExits::orders; ++order) {
        at *= direction;
        const std::complex<double> hat =
            at * (hats.of[order][bins_after(k)] + std::conj(hats.of[order][bins_after(layer.before(k))]));
        for (const std::size_t lane : {p, p + RowExits::most_parts}) {
          out[k].at[2 * order][lane] = at.real(), out[k].at[2 * order + 1][lane] = at.imag();
          out[k].of_hat[2 * order][lane] = hat.real(), out[k].of_hat[2 * order + 1][lane] = hat.imag();
        }
      }
    }
  }
}

/// Gaussian elimination with full pivoting; an unknown that depends on others alone is 0.
Vector solve(Matrix a, Vector b) {
  std::array<std::size_t, tilt_harmonics> column;
  std::iota(column.begin(), column.end(), std::size_t{0});
  double first = 0;
  std::size_t rank = 0;
  for (; rank < tilt_harmonics; ++rank) {
    std::size_t row = rank, col = rank;
    for (std::size_t i = rank; i < tilt_harmonics; ++i) {
      for (std::size_t j = rank; j < tilt_harmonics; ++j) {
        if (std::abs(a[i][j]) > std::abs(a[row][col])) row = i, col = j;
      }
    }
    const double pivot = std::abs(a[row][col]);
    if (rank == 0) first = pivot;
    if (!(pivot > 4 * std::numeric_limits<double>::epsilon() * first)) break;
    std::swap(a[rank], a[row]);
    std::swap(b[rank], b[row]);
    for (Vector& of : a) std::swap(of[rank], of[col]);
    std::swap(column[rank], column[col]);
    for (std::size_t i = rank + 1; i < tilt_harmonics; ++i) {
      const double factor = a[i][rank] / a[rank][rank];
      for (std::size_t j = rank + 1; j < tilt_harmonics; ++j) a[i][j] -= factor * a[rank][j];
      b[i] -= factor * b[rank];
    }
  }
  Vector x{};
  for (std::size_t i = rank; i-- > 0;) {
    double sum = b[i];
    for (std::size_t j = i + 1; j < rank; ++j) sum -= a[i][j] * x[column[j]];
    x[column[i]] = sum / a[i][i];
  }
  return x;
}

double norm(const Vector& x) { return std::sqrt(std::inner_product(x.begin(), x.end(), x.begin(), 0.0)); }

/// Newton's method for one problem.
struct Tilt {
  Vector lambda{}, best{};
  double least_off = std::numeric_limits<double>::infinity();
  bool ends = false;

  void step(const TiltSums& sums, std::size_t lane, const MeanDirections& directions) {
    const double mass = sums.mass[lane];
    Vector off;
    for (std::size_t j = 0; j < tilt_harmonics; ++j) off[j] = directions[j][lane] - sums.of_hat[j][lane] / mass;
    const double is_off = norm(off);
    ends = !std::isfinite(is_off);
    if (ends) return;
    if (is_off < least_off) {
      least_off = is_off;
      best = lambda;
    }
    ends = is_off < near_enough;
    if (ends) return;
    Matrix jacobian;
    for (std::size_t j = 0; j < tilt_harmonics; ++j) {
      for (std::size_t i = 0; i < tilt_harmonics; ++i) {
        jacobian[j][i] = sums.slopes[j][i][lane] / mass - sums.of_hat[j][lane] * sums.by_knot[i][lane] / (mass * mass);
      }
    }
    const Vector by = solve(jacobian, off);
    const double length = norm(by), shortened = std::min(1.0, largest_tilt_step / std::max(length, 1e-12));
    ends = !std::isfinite(length);
    if (ends) return;
    for (std::size_t j = 0; j < tilt_harmonics; ++j) lambda[j] += shortened * by[j];
    ends = norm(lambda) > largest_tilt;
  }
};

TiltedKnots knots_of(const RibbonLanes& lanes) {
  TiltedKnots knots;
  const auto copy = [](const KnotLanes& knot, TiltedKnot& to) {
    std::copy(knot.density.begin(), knot.density.end(), to.density.begin());
    std::copy(knot.hat.begin(), knot.hat.end(), to.hat.begin());
  };
  for (std::size_t k = 0; k < Ribbon::main_knots; ++k) copy(lanes.main.knots[k], knots[k]);
  for (std::size_t k = 0; k < Ribbon::broad_knots; ++k) copy(lanes.broad.knots[k], knots[Ribbon::main_knots + k]);
  return knots;
}

}  // namespace

void place_harmonics(const RibbonLanes& lanes, RowHarmonics& out) {
  static const HalfHats hats;
  place(lanes.main, hats, out.knots.data());
  place(lanes.broad, hats, out.knots.data() + Ribbon::main_knots);
}

MeanDirections mean_directions(const RibbonLanes& lanes, const RowHarmonics& harmonics) {
  TiltSums sums;
  HWY_DYNAMIC_DISPATCH(AddTilted)(knots_of(lanes), harmonics, MeanDirections{}, sums);
  MeanDirections directions;
  for (std::size_t j = 0; j < tilt_harmonics; ++j) {
    for (std::size_t lane = 0; lane < fit_lanes; ++lane) directions[j][lane] = sums.of_hat[j][lane] / sums.mass[lane];
  }
  return directions;
}

void match_directions(RibbonLanes& lanes, const RowHarmonics& harmonics, const MeanDirections& directions) {
  const TiltedKnots knots = knots_of(lanes);
  std::array<Tilt, fit_lanes> tilts;
  for (std::size_t lane = 0; lane < fit_lanes; ++lane) tilts[lane].ends = !lanes.active[lane];
  for (int step = 0; step < most_tilt_steps; ++step) {
    MeanDirections lambda;
    for (std::size_t j = 0; j < tilt_harmonics; ++j) {
      for (std::size_t lane = 0; lane < fit_lanes; ++lane) lambda[j][lane] = tilts[lane].lambda[j];
    }
    TiltSums sums;
    HWY_DYNAMIC_DISPATCH(AddTilted)(knots, harmonics, lambda, sums);
    bool all_end = true;
    for (std::size_t lane = 0; lane < fit_lanes; ++lane) {
      if (!tilts[lane].ends) tilts[lane].step(sums, lane, directions);
      all_end = all_end && tilts[lane].ends;
    }
    if (all_end) break;
  }
  const auto tilt = [&](KnotLanes& knot, const KnotHarmonics& harmonic) {
    for (std::size_t lane = 0; lane < fit_lanes; ++lane) {
      double exponent = 0;
      for (std::size_t j = 0; j < tilt_harmonics; ++j) exponent += tilts[lane].best[j] * harmonic.at[j][lane];
      knot.density[lane] *= std::exp(static_cast<float>(exponent));
    }
  };
  for (std::size_t k = 0; k < Ribbon::main_knots; ++k) tilt(lanes.main.knots[k], harmonics.knots[k]);
  for (std::size_t k = 0; k < Ribbon::broad_knots; ++k) {
    tilt(lanes.broad.knots[k], harmonics.knots[Ribbon::main_knots + k]);
  }
  scale_to_one(lanes);
}

}  // namespace tress::inline v0_2::adaptive
#endif
