// What the renderer's own path tracer asks of its parts: every ray, shading event and draw of a light, in order.
//
// The linker puts the functions below between the path tracer and its parts (-Wl,--wrap=, bench/CMakeLists.txt), so
// that nothing of the renderer is written twice or slowed down. Included by one source file. One thread.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "geometry/fiber_scene.h"
#include "integrate/light_sampler.h"
#include "integrate/scattering.h"

namespace tress::bench {

enum class Step : std::uint8_t { camera_ray, continuation_ray, shadow_ray, begin, evaluate, sample, draw_light };

struct ShadowRay {
  geometry::Ray ray;
  float distance_cm;
};

struct Begin {
  geometry::Hit hit;
  glm::vec3 ray_direction;
  std::array<float, 2> xi;
};

struct LightDraw {
  glm::vec3 point;
  float time;
  float u_light;
  std::array<float, 2> u;
  std::uint32_t object;
};

/// A ray that was drawn by a BCSDF, and how far it got: infinity where it met nothing.
struct Way {
  geometry::Ray ray;
  float distance_cm;
};

struct RecordedPaths {
  std::vector<Step> steps;
  std::vector<geometry::Ray> camera_rays;
  std::vector<Way> ways;
  std::vector<ShadowRay> shadow_rays;
  std::vector<Begin> begins;
  std::vector<glm::vec3> evaluations;         ///< directions, each of the vertex begun last
  std::vector<std::array<float, 4>> samples;  ///< numbers, likewise
  std::vector<LightDraw> light_draws;
  bool is_first_ray = false;  ///< to be set before each path
};

/// Where to record; null: nowhere.
inline RecordedPaths* recording = nullptr;

}  // namespace tress::bench

#define TRESS_WRAPPED(result, name, symbol, ...)                \
  result wrapped_##name(__VA_ARGS__) __asm__("__wrap_" symbol); \
  result real_##name(__VA_ARGS__) __asm__("__real_" symbol);

namespace tress::bench {

using geometry::FiberScene;
using integrate::LightSampler;
using integrate::PathSums;
using integrate::Scattering;
using integrate::Vertex;

// A member function takes its object as the first argument (Itanium C++ ABI).
TRESS_WRAPPED(std::optional<geometry::Hit>, intersect, "_ZNK5tress8geometry10FiberScene9intersectERKNS0_3RayE",
              const FiberScene*, const geometry::Ray&)
TRESS_WRAPPED(bool, occluded, "_ZNK5tress8geometry10FiberScene8occludedERKNS0_3RayEf", const FiberScene*,
              const geometry::Ray&, float)
TRESS_WRAPPED(Vertex, begin,
              "_ZNK5tress9integrate10Scattering5beginERKNS_8geometry3HitERKN3glm3vecILi3EfLNS6_"
              "9qualifierE0EEERKSt5arrayIfLm2EEfNS0_7NearHitE",
              const Scattering*, const geometry::Hit&, const glm::vec3&, const std::array<float, 2>&, float,
              integrate::NearHit)
TRESS_WRAPPED(
    integrate::Scattered, evaluate,
    "_ZNK5tress9integrate10Scattering8evaluateERKNS0_6VertexERKN3glm3vecILi3EfLNS5_9qualifierE0EEERNS0_8PathSumsE",
    const Scattering*, const Vertex&, const glm::vec3&, PathSums&)
TRESS_WRAPPED(Scattering::Sample, sample,
              "_ZNK5tress9integrate10Scattering6sampleERKNS0_6VertexERKSt5arrayIfLm4EERNS0_8PathSumsE",
              const Scattering*, const Vertex&, const std::array<float, 4>&, PathSums&)
TRESS_WRAPPED(LightSampler::Arrival, draw_light,
              "_ZNK5tress9integrate12LightSampler6sampleERKN3glm3vecILi3EfLNS2_9qualifierE0EEEffRKSt5arrayIfLm2EEj",
              const LightSampler*, const glm::vec3&, float, float, const std::array<float, 2>&, std::uint32_t)

#undef TRESS_WRAPPED

std::optional<geometry::Hit> wrapped_intersect(const FiberScene* self, const geometry::Ray& ray) {
  std::optional<geometry::Hit> hit = real_intersect(self, ray);
  if (recording) {
    if (recording->is_first_ray) {
      recording->steps.push_back(Step::camera_ray);
      recording->camera_rays.push_back(ray);
    } else {
      recording->steps.push_back(Step::continuation_ray);
      recording->ways.push_back({ray, hit ? hit->distance_cm : std::numeric_limits<float>::infinity()});
    }
    recording->is_first_ray = false;
  }
  return hit;
}

bool wrapped_occluded(const FiberScene* self, const geometry::Ray& ray, float distance_cm) {
  if (recording) {
    recording->steps.push_back(Step::shadow_ray);
    recording->shadow_rays.push_back({ray, distance_cm});
  }
  return real_occluded(self, ray, distance_cm);
}

Vertex wrapped_begin(const Scattering* self, const geometry::Hit& hit, const glm::vec3& ray_direction,
                     const std::array<float, 2>& xi, float importance, integrate::NearHit near) {
  if (recording) {
    recording->steps.push_back(Step::begin);
    recording->begins.push_back({hit, ray_direction, xi});
  }
  return real_begin(self, hit, ray_direction, xi, importance, near);
}

integrate::Scattered wrapped_evaluate(const Scattering* self, const Vertex& vertex, const glm::vec3& direction,
                                      PathSums& sums) {
  if (recording) {
    recording->steps.push_back(Step::evaluate);
    recording->evaluations.push_back(direction);
  }
  return real_evaluate(self, vertex, direction, sums);
}

Scattering::Sample wrapped_sample(const Scattering* self, const Vertex& vertex, const std::array<float, 4>& u,
                                  PathSums& sums) {
  if (recording) {
    recording->steps.push_back(Step::sample);
    recording->samples.push_back(u);
  }
  return real_sample(self, vertex, u, sums);
}

LightSampler::Arrival wrapped_draw_light(const LightSampler* self, const glm::vec3& point, float time, float u_light,
                                         const std::array<float, 2>& u, std::uint32_t object) {
  if (recording) {
    recording->steps.push_back(Step::draw_light);
    recording->light_draws.push_back({point, time, u_light, u, object});
  }
  return real_draw_light(self, point, time, u_light, u, object);
}

}  // namespace tress::bench
