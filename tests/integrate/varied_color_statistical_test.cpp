// Strands whose colors differ smoothly show them exactly: absorptions are rounded at hits, not once for a strand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/exponential.hpp>
#include <string>
#include <vector>

#include "integrate/picture_mean.h"
#include "integrate/white_fiber.h"
#include "scene/model/strand_fibers.h"
#include "tress/base/random.h"
#include "tress/fiber/chiang2016_model.h"

namespace tress::integrate {
namespace {

constexpr std::uint32_t strand_count = 12;
constexpr int width = 24;

/// Strands side by side, each seen two pixels wide in every row of the picture, in a surround of 1.
scene::Scene side_by_side() {
  scene::Scene scene;
  scene.camera.eye = {0, -50, 0};
  scene.camera.orthographic_height_cm = strand_count;
  scene.image.width = scene.image.height = width;
  scene.environment = scene::Environment(glm::vec3(1.0f));
  scene.grooms.resize(1);
  scene::Groom& groom = scene.grooms[0];
  groom.basis = scene::StrandBasis::linear;
  groom.first_point = {0};
  for (std::uint32_t strand = 0; strand < strand_count; ++strand) {
    const float x = static_cast<float>(strand) - 0.5f * (strand_count - 1);
    groom.points.insert(groom.points.end(), {{x, 0, 20}, {x, 0, -20}});
    groom.radius_cm.insert(groom.radius_cm.end(), {0.49f, 0.49f});
    groom.first_point.push_back(2 * strand + 2);
  }
  return scene;
}

/// The mean of each color over each strand, and its standard error over renders of several seeds.
std::vector<Mean> by_strand(const scene::Scene& scene) {
  const auto model = fiber::make_chiang2016_model();
  std::vector<fiber::FiberId> ids;
  for (const fiber::FiberParameters& fiber : scene.fibers) ids.push_back(model->add_fiber(fiber));
  constexpr int seeds = 16;
  std::vector<double> sum(3 * strand_count), squares(3 * strand_count);
  for (int seed = 0; seed < seeds; ++seed) {
    RenderOptions options = long_paths(256, 61 + static_cast<std::uint64_t>(seed));
    options.max_depth = 1;
    const RenderResult result = render_with(scene, *model, ids, options, 2);
    std::vector<double> mean(3 * strand_count);
    for (std::size_t c = 0; c < 3; ++c) {
      const std::vector<float>& pixels = result.picture.find(std::string(1, "RGB"[c]))->pixels;
      for (std::size_t i = 0; i < pixels.size(); ++i) mean[3 * (i % width / 2) + c] += double{pixels[i]} / (2 * width);
    }
    for (std::size_t i = 0; i < mean.size(); ++i) {
      sum[i] += mean[i];
      squares[i] += mean[i] * mean[i];
    }
  }
  std::vector<Mean> means;
  for (std::size_t i = 0; i < sum.size(); ++i) {
    const double mean = sum[i] / seeds, variance = squares[i] / seeds - mean * mean;
    means.push_back({mean, std::sqrt(std::max(variance, 0.0) / (seeds - 1))});
  }
  return means;
}

/// The reference has a material for each strand, with its absorption exactly. What is left is the curve of exp(-x)
/// between two steps a ratio apart: at most (ratio - 1)^2/(8 ratio) max x^2 exp(-x) = 0.0023 of the light that enters.
/// Twelve strands of three colors at |t| < 5 over 15 degrees of freedom, a false alarm by chance with
/// probability 0.006, seeds are fixed. Strands that are rounded once are held against it too, and must be off.
TEST(VariedColor, OfEachStrandIsTheColorThatItIsGiven) {
  scene::Scene varied = side_by_side(), exact = side_by_side();
  varied.materials.resize(1);
  varied.materials[0].fiber.eccentricity = 1;
  varied.materials[0].pigment =
      scene::Pigment{{.kind = scene::Source::Kind::attribute, .value = glm::vec3(1)},
                     [](const glm::vec3& value, const fiber::FiberParameters&) { return 2.0f * value; }};
  exact.grooms.clear();
  RandomStream random(17);
  for (std::uint32_t strand = 0; strand < strand_count; ++strand) {
    const glm::vec3 color = glm::pow(glm::vec3(random.next(), random.next(), random.next()), glm::vec3(2.0f));
    varied.grooms[0].color.push_back(color);
    exact.materials.push_back(varied.materials[0]);
    exact.materials.back().name += std::to_string(strand);
    exact.materials.back().pigment.reset();
    exact.materials.back().fiber.sigma_a = 2.0f * color;
    scene::Groom groom = side_by_side().grooms[0];
    groom.points = {groom.points[2 * strand], groom.points[2 * strand + 1]};
    groom.radius_cm.resize(2);
    groom.first_point = {0, 2};
    groom.material = strand;
    exact.grooms.push_back(groom);
  }
  constexpr double of_steps = 0.0023;
  ASSERT_FALSE(scene::assign_fibers(&varied) || scene::assign_fibers(&exact));
  scene::Scene once = varied;
  scene::Groom& groom = once.grooms[0];
  groom.choices.clear();
  groom.choices_a_station = 1;
  for (std::uint32_t strand = 0; strand < strand_count; ++strand)
    groom.choices.push_back({0, static_cast<std::uint16_t>(varied.grooms[0].fiber_at(strand, random.next()))});
  const std::vector<Mean> found = by_strand(varied), expected = by_strand(exact), of_once = by_strand(once);
  std::size_t off = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double error = std::hypot(found[i].error, expected[i].error);
    EXPECT_LT(std::abs(found[i].value - expected[i].value), z_limit * error + of_steps) << i / 3 << " " << i % 3;
    EXPECT_LT(error, 0.002);
    off += std::abs(of_once[i].value - expected[i].value) > z_limit * error + of_steps ? 1 : 0;
  }
  EXPECT_GT(off, found.size() / 6);
}

}  // namespace
}  // namespace tress::integrate
