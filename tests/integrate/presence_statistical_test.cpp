// Strands that are there for a share of the rays: alpha, shadows and furnaces whose means are known on paper.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "integrate/picture_mean.h"
#include "integrate/white_fiber.h"

namespace tress::integrate {
namespace {

/// One strand along x through (0, 0, z), of the given width.
scene::Groom strand_along_x(float z, float radius_cm) {
  scene::Groom groom;
  groom.basis = scene::StrandBasis::linear;
  groom.first_point = {0, 2};
  groom.points = {{-50, 0, z}, {50, 0, z}};
  groom.radius_cm = {radius_cm, radius_cm};
  return groom;
}

void give_presence(float presence, scene::Scene* scene) {
  scene->materials.resize(1);
  scene->materials[0].fiber.eccentricity = 1;
  scene->materials[0].presence = scene::Source{.value = glm::vec3(presence)};
  scene::assign_fibers(scene);
}

TEST(StrandPresence, IsTheAlphaBeforeNothing) {
  scene::Scene scene;
  scene.camera.eye = {0, -6, 0};
  scene.image.width = scene.image.height = 16;
  scene.image.transparent = true;
  scene.grooms = {strand_along_x(0, 20)};
  scene.environment = scene::Environment(glm::vec3(1.0f));
  give_presence(0.5f, &scene);
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  const RenderResult result = render_with(scene, model, fibers, long_paths(64, 41), 2);
  for (const char* name : {"A", "coverage"}) {
    const Mean alpha = mean_of(result, name);
    EXPECT_LE(std::abs(alpha.value - 0.5), z_limit * alpha.error + 1e-6) << name;
    EXPECT_LT(alpha.error, 0.004) << "samples are stratified: 64 independent ones of 256 pixels have as much";
  }
  const Mean light = mean_of(result, "G");  // lossless in a surround of 1, premultiplied
  EXPECT_LT(std::abs(light.value - 0.5), z_limit * light.error);
}

// 3 presences x 3 counts x 3 colors at |z| < 5.
TEST(StrandPresence, LeavesFurnacesOfLosslessFibersAtOne) {
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  for (const float presence : {0.1f, 0.5f, 0.9f}) {
    scene::Scene scene = tangle(60, 16, 16);
    scene.environment = scene::Environment(glm::vec3(1.0f));
    give_presence(presence, &scene);
    for (const auto& [lights, bcsdfs] : {std::pair(0, 1), std::pair(2, 1), std::pair(1, 3)}) {
      RenderOptions options = long_paths(64, 42);
      options.light_samples = lights;
      options.bcsdf_samples = bcsdfs;
      const RenderResult result = render_with(scene, model, fibers, options, 2);
      for (const char* color : {"R", "G", "B"}) {
        const Mean mean = mean_of(result, color);
        EXPECT_LT(std::abs(mean.value - 1), z_limit * mean.error + 1e-6) << presence << lights << bcsdfs << color;
        EXPECT_LT(mean.error, 0.02);
      }
    }
  }
}

// A black strand before a ball of light, which it hides from the floor but for what is not there of it.
TEST(StrandPresence, LetsTheRestOfTheLightThrough) {
  scene::Scene scene;
  scene.environment = scene::Environment(glm::vec3(0.0f));
  scene.camera.eye = {3, -4, 1};
  scene.camera.vertical_fov_deg = 0.1f;
  scene.image.width = scene.image.height = 16;
  scene::Mesh floor;
  floor.positions = {{-100, -100, 0}, {100, -100, 0}, {100, 100, 0}, {-100, 100, 0}};
  floor.triangles = {{0, 1, 2}, {0, 2, 3}};
  floor.albedo = glm::vec3(0.5f);
  scene.meshes = {floor};
  scene::Light ball;
  ball.kind = scene::Light::Kind::sphere;
  ball.center = {0, 0, 5};
  ball.radius_cm = 1;
  scene.lights = {ball};
  scene.grooms = {strand_along_x(3, 0.8f)};
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber({})};
  for (const float presence : {0.0f, 0.25f, 0.7f, 1.0f}) {
    give_presence(presence, &scene);
    for (const int lights : {0, 1, 4}) {
      RenderOptions options = long_paths(256, 43);
      options.light_samples = lights;
      const Mean mean = mean_of(render_with(scene, model, fibers, options, 2), "R");
      const double expected = (1 - double{presence}) * 0.5 / 25;
      EXPECT_LE(std::abs(mean.value - expected), z_limit * mean.error + 5e-4 * expected) << presence << " " << lights;
      EXPECT_LE(mean.error, 0.1 * expected);
    }
  }
}

TEST(StrandPresence, IsTheSameToTheBitWithAnyNumberOfThreadsAndAbsentWhereItIsOne) {
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  scene::Scene scene = tangle(60, 40, 33);
  const RenderOptions options = long_paths(8, 44);
  const auto picture_of = [&](float presence, int threads) {
    give_presence(presence, &scene);
    return render_with(scene, model, fibers, options, threads).picture;
  };
  const auto identical = [](const image::Picture& a, const image::Picture& b) {
    return image::compare(a, b, "a", "b")->identical;
  };
  const image::Picture half = picture_of(0.5f, 1), whole = picture_of(1, 1);
  EXPECT_TRUE(identical(half, picture_of(0.5f, 2)));
  EXPECT_FALSE(identical(half, whole));
  scene.materials[0].presence.reset();
  scene::assign_fibers(&scene);
  EXPECT_TRUE(identical(whole, render_with(scene, model, fibers, options, 2).picture));
  EXPECT_TRUE(scene.grooms[0].presence.empty());
}

/// 300 straight strands of a twentieth of a pixel's width, lit from the right, before nothing.
scene::Scene fine_strands() {
  scene::Scene scene;
  scene.camera.eye = {0, -6, 0};
  scene.image.width = scene.image.height = 24;
  scene.image.transparent = true;
  scene.environment = scene::Environment(glm::vec3(0.1f));
  scene::Light sun;
  sun.direction = glm::normalize(glm::vec3(1, -0.5f, 0.3f));
  sun.half_angle_rad = 0.2f;
  sun.radiance = glm::vec3(20.0f);
  scene.lights = {sun};
  scene.grooms.resize(1);
  scene::Groom& groom = scene.grooms[0];
  groom.first_point = {0};
  RandomStream random(7);
  for (int strand = 0; strand < 300; ++strand) {
    const glm::vec3 point(2.4f * random.next() - 1.2f, 0.6f * random.next() - 0.3f, 1.2f);
    const glm::vec3 step(0.2f * random.next() - 0.1f, 0.2f * random.next() - 0.1f, -0.45f);
    for (int i = 0; i < 6; ++i) {
      groom.points.push_back(point + float(i) * step);
      groom.radius_cm.push_back(0.0033f * (1 - 0.1f * float(i)));
    }
    groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
  }
  scene.materials.resize(1);
  scene::assign_fibers(&scene);
  return scene;
}

/// Of one layer over renders of several seeds: the mean over the picture, and the variance between seeds of a pixel.
struct OverSeeds {
  Mean mean;
  double variance = 0;
};

OverSeeds over_seeds(const std::vector<image::Picture>& pictures, const char* layer) {
  const double n = static_cast<double>(pictures.size());
  std::vector<double> means;
  OverSeeds all;
  const std::size_t pixels = pictures[0].find(layer)->pixels.size();
  std::vector<double> sums(pixels), squares(pixels);
  for (const image::Picture& picture : pictures) {
    double sum = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
      const double x = picture.find(layer)->pixels[i];
      sum += x / double(pixels);
      sums[i] += x;
      squares[i] += x * x;
    }
    means.push_back(sum);
    all.mean.value += sum / n;
  }
  for (std::size_t i = 0; i < pixels; ++i)
    all.variance += (squares[i] - sums[i] * sums[i] / n) / (n - 1) / double(pixels);
  for (const double mean : means) all.mean.error += (mean - all.mean.value) * (mean - all.mean.value) / (n * (n - 1));
  all.mean.error = std::sqrt(all.mean.error);
  return all;
}

TEST(LeastWidth, KeepsTheMeanOfFineStrandsAndTakesNoise) {
  WhiteFiber model;
  fiber::LobeColors shares = lossless_shares();
  for (glm::vec3& share : shares) share *= 0.7f;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(shares)};
  scene::Scene scene = fine_strands();
  std::vector<std::vector<image::Picture>> pictures(2);
  for (const bool widened : {false, true}) {
    scene.image.least_width_px = widened ? 1.0f : 0.0f;
    for (std::uint64_t seed = 0; seed < 48; ++seed)
      pictures[widened].push_back(render_with(scene, model, fibers, long_paths(16, 50 + seed), 2).picture);
  }
  for (const char* layer : {"A", "R", "G", "B"}) {
    const OverSeeds own = over_seeds(pictures[0], layer), widened = over_seeds(pictures[1], layer);
    const double error = std::hypot(own.mean.error, widened.mean.error);
    // Where strands of a like direction lie closer than a pixel, wide ones hide one another and narrow ones do not: of
    // the order of the squared coverage of a strand times the number of its neighbors in a pixel, 0.3 % of the whole.
    EXPECT_NEAR(widened.mean.value, own.mean.value, z_limit * error + 0.003 * own.mean.value) << layer;
    EXPECT_LT(error, 0.008 * own.mean.value) << layer << ": the test would see nothing";
    EXPECT_LT(widened.variance, (layer == std::string("A") ? 0.5 : 0.8) * own.variance) << layer;
  }
}

TEST(LeastWidth, ChangesNoBitWhereStrandsAreWider) {
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  scene::Scene scene = tangle(20, 16, 16);  // of 0.06 cm, where a pixel has 0.2 cm
  const RenderOptions options = long_paths(4, 51);
  const image::Picture own = render_with(scene, model, fibers, options, 1).picture;
  scene.image.least_width_px = 0.2f;
  EXPECT_TRUE(image::compare(own, render_with(scene, model, fibers, options, 2).picture, "", "")->identical);
  scene.image.least_width_px = 2;
  const image::Picture widened = render_with(scene, model, fibers, options, 1).picture;
  EXPECT_FALSE(image::compare(own, widened, "", "")->identical);
  EXPECT_TRUE(image::compare(widened, render_with(scene, model, fibers, options, 2).picture, "", "")->identical);
}

}  // namespace
}  // namespace tress::integrate
