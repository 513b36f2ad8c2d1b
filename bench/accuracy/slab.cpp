// The light of a slab of fibers by every model named: what is far from one fiber may be near in the mean of many, and
// the other way round.
//
// Fibers along u, their major axes turned at random, fill a slab between two planes along u. Light that travels at an
// inclination theta meets them at a rate of cos theta over the mean free path of theta = 0; the slab is `depth` mean
// free paths deep. A path comes in from the camera's direction (inclination, in the plane of u and the slab's normal)
// and leaves at the top (back) or below (through). A fiber that is met shows the azimuth phi with a probability in
// proportion to its width there. Three absorptions at once; paths that keep little end by roulette.
//
// Printed: what leaves at the top and below, and in eight bins of sin theta_i at the top, over `fiber3d`'s.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/parallel_for.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "references/registry.h"
#include "references/taught_fiber.h"
#include "results_file.h"

namespace tress {
namespace {

constexpr double pi = std::numbers::pi, degree = pi / 180;
constexpr std::size_t channels = 3, angles = 8, outlets = 2 + angles;  // top, below, top by angle
constexpr std::uint64_t batch = 2048;
constexpr int most_hits = 4096;

struct Setting {
  std::vector<std::string> models{"elliptical", "rough"};
  std::uint64_t paths = 400'000, seed = 1;
  double depth = 6, epsilon = 0;
  double more_tilt_deg = 0;       ///< of fibers with a tilt: next to the same fiber, but rows of other draws
  std::vector<std::size_t> only;  ///< of the slabs; empty: all
  std::array<float, channels> sigma_a{0.03f, 0.1f, 0.4f};
  std::string json;
};

struct Slab {
  double e, alpha, tilt_deg, camera_deg;
};
constexpr std::array slabs{Slab{0.75, 0.18, 3, 0}, Slab{0.75, 0.18, 3, 30}, Slab{0.75, 0.18, 3, -30},
                           Slab{1, 0.15, 3, 30},   Slab{1, 0.15, 3, -30},   Slab{0.5, 0.3, 0, 0}};

using Weights = std::array<std::array<double, channels>, outlets>;

/// Sums of weights of paths and of their squares.
struct Sums {
  Weights sum{}, squares{};
  void add(const Sums& other) {
    for (std::size_t o = 0; o < outlets; ++o) {
      for (std::size_t c = 0; c < channels; ++c) {
        sum[o][c] += other.sum[o][c];
        squares[o][c] += other.squares[o][c];
      }
    }
  }
};

/// The azimuth about the fiber that it shows to the light: with a probability in proportion to its width there.
float shown_azimuth(double e, RandomStream& random) {
  while (true) {
    const float phi = static_cast<float>(2 * pi) * (random.next() - 0.5f);
    if (random.next() < fiber::projected_half_width(phi, static_cast<float>(e))) return phi;
  }
}

void follow(const references::TaughtFiber& taught, const Slab& slab, double depth, RandomStream& random, Sums& sums) {
  fiber::FiberDirection back{static_cast<float>(slab.camera_deg * degree), 0};  // towards where the path is from
  double psi = 0, place = 0;                                                    // of `back` from the normal; depth
  glm::vec3 throughput(1.0f);
  for (int hit = 0; hit < most_hits; ++hit) {
    const double flight = -std::log1p(-static_cast<double>(random.next()));
    place += flight * std::cos(psi);
    if (place < 0 || place > depth) {
      const bool is_top = place < 0;
      const double height = -std::sin(static_cast<double>(back.theta));  // of the direction that it leaves in
      const auto angle = static_cast<std::size_t>(std::clamp(0.5 * (height + 1) * angles, 0.0, angles - 1.0));
      for (std::size_t c = 0; c < channels; ++c) {
        const auto weight = static_cast<double>(throughput[static_cast<int>(c)]);
        for (const std::size_t o : {is_top ? std::size_t{0} : std::size_t{1}, is_top ? 2 + angle : outlets}) {
          if (o == outlets) continue;
          sums.sum[o][c] += weight;
          sums.squares[o][c] += weight * weight;
        }
      }
      return;
    }
    const float phi = shown_azimuth(slab.e, random);
    const float xi1 = random.next(), xi2 = random.next(), h = 2 * random.next() - 1;
    const fiber::FiberEvent event = taught.model().begin(taught.fiber(), {back.theta, phi}, xi1, xi2, h);
    const fiber::FiberSample sample =
        taught.model().sample(event, {random.next(), random.next(), random.next(), random.next()});
    if (!(sample.value.pdf > 0)) return;
    throughput *= sample.value.total() / sample.value.pdf;
    const float keeps = std::min(std::max({throughput.r, throughput.g, throughput.b}) / 0.1f, 1.0f);
    if (!(random.next() < keeps)) return;
    throughput /= keeps;
    psi = std::remainder(psi + static_cast<double>(sample.wi.phi - phi) + pi, 2 * pi);
    back.theta = -sample.wi.theta;
  }
}

/// Two halves of the paths.
std::array<Sums, 2> light_of(const references::TaughtFiber& taught, const Slab& slab, const Setting& setting) {
  std::array<Sums, 2> halves;
  for (std::size_t half = 0; half < 2; ++half) {
    std::vector<Sums> batches((setting.paths / 2 + batch - 1) / batch);
    tbb::parallel_for(std::size_t{0}, batches.size(), [&](std::size_t b) {
      RandomStream random(setting.seed, half, b);
      for (std::uint64_t i = 0; i < batch; ++i) follow(taught, slab, setting.depth, random, batches[b]);
    });
    for (const Sums& part : batches) halves[half].add(part);
    for (Weights* weights : {&halves[half].sum, &halves[half].squares}) {
      for (auto& outlet : *weights) {
        for (double& x : outlet) x /= static_cast<double>(batches.size() * batch);
      }
    }
  }
  return halves;
}

struct Light {
  std::array<Sums, 2> halves;
  double paths = 0;
  double mean(std::size_t o, std::size_t c) const { return 0.5 * (halves[0].sum[o][c] + halves[1].sum[o][c]); }
  /// Relative standard error.
  double error(std::size_t o, std::size_t c) const {
    const double square = 0.5 * (halves[0].squares[o][c] + halves[1].squares[o][c]), m = mean(o, c);
    return std::sqrt(std::max(square - m * m, 0.0) / paths) / m;
  }
};

/// Root mean square of ours over theirs less 1, bins by their light, without the noise of both.
double rms_of_angles(const Light& ours, const Light& theirs, std::size_t c) {
  double sum = 0, light = 0;
  for (std::size_t o = 2; o < outlets; ++o) {
    double product = theirs.mean(o, c);
    for (std::size_t half = 0; half < 2; ++half) {
      product *= ours.halves[half].sum[o][c] / theirs.halves[half].sum[o][c] - 1;
    }
    sum += product;
    light += theirs.mean(o, c);
  }
  return std::sqrt(std::max(sum, 0.0) / light);
}

struct Measured {
  Light light;
  references::Lesson lesson;
};

Measured measure(const std::string& model, const Slab& slab, const Setting& setting) {
  fiber::FiberParameters parameters;
  parameters.eccentricity = static_cast<float>(slab.e);
  parameters.roughness = static_cast<float>(slab.alpha);
  parameters.tilt = static_cast<float>(slab.tilt_deg * degree);
  parameters.sigma_a = {setting.sigma_a[0], setting.sigma_a[1], setting.sigma_a[2]};
  adaptive::Options options;
  if (setting.epsilon > 0) options.epsilon = options.sampled_epsilon = setting.epsilon;
  options.seed = setting.seed;
  references::TaughtFiber taught(*references::find_model(model), parameters, options);
  Measured measured;
  measured.lesson = taught.teach(
      [](RandomStream& random) {
        const float sine = 2 * random.next() - 1;
        return fiber::FiberDirection{std::asin(sine), static_cast<float>(2 * pi) * (random.next() - 0.5f)};
      },
      setting.seed);
  measured.light.halves = light_of(taught, slab, setting);
  measured.light.paths = 2 * std::ceil(static_cast<double>(setting.paths / 2) / batch) * batch;
  return measured;
}

std::string percent(const Light& ours, const Light& theirs, std::size_t outlet) {
  std::string text;
  for (std::size_t c = 0; c < channels; ++c) {
    const double off = ours.mean(outlet, c) / theirs.mean(outlet, c) - 1;
    const double error = std::hypot(ours.error(outlet, c), theirs.error(outlet, c));
    text += fmt::format("{}{:+.2f} +- {:.2f}", c == 0 ? "" : ", ", 100 * off, 100 * error);
  }
  return text;
}

nlohmann::ordered_json to_json(const Light& light) {
  nlohmann::ordered_json json;
  for (std::size_t o = 0; o < outlets; ++o) {
    const std::string name = o == 0 ? "back" : o == 1 ? "through" : fmt::format("back_{}", o - 2);
    for (std::size_t c = 0; c < channels; ++c) {
      json[name]["mean"].push_back(light.mean(o, c));
      json[name]["relative_error"].push_back(light.error(o, c));
    }
  }
  return json;
}

int run(const Setting& setting) {
  for (const std::string& model : setting.models) {
    if (references::find_model(model) != nullptr) continue;
    fmt::print(stderr, "{}: no such model\n", model);
    return 2;
  }
  nlohmann::ordered_json cells = nlohmann::ordered_json::array();
  fmt::print(
      "Over fiber3d's, less 1, per cent, sigma_a {}; rms over eight angles.\n\n| e, alpha, tilt, camera | model | back "
      "| "
      "through | rms of angles |\n|---|---|---|---|---|\n",
      fmt::join(setting.sigma_a, ", "));
  for (std::size_t i = 0; i < slabs.size(); ++i) {
    if (!setting.only.empty() && std::ranges::find(setting.only, i) == setting.only.end()) continue;
    Slab slab = slabs[i];
    if (slab.tilt_deg > 0) slab.tilt_deg += setting.more_tilt_deg;
    const Light truth = measure("fiber3d", slab, setting).light;
    nlohmann::ordered_json cell{{"e", slab.e},
                                {"alpha", slab.alpha},
                                {"tilt_deg", slab.tilt_deg},
                                {"camera_deg", slab.camera_deg},
                                {"fiber3d", to_json(truth)}};
    for (const std::string& model : setting.models) {
      const std::clock_t start = std::clock();
      const Measured measured = measure(model, slab, setting);
      std::string angles_off;
      for (std::size_t c = 0; c < channels; ++c) {
        angles_off += fmt::format("{}{:.3f}", c == 0 ? "" : ", ", rms_of_angles(measured.light, truth, c));
      }
      fmt::print("| {}, {}, {}, {} | {} | {} | {} | {} |\n", slab.e, slab.alpha, slab.tilt_deg, slab.camera_deg, model,
                 percent(measured.light, truth, 0), percent(measured.light, truth, 1), angles_off);
      std::fflush(stdout);
      cell["models"][model] = to_json(measured.light);
      const references::Lesson& lesson = measured.lesson;
      cell["models"][model]["rows"] = {lesson.converged, lesson.open, lesson.refused};
      cell["models"][model]["cpu_seconds"] = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    }
    cells.push_back(std::move(cell));
  }
  if (setting.json.empty()) return 0;
  const nlohmann::ordered_json result{{"context",
                                       {{"compiler", __VERSION__},
                                        {"paths", setting.paths},
                                        {"depth", setting.depth},
                                        {"sigma_a", setting.sigma_a},
                                        {"epsilon", setting.epsilon},
                                        {"more_tilt_deg", setting.more_tilt_deg},
                                        {"seed", setting.seed}}},
                                      {"cells", cells}};
  return bench::write_results(setting.json, result.dump(1) + "\n");
}

}  // namespace
}  // namespace tress

int main(int argc, char** argv) {
  tress::Setting setting;
  CLI::App app("Back-scattered and transmitted light of a slab of fibers, by model against fiber3d");
  app.add_option("--model", setting.models)->delimiter(',');
  app.add_option("--paths", setting.paths)->check(CLI::Range(2, 2000000000));
  app.add_option("--depth", setting.depth, "mean free paths")->check(CLI::Range(0.01, 1000.0));
  app.add_option("--epsilon", setting.epsilon, "of rows; without it each model's default")
      ->check(CLI::Range(1e-6, 1.0));
  app.add_option("--more-tilt", setting.more_tilt_deg,
                 "degrees, of fibers with a tilt: a small one makes rows of other draws of next to the same fiber")
      ->check(CLI::Range(0.0, 10.0));
  app.add_option("--slab", setting.only, "which of the slabs, from 0; all without it")
      ->delimiter(',')
      ->check(CLI::Range(std::size_t{0}, tress::slabs.size() - 1));
  app.add_option("--seed", setting.seed);
  app.add_option("--json", setting.json, "file to write");
  CLI11_PARSE(app, argc, argv);
  return tress::run(setting);
}
