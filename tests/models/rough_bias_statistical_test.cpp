// What all rows do to one side: the light of many directions together, in which the noise of single rows cancels.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

#include "references/far_field.h"
#include "references/registry.h"
#include "references/taught_fiber.h"
#include "support/seed.h"

namespace {

using namespace tress;
using references::whole_flux;

constexpr std::size_t thetas = 12, azimuths = 12;
constexpr double pi = std::numbers::pi;

/// Flux by theta_i and by the distance between phi_i and phi_r, over directions that arrive from everywhere.
std::vector<double> mean_flux(const references::TaughtFiber& taught, std::uint64_t seed) {
  std::vector<double> sum(thetas * azimuths, 0.0);
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 3; ++j) {
      references::FarFieldRequest request;
      request.wr = {-1.2f + 2.4f * float(i) / 7, 0.2f + 0.6f * float(j)};
      request.theta_bins = thetas;
      request.phi_bins = 2 * azimuths;
      request.paths = 50'000;
      request.shifts = 2;
      request.seed = seed + std::uint64_t(3 * i + j);
      const auto field = references::far_field(taught.model(), taught.fiber(), request);
      for (std::size_t bin = 0; bin < thetas * 2 * azimuths; ++bin) {
        const double phi = (double(bin % (2 * azimuths)) + 0.5) / azimuths * pi - pi;
        const double apart = std::abs(std::remainder(phi - double(request.wr.phi), 2 * pi));
        const auto to = std::min(std::size_t(apart / pi * azimuths), azimuths - 1);
        sum[bin / (2 * azimuths) * azimuths + to] +=
            std::pow(std::cos(double(request.wr.theta)), 2) * field.parts[whole_flux].flux[0][bin];
      }
    }
  }
  return sum;
}

// 432 young rows of a clear fiber. Their lobes are widened by the priors of their fits, all to the same side. The root
// of chi^2 over 144 bins, by two runs of the truth so that its noise has no part in it, is 0.0411 to 0.0416 for three
// seeds with the means of four orders of azimuth held, and 0.0515 to 0.0518 with two. Right code fails for no seed that
// was tried.
TEST(RoughRows, WidenTheLobesOfAllDirectionsByLittle) {
  fiber::FiberParameters parameters;
  parameters.eccentricity = 0.8f;
  parameters.roughness = 0.2f;
  parameters.sigma_a = glm::vec3(0);
  adaptive::Options options;
  options.seed = test::seed(3);
  references::TaughtFiber rows(*references::find_model("rough"), parameters, options),
      truth(*references::find_model("fiber3d"), parameters, options);
  rows.teach(
      [](RandomStream& random) {
        const float theta = std::asin(2 * random.next() - 1) * 0.9f;
        return fiber::FiberDirection{theta, 2 * float(pi) * random.next()};
      },
      options.seed);
  const std::vector<double> ours = mean_flux(rows, 100), theirs = mean_flux(truth, 200), again = mean_flux(truth, 300);
  double off = 0, all = 0;
  for (std::size_t bin = 0; bin < ours.size(); ++bin) {
    off += (ours[bin] - theirs[bin]) * (ours[bin] - again[bin]) / (0.5 * (theirs[bin] + again[bin]));
    all += 0.5 * (theirs[bin] + again[bin]);
  }
  const double error = std::sqrt(std::max(off, 0.0) / all);
  RecordProperty("error", std::to_string(error));
  EXPECT_LT(error, 0.045);
}

}  // namespace
