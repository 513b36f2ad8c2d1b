// Where a fiber traced in three dimensions sends the light of TRRT and of everything after it, along itself, and how
// far from it the longitudinal lobe of that light is: by the published rule, with 5/2 of the scales' tilt, and that of
// `elliptical` (LobeWidths::as_traced). Markdown on stdout, with --json every cell.
//
//   bench_residual_lobe [--paths N] [--e ...] [--alpha ...] [--tilt ...] [--theta ...] [--cells] [--json FILE]
//
// Clear fibers, in the mean over phi_r. Errors are relative L2 over 36 bins of theta_i of the light of mass 1, by two
// independent traces A and B whose noise is thereby taken out: sqrt(sum (f - A)(f - B) / sum A B). `off` is how far the
// mean of sin theta_i is from the traced one. Both are root mean squares over e, theta_r and the two kinds of light,
// weighted by the light that there is.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "fiber/lobe_widths.h"
#include "fiber/longitudinal.h"
#include "fiber/rough_fiber.h"
#include "tress/base/random.h"
#include "tress/fiber/parameters.h"

namespace {

using namespace tress;

constexpr double pi = std::numbers::pi, degree = pi / 180;
constexpr std::size_t bins = 36;

/// Light by its inclination: the sums of its weights by equal steps of theta_i from -pi/2 up, and of 1, s, s^2, s the
/// sine of theta_i.
struct Light {
  std::array<double, bins> by_theta{};
  double energy = 0, first = 0, second = 0;

  void add(double weight, double sine) {
    const double theta = std::asin(std::clamp(sine, -1.0, 1.0));
    by_theta[std::min(static_cast<std::size_t>((theta / pi + 0.5) * bins), bins - 1)] += weight;
    energy += weight, first += weight * sine, second += weight * sine * sine;
  }
  double mean() const { return first / energy; }
  double deviation() const { return std::sqrt(std::max(second / energy - mean() * mean(), 0.0)); }
};

/// Of TRRT and of what is later.
using Kinds = std::array<Light, 2>;
constexpr std::array<const char*, 2> kind_names{"TRRT", "later"};

Kinds traced(const fiber::FiberParameters& parameters, float theta_r, int paths, std::uint64_t seed) {
  const fiber::RoughFiber rough(parameters);
  RandomStream random(seed);
  Kinds light;
  std::vector<fiber::SplitExit> exits;
  for (int i = 0; i < paths; ++i) {
    const float phi_r = static_cast<float>(2 * pi) * random.next(), h = 2 * random.next() - 1;
    fiber::RoughFiber::FacetNumbers u;
    for (auto& facet : u) facet = {random.next(), random.next()};
    exits.clear();
    rough.trace_split(rough.entry({theta_r, phi_r}, h), u, random, exits);
    for (const fiber::SplitExit& exit : exits) {
      if (exit.order < 3) continue;
      light[exit.order > 3 ? 1 : 0].add(static_cast<double>(exit.weight) / paths,
                                        static_cast<double>(exit.direction.x));
    }
  }
  return light;
}

Light of_lobe(const fiber::LobeWidths& widths, float theta_r) {
  constexpr int points = 3600, lane = fiber::LobeWidths::lane_of(3);
  const fiber::LobeWidths::At at = widths.at(theta_r);
  const fiber::LongitudinalLobe lobe(theta_r, at.tilt[lane] + at.shift[lane], at.lambda[lane]);
  Light light;
  for (int i = 0; i < points; ++i) {
    const double theta = -pi / 2 + (i + 0.5) * pi / points;
    light.add(static_cast<double>(lobe.density(static_cast<float>(theta))) * pi / points, std::sin(theta));
  }
  return light;
}

/// Squared, relative to sum A B.
double error2(const Light& f, const Light& a, const Light& b) {
  double error = 0, norm = 0;
  for (std::size_t i = 0; i < bins; ++i) {
    const double own = f.by_theta[i] / f.energy, one = a.by_theta[i] / a.energy, other = b.by_theta[i] / b.energy;
    error += (own - one) * (own - other);
    norm += one * other;
  }
  return error / norm;
}

struct Sums {
  double weight = 0;
  std::array<double, 2> error{}, off{};  ///< by rule: squares, weighted
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"TRRT and later orders of fibers with tilted scales: traced, and as lobes"};
  int paths = 20000;
  bool cells = false;
  std::string json_file;
  std::vector<double> eccentricities{0.5, 0.75, 1}, alphas{0.05, 0.1, 0.2, 0.4}, tilts{0, 1.5, 3, 5, 8},
      thetas{-60, -30, 0, 30, 60};
  app.add_option("--paths", paths, "of each of two traces of a cell")->check(CLI::PositiveNumber);
  app.add_option("--e", eccentricities)->delimiter(',');
  app.add_option("--alpha", alphas)->delimiter(',');
  app.add_option("--tilt", tilts, "degrees")->delimiter(',');
  app.add_option("--theta", thetas, "theta_r, degrees")->delimiter(',');
  app.add_flag("--cells", cells, "a row a cell, too");
  app.add_option("--json", json_file);
  CLI11_PARSE(app, argc, argv);

  nlohmann::json all = nlohmann::json::array();
  std::string table =
      "| tilt, alpha | light | L2: published | elliptical | mean of sin theta off: published | elliptical "
      "|\n|---|---|---|---|---|---|\n";
  if (cells)
    fmt::print("| tilt, alpha, e, theta_r | light | part | traced: mean, deviation | published | elliptical |\n");
  for (const double tilt : tilts) {
    for (const double alpha : alphas) {
      Sums sums;
      for (const double e : eccentricities) {
        for (const double theta : thetas) {
          fiber::FiberParameters parameters;
          parameters.eccentricity = static_cast<float>(e);
          parameters.roughness = static_cast<float>(alpha);
          parameters.tilt = static_cast<float>(tilt * degree);
          parameters.sigma_a = glm::vec3(0);
          const auto theta_r = static_cast<float>(theta * degree);
          const Kinds a = traced(parameters, theta_r, paths, 1), b = traced(parameters, theta_r, paths, 2);
          const std::array<Light, 2> rules{of_lobe(fiber::LobeWidths(parameters), theta_r),
                                           of_lobe(fiber::LobeWidths::as_traced(parameters), theta_r)};
          for (std::size_t kind = 0; kind < a.size(); ++kind) {
            const double energy = 0.5 * (a[kind].energy + b[kind].energy);
            const double mean = 0.5 * (a[kind].mean() + b[kind].mean());
            const double deviation = 0.5 * (a[kind].deviation() + b[kind].deviation());
            sums.weight += energy;
            nlohmann::json cell{{"tilt", tilt},     {"alpha", alpha},           {"e", e},
                                {"theta_r", theta}, {"part", kind_names[kind]}, {"light", energy},
                                {"mean", mean},     {"deviation", deviation}};
            for (std::size_t rule = 0; rule < rules.size(); ++rule) {
              const double error = error2(rules[rule], a[kind], b[kind]), off = rules[rule].mean() - mean;
              sums.error[rule] += energy * error;
              sums.off[rule] += energy * off * off;
              cell[rule == 0 ? "published" : "elliptical"] = {{"mean", rules[rule].mean()},
                                                              {"deviation", rules[rule].deviation()},
                                                              {"l2", std::sqrt(std::max(error, 0.0))}};
            }
            all.push_back(cell);
            if (cells) {
              fmt::print(
                  "| {:g}, {:g}, {:g}, {:g} | {:.3f} | {} | {:.2f}, {:.2f} | {:.2f}, {:.2f} | {:.2f}, {:.2f} |\n", tilt,
                  alpha, e, theta, energy, kind_names[kind], mean, deviation, rules[0].mean(), rules[0].deviation(),
                  rules[1].mean(), rules[1].deviation());
            }
          }
        }
      }
      const auto root = [&](double sum) { return std::sqrt(std::max(sum, 0.0) / sums.weight); };
      const double share = sums.weight / static_cast<double>(eccentricities.size() * thetas.size());
      table += fmt::format("| {:g}, {:g} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n", tilt, alpha, share,
                           root(sums.error[0]), root(sums.error[1]), root(sums.off[0]), root(sums.off[1]));
    }
  }
  fmt::print("{}", table);
  if (json_file.empty()) return 0;
  std::ofstream out(json_file);
  out << all.dump(1) << '\n';
  return out.flush() ? 0 : 1;
}
