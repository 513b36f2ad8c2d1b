// Draws from all lights of a scene, including the environment.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "base/bands.h"
#include "integrate/light_clearance.h"
#include "scene/model/light.h"
#include "scene/model/scene.h"

namespace tress::integrate {

/// Immutable; thread-safe. The scene must outlive it.
///
/// Nine tenths of the draws choose a light in proportion to the unshadowed light that it sends on average to points
/// spread over the scene. One tenth chooses evenly, so that a light that is near only a part of the scene is drawn
/// enough. Black lights are never drawn. The environment is one of the lights. At an object, the lights that do not
/// illuminate it (scene::LightLinks) are left out, and the others are drawn so much more.
class LightSampler {
 public:
  explicit LightSampler(const scene::Scene& scene);

  /// Light that may come from one direction.
  struct Arrival {
    glm::vec3 direction{0, 0, 1};                                ///< unit, world
    float distance_cm = std::numeric_limits<float>::infinity();  ///< distance to the light
    glm::vec3 radiance{0.0f};                                    ///< unshadowed; linear RGB, or bands (base/bands.h)
    std::size_t group = 0;                                       ///< index into scene::light_groups()
    glm::vec3 way{0.0f};  ///< movement of the light while the shutter is open, cm; set by along()
    float density = 0;    ///< density of drawing this light and this direction, 1/sr; 0: no light
    /// The shadow ray, set by sample(). It ends LightClearance::bound_cm() above the light, so that a mesh flush with
    /// the light casts no shadow.
    LightClearance::Segment shadow{};
    bool is_seen = false;  ///< whether the camera sees the light; set by along()
    /// Whether along() left out what is before the light, because shadow rays to it meet other objects than scattered
    /// rays: whoever asked has to trace `shadow`.
    bool needs_shadow_ray = false;
    const scene::ObjectMarks* passed = nullptr;  ///< Ray::passed of the shadow ray
  };

  /// Draws a light and a direction to it. u_light, u: uniform in [0, 1). time: time of the shutter, [0, 1], at which
  /// the lights move. object: the one that the point lies on (scene::ObjectMarks).
  Arrival sample(const glm::vec3& point, float time, float u_light, const std::array<float, 2>& u,
                 std::uint32_t object) const;

  /// Calls visit(Arrival) for each light that a ray in a unit direction meets within distance_cm, or flush with the hit
  /// there (LightClearance). distance_cm is infinity if the ray met nothing; it then sees distant lights and the
  /// environment. Lights hide nothing. `density` is that of sample() drawing this direction by this light, so that each
  /// light is an integral of its own. object: the one that the ray leaves, or no_object, which all lights illuminate.
  template <class Visit>
  void along(const glm::vec3& origin, const glm::vec3& direction, float time, float distance_cm, std::uint32_t object,
             Visit&& visit) const {
    for (const Choice& choice : choices_) {
      const float probability = probability_at(choice, object);
      if (!(probability > 0)) continue;
      Arrival arrival;
      arrival.needs_shadow_ray = choice.needs_shadow_ray && object != scene::no_object;
      arrival.passed = &choice.passed;
      const float limit_cm = arrival.needs_shadow_ray ? std::numeric_limits<float>::infinity() : distance_cm;
      const bool escapes = limit_cm == std::numeric_limits<float>::infinity();
      arrival.direction = direction;
      arrival.group = choice.group;
      if (choice.light != nullptr) {
        if (!escapes && choice.light->kind == scene::Light::Kind::distant) continue;
        const bool meets = choice.light->later.empty()
                               ? meet(*choice.light, choice.clearance, origin, limit_cm, &arrival)
                               : meet_moving(choice, origin, time, limit_cm, &arrival);
        if (!meets) continue;
        arrival.is_seen = choice.light->visible;
        arrival.density *= probability;
      } else {
        if (!escapes) continue;
        const scene::Environment::Seen seen =
            scene_.environment.look(scene::turned_to_environment(scene_, direction, time));
        arrival.radiance = seen.radiance;
        arrival.density = probability * seen.pdf_solid_angle;
        arrival.shadow = {direction, limit_cm};
      }
      arrival.radiance = carried(arrival.radiance);
      visit(arrival);
    }
  }

  /// The nearest light that the camera sees (scene::Light::visible) along a ray. distance_cm: where the ray meets
  /// something; infinity if it does not. `density` is 0 if there is no such light; otherwise its value has no meaning.
  Arrival seen(const glm::vec3& origin, const glm::vec3& direction, float time, float distance_cm) const;

  /// Whether sample() uses u_light.
  bool has_choice() const { return choices_.size() > 1; }

 private:
  struct Choice {
    const scene::Light* light;  ///< null for the environment
    float probability;
    std::size_t group = 0;
    LightClearance clearance{};
    scene::ObjectMarks unlit{}, passed{};  ///< objects that it does not illuminate, and that do not block it
    bool needs_shadow_ray = false;         ///< Arrival::needs_shadow_ray
  };
  /// The probability with which sample() draws a light at an object.
  float probability_at(const Choice& choice, std::uint32_t object) const {
    if (lit_share_.empty() || object == scene::no_object) return choice.probability;
    return !choice.unlit.empty() && choice.unlit[object] != 0 ? 0 : choice.probability / lit_share_[object];
  }
  void link(const scene::LightLinks& links);
  /// Light as paths carry it: in bands if the render is spectral.
  glm::vec3 carried(const glm::vec3& radiance) const {
    return scene_.integrator.spectral ? bands_of_rgb(radiance) : radiance;
  }
  /// Whether a ray in the direction of *arrival meets the light. Sets distance, radiance and the light's own density in
  /// *arrival.
  static bool meet(const scene::LightShape& light, const LightClearance& clearance, const glm::vec3& origin,
                   float distance_cm, Arrival* arrival) {
    const scene::LightSample met = scene::light_along(light, origin, arrival->direction);
    if (!(met.pdf_solid_angle > 0)) return false;
    if (!clearance.is_seen(origin, arrival->direction, met.distance, distance_cm)) return false;
    arrival->distance_cm = met.distance;
    arrival->radiance = met.radiance;
    arrival->density = met.pdf_solid_angle;
    if (arrival->needs_shadow_ray) arrival->shadow = clearance.shadow(origin, arrival->direction, met.distance);
    return true;
  }
  static bool meet_moving(const Choice& choice, const glm::vec3& origin, float time, float distance_cm,
                          Arrival* arrival);

  const scene::Scene& scene_;
  bool some_seen_ = false;       ///< whether the camera sees any light
  std::vector<Choice> choices_;  ///< their probabilities add up to 1
  /// By object: the sum of the probabilities of the lights that illuminate it. Empty if all lights illuminate all.
  std::vector<float> lit_share_;
};

}  // namespace tress::integrate
