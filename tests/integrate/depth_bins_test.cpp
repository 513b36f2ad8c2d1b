// The light of a pixel by depth, and the deep picture of a film.
#include "integrate/depth_bins.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "integrate/film.h"
#include "tress/base/random.h"

namespace tress::integrate {
namespace {

DepthBins bins_of(const std::vector<float>& distances_cm) {
  DepthBins bins;
  for (const float cm : distances_cm) bins.add(glm::dvec3(1, 2, 4), cm);
  return bins;
}

Film film_with_depths(Ground ground) {
  Film::Extra extra;
  extra.depth_bins = true;
  return Film({0, 0, 2, 1}, false, false, ground, 0, false, extra);
}

/// A path to a strand, to a light that the camera sees, to a matte, and to nothing.
std::vector<PathSums> four_ways() {
  std::vector<PathSums> paths(4);
  paths[0].layers[0] = glm::vec3(8);
  paths[0].coverage = 1;
  paths[0].distance_cm = 30;
  paths[1].layers[emission_layer] = glm::vec3(4);
  paths[1].sees_light = true;
  paths[1].light_cm = 20;
  paths[2].held_out = true;
  paths[3].layers[background_layer] = glm::vec3(2);
  return paths;
}

TEST(DepthBins, KeepEightDepthsAndJoinTheNearest) {
  const DepthBins eight = bins_of({70, 10, 60, 20, 50, 30, 45, 80});
  for (std::size_t i = 0; i + 1 < 8; ++i) EXPECT_LT(eight.bins[i].far_cm, eight.bins[i + 1].near_cm);
  EXPECT_EQ(eight.bins[7].near_cm, 80);
  DepthBins nine = eight;
  nine.add(glm::dvec3(1, 2, 4), 72);
  EXPECT_EQ(nine.bins[6].near_cm, 70);
  EXPECT_EQ(nine.bins[6].far_cm, 72);
  EXPECT_EQ(nine.bins[6].paths, 2u);
  EXPECT_EQ(nine.bins[6].light, glm::dvec3(2, 4, 8));
  EXPECT_EQ(nine.bins[7].near_cm, 80);
  nine.add(glm::dvec3(1, 2, 4), 71);
  EXPECT_EQ(nine.bins[6].paths, 3u) << "within";
  nine.add(glm::dvec3(1, 2, 4), std::numeric_limits<float>::max());
  EXPECT_EQ(nine.bins[7].near_cm, std::numeric_limits<float>::max()) << "a background stays apart";
  EXPECT_TRUE(nine.are_sound(11));
  EXPECT_FALSE(nine.are_sound(10));
}

TEST(DepthBins, LoseNoPathAndNoLightOfAnyOrder) {
  RandomStream random(7, 0, 0);
  for (int run = 0; run < 100; ++run) {
    std::vector<float> distances;
    for (int i = 0; i < 64; ++i) distances.push_back(100 * random.next() * (i % 3 == 0 ? 0.01f : 1.0f));
    const DepthBins bins = bins_of(distances);
    ASSERT_TRUE(bins.are_sound(64));
    std::uint32_t paths = 0;
    glm::dvec3 light(0.0);
    for (const DepthBin& bin : bins.bins) {
      paths += bin.paths;
      light += bin.light;
    }
    EXPECT_EQ(paths, 64u);
    EXPECT_EQ(light, glm::dvec3(64, 128, 256));
  }
}

TEST(DeepPicture, HasOpaquePathsByDepthAndTheBackgroundFarthest) {
  Film film = film_with_depths(Ground::backdrop);
  for (const PathSums& path : four_ways()) film.add(0, 0, path);
  const image::DeepPicture deep = film.deep_picture();
  EXPECT_EQ(deep.counts, (std::vector<std::uint32_t>{3, 3})) << "a pixel without paths shows the nearest";
  ASSERT_EQ(deep.samples.size(), 6u);
  EXPECT_EQ(deep.samples[0].front_cm, 20) << "the light";
  EXPECT_EQ(deep.samples[0].alpha, 0.25f);
  EXPECT_EQ(deep.samples[0].color, glm::vec3(1)) << "4 of 4 paths";
  EXPECT_EQ(deep.samples[1].front_cm, 30) << "the strand";
  EXPECT_FLOAT_EQ(deep.samples[1].alpha, 1.0f / 3) << "of what is behind the light";
  EXPECT_FLOAT_EQ(deep.samples[1].color.x, 8.0f / 3);
  EXPECT_EQ(deep.samples[2].front_cm, std::numeric_limits<float>::max()) << "the background";
  EXPECT_EQ(deep.samples[2].back_cm, std::numeric_limits<float>::max());
  EXPECT_EQ(deep.samples[2].alpha, 0.5f) << "the matte has none";

  Film transparent = film_with_depths(Ground::nothing);
  for (const PathSums& path : four_ways()) transparent.add(0, 0, path);
  EXPECT_EQ(transparent.deep_picture().counts[0], 2u) << "without background";

  const Film without({0, 0, 2, 1}, false);
  EXPECT_TRUE(without.deep_picture().samples.empty());
}

TEST(DeepPicture, IsTheSameAfterACheckpoint) {
  Film film = film_with_depths(Ground::backdrop);
  for (const PathSums& path : four_ways()) film.add(0, 0, path);
  std::map<std::string, std::string> saved;
  for (const auto& [name, bytes] : film.sections()) saved[name] = bytes;
  Film restored = film_with_depths(Ground::backdrop);
  ASSERT_TRUE(restored.set_sections(saved));
  const image::DeepPicture a = film.deep_picture(), b = restored.deep_picture();
  EXPECT_EQ(a.counts, b.counts);
  ASSERT_EQ(a.samples.size(), b.samples.size());
  EXPECT_EQ(std::memcmp(a.samples.data(), b.samples.data(), a.samples.size() * sizeof(image::DeepSample)), 0);
  auto damaged = saved;
  damaged["film.depth"].assign(damaged["film.depth"].size(), '\xff');
  EXPECT_FALSE(film_with_depths(Ground::backdrop).set_sections(damaged));
  saved.erase("film.depth");
  EXPECT_FALSE(film_with_depths(Ground::backdrop).set_sections(saved));
}

}  // namespace
}  // namespace tress::integrate
