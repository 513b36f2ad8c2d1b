// The longitudinal lobe's shape (the paper's section 3.1 and figure 4): how far the logistic, the Gaussian and the
// Cauchy law are from each other and from where a rough fiber traced in three dimensions sends its light. JSON on
// stdout.
//
//   bench_longitudinal_shapes [--paths N]     of each of 16 fibers; all threads
//
// `to_gaussian`: least relative squared L2, integral (M - G)^2 / integral G^2 over the hemisphere, over the width of a
// law to a Gaussian lobe G of the same tilt whose half width is that of a logistic of scale lambda; at_equal_width:
// without the search. `to_fiber`: the same to the distribution of theta_i of R, TT, TRT and TRRT of a clear, round,
// untilted fiber with Beckmann facets of roughness alpha, in bins of a degree, whose own noise (from two halves) is
// taken out: with width and shift by the program's rule, and with those that fit best. R has its |cos| of the azimuth
// in both.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "fiber/circle_ray.h"
#include "fiber/longitudinal.h"
#include "fiber/rough_fiber.h"
#include "tress/base/random.h"
#include "tress/fiber/parameters.h"

namespace {

using namespace tress;
using fiber::LongitudinalShape;

constexpr double pi = std::numbers::pi, degree = pi / 180;
constexpr int bins = 180, points_a_bin = 4, orders = 4;
using Bins = std::array<double, bins>;
constexpr std::array<std::pair<const char*, LongitudinalShape>, 3> shapes{{{"logistic", LongitudinalShape::logistic},
                                                                           {"gaussian", LongitudinalShape::gaussian},
                                                                           {"cauchy", LongitudinalShape::cauchy}}};
constexpr std::array<const char*, orders> names{"R", "TT", "TRT", "TRRT"};

struct Width {
  double lambda, shift;  ///< radians, of theta_h
};

/// Coordinate search in the logarithm of the width and in the shift.
Width best_width(Width width, bool with_shift, const std::function<double(const Width&)>& error) {
  double best = error(width);
  for (double step = 0.4; step > 1e-3;) {
    bool better = false;
    for (const double sign : {1.0, -1.0}) {
      for (const bool shifts : {false, true}) {
        if (shifts && !with_shift) continue;
        Width tried = width;
        if (shifts)
          tried.shift += sign * step * width.lambda;
        else
          tried.lambda = std::clamp(tried.lambda * std::exp(sign * step), 0.25 * degree, 45 * degree);
        const double e = error(tried);
        if (e < best) best = e, width = tried, better = true;
      }
    }
    if (!better) step /= 2;
  }
  return width;
}

double distance(const Bins& ours, const Bins& theirs) {
  double error = 0, norm = 0;
  for (std::size_t i = 0; i < bins; ++i) {
    error += (ours[i] - theirs[i]) * (ours[i] - theirs[i]);
    norm += theirs[i] * theirs[i];
  }
  return error / norm;
}

/// Masses of the bins. p: 0 has the factor |cos gamma| of R, averaged over the width of a round fiber.
Bins lobe(int p, double theta_r, LongitudinalShape shape, const Width& width) {
  Bins all{};
  const int offsets = p == 0 ? 24 : 1;
  double light = 0;
  for (int k = 0; k < offsets; ++k) {
    const double h = (k + 0.5) / offsets;
    const double share =
        p > 0 ? 1.0
              : static_cast<double>(
                    fiber::CircleRay(1.55f, static_cast<float>(theta_r), static_cast<float>(h)).reflectance);
    const double lambda = width.lambda * (p > 0 ? 1 : std::sqrt(1 - h * h));
    const fiber::LongitudinalLobe m(static_cast<float>(theta_r), static_cast<float>(width.shift),
                                    static_cast<float>(lambda), shape);
    light += share;
    for (int i = 0; i < bins * points_a_bin; ++i) {
      const double theta = -pi / 2 + (i + 0.5) * pi / (bins * points_a_bin);
      all[static_cast<std::size_t>(i / points_a_bin)] +=
          share * m.density(static_cast<float>(theta)) * pi / (bins * points_a_bin);
    }
  }
  for (double& x : all) x /= light;
  return all;
}

nlohmann::json to_gaussian() {
  nlohmann::json all;
  for (const double theta_r : {0.0, 60.0}) {
    for (const double lambda : {1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 14.0, 20.0}) {
      const Bins truth = lobe(1, theta_r * degree, LongitudinalShape::gaussian, {lambda * degree, 0});
      nlohmann::json one{{"theta_r_deg", theta_r}, {"lambda_deg", lambda}};
      for (const auto& [name, shape] : shapes) {
        if (shape == LongitudinalShape::gaussian) continue;
        const auto error = [&](const Width& width) { return distance(lobe(1, theta_r * degree, shape, width), truth); };
        const Width best = best_width({lambda * degree, 0}, false, error);
        one[name] = {{"best", error(best)},
                     {"best_over_equal_width", best.lambda / (lambda * degree)},
                     {"at_equal_width", error({lambda * degree, 0})}};
      }
      all.push_back(one);
    }
  }
  return all;
}

/// Flux of each order by theta_i, of mass 1, and its noise as distance() has it.
struct Traced {
  std::array<Bins, orders> flux{};
  std::array<double, orders> noise{}, energy{};
};

Traced trace(const fiber::FiberParameters& parameters, double theta_r, std::uint64_t paths, std::uint64_t seed) {
  const fiber::RoughFiber rough(parameters);
  std::array<std::array<Bins, orders>, 2> half{};
  for (std::uint64_t k = 0; k < paths; ++k) {
    RandomStream random(seed, k);
    const fiber::RoughEntry entry = rough.entry({static_cast<float>(theta_r), 0}, 2 * random.next() - 1);
    const std::array<float, 4> u{random.next(), random.next(), random.next(), random.next()};
    const fiber::RoughExit exit = rough.trace(entry, u, random);
    if (exit.order >= orders || !(exit.throughput.g > 0)) continue;
    const double at = (static_cast<double>(exit.angles().theta) / pi + 0.5) * bins;
    half[k % 2][static_cast<std::size_t>(exit.order)][static_cast<std::size_t>(std::clamp(at, 0.0, bins - 1.0))] +=
        static_cast<double>(exit.throughput.g);
  }
  Traced traced;
  for (std::size_t p = 0; p < orders; ++p) {
    double mass = 0, noise = 0, norm = 0;
    for (std::size_t i = 0; i < bins; ++i) mass += traced.flux[p][i] = half[0][p][i] + half[1][p][i];
    for (std::size_t i = 0; i < bins; ++i) {
      noise += (half[0][p][i] - half[1][p][i]) * (half[0][p][i] - half[1][p][i]);
      norm += traced.flux[p][i] * traced.flux[p][i];
      traced.flux[p][i] /= std::max(mass, 1e-30);
    }
    traced.noise[p] = noise / std::max(norm, 1e-30);
    traced.energy[p] = mass / static_cast<double>(paths);
  }
  return traced;
}

nlohmann::json of_fiber(double alpha, double theta_r, std::uint64_t paths, std::uint64_t seed) {
  fiber::FiberParameters parameters;
  parameters.eccentricity = 1;
  parameters.roughness = static_cast<float>(alpha);
  parameters.tilt = 0;
  parameters.sigma_a = glm::vec3(0.0f);
  const Traced traced = trace(parameters, theta_r, paths, seed);
  nlohmann::json all;
  for (int p = 0; p < orders; ++p) {
    const auto at = static_cast<std::size_t>(p);
    const auto r = static_cast<float>(theta_r);
    const Width rule{static_cast<double>(fiber::longitudinal_lambda(parameters, p, r)),
                     static_cast<double>(fiber::roughness_shift(parameters, p, r))};
    nlohmann::json one{{"alpha", alpha},
                       {"theta_r_deg", std::round(theta_r / degree)},
                       {"lobe", names[at]},
                       {"energy", traced.energy[at]},
                       {"noise", traced.noise[at]},
                       {"rule_lambda_deg", rule.lambda / degree},
                       {"rule_shift_deg", rule.shift / degree},
                       {"theta_i", nlohmann::json(traced.flux[at])}};
    for (const auto& [name, shape] : shapes) {
      const auto error = [&](const Width& width) { return distance(lobe(p, theta_r, shape, width), traced.flux[at]); };
      const Width best = best_width(rule, true, error);
      const auto beyond_noise = [&](const Width& width) { return std::max(error(width) - traced.noise[at], 0.0); };
      one[name] = {{"rule", beyond_noise(rule)},
                   {"best", beyond_noise(best)},
                   {"best_lambda_deg", best.lambda / degree},
                   {"best_shift_deg", best.shift / degree}};
    }
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t paths = 200000;
  if (argc == 3 && std::string(argv[1]) == "--paths") paths = std::strtoull(argv[2], nullptr, 10);
  if (paths < 2 || (argc != 1 && argc != 3)) {
    fmt::print(stderr, "usage: bench_longitudinal_shapes [--paths N]\n");
    return 2;
  }
  std::vector<std::pair<double, double>> fibers;
  for (const double alpha : {0.05, 0.1, 0.2, 0.3}) {
    for (const double theta_r : {0.0, 30.0, 60.0, 80.0}) fibers.emplace_back(alpha, theta_r * degree);
  }
  std::vector<nlohmann::json> found(fibers.size());
  const std::size_t workers = std::max(1u, std::thread::hardware_concurrency());
  std::vector<std::jthread> threads;
  for (std::size_t worker = 0; worker < workers; ++worker) {
    threads.emplace_back([&, worker] {
      for (std::size_t i = worker; i < fibers.size(); i += workers)
        found[i] = of_fiber(fibers[i].first, fibers[i].second, paths, i + 1);
    });
  }
  threads.clear();
  nlohmann::json result{{"paths", paths}, {"to_gaussian", to_gaussian()}, {"to_fiber", nlohmann::json::array()}};
  for (const auto& lobes : found) result["to_fiber"].insert(result["to_fiber"].end(), lobes.begin(), lobes.end());
  fmt::print("{}\n", result.dump());
}
