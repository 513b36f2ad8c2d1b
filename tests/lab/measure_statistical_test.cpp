// tress-lab measure finds the fiber whose light it was given.
#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "base/pi.h"
#include "cli/run_tress.h"
#include "fiber/rough_paths.h"
#include "support/scale.h"
#include "support/seed.h"
#include "tress/base/random.h"

namespace tress::test {
namespace {

/// What a detector, a disc so many degrees wide, sees of a fiber at all rotations, as a file of `measure`.
std::string measured(const fiber::FiberParameters& hair, double incidence, double detector, int batches,
                     std::uint64_t key) {
  struct Sample {
    int phi, theta;
    glm::dvec3 direction;
    double light = 0;
  };
  std::vector<Sample> samples;
  for (int phi = -180; phi < 180; phi += 20) {
    for (int theta = -75; theta <= 75; theta += 10) {
      const double across = std::cos(theta * degree);
      samples.push_back(
          {phi, theta, {std::sin(theta * degree), across * std::cos(phi * degree), across * std::sin(phi * degree)}});
    }
  }
  fiber::RoughPaths traced(hair);
  RandomStream random(key, 0);
  for (int batch = 0; batch < batches; ++batch) {
    const float turned = random.next() * two_pi_f;
    traced.add_sobol({static_cast<float>(incidence * degree), turned}, random.next_bits(), 0, 1024, 0);
    const fiber::RoughPathExits& exits = traced.trace();
    const double width = static_cast<double>(fiber::projected_half_width(turned, hair.eccentricity));
    for (std::size_t i = 0; i < exits.size(); ++i) {
      fiber::RoughExit exit;
      exit.direction = exits.direction(i);
      const fiber::FiberDirection there = exit.angles();
      const double theta = static_cast<double>(there.theta), phi = static_cast<double>(there.phi - turned);
      const glm::dvec3 direction(std::sin(theta), std::cos(theta) * std::cos(phi), std::cos(theta) * std::sin(phi));
      const double light = width * static_cast<double>(exits.weight(i) * std::exp(-hair.sigma_a.r * exits.way(i)));
      for (Sample& sample : samples) {
        if (glm::dot(sample.direction, direction) > std::cos(detector / 2 * degree)) sample.light += light;
      }
    }
  }
  std::string text = fmt::format("# incidence {}\n# detector {}\n", incidence, detector);
  for (const Sample& sample : samples) text += fmt::format("{} {} {:.6g}\n", sample.phi, sample.theta, sample.light);
  return text;
}

using FittedFiber = CommandTest;

// Seeds 5 and 6. A stated error comes from 16 draws: Student's law with 15 degrees of freedom. Over twelve seeds the
// differences of the four numbers were 1.2 stated errors in the root mean square. 5 are then passed by one of the four
// with a chance of 0.003. The stated errors are at most half of what the second bound leaves them.
TEST_F(FittedFiber, IsTheOneThatWasTraced) {
  fiber::FiberParameters hair;
  hair.eccentricity = 0.85f;
  hair.roughness = 0.2f;
  hair.tilt = 0.05f;
  hair.sigma_a = glm::vec3(0.3f);
  const double detector = 3 * widened(1 << 18);  // fewer paths in a wider one have the same noise
  write_text(path("hair.txt"), measured(hair, 40, detector, scaled(2048), seed(5)));
  const Outcome outcome = run(
      {"measure", path("hair.txt"), "--seed", std::to_string(seed(6)), "--fit-paths", std::to_string(scaled(1 << 18))});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  std::map<std::string, std::pair<double, double>> found;  // value and error
  std::istringstream lines(outcome.out);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name, sign;
    double value = 0, error = 0;
    if (words >> name >> value) {
      words >> sign >> error;
      found[name] = {value, error};
    }
  }
  const std::vector<std::pair<std::string, double>> truth{
      {"eccentricity", 0.85}, {"roughness", 0.2}, {"tilt", 0.05 / degree}, {"sigma_a", 0.3}};
  for (const auto& [name, value] : truth) {
    ASSERT_GT(found[name].second, 0) << outcome.out;
    RecordProperty(name, fmt::format("{:.5g} +- {:.2g}", found[name].first, found[name].second));
    EXPECT_NEAR(found[name].first, value, 5 * found[name].second) << name << "\n" << outcome.out;
    EXPECT_LT(found[name].second, 0.1 * value + 0.02) << name << ": the error is of use";
  }
  // The residual is noise of both lights: of the file's, which has 8 times the paths and no mirror images, about half.
  EXPECT_GT(found["residual"].first, 0.8 * found["noise"].first) << outcome.out;
  EXPECT_LT(found["residual"].first, 1.6 * found["noise"].first) << outcome.out;
}

}  // namespace
}  // namespace tress::test
