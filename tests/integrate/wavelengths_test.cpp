// A spectral render carries bands (base/bands.h) and gives RGB.
#include <gtest/gtest.h>

#include <cstddef>
#include <string>

#include "base/bands.h"
#include "integrate/white_fiber.h"

namespace tress::integrate {
namespace {

/// A tangle before a wall in colored light, with a lamp that the camera sees. color: applied to every color.
scene::Scene colored(glm::vec3 (*color)(const glm::vec3&)) {
  scene::Scene scene = tangle(12, 16, 16);
  scene.environment = scene::Environment(color(glm::vec3(1, 0.5f, 0.2f)));
  scene.environment_group = "sky";
  scene::Light lamp;
  lamp.kind = scene::Light::Kind::sphere;
  lamp.center = {0.4f, -0.6f, 1.0f};
  lamp.radius_cm = 0.3f;
  lamp.radiance = 8.0f * color(glm::vec3(1, 0.5f, 0.2f));  // so that both renders choose lights alike
  lamp.visible = true;
  scene.lights = {lamp};
  scene::Mesh wall;
  wall.positions = {{-2, 1.5f, -2}, {2, 1.5f, -2}, {0, 1.5f, 2}};
  wall.triangles = {{0, 1, 2}};
  wall.albedo = color(glm::vec3(0.8f, 0.3f, 0.1f));
  scene.meshes = {wall};
  return scene;
}

RenderResult rendered(const scene::Scene& scene) {
  WhiteFiber model;
  RenderOptions options;
  options.samples = 4;
  options.roulette = Roulette::throughput;
  options.shadow_roulette = false;  // it goes by the brightness of RGB
  return render_with(scene, model, {model.add_fiber(lossless_shares())}, options);
}

// The same paths as those of a scene that has bands for colors, whose picture is brought to RGB here.
TEST(Spectral, PictureIsThatOfItsBandsInRgb) {
  scene::Scene spectral = colored([](const glm::vec3& rgb) { return rgb; });
  spectral.integrator.spectral = true;
  const image::Picture found = rendered(spectral).picture, bands = rendered(colored(bands_of_rgb)).picture;
  for (const char* layer : {"", "R.", "TT.", "TRT.", "residual.", "surface.", "emission.", "background.", "albedo.",
                            "light.sky.", "light.other."}) {
    const auto channel = [&](const image::Picture& picture, const char* name) {
      const image::Channel* one = picture.find(std::string(layer) + name);
      EXPECT_TRUE(one) << layer << name;
      return one;
    };
    const image::Channel *r = channel(bands, "R"), *g = channel(bands, "G"), *b = channel(bands, "B");
    if (!r || !g || !b) continue;
    float most = 0;
    for (std::size_t i = 0; i < r->pixels.size(); ++i) {
      const glm::vec3 rgb = rgb_of_bands({r->pixels[i], g->pixels[i], b->pixels[i]});
      most = std::max({most, rgb.r, rgb.g, rgb.b});
      EXPECT_NEAR(channel(found, "R")->pixels[i], rgb.r, 1e-5f * (1 + most)) << layer << i;
      EXPECT_NEAR(channel(found, "G")->pixels[i], rgb.g, 1e-5f * (1 + most)) << layer << i;
      EXPECT_NEAR(channel(found, "B")->pixels[i], rgb.b, 1e-5f * (1 + most)) << layer << i;
    }
    EXPECT_GT(most, 0) << layer;
  }
}

}  // namespace
}  // namespace tress::integrate
