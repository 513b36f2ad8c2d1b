// What is learned of the light after a hit, and what a path does by it; that it is without bias is tested beside.
#include "integrate/deeper_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "image/picture.h"
#include "integrate/white_fiber.h"

namespace tress::integrate {
namespace {

const glm::vec3 up{0, 0, 1}, down{0, 0, -1};
constexpr DeeperLight::PictureSoFar picture{0.5, 4, 9};  // mean, variance, hits

scene::Scene unit_cube() {
  scene::Scene scene;
  scene.meshes.resize(1);
  scene.meshes[0].positions = {{0, 0, 0}, {1, 1, 1}, {1, 0, 0}};
  return scene;
}

/// Half of the copies bring twice this radiance in every channel, the others nothing.
void teach(const DeeperLight& deeper, std::size_t place, float light, std::uint64_t hits, int copies) {
  for (int i = 0; i < copies; ++i) deeper.note(place, glm::vec3(i % 2 == 0 ? 2 * light : 0.0f), hits);
}

TEST(DeeperLight, LetsMorePathsGoOnWhereMoreLightComesAtLessCost) {
  DeeperLight deeper(unit_cube());
  deeper.update(picture, 1);  // the unit
  const glm::vec3 left{0.2f, 0.2f, 0.2f}, right{0.8f, 0.8f, 0.8f};
  const std::size_t bright = deeper.place(left, up), dark = deeper.place(right, up), dear = deeper.place(left, down);
  ASSERT_NE(bright, dark);
  ASSERT_NE(bright, dear);
  EXPECT_FALSE(deeper.is_ready());
  constexpr int copies = 400000;  // what a cell leans on weighs 64
  teach(deeper, bright, 0.5f, 2, copies);
  teach(deeper, dark, 0.125f, 2, copies);
  teach(deeper, dear, 0.5f, 8, copies);
  deeper.update(picture, 2);
  ASSERT_TRUE(deeper.is_ready());
  EXPECT_EQ(deeper.noted(), 3u * copies);
  const glm::vec3 weak(0.02f);
  const auto at = [&](const glm::vec3& point, const glm::vec3& direction, const glm::vec3& throughput) {
    return deeper.copies(deeper.place(point, direction), throughput);
  };
  const float of_bright = at(left, up, 16.0f * weak);
  ASSERT_LT(of_bright, 1);
  ASSERT_GT(at(right, up, 16.0f * weak), DeeperLight::least_copies);
  EXPECT_NEAR(at(right, up, 16.0f * weak) / of_bright, 0.25, 0.002);  // a quarter of the light
  EXPECT_NEAR(at(left, down, 16.0f * weak) / of_bright, 0.5, 0.002);  // four times the cost
  EXPECT_NEAR(at(left, up, 8.0f * weak) / of_bright, 0.5, 0.002);     // half of the weight
  // w sqrt(E[L^2] hits_0 / (E[C] V_0)), and half as much again.
  EXPECT_NEAR(of_bright, 1.5 * 0.32 * std::sqrt(0.5 * 9 / (2 * 4)), 0.002);
}

TEST(DeeperLight, PartsByTheVarianceAlone) {
  DeeperLight deeper(unit_cube());
  deeper.update(picture, 1);
  const glm::vec3 left{0.2f, 0.2f, 0.2f}, right{0.8f, 0.8f, 0.8f};
  for (int i = 0; i < 400000; ++i) deeper.note(deeper.place(left, up), glm::vec3(1.0f), 2);
  teach(deeper, deeper.place(right, up), 1, 2, 400000);
  deeper.update(picture, 2);
  EXPECT_EQ(deeper.copies(deeper.place(left, up), glm::vec3(2.0f)), 1);  // light that is always the same
  EXPECT_NEAR(deeper.copies(deeper.place(right, up), glm::vec3(2.0f)), 1.5 * 2 * std::sqrt(9.0 / (2 * 4)), 0.01);
}

TEST(DeeperLight, HasCopiesWithinBoundsForEveryWeight) {
  DeeperLight deeper(unit_cube());
  deeper.update(picture, 1);
  const std::size_t place = deeper.place({0.2f, 0.2f, 0.2f}, up);
  teach(deeper, place, 0.5f, 2, 4000);
  deeper.note(place, glm::vec3(std::numeric_limits<float>::infinity()), 1);
  deeper.note(place, glm::vec3(std::numeric_limits<float>::quiet_NaN()), 1);
  deeper.note(place, glm::vec3(-std::numeric_limits<float>::max()), std::numeric_limits<std::uint64_t>::max());
  deeper.update(picture, 2);
  EXPECT_EQ(deeper.noted(), 4001u);
  constexpr float most = std::numeric_limits<float>::max();
  for (const float weight : {0.0f, -1.0f, 1e-30f, 1e30f, most, std::numeric_limits<float>::quiet_NaN()}) {
    const float copies = deeper.copies(place, glm::vec3(weight, 0, weight));
    EXPECT_GE(copies, DeeperLight::least_copies) << weight;
    EXPECT_LE(copies, DeeperLight::most_copies) << weight;
  }
  for (const glm::vec3& point : {glm::vec3(-most), glm::vec3(most, 0, -most), glm::vec3(0.5f)}) {
    EXPECT_LT(deeper.place(point, up), deeper.place_count());
  }
}

TEST(DeeperLight, OfABlackPictureOrOneWithoutVarianceIsNotReady) {
  DeeperLight black(unit_cube()), constant(unit_cube());
  black.update({0, 0, 9}, 1);
  constant.update({1, 0, 9}, 1);
  for (const DeeperLight* deeper : {&black, &constant}) teach(*deeper, 100, 1, 2, 4000);
  black.update({0, 0, 9}, 2);
  constant.update({1, 0, 9}, 2);
  EXPECT_FALSE(black.is_ready());
  EXPECT_FALSE(constant.is_ready());
  EXPECT_EQ(black.noted(), 0u);
}

TEST(DeeperLight, RefinesWhereHitsAreAndStaysBounded) {
  DeeperLight deeper(unit_cube());
  deeper.update(picture, 1);
  const std::size_t at_first = deeper.place_count();
  RandomStream random(3);
  for (std::uint64_t pass = 2; pass < 12; ++pass) {
    for (int i = 0; i < 400000; ++i) {
      const float x = random.next(), y = random.next(), z = random.next();
      deeper.note(deeper.place({x, y, z}, up), glm::vec3(x), 3);
    }
    deeper.update(picture, pass);
  }
  EXPECT_GT(deeper.place_count(), 10 * at_first);
  EXPECT_LT(deeper.bytes(), std::size_t{32} << 20);
}

TEST(DeeperLight, IsDueWhenThereIsAnEighthMore) {
  DeeperLight deeper(unit_cube());
  EXPECT_FALSE(deeper.is_due(0));
  EXPECT_TRUE(deeper.is_due(1));
  deeper.update(picture, 800);
  EXPECT_FALSE(deeper.is_due(899));
  EXPECT_TRUE(deeper.is_due(900));
}

TEST(DeeperLight, GoesOnFromAStateToTheSameBits) {
  const auto taught = [](DeeperLight& deeper, std::uint64_t seed) {
    RandomStream random(seed);
    for (int i = 0; i < 50000; ++i) {
      const float x = random.next(), y = random.next(), z = random.next();
      deeper.note(deeper.place({x, y, z}, up), glm::vec3(x * y), 3);
    }
  };
  DeeperLight first(unit_cube()), second(unit_cube());
  first.update(picture, 1);
  taught(first, 1);
  first.update(picture, 2);
  taught(first, 2);  // not yet taken in
  const std::string state = first.state();
  EXPECT_FALSE(second.set_state(state.substr(1)));
  EXPECT_FALSE(second.set_state(""));
  EXPECT_EQ(second.place_count(), DeeperLight(unit_cube()).place_count());
  ASSERT_TRUE(second.set_state(state));
  EXPECT_EQ(second.state(), state);
  for (DeeperLight* deeper : {&first, &second}) {
    deeper->update(picture, 3);
    taught(*deeper, 3);
    deeper->update(picture, 4);
  }
  EXPECT_TRUE(second.is_ready());
  EXPECT_EQ(second.state(), first.state());
}

TEST(LearnedRoulette, GivesTheSameBitsForAnyNumberOfThreads) {
  WhiteFiber model;
  fiber::LobeColors shares{};
  shares[0] = {0.9f, 0.7f, 0.6f};
  const std::vector<fiber::FiberId> fibers{model.add_fiber(shares)};
  const scene::Scene scene = tangle(300, 48, 48);
  RenderOptions options;
  options.samples = 10;
  options.seed = 4;
  DeeperProgress progress;
  const RenderResult one = render_with(scene, model, fibers, options, 1, never_stop, [&](const PassProgress& pass) {
    progress = pass.deeper;
    return true;
  });
  EXPECT_GT(progress.copies, 1000u);
  EXPECT_GT(progress.bytes, 1000u);
  for (const int threads : {2, 5}) {
    const auto difference =
        image::compare(one.picture, render_with(scene, model, fibers, options, threads).picture, "one thread", "more");
    ASSERT_TRUE(difference);
    EXPECT_TRUE(difference->identical) << threads;
  }
  options.roulette = Roulette::throughput;
  const auto other = image::compare(one.picture, render_with(scene, model, fibers, options, 1).picture, "a", "b");
  ASSERT_TRUE(other);
  EXPECT_FALSE(other->identical);  // else nothing was tested
}

}  // namespace
}  // namespace tress::integrate
