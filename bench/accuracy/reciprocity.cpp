// How far each model is from reciprocity. The light that one direction a sends into another b is that which b sends
// into a: with S in dtheta dphi and w the projected width,
//   w(phi_r) S(r -> i) / cos^2 theta_i = w(phi_i) S(i -> r) / cos^2 theta_r.
// So the light that bins of directions exchange under light from everywhere,
//   T(a, b) = integral over r in a, i in b of w(phi_r) cos^2 theta_r S(r -> i), over that of all r and i,
// is symmetric. The measure is |T - T'| / |T|, T' the transpose, in L2 over pairs of bins: 0 where a model is
// reciprocal, and otherwise how far, in the sense of the far field's own error, exchanging light and eye changes it.
// Without noise: T is estimated twice, by independent paths, and products of the two are taken.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/parallel_for.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "references/far_field.h"
#include "references/registry.h"
#include "references/taught_fiber.h"
#include "results_file.h"

namespace tress {
namespace {

using fiber::FiberDirection;
using references::flux_parts;
using references::whole_flux;

constexpr double pi = std::numbers::pi, degree = pi / 180;
constexpr std::size_t theta_bins = 18, phi_bins = 24, bins = theta_bins * phi_bins, channels = 2;
constexpr std::uint64_t batch = 16384;
constexpr std::size_t batches_at_once = 16;

struct Setting {
  std::vector<std::string> models{"fiber3d", "rough", "elliptical"};
  std::uint64_t paths = 4'000'000, seed = 1;
  double epsilon = 0;
  std::array<float, channels> sigma_a{0.0f, 0.5f};
  std::string json;
};

struct Fiber {
  double e, alpha, tilt_deg;
};
constexpr std::array fibers{Fiber{1, 0.2, 0}, Fiber{0.75, 0.2, 0}, Fiber{0.75, 0.2, 3}, Fiber{0.5, 0.3, 0}};

std::size_t bin_of(const FiberDirection& w) {
  const auto index = [](double turn, std::size_t count) {
    return static_cast<std::size_t>(std::clamp(turn * static_cast<double>(count), 0.0, static_cast<double>(count) - 1));
  };
  return index(static_cast<double>(w.theta) / pi + 0.5, theta_bins) * phi_bins +
         index(0.5 * (static_cast<double>(w.phi) / pi + 1), phi_bins);
}

/// With the density w(phi) cos^2 theta in dtheta dphi: light from everywhere, as the fiber meets it.
FiberDirection drawn_from_everywhere(double e, RandomStream& random) {
  FiberDirection direction;
  do {
    direction.theta = static_cast<float>(pi) * (random.next() - 0.5f);
  } while (random.next() >= std::cos(direction.theta) * std::cos(direction.theta));
  do {
    direction.phi = static_cast<float>(2 * pi) * (random.next() - 0.5f);
  } while (random.next() >= fiber::projected_half_width(direction.phi, static_cast<float>(e)));
  return direction;
}

/// T by part and channel, of one half of the paths.
using Exchange = std::array<std::array<std::vector<double>, channels>, flux_parts>;

struct Path {
  std::size_t pair;  ///< a bins + b
  std::array<std::array<float, channels>, flux_parts> weights;
};

std::vector<Path> trace(const references::TaughtFiber& taught, double e, std::uint64_t seed, std::uint64_t key) {
  RandomStream random(seed, key, 0x65786368ull);
  std::vector<Path> paths;
  for (std::uint64_t i = 0; i < batch; ++i) {
    const FiberDirection wr = drawn_from_everywhere(e, random);
    const float xi1 = random.next(), xi2 = random.next(), h = 2 * random.next() - 1;
    const fiber::FiberEvent event = taught.model().begin(taught.fiber(), wr, xi1, xi2, h);
    const fiber::FiberSample sample =
        taught.model().sample(event, {random.next(), random.next(), random.next(), random.next()});
    if (!(sample.value.pdf > 0)) continue;
    Path& path = paths.emplace_back();
    path.pair = bin_of(wr) * bins + bin_of(sample.wi);
    path.weights = {};
    for (std::size_t lobe = 0; lobe < fiber::lobe_count; ++lobe) {
      for (std::size_t c = 0; c < channels; ++c) {
        const float weight = sample.value.s[lobe][static_cast<int>(c)] / sample.value.pdf;
        path.weights[references::flux_part(lobe)][c] += weight;
        path.weights[whole_flux][c] += weight;
      }
    }
  }
  return paths;
}

Exchange exchange(const references::TaughtFiber& taught, double e, const Setting& setting, std::uint64_t half) {
  Exchange result;
  for (auto& part : result) part.fill(std::vector<double>(bins * bins));
  const std::uint64_t count = (setting.paths / 2 + batch - 1) / batch;
  for (std::uint64_t first = 0; first < count; first += batches_at_once) {
    std::vector<std::vector<Path>> batches(std::min<std::uint64_t>(count - first, batches_at_once));
    tbb::parallel_for(std::size_t{0}, batches.size(),
                      [&](std::size_t b) { batches[b] = trace(taught, e, setting.seed, 2 * (first + b) + half); });
    for (const std::vector<Path>& paths : batches) {
      for (const Path& path : paths) {
        for (std::size_t p = 0; p < flux_parts; ++p) {
          for (std::size_t c = 0; c < channels; ++c) {
            result[p][c][path.pair] += static_cast<double>(path.weights[p][c]) / static_cast<double>(count * batch);
          }
        }
      }
    }
  }
  return result;
}

/// |T - T'| / |T| from two estimates of T. Below 0 in the square is noise about 0.
double asymmetry(const std::vector<double>& one, const std::vector<double>& other) {
  double off = 0, power = 0;
  for (std::size_t a = 0; a < bins; ++a) {
    for (std::size_t b = 0; b < bins; ++b) {
      const std::size_t there = a * bins + b, back = b * bins + a;
      off += (one[there] - one[back]) * (other[there] - other[back]);
      power += one[there] * other[there];
    }
  }
  return std::copysign(std::sqrt(std::abs(off) / power), off);
}

int run(const Setting& setting) {
  nlohmann::ordered_json cells = nlohmann::ordered_json::array();
  fmt::print("|T - T'| / |T|, sigma_a {}; of lobes by themselves.\n\n| e, alpha, tilt | model |",
             fmt::join(setting.sigma_a, " and "));
  for (const char* part : references::flux_part_names) fmt::print(" {} |", part);
  fmt::print("\n|---|---|---|---|---|---|---|\n");
  for (const Fiber& shape : fibers) {
    fiber::FiberParameters parameters;
    parameters.eccentricity = static_cast<float>(shape.e);
    parameters.roughness = static_cast<float>(shape.alpha);
    parameters.tilt = static_cast<float>(shape.tilt_deg * degree);
    parameters.sigma_a = {setting.sigma_a[0], setting.sigma_a[1], setting.sigma_a[1]};
    nlohmann::ordered_json cell{{"e", shape.e}, {"alpha", shape.alpha}, {"tilt_deg", shape.tilt_deg}};
    for (const std::string& model : setting.models) {
      const fiber::ModelInfo* info = references::find_model(model);
      if (info == nullptr) {
        fmt::print(stderr, "{}: no such model\n", model);
        return 2;
      }
      adaptive::Options options;
      if (setting.epsilon > 0) options.epsilon = options.sampled_epsilon = setting.epsilon;
      options.seed = setting.seed;
      references::TaughtFiber taught(*info, parameters, options);
      taught.teach([&](RandomStream& random) { return drawn_from_everywhere(shape.e, random); }, setting.seed);
      const Exchange one = exchange(taught, shape.e, setting, 0), other = exchange(taught, shape.e, setting, 1);
      fmt::print("| {}, {}, {} | {} |", shape.e, shape.alpha, shape.tilt_deg, model);
      for (std::size_t p = 0; p < flux_parts; ++p) {
        std::string text;
        for (std::size_t c = 0; c < channels; ++c) {
          const double off = asymmetry(one[p][c], other[p][c]);
          text += fmt::format("{}{:.3f}", c == 0 ? " " : ", ", off);
          cell["models"][model][references::flux_part_names[p]].push_back(std::round(off * 1e5) / 1e5);
        }
        fmt::print("{} |", text);
      }
      fmt::print("\n");
      std::fflush(stdout);
    }
    cells.push_back(std::move(cell));
  }
  if (setting.json.empty()) return 0;
  const nlohmann::ordered_json result{{"context",
                                       {{"compiler", __VERSION__},
                                        {"paths", setting.paths},
                                        {"bins", {theta_bins, phi_bins}},
                                        {"sigma_a", setting.sigma_a},
                                        {"epsilon", setting.epsilon},
                                        {"seed", setting.seed}}},
                                      {"cells", cells}};
  return bench::write_results(setting.json, result.dump(1) + "\n");
}

}  // namespace
}  // namespace tress

int main(int argc, char** argv) {
  tress::Setting setting;
  CLI::App app("How far each model is from reciprocity");
  app.add_option("--model", setting.models)->delimiter(',');
  app.add_option("--paths", setting.paths)->check(CLI::Range(2, 2000000000));
  app.add_option("--epsilon", setting.epsilon, "of rows; without it each model's default")
      ->check(CLI::Range(1e-6, 1.0));
  app.add_option("--seed", setting.seed);
  app.add_option("--json", setting.json, "file to write");
  CLI11_PARSE(app, argc, argv);
  return tress::run(setting);
}
