// What must hold of a picture whatever the numbers drawn: same bits, layers, interruption, passes.
#include "integrate/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <string>
#include <string_view>

#include "integrate/film.h"
#include "integrate/pass_order.h"
#include "integrate/sample_plan.h"
#include "integrate/white_fiber.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::integrate {
namespace {

RenderOptions few_samples(int samples) {
  RenderOptions options;
  options.samples = samples;
  options.max_depth = 20;
  options.seed = 3;
  return options;
}

const std::vector<float>& channel(const RenderResult& result, std::string_view name) {
  const image::Channel* found = result.picture.find(std::string(name));
  EXPECT_TRUE(found) << name;
  return found->pixels;
}

TEST(PassOrder, first_passes_are_disjoint_and_cover_the_picture) {
  int pixels[initial_passes] = {};
  std::set<int> ranks;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      int passes = 0;
      for (int pass = 0; pass < initial_passes; ++pass) {
        if (!in_pass(pass, x, y)) continue;
        ++passes;
        ++pixels[pass];
        EXPECT_EQ(sample_of_pass(pass), 0u);
      }
      EXPECT_EQ(passes, 1);
      EXPECT_TRUE(in_pass(initial_passes, x, y));
      if (x < 8 && y < 8) ranks.insert(rank_in_tile(x, y));
    }
  }
  EXPECT_EQ(ranks.size(), 64u);
  EXPECT_EQ(pixels[0], 64 * 64 / 64);
  EXPECT_EQ(pixels[1], 64 * 64 / 16);
  EXPECT_EQ(pixels[2], 64 * 64 / 4);
  EXPECT_EQ(pixels[3], 64 * 64 * 43 / 64);
  EXPECT_EQ(sample_of_pass(pass_count(17) - 1), 16u);
}

/// What a pixel brought changes the samples of those around it, not its own: else a picture would be too dark. What it
/// does to the mean over 400 pixels is all that its own count sees.
TEST(SamplePlan, gives_a_pixel_samples_by_the_pixels_around_it) {
  const image::Window window{0, 0, 20, 20};
  const auto planned = [&](double own_deviations) {
    SamplePlan plan(window, true);
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 20; ++x) {
        PixelSums sums;
        sums.samples = 8;
        sums.vertices = 16;
        sums.squared_deviations = glm::dvec3(x == 10 && y == 10 ? own_deviations : x < 10 ? 1.0 : 4.0);
        plan.note(x, y, sums);
      }
    plan.pass_ended(initial_passes + 6);  // each pixel has 8
    return plan;
  };
  const SamplePlan dark = planned(0), even = planned(4), bright = planned(40);
  const int later = initial_passes + 6 + 56;
  const std::uint32_t own = even.samples_after(later, 10, 10);
  EXPECT_GT(own, even.samples_after(later, 3, 10)) << "where it is noisier";
  EXPECT_NEAR(dark.samples_after(later, 10, 10), own, 1 + 0.05 * own);
  EXPECT_NEAR(bright.samples_after(later, 10, 10), own, 1 + 0.05 * own);
  EXPECT_GT(bright.samples_after(later, 11, 11), 1.1 * even.samples_after(later, 11, 11));
  double mean = 0;
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 20; ++x) {
      const std::uint32_t count = even.samples_after(later, x, y);
      EXPECT_GE(count, 32u) << "what the next plan goes by";
      mean += count / 400.0;
    }
  EXPECT_NEAR(mean, 64, 0.5);
}

TEST(Renderer, reports_every_pass_and_ends_with_the_samples_asked_for) {
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  std::vector<PassProgress> passes;
  const RenderResult result =
      render_with(tangle(50, 37, 21), model, fibers, few_samples(3), 2, never_stop, [&](const PassProgress& progress) {
        passes.push_back(progress);
        return true;
      });
  ASSERT_EQ(passes.size(), 6u);
  std::uint64_t paths = 0;
  for (std::size_t i = 0; i < passes.size(); ++i) {
    EXPECT_EQ(passes[i].pass, static_cast<int>(i));
    EXPECT_EQ(passes[i].pass_count, 6);
    paths += passes[i].pixels;
    EXPECT_EQ(passes[i].paths_so_far, paths);
    EXPECT_EQ(passes[i].paths_total, 37u * 21u * 3u);
    EXPECT_GE(passes[i].cpu_seconds, 0);
  }
  EXPECT_EQ(paths, 37u * 21u * 3u);
  EXPECT_EQ(result.passes, 6);
  EXPECT_EQ(result.samples_per_pixel, 3);
  EXPECT_FALSE(result.interrupted);
  EXPECT_GT(result.queries, 0u);
  EXPECT_EQ(result.exact_queries * 2, result.queries);
}

TEST(Renderer, gives_the_same_bits_for_any_number_of_threads) {
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  const scene::Scene scene = tangle(150, 67, 41);
  RenderOptions options = few_samples(4);
  options.light_samples = 2;
  options.bcsdf_samples = 2;
  const RenderResult one = render_with(scene, model, fibers, options, 1);
  for (const int threads : {2, 8, 16}) {
    const RenderResult many = render_with(scene, model, fibers, options, threads);
    ASSERT_EQ(one.picture.channels.size(), many.picture.channels.size());
    for (std::size_t i = 0; i < one.picture.channels.size(); ++i) {
      EXPECT_EQ(one.picture.channels[i].pixels, many.picture.channels[i].pixels) << one.picture.channels[i].name;
    }
    EXPECT_EQ(one.queries, many.queries);
  }
  options.seed = 4;
  EXPECT_NE(render_with(scene, model, fibers, options, 1).picture.channels[0].pixels, one.picture.channels[0].pixels);
}

TEST(Renderer, layers_sum_to_beauty_bit_for_bit) {
  WhiteFiber model;
  fiber::LobeColors shares = lossless_shares();
  shares[5] = shares[4];
  const std::vector<fiber::FiberId> fibers{model.add_fiber(shares)};
  scene::Scene scene = tangle(100, 40, 40);
  for (const bool glint : {false, true}) {
    scene.fibers[0].split_glint = glint;
    if (!glint) shares[5] = glm::vec3(0.0f);
    const std::vector<fiber::FiberId> ids{model.add_fiber(shares)};
    const RenderResult result = render_with(scene, model, glint ? fibers : ids, few_samples(4));
    EXPECT_EQ(result.picture.find("GLINT.R") != nullptr, glint);
    for (const std::string color : {"R", "G", "B"}) {
      std::vector<float> sum(40 * 40, 0.0f);
      for (const char* layer : {"R", "TT", "TRT", "TRRT", "residual", "GLINT", "surface", "background"}) {
        if (!glint && layer == std::string("GLINT")) continue;
        const std::vector<float>& part = channel(result, std::string(layer) + "." + color);
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += part[i];
      }
      EXPECT_EQ(sum, channel(result, color));
    }
    for (const float share : channel(result, "ais.exact")) EXPECT_TRUE(share == 0.0f || share == 0.5f);
    for (const float mean : channel(result, "ais.objective")) EXPECT_TRUE(mean == 0.0f || mean == 0.25f);
  }
}

TEST(Renderer, writes_albedo_normal_tangent_and_distance_of_what_is_seen) {
  WhiteFiber model;
  fiber::LobeColors shares{};
  shares[0] = {0.25f, 0, 0.5f};
  shares[2] = {0.25f, 0.75f, 0};
  const std::vector<fiber::FiberId> fibers{model.add_fiber(shares)};
  // One straight strand, thinner than a pixel is high, across the middle of the picture: a part of the paths see it.
  scene::Scene scene;
  scene.camera.eye = {0, -10, 0};
  scene.camera.vertical_fov_deg = 10;
  scene.image.width = scene.image.height = 15;
  scene.materials.resize(1);
  scene.grooms.resize(1);
  scene.grooms[0].first_point = {0, 2};
  scene.grooms[0].points = {{-9, 0, 0}, {9, 0, 0}};
  scene.grooms[0].radius_cm = {0.03f, 0.03f};
  scene::assign_fibers(&scene);
  const RenderResult result = render_with(scene, model, fibers, few_samples(64));
  int partial = 0;
  for (std::size_t i = 0; i < 15 * 15; ++i) {
    const float covered = channel(result, "coverage")[i];
    partial += covered > 0 && covered < 1;
    // Colors are means over all paths, tangent and distance over those that met the fiber.
    EXPECT_NEAR(channel(result, "albedo.R")[i], 0.5f * covered, 1e-5);
    EXPECT_NEAR(channel(result, "albedo.G")[i], 0.75f * covered, 1e-5);
    EXPECT_NEAR(channel(result, "albedo.B")[i], 0.5f * covered, 1e-5);
    EXPECT_NEAR(channel(result, "tangent.X")[i], covered > 0 ? 1 : 0, 1e-5);
    EXPECT_NEAR(channel(result, "tangent.Y")[i], 0, 1e-5);
    EXPECT_NEAR(channel(result, "tangent.Z")[i], 0, 1e-5);
    EXPECT_NEAR(channel(result, "N.X")[i], 0, 1e-5);  // across the fiber, towards the camera
    EXPECT_NEAR(channel(result, "N.Y")[i], covered > 0 ? -1 : 0, 1e-4);
    // The strand is 10 cm away; to the picture's side a ray is longer by at most 1 / cos(atan(tan 5 degrees)).
    const float distance = channel(result, "Z")[i];
    if (covered > 0) {
      EXPECT_GT(distance, 9.9f);
      EXPECT_LT(distance, 10.06f);
    } else {
      EXPECT_EQ(distance, 0);
    }
  }
  EXPECT_GE(partial, 15);
}

TEST(Renderer, a_crop_has_the_pixels_of_the_whole_picture) {
  WhiteFiber model;  // learns nothing: pixels depend on nothing but themselves
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  const scene::Scene scene = tangle(150, 67, 41);
  RenderOptions options = few_samples(3);
  options.light_samples = 2;
  options.roulette = Roulette::throughput;
  const RenderResult whole = render_with(scene, model, fibers, options, 2);
  for (const image::Window window : {image::Window{20, 7, 30, 21}, {0, 0, 1, 1}, {66, 40, 1, 1}, {0, 0, 67, 41}}) {
    options.crop = window;
    const RenderResult part = render_with(scene, model, fibers, options, 2);
    EXPECT_EQ(part.picture.window(), window);
    EXPECT_EQ(part.picture.whole(), whole.picture.whole());
    EXPECT_EQ(part.samples_per_pixel, 3);
    const auto difference = image::compare(whole.picture, part.picture, "whole", "part");
    ASSERT_TRUE(difference);
    EXPECT_TRUE(difference->identical);
  }
}

TEST(Renderer, layer_is_the_lobe_of_the_first_hit) {
  WhiteFiber model;
  fiber::LobeColors only_r{}, only_tt{};
  only_r[0] = glm::vec3(0.5f);
  only_tt[1] = glm::vec3(0.5f);
  // A fence of R fibers before a wall of TT fibers: light bounces between them.
  scene::Scene scene;
  scene.camera.eye = {0, -6, 0};
  scene.image.width = scene.image.height = 32;
  scene.environment_visible = false;
  scene.materials.resize(2);
  scene.grooms.resize(2);
  for (std::uint32_t which = 0; which < 2; ++which) {
    scene::Groom& groom = scene.grooms[which];
    groom.material = which;
    groom.first_point = {0};
    for (int i = -20; i <= 20; ++i) {
      const float x = 0.1f * static_cast<float>(i), y = which == 0 ? 0.0f : 0.3f;
      groom.points.insert(groom.points.end(), {{x, y, -3}, {x, y, 3}});
      groom.radius_cm.insert(groom.radius_cm.end(), 2, which == 0 ? 0.06f : 0.02f);
      groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
    }
  }
  scene::assign_fibers(&scene);
  const std::vector<fiber::FiberId> fibers{model.add_fiber(only_r), model.add_fiber(only_tt)};
  // The fence covers all: no camera ray sees the wall.
  const RenderResult fenced = render_with(scene, model, fibers, few_samples(4));
  double r = 0;
  for (const float value : channel(fenced, "R.R")) r += value;
  EXPECT_GT(r, 0);
  for (const char* layer : {"TT.R", "TRT.G", "residual.B", "surface.R", "background.R"}) {
    for (const float value : channel(fenced, layer)) EXPECT_EQ(value, 0);
  }
  for (const float value : channel(fenced, "coverage")) EXPECT_EQ(value, 1);
  scene.grooms[0].radius_cm.assign(scene.grooms[0].radius_cm.size(), 0.02f);
  double tt = 0;
  const RenderResult open = render_with(scene, model, fibers, few_samples(4));
  for (const float value : channel(open, "TT.R")) tt += value;
  EXPECT_GT(tt, 0);
}

TEST(Renderer, a_surface_that_is_seen_has_a_layer_its_albedo_and_the_normal_towards_the_camera) {
  scene::Scene scene;
  scene.camera.eye = {0, -6, 0};
  scene.camera.vertical_fov_deg = 20;
  scene.image.width = scene.image.height = 16;
  scene::Mesh wall;  // across the view, wound either way
  wall.positions = {{-9, 0, -9}, {9, 0, -9}, {9, 0, 9}, {-9, 0, 9}};
  wall.albedo = {0.25f, 0.5f, 1};
  WhiteFiber model;
  for (const bool turned : {false, true}) {
    wall.triangles =
        turned ? std::vector<glm::uvec3>{{0, 2, 1}, {0, 3, 2}} : std::vector<glm::uvec3>{{0, 1, 2}, {0, 2, 3}};
    scene.meshes = {wall};
    RenderOptions options = few_samples(2);
    options.light_samples = 0;  // every path then brings the albedo: a convex furnace, drawn by the cosine
    const RenderResult result = render_with(scene, model, {}, options);
    for (std::size_t i = 0; i < 16 * 16; ++i) {
      EXPECT_EQ(channel(result, "coverage")[i], 1);
      EXPECT_NEAR(channel(result, "surface.R")[i], 0.25f, 1e-6);
      EXPECT_EQ(channel(result, "R")[i], channel(result, "surface.R")[i]);
      EXPECT_NEAR(channel(result, "albedo.G")[i], 0.5f, 1e-6);
      EXPECT_NEAR(channel(result, "N.Y")[i], -1, 1e-6);
      EXPECT_EQ(channel(result, "tangent.X")[i], 0);
      EXPECT_GE(channel(result, "Z")[i], 6 - 1e-5f);
      EXPECT_LT(channel(result, "Z")[i], 6.3f);
      for (const char* layer : {"R.R", "residual.B", "background.R", "ais.exact"})
        EXPECT_EQ(channel(result, layer)[i], 0);
    }
  }
}

/// A wall whose normals lean by 20 degrees is lit as a wall that leans: by a light of one direction, cos / pi times the
/// albedo times the irradiance, and by none that its faces are turned from. N is the leaning one.
TEST(Renderer, a_surface_is_shaded_by_the_normals_of_its_corners) {
  scene::Scene scene;
  scene.camera.eye = {0, -6, 0};
  scene.camera.vertical_fov_deg = 20;
  scene.image.width = scene.image.height = 8;
  scene.environment = scene::Environment(glm::vec3(0.0f));
  scene::Mesh wall;
  wall.positions = {{-9, 0, -9}, {9, 0, -9}, {9, 0, 9}, {-9, 0, 9}};
  wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  wall.albedo = glm::vec3(0.5f);
  const float lean = 20 * std::numbers::pi_v<float> / 180;
  wall.normals = {{std::sin(lean), -std::cos(lean), 0}};
  wall.corner_normals = {glm::uvec3(0), glm::uvec3(0)};
  scene.meshes = {wall};
  WhiteFiber model;
  for (const float azimuth_deg :
       {0.0f, 20.0f, -30.0f, 85.0f, 95.0f}) {  // from the wall's normal to the side it leans to
    const float azimuth = azimuth_deg * std::numbers::pi_v<float> / 180;
    scene::Light light;
    light.direction = {std::sin(azimuth), -std::cos(azimuth), 0};
    light.half_angle_rad = 1e-3f;
    light.radiance = glm::vec3(1 / (std::numbers::pi_v<float> * 1e-6f));  // of irradiance 1
    scene.lights = {light};
    RenderOptions options = few_samples(4);
    options.shadow_roulette = false;  // every sample then brings the same
    const RenderResult result = render_with(scene, model, {}, options);
    const float of_face = std::max(0.0f, std::cos(azimuth)), cosine = std::cos(azimuth - lean);
    const float share = std::min(1.0f, of_face / (cosine * std::cos(lean))), fade = share * (1 + share * (1 - share));
    for (std::size_t i = 0; i < 64; ++i) {
      EXPECT_NEAR(channel(result, "surface.R")[i], 0.5f * fade * cosine / std::numbers::pi_v<float>, 2e-4)
          << azimuth_deg;
      EXPECT_NEAR(channel(result, "N.X")[i], std::sin(lean), 1e-5);
    }
  }
}

/// A sphere of 8 x 12 faces with the normals of a smooth one, under a light of one direction: every pixel within its
/// outline is lit by its normals, also where its faces are turned from the light or hide it. Without lights it is white
/// in a white surround.
TEST(Renderer, a_coarse_mesh_is_lit_as_the_smooth_surface_that_it_stands_for) {
  constexpr std::uint32_t across = 12, down = 8;
  constexpr float pi = std::numbers::pi_v<float>;
  scene::Mesh ball;
  ball.albedo = glm::vec3(1);
  for (std::uint32_t row = 0; row <= down; ++row)
    for (std::uint32_t column = 0; column < across; ++column) {
      const float theta = pi * static_cast<float>(row) / down, phi = 2 * pi * static_cast<float>(column) / across;
      ball.positions.emplace_back(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
    }
  for (std::uint32_t row = 0; row < down; ++row)
    for (std::uint32_t column = 0; column < across; ++column) {
      const std::uint32_t a = across * row + column, b = across * row + (column + 1) % across;
      if (row + 1 < down) ball.triangles.emplace_back(a, b + across, a + across);
      if (row > 0) ball.triangles.emplace_back(a, b, b + across);
    }
  ball.normals = ball.positions;
  ball.corner_normals = ball.triangles;
  scene::Scene scene;
  scene.camera.eye = {0, -20, 0};
  scene.camera.vertical_fov_deg = 6;
  scene.image.width = scene.image.height = 32;
  scene.meshes = {ball};
  WhiteFiber model;
  scene.environment = scene::Environment(glm::vec3(0.0f));
  scene::Light light;
  const glm::vec3 towards = glm::normalize(glm::vec3(1, -0.15f, 0.2f));
  light.direction = towards;
  light.half_angle_rad = 1e-3f;
  light.radiance = glm::vec3(1e6f / pi);  // of irradiance 1
  scene.lights = {light};
  RenderOptions options = few_samples(4);
  options.shadow_roulette = false;
  options.max_depth = 1;
  const RenderResult lit = render_with(scene, model, {}, options);
  scene.lights.clear();
  scene.environment = scene::Environment(glm::vec3(1.0f));
  const RenderResult white = render_with(scene, model, {}, few_samples(64));
  int inside = 0, wrong = 0;
  double mean = 0;
  for (std::size_t i = 0; i < 32 * 32; ++i) {
    const glm::vec3 normal(channel(lit, "N.X")[i], channel(lit, "N.Y")[i], channel(lit, "N.Z")[i]);
    // Within the outline, and where all of a pixel's normals are on one side of the edge between light and shadow.
    if (!(normal.y < -0.4f) || std::abs(glm::dot(normal, towards)) < 0.1f) continue;
    ++inside;
    const float expected = std::max(0.0f, glm::dot(normal, towards)) / pi;
    // Normals are interpolated and made unit, light starts from the surface: no picture error but rounding.
    wrong += !(std::abs(channel(lit, "surface.R")[i] - expected) < 2e-3f);
    mean += static_cast<double>(channel(white, "surface.R")[i]);
  }
  // Some 30,000 samples whose standard deviation is near 1: three standard errors.
  EXPECT_NEAR(mean / inside, 1, 0.02);
  EXPECT_GT(inside, 300);
  EXPECT_EQ(wrong, 0);
}

TEST(Renderer, shows_the_environment_behind_only_if_asked) {
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  scene::Scene scene = tangle(1, 16, 16);
  scene.camera.look_at = {0, -12, 0};  // away from the hair
  for (const bool visible : {false, true}) {
    scene.environment_visible = visible;
    const RenderResult result = render_with(scene, model, fibers, few_samples(2));
    for (const char* name : {"R", "background.G"}) {
      for (const float value : channel(result, name)) EXPECT_EQ(value, visible ? 1.0f : 0.0f);
    }
    for (const float value : channel(result, "coverage")) EXPECT_EQ(value, 0);
    for (const float value : channel(result, "A")) EXPECT_EQ(value, visible ? 1.0f : 0.0f);
    for (const float value : channel(result, "ais.exact")) EXPECT_EQ(value, 0);
  }
}

/// A compositor's "over": A + (1 - A.alpha) B, premultiplied. The opaque picture over anything is itself; the
/// transparent one over a plate is the plate seen through the hair, and beauty and background of it are the opaque
/// one's.
TEST(Renderer, a_transparent_picture_has_its_backdrop_in_a_layer_alone_and_alpha_is_the_coverage) {
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  scene::Scene scene = tangle(20, 24, 24);
  scene.environment = scene::Environment(glm::vec3(0.5f, 1.0f, 2.0f));
  const RenderResult opaque = render_with(scene, model, fibers, few_samples(8));
  scene.image.transparent = true;
  const RenderResult clear = render_with(scene, model, fibers, few_samples(8));
  double seen_through = 0;
  for (std::size_t i = 0; i < 24 * 24; ++i) {
    EXPECT_EQ(channel(opaque, "A")[i], 1);
    const float alpha = channel(clear, "A")[i];
    EXPECT_EQ(alpha, channel(clear, "coverage")[i]);
    EXPECT_EQ(channel(clear, "coverage")[i], channel(opaque, "coverage")[i]);
    EXPECT_EQ(channel(clear, "background.G")[i], channel(opaque, "background.G")[i]);
    EXPECT_NEAR(channel(clear, "background.G")[i], 1 - alpha, 1e-6) << "the backdrop is 1 where it is seen";
    EXPECT_NEAR(channel(clear, "G")[i] + channel(clear, "background.G")[i], channel(opaque, "G")[i], 1e-6);
    if (alpha == 0) {
      EXPECT_EQ(channel(clear, "G")[i], 0);
      EXPECT_EQ(channel(clear, "variance.G")[i], 0);
    }
    seen_through += 1 - alpha;
  }
  EXPECT_GT(seen_through, 24);
  EXPECT_LT(seen_through, 23 * 24);
}

/// Of an adaptive picture the samples of a pixel differ, between a half and four times what is spread after the first
/// 8; their mean is what was asked for but for rounding; and the bits do not depend on the threads.
TEST(Renderer, an_adaptive_picture_has_its_samples_where_it_is_noisy) {
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  scene::Scene scene = tangle(60, 40, 33);
  scene.environment_visible = false;
  scene::Light light;  // small and bright: noise, and less of it where there is no hair
  light.kind = scene::Light::Kind::sphere;
  light.center = {0, -8, 6};
  light.radius_cm = 0.5f;
  light.radiance = glm::vec3(500.0f);
  scene.lights = {light};
  RenderOptions options = few_samples(24);
  options.max_depth = 4;
  options.adaptive = true;
  const RenderResult one = render_with(scene, model, fibers, options, 1);
  const std::vector<float>& samples = channel(one, "samples");
  double sum = 0;
  for (const float count : samples) {
    EXPECT_GE(count, 8 + 16 / 2);
    EXPECT_LE(count, 8 + 16 * 4 + 1);
    sum += static_cast<double>(count) / static_cast<double>(samples.size());
  }
  EXPECT_NEAR(sum, 24, 0.2);
  EXPECT_NEAR(one.samples_per_pixel, sum, 1e-9);
  EXPECT_GT(*std::ranges::max_element(samples), 1.5f * *std::ranges::min_element(samples));
  EXPECT_FALSE(one.interrupted);
  const RenderResult many = render_with(scene, model, fibers, options, 8);
  for (std::size_t i = 0; i < one.picture.channels.size(); ++i)
    EXPECT_EQ(one.picture.channels[i].pixels, many.picture.channels[i].pixels) << one.picture.channels[i].name;
  options.adaptive = false;
  const RenderResult even = render_with(scene, model, fibers, options, 2);
  for (const float count : channel(even, "samples")) EXPECT_EQ(count, 24);
}

/// Saved before the first plan, at it, and after it: a render that goes on from there has the same bits.
TEST(Renderer, an_adaptive_picture_goes_on_from_where_it_was_saved) {
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  const scene::Scene scene = tangle(60, 24, 17);
  RenderOptions options = few_samples(20);
  options.max_depth = 4;
  options.adaptive = true;
  const RenderResult whole = render_with(scene, model, fibers, options, 2);
  for (const int last : {1, 6, 10, 15, 22}) {
    RenderState state;
    render_with(scene, model, fibers, options, 2, never_stop, [&](const PassProgress& pass) {
      if (pass.pass < last) return true;
      state.passes = pass.pass + 1;
      state.paths = pass.paths_so_far;
      for (const auto& [name, bytes] : pass.sections()) state.sections[name] = std::string(bytes);
      return false;
    });
    RenderOptions on = options;
    on.resume = &state;
    const RenderResult rest = render_with(scene, model, fibers, on, 2);
    ASSERT_FALSE(rest.unusable) << last;
    EXPECT_EQ(channel(rest, "R"), channel(whole, "R")) << last;
    EXPECT_EQ(channel(rest, "samples"), channel(whole, "samples")) << last;
    state.sections.erase("plan.notes");
    EXPECT_TRUE(render_with(scene, model, fibers, on, 2).unusable);
  }
}

TEST(Renderer, interrupted_anywhere_returns_a_finite_picture) {
  for (const int events : {0, 1, 40, 400, 3000}) {
    WhiteFiber model;
    const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
    std::atomic<bool> stop{events == 0};
    std::atomic<int> count{0};
    model.on_begin = [&] {
      if (++count == events) stop = true;
    };
    const RenderResult result = render_with(tangle(80, 64, 64), model, fibers, few_samples(8), 2, stop);
    EXPECT_TRUE(result.interrupted);
    EXPECT_LT(result.samples_per_pixel, 8);
    for (const image::Channel& layer : result.picture.channels) {
      ASSERT_EQ(layer.pixels.size(), 64u * 64u);
      for (const float value : layer.pixels) ASSERT_TRUE(std::isfinite(value)) << layer.name;
    }
    for (const float coverage : channel(result, "coverage")) {
      EXPECT_GE(coverage, 0);
      EXPECT_LE(coverage, 1);
    }
  }
}

TEST(Renderer, stops_after_a_pass_when_asked) {
  WhiteFiber model;
  const std::vector<fiber::FiberId> fibers{model.add_fiber(lossless_shares())};
  const RenderResult result = render_with(tangle(20, 16, 16), model, fibers, few_samples(8), 1, never_stop,
                                          [](const PassProgress& progress) { return progress.pass < 4; });
  EXPECT_EQ(result.passes, 5);
  EXPECT_EQ(result.samples_per_pixel, 2);
  EXPECT_FALSE(result.interrupted);
}

TEST(Renderer, the_order_of_materials_changes_no_pixel) {
  // Twelve materials, a strand of each after the other; the scene names them from any of them on.
  constexpr std::uint32_t count = 12;
  const auto rendered = [&](std::uint32_t first) {
    scene::Scene scene = tangle(60, 24, 24);
    const scene::Groom all = scene.grooms[0];
    scene.camera.vertical_fov_deg = 14;
    scene.grooms.assign(count, {});
    scene.materials.assign(count, {});
    for (std::uint32_t which = 0; which < count; ++which) {
      scene::Material& material = scene.materials[(which + first) % count];
      material.name = "material " + std::to_string(which);
      material.fiber.eccentricity = 1;
      material.fiber.tilt = 0;
      material.fiber.roughness = 0.1f + 0.03f * static_cast<float>(which);
      scene::Groom& groom = scene.grooms[which];
      groom.material = (which + first) % count;
      groom.first_point = {0};
      for (std::uint32_t strand = which; strand < all.strand_count(); strand += count) {
        for (std::uint32_t i = all.first_point[strand]; i < all.first_point[strand + 1]; ++i) {
          groom.points.push_back(all.points[i]);
          groom.radius_cm.push_back(all.radius_cm[i]);
        }
        groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
      }
    }
    scene::assign_fibers(&scene);
    const auto model = *fiber::make_elliptical_model(fiber::Estimator::exact, nullptr);
    std::vector<fiber::FiberId> fibers;
    for (const fiber::FiberParameters& fiber : scene.fibers) fibers.push_back(model->add_fiber(fiber));
    return render_with(scene, *model, fibers, few_samples(1), 2);
  };
  const RenderResult given = rendered(0), rotated = rendered(5);
  EXPECT_GT(given.queries, 100u);
  const auto difference = image::compare(given.picture, rotated.picture, "given", "rotated");
  ASSERT_TRUE(difference);
  EXPECT_TRUE(difference->identical);
}

TEST(Film, unsampled_pixels_show_the_nearest_sampled_one) {
  Film film({2, 3, 5, 1}, false);
  EXPECT_EQ(film.picture().find("R")->pixels, std::vector<float>(5, 0.0f));
  PathSums near, far;
  near.layers[background_layer] = glm::vec3(1.0f);
  far.layers[background_layer] = glm::vec3(3.0f);
  far.coverage = 0.5f;
  for (int i = 0; i < 2; ++i) {
    film.pixel(2, 3).add(near);
    film.pixel(5, 3).add(far);
  }
  const image::Picture picture = film.picture();
  EXPECT_EQ(picture.find("R")->pixels, (std::vector<float>{1, 1, 3, 3, 3}));
  EXPECT_EQ(picture.find("coverage")->pixels, (std::vector<float>{0, 0, 0.5f, 0.5f, 0.5f}));
  EXPECT_EQ(film.samples_per_pixel(), 0.8);
  const image::Picture beauty = film.beauty_picture();
  EXPECT_EQ(beauty.window(), picture.window());
  ASSERT_EQ(beauty.channels.size(), 4u);
  for (std::size_t c = 0; c < 4; ++c) {
    EXPECT_EQ(beauty.channels[c].name, picture.channels[c].name);
    EXPECT_EQ(beauty.channels[c].pixels, picture.channels[c].pixels);
  }
}

TEST(Film, reports_the_variance_of_the_mean_and_the_noise) {
  Film film({0, 0, 2, 1}, false);
  PathSums path;
  path.coverage = 1;
  for (const float value : {1001.0f, 1002.0f, 1006.0f}) {
    path.layers[0] = {value, 2 * value, 0};
    film.pixel(0, 0).add(path);
    if (value == 1001) {
      EXPECT_EQ(film.pixel(0, 0).variance_of_mean(), glm::dvec3(0.0));
    }
  }
  // Mean 1003, squared deviations 4 + 1 + 9, over 3 * 2.
  const glm::dvec3 variance = film.pixel(0, 0).variance_of_mean();
  EXPECT_NEAR(variance.x, 14.0 / 6, 1e-9);
  EXPECT_NEAR(variance.y, 4 * 14.0 / 6, 4e-9);
  EXPECT_EQ(variance.z, 0);
  EXPECT_EQ(film.picture().find("variance.R")->pixels[0], static_cast<float>(variance.x));
  // Halves: 1002 and the mean of the others, 1003.5: their difference squared, times 1 * 2 / 3^2.
  const glm::dvec3 by_halves = film.pixel(0, 0).variance_by_halves();
  EXPECT_NEAR(by_halves.x, 0.5, 1e-9);
  EXPECT_NEAR(by_halves.y, 2, 4e-9);
  // Mean variance over the mean 1003, with 32 pixels' worth of 5 * 14 / 6; the pixel without a hit does not count.
  PathSums bright;
  bright.layers[background_layer] = glm::vec3(1e6f);
  film.pixel(1, 0).add(bright);
  EXPECT_NEAR(film.relative_noise(), std::sqrt((2.5 + 32 * 5 * 14.0 / 6) / 33 / 3) / 1003, 1e-6);
  path.layers[0] = glm::vec3(3e38f, 0, 0);  // its square is past a float
  film.pixel(0, 0).add(path);
  EXPECT_EQ(film.picture().find("variance.R")->pixels[0], std::numeric_limits<float>::max());
  // Nearly all is in one of four paths: the mean is its quarter, its variance 1/16; of one channel of three.
  EXPECT_NEAR(film.relative_noise() * film.relative_noise(), 3, 1e-6) << "of the variance itself";
}

TEST(Film, a_long_render_of_a_constant_is_that_constant) {
  // What `--time` brings over night: in float sums 0.1 was 0.0998964 by then, and queries had gone past 32 bits.
  Film film({0, 0, 1, 1}, false);
  PathSums path;
  path.layers[background_layer] = glm::vec3(0.1f, 0.3f, 0.7f);
  path.coverage = 1;
  path.distance_cm = 0.7f;
  path.queries = 60000;
  path.exact_queries = 15000;
  for (int i = 0; i < 1 << 17; ++i) film.pixel(0, 0).add(path);
  const image::Picture picture = film.picture();
  const auto value = [&](const char* name) { return picture.find(name)->pixels[0]; };
  EXPECT_EQ(value("R"), 0.1f);
  EXPECT_EQ(value("G"), 0.3f);
  EXPECT_EQ(value("B"), 0.7f);
  EXPECT_EQ(value("Z"), 0.7f);
  EXPECT_EQ(value("ais.exact"), 0.25f);
  EXPECT_EQ(film.queries(), 60000ull << 17);
  EXPECT_LT(value("variance.R"), 1e-20f);
}

TEST(Renderer, paths_that_overflow_are_dropped_and_the_picture_is_finite) {
  WhiteFiber model;  // every scattering returns a thousand times the light: floats end after a dozen
  fiber::LobeColors shares{};
  shares[0] = shares[2] = glm::vec3(500.0f);
  const std::vector<fiber::FiberId> fibers{model.add_fiber(shares)};
  for (const Roulette rule : {Roulette::throughput, Roulette::learned}) {
    RenderOptions options = few_samples(8);
    options.roulette = rule;
    std::uint64_t dropped = 0, paths = 0;
    const RenderResult result =
        render_with(tangle(150, 32, 32), model, fibers, options, 2, never_stop, [&](const PassProgress& progress) {
          dropped += progress.dropped_samples;
          paths += progress.pixels;
          return true;
        });
    // What is learned ends most of them before floats do: so much light is noise.
    EXPECT_GT(dropped, rule == Roulette::throughput ? 10u : 0u);
    EXPECT_LT(dropped, paths / 2);
    EXPECT_EQ(result.dropped_samples, dropped);
    EXPECT_EQ(result.samples_per_pixel, static_cast<double>(paths - dropped) / (32 * 32));
    for (const image::Channel& layer : result.picture.channels) {
      for (const float value : layer.pixels) ASSERT_TRUE(std::isfinite(value)) << layer.name;
    }
  }
}

TEST(Film, a_path_that_is_not_finite_leaves_the_mean_to_the_others) {
  const auto with = [](auto&& change) {
    PathSums path;
    path.layers[0] = glm::vec3(0.5f);
    path.coverage = 1;
    path.distance_cm = 2;
    path.queries = 3;
    path.objective = 1;
    change(path);
    return path;
  };
  constexpr float infinite = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  Film film({0, 0, 2, 1}, false);
  PixelSums& pixel = film.pixel(0, 0);
  EXPECT_TRUE(pixel.add(with([](PathSums&) {})));
  std::uint32_t dropped = 0;
  for (const float bad : {infinite, -infinite, nan}) {
    for (int c = 0; c < 3; ++c) {
      for (std::size_t layer = 0; layer < layer_count; ++layer) {
        EXPECT_FALSE(pixel.add(with([&](PathSums& path) { path.layers[layer][c] = bad; })));
      }
      EXPECT_FALSE(pixel.add(with([&](PathSums& path) { path.albedo[c] = bad; })));
      EXPECT_FALSE(pixel.add(with([&](PathSums& path) { path.normal[c] = bad; })));
    }
    EXPECT_FALSE(pixel.add(with([&](PathSums& path) { path.coverage = bad; })));
    EXPECT_FALSE(pixel.add(with([&](PathSums& path) { path.distance_cm = bad; })));
    EXPECT_FALSE(pixel.add(with([&](PathSums& path) { path.objective = bad; })));
    dropped += 3 * (static_cast<std::uint32_t>(layer_count) + 2) + 3;
  }
  // Every layer is finite and their sum is not.
  EXPECT_FALSE(pixel.add(with([](PathSums& path) { path.layers[0].x = path.layers[1].x = 3e38f; })));
  EXPECT_TRUE(pixel.add(with([](PathSums& path) { path.layers[0] = glm::vec3(1.5f); })));
  EXPECT_EQ(pixel.samples, 2u);
  EXPECT_EQ(pixel.dropped, dropped + 1);
  EXPECT_EQ(film.dropped_samples(), dropped + 1);
  EXPECT_EQ(film.queries(), 3 * (dropped + 3)) << "what was asked was asked";
  // The other pixel has dropped paths alone, and shows its neighbour.
  EXPECT_FALSE(film.pixel(1, 0).add(with([&](PathSums& path) { path.layers[2].y = nan; })));
  const image::Picture picture = film.picture();
  for (const std::size_t i : {0u, 1u}) {
    EXPECT_EQ(picture.find("R")->pixels[i], 1);
    EXPECT_EQ(picture.find("coverage")->pixels[i], 1);
    EXPECT_EQ(picture.find("Z")->pixels[i], 2);
    EXPECT_EQ(picture.find("variance.G")->pixels[i], 0.25f);
  }
  EXPECT_EQ(film.samples_per_pixel(), 1);
}

TEST(Film, sums_of_the_largest_floats_are_finite) {
  constexpr float largest = std::numeric_limits<float>::max();
  Film film({0, 0, 1, 1}, false);
  PathSums bright, dark;
  bright.layers[0] = bright.layers[1] = bright.albedo = glm::vec3(largest / 2);
  bright.distance_cm = largest;
  bright.coverage = dark.coverage = 1;
  for (int i = 0; i < 1000; ++i) {
    EXPECT_TRUE(film.pixel(0, 0).add(bright));
    EXPECT_TRUE(film.pixel(0, 0).add(dark));
  }
  for (const image::Channel& channel : film.picture().channels) {
    EXPECT_TRUE(std::isfinite(channel.pixels[0])) << channel.name;
  }
  EXPECT_NEAR(film.picture().find("R")->pixels[0] / largest, 0.5, 1e-6);
  EXPECT_TRUE(std::isfinite(film.relative_noise()));
  EXPECT_GT(film.relative_noise(), 0);
}

}  // namespace
}  // namespace tress::integrate
