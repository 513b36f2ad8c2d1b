#include "lab/fiber_fit.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <limits>
#include <numeric>
#include <utility>

#include "base/pi.h"
#include "fiber/rough_paths.h"
#include "tress/base/random.h"

namespace tress::lab {
namespace {

constexpr std::uint32_t batch_paths = 512;  // from one direction

fiber::FiberParameters fiber_of(const FiberFitRequest& request, const FiberValues& values) {
  fiber::FiberParameters fiber;
  fiber.eta = static_cast<float>(request.eta);
  fiber.eccentricity = static_cast<float>(values[0]);
  fiber.roughness = static_cast<float>(values[1]);
  fiber.tilt = static_cast<float>(values[2] * degree);
  fiber.sigma_a = glm::vec3(static_cast<float>(values[3]));
  fiber.medulla_radius = static_cast<float>(values[4]);
  fiber.medulla_scattering = static_cast<float>(values[5]);
  return fiber;
}

/// The light of candidates at the samples of a request, per steradian and unit of flux through the widest section.
class TracedLight {
 public:
  explicit TracedLight(const FiberFitRequest& request) : request_(request), order_(request.samples.size()) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::ranges::sort(order_, {}, [&](std::size_t i) { return request.samples[i].theta; });
    for (const std::size_t i : order_) {
      const double theta = request.samples[i].theta, phi = request.samples[i].phi;
      thetas_.push_back(theta);
      directions_.emplace_back(std::sin(theta), std::cos(theta) * std::cos(phi), std::cos(theta) * std::sin(phi));
    }
  }

  Eigen::VectorXd at(const FiberValues& values, std::uint64_t paths, std::uint64_t seed) const {
    const fiber::FiberParameters fiber = fiber_of(request_, values);
    const std::size_t batches = (paths + batch_paths - 1) / batch_paths;
    const auto size = static_cast<Eigen::Index>(order_.size());
    const Eigen::VectorXd sorted = tbb::parallel_deterministic_reduce(
        tbb::blocked_range<std::size_t>(0, batches, 8), Eigen::VectorXd(Eigen::VectorXd::Zero(size)),
        [&](const auto& range, Eigen::VectorXd sum) {
          for (std::size_t i = range.begin(); i != range.end(); ++i) add(fiber, i, batches, seed, sum);
          return sum;
        },
        std::plus<Eigen::VectorXd>());
    Eigen::VectorXd light(size);
    for (std::size_t i = 0; i < order_.size(); ++i)
      light[static_cast<Eigen::Index>(order_[i])] = sorted[static_cast<Eigen::Index>(i)];
    return light / (static_cast<double>(batches) * batch_paths);
  }

 private:
  /// The window of the detector is a Gaussian with the variance and the solid angle of a disc: so smooth that a small
  /// change of the fiber is a small change of the light.
  void add(const fiber::FiberParameters& fiber, std::size_t index, std::size_t batches, std::uint64_t seed,
           Eigen::VectorXd& sum) const {
    const double sigma = request_.detector / 4, reach = 4 * sigma, by_variance = 1 / (sigma * sigma);
    // All rotations are a quarter of a turn and its mirror images.
    const bool mirrored = !request_.rotation;
    RandomStream random(seed, index);
    const double within = static_cast<double>(index) + static_cast<double>(random.next());
    const double phi = request_.rotation.value_or(within / static_cast<double>(batches) * pi / 2);
    const double flux = static_cast<double>(fiber::projected_half_width(static_cast<float>(phi), fiber.eccentricity)) *
                        by_variance / two_pi / (mirrored ? 2 : 1);
    fiber::RoughPaths traced(fiber);
    traced.add_sobol({static_cast<float>(request_.incidence), static_cast<float>(phi)}, mix_bits(seed),
                     static_cast<std::uint32_t>(index) * batch_paths, batch_paths, 0);
    const fiber::RoughPathExits& exits = traced.trace();
    const double cosine = std::cos(phi), sine = std::sin(phi), sigma_a = static_cast<double>(fiber.sigma_a.r);
    for (std::size_t i = 0; i < exits.size(); ++i) {
      const glm::dvec3 there(exits.direction(i));
      const glm::dvec3 direction(there.x, there.y * cosine + there.z * sine, there.z * cosine - there.y * sine);
      const double theta = std::asin(std::clamp(direction.x, -1.0, 1.0));
      const double light =
          flux * static_cast<double>(exits.weight(i)) * std::exp(-sigma_a * static_cast<double>(exits.way(i)));
      const auto first = std::ranges::lower_bound(thetas_, theta - reach) - thetas_.begin();
      for (auto k = first; k < std::ssize(thetas_) && thetas_[static_cast<std::size_t>(k)] < theta + reach; ++k) {
        const glm::dvec3& sample = directions_[static_cast<std::size_t>(k)];
        const double in_plane = sample.x * direction.x + sample.y * direction.y - 1, across = sample.z * direction.z;
        const auto seen = [&](double less) {
          return less < -8 / by_variance ? 0 : light * std::exp(less * by_variance);
        };
        sum[k] += seen(in_plane + across) + (mirrored ? seen(in_plane - across) : 0);
      }
    }
  }

  const FiberFitRequest& request_;
  std::vector<std::size_t> order_;  ///< samples by theta
  std::vector<double> thetas_;
  std::vector<glm::dvec3> directions_;
};

class Fitter {
 public:
  explicit Fitter(const FiberFitRequest& request) : request_(request), traced_(request) {
    const auto size = static_cast<Eigen::Index>(request.samples.size());
    values_.resize(size);
    for (Eigen::Index i = 0; i < size; ++i) values_[i] = request.samples[static_cast<std::size_t>(i)].value;
    roots_ = (values_.cwiseMax(0).array() + 0.05 * values_.cwiseAbs().mean()).rsqrt();
    for (std::size_t n = 0; n < fiber_numbers.size(); ++n) {
      if (!request.held[n]) free_.push_back(n);
    }
  }

  /// A coarse fit by a quarter of the paths goes downhill to where the noise of the least squares ends it. Steps that
  /// only follow the slopes, which have less noise for being those of wide steps, then end it by all paths.
  FiberFit fit() {
    Place at = best_start();
    Pair differences = differences_of(at, coarse);
    double damping = 0.01;
    bool ended = free_.empty();
    for (int step = 0; step < 20 && !ended; ++step) {
      const Slopes slopes = slopes_at(at, coarse);
      const double before = product(differences);
      bool better = false;
      while (!better && damping < 1e3) {
        const Place next = within(at - downhill(slopes, differences, damping));
        const Pair there = differences_of(next, coarse);
        better = product(there) < before;
        damping *= better ? 0.2 : 5;
        if (!better) continue;
        ended = (next - at).cwiseAbs().maxCoeff() < 0.005;
        at = next;
        differences = there;
      }
      ended = ended || !better;
    }
    for (int step = 0; step < 4 && !free_.empty(); ++step) {
      const Place move = downhill(slopes_at(at, 1), differences_of(at, 1), 0).cwiseMax(-0.2).cwiseMin(0.2);
      if (!move.allFinite()) break;
      at = within(at - move);
    }
    return with_errors(at);
  }

 private:
  using Place = Eigen::VectorXd;  // logarithms of the free numbers plus their offsets
  /// Of each sample, by two independent halves of the paths. The noise of a half is in no product of both, so that
  /// fibers with less noise are no better for it.
  using Pair = Eigen::Matrix<double, Eigen::Dynamic, 2>;
  using Slopes = std::array<Eigen::MatrixXd, 2>;

  static constexpr std::uint64_t coarse = 4;  // of the paths of a candidate a share of 1 over this

  static double product(const Pair& differences) { return differences.col(0).dot(differences.col(1)); }
  static Eigen::MatrixXd square_of(const Slopes& slopes) {
    const Eigen::MatrixXd square = slopes[0].transpose() * slopes[1];
    return (square + square.transpose()) / 2;
  }
  static Place downhill(const Slopes& slopes, const Pair& differences, double damping) {
    Eigen::MatrixXd square = square_of(slopes);
    square.diagonal() += damping * square.diagonal().cwiseAbs();
    return square.ldlt().solve(slopes[0].transpose() * differences.col(1) +
                               slopes[1].transpose() * differences.col(0)) /
           2;
  }

  static double logarithm(std::size_t number, double value) { return std::log(value + fiber_numbers[number].offset); }
  FiberValues numbers_at(const Place& place) const {
    FiberValues values{};
    for (std::size_t n = 0; n < values.size(); ++n) values[n] = request_.held[n].value_or(0);
    for (std::size_t k = 0; k < free_.size(); ++k) {
      const FiberNumber& number = fiber_numbers[free_[k]];
      values[free_[k]] = std::clamp(std::exp(place[static_cast<Eigen::Index>(k)]) - number.offset, number.range.least,
                                    number.range.most);
    }
    return values;
  }
  Place within(Place place) const {
    for (std::size_t k = 0; k < free_.size(); ++k) {
      const scene::Range& range = fiber_numbers[free_[k]].range;
      double& x = place[static_cast<Eigen::Index>(k)];
      x = std::clamp(x, logarithm(free_[k], range.least), logarithm(free_[k], range.most));
    }
    return place;
  }

  /// The light of a candidate times the scale that makes the weighted differences least.
  Pair light_at(const Place& place, std::uint64_t paths, std::uint64_t seed, double* scale = nullptr) {
    ++candidates_;
    Pair light(values_.size(), 2);
    for (std::uint64_t half = 0; half < 2; ++half)
      light.col(static_cast<Eigen::Index>(half)) = traced_.at(numbers_at(place), paths / 2, mix_bits(2 * seed + half));
    const Eigen::VectorXd weights = roots_.cwiseAbs2();
    const double square = (light.col(0).cwiseProduct(light.col(1))).dot(weights);
    const double factor = square > 0 ? light.rowwise().mean().cwiseProduct(values_).dot(weights) / square : 0;
    if (scale != nullptr) *scale = factor;
    return factor * light;
  }
  Pair differences_of(const Place& place, std::uint64_t share) {
    return roots_.asDiagonal() * (light_at(place, request_.paths / share, request_.seed).colwise() - values_);
  }

  Place best_start() {
    Place best;
    double least = std::numeric_limits<double>::infinity();
    for (unsigned choice = 0; choice < 1u << free_.size(); ++choice) {
      Place place(static_cast<Eigen::Index>(free_.size()));
      bool known = false;  // a number with one start has been there
      for (std::size_t k = 0; k < free_.size(); ++k) {
        const auto& starts = fiber_numbers[free_[k]].starts;
        known = known || ((choice >> k & 1) != 0 && starts[0] == starts[1]);
        place[static_cast<Eigen::Index>(k)] = logarithm(free_[k], starts[choice >> k & 1]);
      }
      if (known) continue;
      const double square = product(differences_of(place, coarse));
      if (square < least) best = place;
      least = std::min(least, square);
    }
    return best;
  }

  Slopes slopes_at(const Place& at, std::uint64_t share) {
    constexpr double step = 0.15;
    Slopes slopes;
    slopes.fill(Eigen::MatrixXd(values_.size(), at.size()));
    for (Eigen::Index k = 0; k < at.size(); ++k) {
      const Place above = within(at + step * Place::Unit(at.size(), k)),
                  below = within(at - step * Place::Unit(at.size(), k));
      const Pair slope = (differences_of(above, share) - differences_of(below, share)) / (above[k] - below[k]);
      for (Eigen::Index half = 0; half < 2; ++half) slopes[static_cast<std::size_t>(half)].col(k) = slope.col(half);
    }
    return slopes;
  }

  FiberFit with_errors(const Place& at) {
    constexpr int seeds = 16;
    FiberFit fit;
    fit.values = numbers_at(at);
    const Eigen::VectorXd light = light_at(at, request_.paths, request_.seed, &fit.scale).rowwise().mean();
    fit.light.assign(light.begin(), light.end());
    const double whole = values_.cwiseProduct(roots_).norm();
    fit.residual = (light - values_).cwiseProduct(roots_).norm() / whole;
    Eigen::MatrixXd noise(light.size(), seeds);
    for (int s = 0; s < seeds; ++s) {
      const std::uint64_t other = mix_bits(request_.seed + 0x9e3779b97f4a7c15ull * static_cast<std::uint64_t>(s + 1));
      noise.col(s) = light_at(at, request_.paths, other).rowwise().mean().cwiseProduct(roots_);
    }
    noise.colwise() -= noise.rowwise().mean().eval();
    fit.noise = noise.norm() / std::sqrt(seeds - 1.0) / whole;
    if (!free_.empty()) {
      const Slopes slopes = slopes_at(at, 1);
      const Eigen::MatrixXd moves = square_of(slopes).ldlt().solve((slopes[0] + slopes[1]).transpose() * noise / 2);
      const double above = fit.noise > 0 ? std::max(1.0, fit.residual / fit.noise) : 1;
      for (std::size_t k = 0; k < free_.size(); ++k) {
        const double of_logarithm = moves.row(static_cast<Eigen::Index>(k)).norm() / std::sqrt(seeds - 1.0) * above;
        const bool matters = slopes[0].col(static_cast<Eigen::Index>(k)).squaredNorm() > 0;
        fit.errors[free_[k]] = matters ? of_logarithm * (fit.values[free_[k]] + fiber_numbers[free_[k]].offset)
                                       : std::numeric_limits<double>::infinity();
      }
    }
    fit.candidates = candidates_;
    return fit;
  }

  const FiberFitRequest& request_;
  TracedLight traced_;
  Eigen::VectorXd values_, roots_;  ///< roots of the weights
  std::vector<std::size_t> free_;
  int candidates_ = 0;
};

}  // namespace

FiberFit fit_fiber(const FiberFitRequest& request) { return Fitter(request).fit(); }

}  // namespace tress::lab
