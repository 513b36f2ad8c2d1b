// Draws from all lights of a scene, including the environment.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "integrate/light_clearance.h"
#include "scene/model/light.h"
#include "scene/model/scene.h"

namespace tress::integrate {

/// Immutable; thread-safe. The scene must outlive it.
///
/// Nine tenths of the draws choose a light in proportion to the unshadowed light that it sends on average to points
/// spread over the scene. One tenth chooses evenly, so that a light that is near only a part of the scene is drawn
/// enough. Black lights are never drawn. The environment is one of the lights.
class LightSampler {
 public:
  explicit LightSampler(const scene::Scene& scene);

  /// Light that may come from one direction.
  struct Arrival {
    glm::vec3 direction{0, 0, 1};                                ///< unit, world
    float distance_cm = std::numeric_limits<float>::infinity();  ///< distance to the light
    glm::vec3 radiance{0.0f};                                    ///< linear RGB, unshadowed
    std::size_t group = 0;                                       ///< index into scene::light_groups()
    glm::vec3 way{0.0f};  ///< movement of the light while the shutter is open, cm; set by along()
    float density = 0;    ///< density of drawing this light and this direction, 1/sr; 0: no light
    /// The shadow ray, set by sample(). It ends LightClearance::bound_cm() above the light, so that a mesh flush with
    /// the light casts no shadow.
    LightClearance::Segment shadow{};
    bool is_seen = false;  ///< whether the camera sees the light; set by along()
  };

  /// Draws a light and a direction to it. u_light, u: uniform in [0, 1). time: time of the shutter, [0, 1], at which
  /// the lights move.
  Arrival sample(const glm::vec3& point, float time, float u_light, const std::array<float, 2>& u) const;

  /// Calls visit(Arrival) for each light that a ray in a unit direction meets within distance_cm, or flush with the hit
  /// there (LightClearance). distance_cm is infinity if the ray met nothing; it then sees distant lights and the
  /// environment. Lights hide nothing. `density` is that of sample() drawing this direction by this light, so that each
  /// light is an integral of its own.
  template <class Visit>
  void along(const glm::vec3& origin, const glm::vec3& direction, float time, float distance_cm, Visit&& visit) const {
    const bool escapes = distance_cm == std::numeric_limits<float>::infinity();
    for (const Choice& choice : choices_) {
      Arrival arrival;
      arrival.direction = direction;
      arrival.group = choice.group;
      if (choice.light != nullptr) {
        if (!escapes && choice.light->kind == scene::Light::Kind::distant) continue;
        const bool meets = choice.light->later.empty()
                               ? meet(*choice.light, choice.clearance, origin, distance_cm, &arrival)
                               : meet_moving(choice, origin, time, distance_cm, &arrival);
        if (!meets) continue;
        arrival.is_seen = choice.light->visible;
        arrival.density *= choice.probability;
      } else {
        if (!escapes) continue;
        const scene::Environment::Seen seen =
            scene_.environment.look(scene::turned_to_environment(scene_, direction, time));
        arrival.radiance = seen.radiance;
        arrival.density = choice.probability * seen.pdf_solid_angle;
      }
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
  };
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
    return true;
  }
  static bool meet_moving(const Choice& choice, const glm::vec3& origin, float time, float distance_cm,
                          Arrival* arrival);

  const scene::Scene& scene_;
  bool some_seen_ = false;       ///< whether the camera sees any light
  std::vector<Choice> choices_;  ///< their probabilities add up to 1
};

}  // namespace tress::integrate
