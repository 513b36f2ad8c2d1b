// The two half pictures of a film and their variances (half_layers).
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "integrate/film.h"

namespace tress::integrate {
namespace {

Film film_with_halves(std::uint32_t first_sample = 0) {
  Film::Extra extra;
  extra.halves = true;
  extra.first_sample = first_sample;
  return Film({0, 0, 2, 1}, false, false, Ground::backdrop, 0, false, extra);
}

void add(const std::vector<float>& values, Film* film) {
  for (const float value : values) {
    PathSums path;
    path.layers[0] = {value, 2 * value, 0};
    path.coverage = 1;
    film->add(0, 0, path);
  }
}

float value(const image::Picture& picture, const std::string& name) {
  const image::Channel* channel = picture.find(name);
  EXPECT_TRUE(channel) << name;
  return channel ? channel->pixels[0] : -1;
}

void expect_halves_of_five(const image::Picture& picture) {
  EXPECT_EQ(value(picture, "half_a.R"), 1003.0f) << "1001, 1006, 1002";
  EXPECT_EQ(value(picture, "half_b.R"), 1009.0f) << "1008, 1010";
  EXPECT_EQ(value(picture, "half_b.G"), 2018.0f);
  EXPECT_NEAR(value(picture, "half_a_variance.R"), (4 + 9 + 1) / 6.0, 1e-5);
  EXPECT_NEAR(value(picture, "half_a_variance.G"), 4 * (4 + 9 + 1) / 6.0, 1e-5);
  EXPECT_NEAR(value(picture, "half_b_variance.R"), (1 + 1) / 2.0, 1e-5);
  EXPECT_EQ(value(picture, "half_b_variance.B"), 0.0f);
}

const std::vector<float> five{1001, 1008, 1006, 1010, 1002};

TEST(HalfPictures, AreTheMeansOfEvenAndOddPathsWithTheirOwnVariances) {
  Film film = film_with_halves();
  add(five, &film);
  expect_halves_of_five(film.picture());
  // They add up to beauty by their samples, and in squared deviations to the variance of it.
  const image::Picture picture = film.picture();
  EXPECT_NEAR(value(picture, "R"), (3 * 1003.0 + 2 * 1009.0) / 5, 1e-3);
  EXPECT_EQ(value(picture, "half_a.R"), picture.find("half_a.R")->pixels[1]) << "a pixel without paths: the nearest";
}

TEST(HalfPictures, OfOnePathAreBothThatPathWithoutVariance) {
  Film film = film_with_halves();
  add({3}, &film);
  const image::Picture picture = film.picture();
  for (const char* name : {"half_a.R", "half_b.R"}) EXPECT_EQ(value(picture, name), 3.0f);
  for (const char* name : {"half_a_variance.R", "half_b_variance.R"}) EXPECT_EQ(value(picture, name), 0.0f);
}

TEST(HalfPictures, AreTheSameOfPartsAndAfterACheckpoint) {
  Film joined = film_with_halves();
  add({five[0], five[1], five[2]}, &joined);
  Film later = film_with_halves(3);  // begins with an odd path
  add({five[3], five[4]}, &later);
  joined.add(later);
  expect_halves_of_five(joined.picture());

  std::map<std::string, std::string> saved;
  for (const auto& [name, bytes] : joined.sections()) saved[name] = bytes;
  Film restored = film_with_halves();
  ASSERT_TRUE(restored.set_sections(saved));
  expect_halves_of_five(restored.picture());
  saved.erase("film.halves");
  EXPECT_FALSE(film_with_halves().set_sections(saved));
}

TEST(HalfPictures, AreThereOnlyIfAskedFor) {
  const Film film({0, 0, 2, 1}, false);
  EXPECT_EQ(film.picture().find("half_a.R"), nullptr);
}

}  // namespace
}  // namespace tress::integrate
