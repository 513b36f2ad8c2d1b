// The traced rough fiber by itself: against ../shared/reference/fiber3d.csv with as many paths as asked for, what its
// furnace loses to masking, how far a tilted cuticle turns its lobes, and what a path costs. Markdown on stdout.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <numbers>
#include <string>

#include "fiber/fiber3d_reference.h"
#include "fiber/rough_fiber.h"
#include "support/chi_square.h"

namespace tress {
namespace {

constexpr double degree = std::numbers::pi / 180;

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Calls visit(exit) for `paths` paths stratified in h. Returns nanoseconds a path.
template <class Visit>
double trace(const fiber::FiberParameters& parameters, double theta_deg, double phi_deg, int paths, Visit&& visit) {
  const fiber::RoughFiber rough(parameters, fiber::Masked::is_lost);
  const fiber::FiberDirection wr{static_cast<float>(theta_deg * degree), static_cast<float>(phi_deg * degree)};
  RandomStream random(11);
  const double start = cpu_seconds();
  for (int i = 0; i < paths; ++i) {
    const double h = 2 * (i + static_cast<double>(random.next())) / paths - 1;
    const std::array<float, 4> u{random.next(), random.next(), random.next(), random.next()};
    visit(rough.trace(rough.entry(wr, static_cast<float>(h)), u, random));
  }
  return 1e9 * (cpu_seconds() - start) / paths;
}

fiber::FiberParameters clear_fiber(double e, double alpha, double tilt_deg) {
  fiber::FiberParameters parameters;
  parameters.eccentricity = static_cast<float>(e);
  parameters.roughness = static_cast<float>(alpha);
  parameters.tilt = static_cast<float>(tilt_deg * degree);
  parameters.sigma_a = glm::vec3(0);
  return parameters;
}

bool compare(const std::string& file, int paths) {
  const auto all = test::fiber3d_reference(test::rows_of_file(file));
  if (all.empty()) return false;
  fmt::print(
      "{} paths a configuration.\n\n| configuration | lobe | energy | theirs | difference in SE | bins | p value | "
      "largest deviation of a bin, SE |\n|---|---|---|---|---|---|---|---|\n",
      paths);
  double worst = 0, smallest = 1;
  int bins = 0;
  for (const auto& [id, reference] : all) {
    const test::TracedFlux traced =
        test::trace_flux(reference.parameters, reference.wr, paths, 77 + static_cast<std::uint64_t>(id));
    for (std::size_t lobe = 0; lobe < test::flux_lobes.size(); ++lobe) {
      const test::FluxComparison c = test::compare_flux(reference, traced, lobe, paths);
      fmt::print("| {} | {} | {:.6f} | {:.6f} | {:+.2f} | {} | {:.3f} | {:.2f} |\n", id, test::flux_lobes[lobe],
                 c.energy, c.expected_energy, (c.energy - c.expected_energy) / c.energy_error,
                 c.chi_square.degrees_of_freedom, c.chi_square.p_value, c.largest_deviation);
      worst = std::max(worst, c.largest_deviation);
      smallest = std::min(smallest, c.chi_square.p_value);
      bins += c.chi_square.degrees_of_freedom;
    }
  }
  fmt::print("\n{} bins, largest deviation {:.2f} SE, smallest of 24 p values {:.3g}\n\n", bins, worst, smallest);
  return true;
}

void furnace(int paths) {
  fmt::print(
      "What masking takes of clear fibers, per cent; e .85, phi 35 (in brackets: nanoseconds a path).\n\n| alpha | "
      "theta_r 0 | 30 | 60 | 80 |\n|---|---|---|---|---|\n");
  for (const double alpha : {0.01, 0.05, 0.1, 0.2, 0.3, 0.5}) {
    fmt::print("| {} |", alpha);
    for (const double theta : {0.0, 30.0, 60.0, 80.0}) {
      double kept = 0;
      const double ns = trace(clear_fiber(0.85, alpha, 0), theta, 35, paths, [&](const fiber::RoughExit& exit) {
        kept += static_cast<double>(exit.throughput.g) / paths;
      });
      fmt::print(" {:.2f} ({:.0f}) |", 100 * (1 - kept), ns);
    }
    fmt::print("\n");
  }
}

void tilt(int paths) {
  fmt::print(
      "\nHow far a tilt of 1 degree moves the mean theta_i, in tilts (standard error).\n\n| e | alpha | theta_r | R "
      "| TT | TRT |\n|---|---|---|---|---|---|\n");
  for (const auto& [e, alpha, theta] :
       {std::array{1.0, 0.01, 0.0}, std::array{1.0, 0.1, 0.0}, std::array{1.0, 0.1, 30.0}, std::array{0.85, 0.1, 0.0},
        std::array{0.7, 0.1, 30.0}}) {
    std::array<test::SampleMean, 3> with, without;
    for (const double tau : {0.0, 1.0}) {
      trace(clear_fiber(e, alpha, tau), theta, 35, paths, [&](const fiber::RoughExit& exit) {
        if (exit.order > 2 || !(exit.throughput.g > 0)) return;
        (tau > 0 ? with : without)[static_cast<std::size_t>(exit.order)].add(static_cast<double>(exit.angles().theta));
      });
    }
    fmt::print("| {} | {} | {:.0f} |", e, alpha, theta);
    for (std::size_t p = 0; p < 3; ++p) {
      fmt::print(" {:+.2f} ({:.2f}) |", (with[p].mean() - without[p].mean()) / degree,
                 std::hypot(with[p].standard_error(), without[p].standard_error()) / degree);
    }
    fmt::print("\n");
  }
}

}  // namespace
}  // namespace tress

int main(int argc, char** argv) {
  const int paths = argc > 2 ? std::atoi(argv[2]) : 8000000;
  if (argc < 2 || argc > 3 || paths < 1000) {
    fmt::print(stderr, "usage: bench_fiber3d_tracer .../reference/fiber3d.csv [PATHS]\n");
    return 2;
  }
  if (!tress::compare(argv[1], paths)) {
    fmt::print(stderr, "{}: no configurations there\n", argv[1]);
    return 1;
  }
  tress::furnace(std::min(paths, 4000000));
  tress::tilt(std::min(paths, 4000000));
  return 0;
}
