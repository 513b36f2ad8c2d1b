// Layers of data that are asked for: what was hit first, and which strand; mattes of single strands.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "integrate/cryptomatte.h"
#include "integrate/data_layers.h"
#include "integrate/renderer.h"
#include "integrate/white_fiber.h"

namespace tress::integrate {
namespace {

DataLayers all_layers() {
  DataLayers layers;
  for (const char* name : data_layer_names) EXPECT_TRUE(layers.ask(name));
  return layers;
}

Film film_with(const DataLayers& layers) {
  Film::Extra extra;
  extra.data = layers;
  return Film({0, 0, 1, 1}, false, false, Ground::backdrop, 0, false, extra);
}

float pixel_of(const image::Picture& picture, const std::string& name, std::size_t pixel = 0) {
  const image::Channel* channel = picture.find(name);
  EXPECT_TRUE(channel) << name;
  return channel ? channel->pixels[pixel] : NAN;
}

PathSums path_to(float distance_cm, const DataHit& hit) {
  PathSums path;
  path.coverage = 1;
  path.distance_cm = distance_cm;
  path.data = hit;
  return path;
}

DataHit on_strand(std::int64_t strand, float place, const glm::vec3& position) {
  DataHit hit{.position = position, .on_strand = true, .place = place, .strand = strand};
  hit.matte_bits = static_cast<std::uint32_t>(1000 + strand);
  return hit;
}

/// Five paths: one meets nothing, one a mesh, three strands, of which one has root uv.
std::vector<PathSums> five_paths() {
  DataHit with_uv = on_strand(7, 0.5f, {3, 0, 0});
  with_uv.has_uv = true;
  with_uv.root_uv = {0.25f, 0.75f};
  return {path_to(5, on_strand(12, 0.25f, {1, 2, 3})), PathSums{}, path_to(1, {.position = {5, 2, 1}}),
          path_to(4, with_uv), path_to(4, on_strand(9, 0.75f, {7, 0, 0}))};
}

void expect_means_of_five(const image::Picture& picture) {
  EXPECT_EQ(pixel_of(picture, "P.X"), 4.0f) << "of the four that met something";
  EXPECT_EQ(pixel_of(picture, "P.Y"), 1.0f);
  EXPECT_EQ(pixel_of(picture, "P.Z"), 1.0f);
  EXPECT_EQ(pixel_of(picture, "strand_place"), 0.5f) << "of the three that met strands";
  EXPECT_EQ(pixel_of(picture, "strand_uv.u"), 0.25f) << "of the one that has them";
  EXPECT_EQ(pixel_of(picture, "strand_uv.v"), 0.75f);
  EXPECT_EQ(pixel_of(picture, "strand_id"), 7.0f)
      << "the nearest strand, of two at 4 cm the least id; the mesh is no strand";
}

TEST(DataLayers, AreMeansOverThePathsThatMetWhatTheyAreOf) {
  Film film = film_with(all_layers());
  for (const PathSums& path : five_paths()) film.add(0, 0, path);
  expect_means_of_five(film.picture());
  Film empty = film_with(all_layers());
  empty.add(0, 0, PathSums{});
  for (const char* name : {"P.X", "strand_uv.v", "strand_place", "strand_id"})
    EXPECT_EQ(pixel_of(empty.picture(), name), 0.0f) << name;
}

TEST(DataLayers, AreTheSameOfPartsInAnyOrderAndAfterACheckpoint) {
  const std::vector<PathSums> paths = five_paths();
  for (const bool turned : {false, true}) {
    Film one = film_with(all_layers()), other = film_with(all_layers());
    for (std::size_t i = 0; i < paths.size(); ++i) (i < 3 ? one : other).add(0, 0, paths[i]);
    Film& joined = turned ? other : one;
    EXPECT_EQ(joined.add(turned ? one : other), 0u);
    expect_means_of_five(joined.picture());
    std::map<std::string, std::string> saved;
    for (const auto& [name, bytes] : joined.sections()) saved[name] = bytes;
    Film restored = film_with(all_layers());
    ASSERT_TRUE(restored.set_sections(saved));
    expect_means_of_five(restored.picture());
    EXPECT_EQ(restored.strand_counts().bytes(), joined.strand_counts().bytes());
    for (const char* section : {"film.data", "film.strands"}) {
      auto less = saved;
      less.erase(section);
      EXPECT_FALSE(film_with(all_layers()).set_sections(less)) << section;
    }
  }
}

TEST(DataLayers, AreThereOnlyIfAskedFor) {
  DataLayers layers;
  EXPECT_FALSE(layers.ask("Z"));
  EXPECT_FALSE(layers.has_any());
  EXPECT_TRUE(layers.ask("strand_id"));
  EXPECT_EQ(layers.names(), std::vector<std::string>{"strand_id"});
  const image::Picture picture = film_with(layers).picture();
  EXPECT_TRUE(picture.find("strand_id"));
  for (const char* name : {"P.X", "strand_uv.u", "strand_place"}) EXPECT_FALSE(picture.find(name)) << name;
}

/// Two straight strands down from z = 8 at x = -1.5 and 1.5, whose second segment is three times as long as the first,
/// seen by parallel rays along y.
scene::Scene two_strands() {
  scene::Scene scene;
  scene.camera.eye = {0, -10, 4};
  scene.camera.look_at = {0, 0, 4};
  scene.camera.orthographic_height_cm = 8;
  scene.image.width = scene.image.height = 8;
  scene.materials.resize(1);
  scene.grooms.resize(1);
  scene::Groom& groom = scene.grooms[0];
  groom.object = "pair";
  groom.basis = scene::StrandBasis::linear;
  groom.first_point = {0};
  for (const float x : {-1.5f, 1.5f}) {
    for (const float z : {8.0f, 6.0f, 0.0f}) {
      groom.points.emplace_back(x, 0, z);
      groom.radius_cm.push_back(2.0f);
    }
    groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
  }
  groom.id = {16777215, 3};
  groom.root_uv = {{0.125f, 0.5f}, {0.75f, 1.5f}};
  scene::assign_fibers(&scene);
  return scene;
}

RenderOptions options_with(const DataLayers& layers, int samples) {
  RenderOptions options;
  options.samples = samples;
  options.max_depth = 1;
  options.data = layers;
  return options;
}

TEST(DataLayers, OfARenderAreThoseOfTheStrandsThatAreSeen) {
  const scene::Scene scene = two_strands();
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  const image::Picture picture = render_with(scene, model, fibers, options_with(all_layers(), 64)).picture;
  for (std::size_t row = 1; row < 7; ++row) {
    for (const std::size_t column : {2ul, 5ul}) {  // no path of them meets the other strand
      const std::size_t pixel = row * 8 + column;
      const bool left = column == 2;
      ASSERT_EQ(pixel_of(picture, "coverage", pixel), 1.0f);
      // The tent has a standard deviation of 0.41 pixels, of 1 cm; 64 stratified paths bring the mean within 0.05.
      EXPECT_NEAR(pixel_of(picture, "P.X", pixel), double(column) - 3.5, 0.05);
      EXPECT_NEAR(pixel_of(picture, "P.Z", pixel), 7.5 - double(row), 0.05);
      EXPECT_NEAR(pixel_of(picture, "strand_place", pixel), (double(row) + 0.5) / 8, 0.05 / 8);
      EXPECT_EQ(pixel_of(picture, "strand_uv.u", pixel), left ? 0.125f : 0.75f);
      EXPECT_EQ(pixel_of(picture, "strand_uv.v", pixel), left ? 0.5f : 1.5f);
      EXPECT_EQ(pixel_of(picture, "strand_id", pixel), left ? 16777215.0f : 3.0f);
      EXPECT_EQ(pixel_of(picture, "CryptoStrand00.R", pixel), matte_id(left ? "pair/16777215" : "pair/3"));
      EXPECT_EQ(pixel_of(picture, "CryptoStrand00.G", pixel), 1.0f);
    }
  }
}

/// As a compositor decodes it that knows the name: the shares of all ranks with its id.
std::vector<double> decoded(const image::Picture& picture, const std::string& kind, const std::string& name) {
  const auto bits = std::bit_cast<std::uint32_t>(matte_id(name));
  std::vector<double> matte;
  for (int layer = 0; picture.find(fmt::format("{}0{}.R", kind, layer)); ++layer) {
    for (const auto& [id, share] : {std::pair("R", "G"), std::pair("B", "A")}) {
      const std::vector<float>& ids = picture.find(fmt::format("{}0{}.{}", kind, layer, id))->pixels;
      const std::vector<float>& shares = picture.find(fmt::format("{}0{}.{}", kind, layer, share))->pixels;
      matte.resize(ids.size());
      for (std::size_t i = 0; i < ids.size(); ++i)
        if (std::bit_cast<std::uint32_t>(ids[i]) == bits) matte[i] += double{shares[i]};
    }
  }
  return matte;
}

// Of a scene in which each strand is a groom of its own, the mattes of objects are those of strands: paths meet the
// same first whatever the strands belong to.
TEST(CryptoStrand, MattesOfAFileAreThoseOfGroomsOfOneStrand) {
  scene::Scene together = tangle(12, 31, 23);
  together.materials[0].fiber.eccentricity = 1;  // no width depends on how a strand is turned
  scene::assign_fibers(&together);
  together.grooms[0].object = "ball";
  scene::Scene apart = together;
  const scene::Groom groom = together.grooms[0];
  apart.grooms.clear();
  for (std::uint32_t strand = 0; strand < groom.strand_count(); ++strand) {
    scene::Groom one;
    one.object = fmt::format("ball/{}", strand);
    const auto from = [&](const auto& values) { return values.begin() + groom.first_point[strand]; };
    const auto to = [&](const auto& values) { return values.begin() + groom.first_point[strand + 1]; };
    one.points.assign(from(groom.points), to(groom.points));
    one.radius_cm.assign(from(groom.radius_cm), to(groom.radius_cm));
    one.first_point = {0, static_cast<std::uint32_t>(one.points.size())};
    apart.grooms.push_back(one);
  }
  scene::assign_fibers(&apart);
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  RenderOptions options = options_with(all_layers(), 7);
  const image::Picture rendered = render_with(together, model, fibers, options, 2).picture;
  options.mattes = true;
  options.data = {};
  const image::Picture objects = render_with(apart, model, fibers, options, 2).picture;
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) / ("tress_strands_" + std::to_string(getpid()) + ".exr");
  ASSERT_FALSE(image::write_exr(file, rendered, image::Precision::half));
  const auto picture = image::read_exr(file);
  std::filesystem::remove(file);
  ASSERT_TRUE(picture);
  const std::string prefix = "cryptomatte/" + MatteKind{"CryptoStrand", {}}.key() + "/";
  EXPECT_EQ(picture->metadata.at(prefix + "name"), "CryptoStrand");
  EXPECT_EQ(picture->metadata.at(prefix + "manifest"), "{}") << "Blender lists layers by their manifests";
  const std::vector<float>& last = objects.find("CryptoObject02.B")->pixels;
  std::vector<double> sum(last.size());
  int strands_seen = 0, shared = 0;
  for (std::uint32_t strand = 0; strand < groom.strand_count(); ++strand) {
    const std::string name = fmt::format("ball/{}", strand);
    const std::vector<double> one = decoded(*picture, "CryptoStrand", name);
    const std::vector<double> other = decoded(objects, "CryptoObject", name);
    double seen = 0;
    for (std::size_t i = 0; i < one.size(); ++i) {
      if (last[i] == 0) {
        EXPECT_EQ(one[i], other[i]) << name << " in pixel " << i << ", where no object is without a rank";
      }
      shared += one[i] > 0 && one[i] < double{rendered.find("coverage")->pixels[i]};
      sum[i] += one[i];
      seen += one[i];
    }
    strands_seen += seen > 0;
  }
  for (std::size_t i = 0; i < sum.size(); ++i) EXPECT_NEAR(sum[i], double{rendered.find("coverage")->pixels[i]}, 1e-6);
  EXPECT_GT(strands_seen, 6);
  EXPECT_GT(shared, 20);
  options = options_with(all_layers(), 7);
  EXPECT_TRUE(image::compare(rendered, render_with(together, model, fibers, options, 1).picture, "", "")->identical);
  image::Picture without = rendered;
  image::keep_layers({"Z"}, &without);
  EXPECT_FALSE(without.metadata.contains(prefix + "name"));
}

}  // namespace
}  // namespace tress::integrate
