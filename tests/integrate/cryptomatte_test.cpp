// Mattes: ids against published values, ranks and shares by hand, a file read back as a compositor decodes it.
#include "integrate/cryptomatte.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "integrate/renderer.h"
#include "integrate/white_fiber.h"
#include "scene/read/load_scene.h"

namespace tress::integrate {
namespace {

// From the unit tests of the specification's own decoder (cryptomatte_utilities_tests.py) and the manifests that the
// specification quotes.
TEST(Cryptomatte, IdsAreThePublishedOnes) {
  const std::map<std::string, double> published{
      {"hello", 6.0705627102400005616e-17},
      {"cube", -4.08461912519e+15},
      {"sphere", 2.79018604383e+15},
      {"plane", 3.66557617593e-11},
      {"\xd1\x80\xd0\xb0\xd0\xb2\xd0\xbd\xd0\xb8\xd0\xbd\xd0\xb0", -1.31926312e-25},
      {"m\xc3\xa4"
       "dchen",
       6.23612982e+25}};
  for (const auto& [name, id] : published) EXPECT_NEAR(double{matte_id(name)} / id, 1, 1e-8) << name;
  EXPECT_EQ(hex_of_id(matte_id("bunny")), "13851a76");
  EXPECT_EQ(hex_of_id(matte_id("default")), "42c9679f");
  EXPECT_EQ(hex_of_id(matte_id("bunny_porcelain_mat")), "b24b26d4");
}

// "n17" hashes to 000738c5 and "n535" to ff8d97ef (by another MurmurHash3, in Python): exponents 0 and 255.
TEST(Cryptomatte, IdsOfAllZeroOrAllOneExponentsAreMadeNormal) {
  EXPECT_EQ(murmur_hash("n17"), 0x000738c5u);
  EXPECT_EQ(hex_of_id(matte_id("n17")), "008738c5");
  EXPECT_EQ(murmur_hash("n535"), 0xff8d97efu);
  EXPECT_EQ(hex_of_id(matte_id("n535")), "ff0d97ef");
  EXPECT_EQ(murmur_hash(""), 0u);
  for (int i = 0; i < 3000; ++i) EXPECT_TRUE(std::isnormal(matte_id(fmt::format("n{}", i)))) << i;
}

PathSums met(std::uint32_t object) {
  PathSums path;
  path.coverage = 1;
  path.object = object;
  return path;
}

const std::vector<float>& pixels(const image::Picture& picture, const std::string& name) {
  const image::Channel* channel = picture.find(name);
  EXPECT_TRUE(channel) << name;
  return channel->pixels;
}

TEST(Cryptomatte, RanksAreBySharesOfPathsAndEqualNamesAreOne) {
  Film film({0, 0, 2, 1}, false, false, Ground::backdrop, 4);
  // Of 10 paths 1 meets nothing, 2 meet object 0, 3 object 1, 2 object 2 and 2 object 3, in this order.
  film.add(0, 0, PathSums{});
  for (const std::uint32_t object : {3u, 1u, 0u, 2u, 1u, 3u, 0u, 2u, 1u}) film.add(0, 0, met(object));
  film.add(1, 0, PathSums{});
  image::Picture picture = film.picture();
  const MatteKind kind{"CryptoObject", {"a", "b", "c", "a"}};
  EXPECT_EQ(kind.ranks(), 4u);
  add_mattes(film, kind, &picture);
  const auto id = [](const char* name) { return matte_id(name); };
  EXPECT_EQ(pixels(picture, "CryptoObject00.R"), (std::vector<float>{id("a"), 0}));  // 2 + 2 of 10
  EXPECT_EQ(pixels(picture, "CryptoObject00.G"), (std::vector<float>{0.4f, 0}));
  EXPECT_EQ(pixels(picture, "CryptoObject00.B"), (std::vector<float>{id("b"), 0}));
  EXPECT_EQ(pixels(picture, "CryptoObject00.A"), (std::vector<float>{0.3f, 0}));
  EXPECT_EQ(pixels(picture, "CryptoObject01.R"), (std::vector<float>{id("c"), 0}));
  EXPECT_EQ(pixels(picture, "CryptoObject01.G"), (std::vector<float>{0.2f, 0}));
  EXPECT_EQ(pixels(picture, "CryptoObject01.A"), (std::vector<float>{0, 0}));
  EXPECT_EQ(pixels(picture, "coverage"), (std::vector<float>{0.9f, 0}));
  EXPECT_FALSE(picture.find("CryptoObject02.R"));
  const std::string prefix = "cryptomatte/3ae39a5/";  // "CryptoObject" hashes to 3ae39a58
  EXPECT_EQ(picture.metadata.at(prefix + "name"), "CryptoObject");
  EXPECT_EQ(picture.metadata.at(prefix + "hash"), "MurmurHash3_32");
  EXPECT_EQ(picture.metadata.at(prefix + "conversion"), "uint32_to_float32");
  EXPECT_EQ(nlohmann::json::parse(picture.metadata.at(prefix + "manifest")),
            nlohmann::json({{"a", hex_of_id(id("a"))}, {"b", hex_of_id(id("b"))}, {"c", hex_of_id(id("c"))}}));
}

// What has no rank is left out and given to nobody: the shares are those of the objects, and their sum is short.
TEST(Cryptomatte, MoreNamesThanRanksAreLeftOut) {
  constexpr std::uint32_t objects = 20;
  Film film({0, 0, 1, 1}, false, false, Ground::backdrop, objects);
  std::vector<std::string> names;
  std::uint32_t paths = 0;
  for (std::uint32_t object = 0; object < objects; ++object) {
    names.push_back("object " + std::to_string(object));
    // The later an object comes the more paths meet it, up to the 16th, which is the last that there is room for.
    for (std::uint32_t i = 0; i <= object; ++i, ++paths) film.add(0, 0, met(object));
  }
  image::Picture picture = film.picture();
  add_mattes(film, {"CryptoObject", names}, &picture);
  double sum = 0;
  const char* const shares[] = {"00.G", "00.A", "01.G", "01.A", "02.G", "02.A"};
  for (std::uint32_t rank = 0; rank < 6; ++rank) {
    const float share = pixels(picture, std::string("CryptoObject") + shares[rank])[0];
    EXPECT_FLOAT_EQ(share, static_cast<float>(16 - rank) / static_cast<float>(paths)) << rank;
    sum += double{share};
  }
  EXPECT_EQ(pixels(picture, "CryptoObject00.R")[0], matte_id("object 15"));
  EXPECT_LT(sum, 1);
  EXPECT_FALSE(picture.find("CryptoObject03.R"));
}

// Paths of three films added up, and of one: the same counts in the same order, however many objects the scene has.
TEST(Cryptomatte, CountsOfPartsAddUpToThoseOfOneFilm) {
  constexpr std::uint32_t objects = 40;
  const image::Window window{0, 0, 1, 1};
  const auto film = [&] { return Film(window, false, false, Ground::backdrop, objects); };
  Film whole = film(), joined = film();
  const std::vector<std::vector<std::uint32_t>> parts{
      {7, 3, 7, 9, 1, 2, 7, 30}, {30, 31, 32, 33, 34, 7, 35, 36, 37, 38}, {39, 7, 0, 39, 4, 5, 6, 7}};
  for (const std::vector<std::uint32_t>& part : parts) {
    Film own = film();
    for (const std::uint32_t object : part) {
      whole.add(0, 0, met(object));
      own.add(0, 0, met(object));
    }
    EXPECT_EQ(joined.add(own), 0u);
  }
  EXPECT_EQ(joined.object_counts().bytes(), whole.object_counts().bytes());

  // A part without room may have left out what the parts before it have counted: that is reported, of this pixel.
  Film full = film();
  for (std::uint32_t object = 0; object < objects; ++object) full.add(0, 0, met(object));
  EXPECT_EQ(joined.add(full), 1u);
  Film first = film();
  EXPECT_EQ(first.add(full), 0u) << "nothing came before it";
}

TEST(Cryptomatte, DroppedPathsAreInNoMatte) {
  Film film({0, 0, 1, 1}, false, false, Ground::backdrop, 1);
  PathSums infinite = met(0);
  infinite.layers[0] = glm::vec3(INFINITY);
  film.add(0, 0, infinite);
  film.add(0, 0, PathSums{});
  EXPECT_EQ(film.object_counts().of(0)[0].paths, 0u);
}

TEST(Cryptomatte, NamesThatAreNotUtf8StillMakeAManifest) {
  const Film film({0, 0, 1, 1}, false, false, Ground::backdrop, 1);
  image::Picture picture = film.picture();
  add_mattes(film, {"CryptoObject", {"f\xff\"\\"}}, &picture);
  EXPECT_TRUE(nlohmann::json::accept(picture.metadata.at("cryptomatte/3ae39a5/manifest")));
}

/// As a compositor decodes it: the shares of all ranks that have the id of a name.
std::vector<double> matte_of(const image::Picture& picture, const std::string& kind, const std::string& key,
                             const std::string& name) {
  const auto manifest = nlohmann::json::parse(picture.metadata.at("cryptomatte/" + key + "/manifest"));
  const auto bits = static_cast<std::uint32_t>(std::stoul(manifest.at(name).get<std::string>(), nullptr, 16));
  std::vector<double> matte;
  for (int layer = 0; picture.find(kind + "0" + std::to_string(layer) + ".R"); ++layer) {
    for (const auto& [id, share] : {std::pair("R", "G"), std::pair("B", "A")}) {
      const std::string prefix = kind + "0" + std::to_string(layer) + ".";
      const std::vector<float>&ids = pixels(picture, prefix + id), &shares = pixels(picture, prefix + share);
      matte.resize(ids.size());
      for (std::size_t i = 0; i < ids.size(); ++i)
        if (std::bit_cast<std::uint32_t>(ids[i]) == bits) matte[i] += double{shares[i]};
    }
  }
  return matte;
}

// Written with halves and read back, ids have all of their bits and the mattes of all names add up to the coverage.
TEST(Cryptomatte, MattesOfAFileAddUpToTheCoverage) {
  scene::Scene scene = tangle(40, 31, 23);
  scene.grooms.push_back(scene.grooms[0]);
  for (glm::vec3& point : scene.grooms[1].points) point.x += 0.35f;
  scene.grooms[0].object = "left";
  scene.grooms[1].object = "right";
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  RenderOptions options;
  options.samples = 7;
  options.max_depth = 2;
  options.mattes = true;
  const image::Picture rendered = render_with(scene, model, fibers, options, 2).picture;
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) / ("tress_mattes_" + std::to_string(getpid()) + ".exr");
  ASSERT_FALSE(image::write_exr(file, rendered, image::Precision::half));
  const auto picture = image::read_exr(file);
  std::filesystem::remove(file);
  ASSERT_TRUE(picture);
  const std::vector<double> left = matte_of(*picture, "CryptoObject", "3ae39a5", "left"),
                            right = matte_of(*picture, "CryptoObject", "3ae39a5", "right"),
                            material = matte_of(*picture, "CryptoMaterial", "be359d6", "brown");
  const std::vector<float>& coverage = rendered.find("coverage")->pixels;
  double of_left = 0, of_right = 0, both = 0;
  for (std::size_t i = 0; i < coverage.size(); ++i) {
    EXPECT_NEAR(left[i] + right[i], double{coverage[i]}, 1e-6) << i;
    EXPECT_NEAR(material[i], double{coverage[i]}, 1e-6) << i;
    of_left += left[i], of_right += right[i], both += left[i] * right[i];
  }
  EXPECT_GT(of_left, 1);
  EXPECT_GT(of_right, 1);
  EXPECT_GT(both, 0);  // pixels that have both
  const image::Picture again = render_with(scene, model, fibers, options, 1).picture;
  EXPECT_TRUE(image::compare(rendered, again, "two threads", "one")->identical);
}

/// A file of two prototypes, both with strands 0 and 1, drawn three and two times, and of two strands beside them: all
/// ids differ. Instances count on from one prototype to the next; what is no instance keeps its name.
TEST(Cryptomatte, StrandsOfDifferentPrototypesDiffer) {
  const std::string curves =
      "int[] curveVertexCounts = [2, 2] point3f[] points = [(0, 0, 0), (0, 0, 1), (1, 0, 0), (1, 0, 1)] float[] widths "
      "= "
      "[0.1] (interpolation = \"constant\") uniform token type = \"linear\" int[] primvars:id = [0, 1] ( interpolation "
      "= "
      "\"uniform\" )";
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) / ("tress_prototypes_" + std::to_string(getpid()) + ".usda");
  std::ofstream(file) << fmt::format(
      "#usda 1.0\n(metersPerUnit = 0.01 upAxis = \"Z\")\ndef BasisCurves \"own\" {{ {0} }}\ndef PointInstancer \"i\" "
      "{{ rel "
      "prototypes = [</i/A>, </i/B>] int[] protoIndices = [0, 1, 0, 0, 1] point3f[] positions = [(0, 9, 0), (0, 8, 0), "
      "(0, "
      "7, 0), (0, 6, 0), (0, 5, 0)]\ndef BasisCurves \"A\" {{ {0} }}\ndef BasisCurves \"B\" {{ {0} }} }}\n",
      curves);
  const auto scene = scene::load_scene(file);
  std::filesystem::remove(file);
  ASSERT_TRUE(scene) << scene.error().message();
  ASSERT_EQ(scene->grooms.size(), 3u);
  std::set<std::uint32_t> ids, expected;
  std::size_t count = 0;
  for (const scene::Groom& groom : scene->grooms)
    for (std::uint32_t instance = 0; instance < groom.times(); ++instance)
      for (std::uint32_t strand = 0; strand < groom.strand_count(); ++strand, ++count)
        ids.insert(strand_matte_bits(groom, instance, strand));
  EXPECT_EQ(count, 12u);
  for (const char* strand : {"0", "1"}) {
    const std::string object = scene->grooms[0].object;
    expected.insert(std::bit_cast<std::uint32_t>(matte_id(object + "/" + strand)));
    for (int instance = 0; instance < 5; ++instance)
      expected.insert(std::bit_cast<std::uint32_t>(matte_id(fmt::format("{}/{}/{}", object, instance, strand))));
  }
  EXPECT_EQ(ids, expected);
}

TEST(Cryptomatte, LayersThatAreNotKeptTakeTheirEntriesAlong) {
  const Film film({0, 0, 1, 1}, false, false, Ground::backdrop, 1);
  image::Picture picture = film.picture();
  add_mattes(film, {"CryptoObject", {"a"}}, &picture);
  add_mattes(film, {"CryptoMaterial", {"b"}}, &picture);
  image::keep_layers({"CryptoMaterial", "Z"}, &picture);
  EXPECT_TRUE(picture.find("CryptoMaterial00.A"));
  EXPECT_FALSE(picture.find("CryptoObject00.A"));
  EXPECT_TRUE(picture.metadata.contains("cryptomatte/be359d6/manifest"));
  EXPECT_FALSE(picture.metadata.contains("cryptomatte/3ae39a5/manifest"));
}

}  // namespace
}  // namespace tress::integrate
