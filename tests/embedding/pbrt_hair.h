// Hair of tress in a renderer with the conventions of pbrt-v4 (include/hosts.md has the places where it goes). C++17,
// and of tress the C interface alone. Directions are in the host's shading frame: x along the fiber from root to tip,
// z the shading normal, which points at the camera's side; unit length.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>

#include "tress/tress.hpp"

namespace pbrt_hair {

struct Direction {
  float x, y, z;
};

/// The learning of one render: fibers are added while the scene is read, rows are learned between the host's waves.
class Session {
 public:
  /// model: TRESS_ELLIPTICAL or TRESS_ROUGH. cache: of earlier renders; "": none. telemetry: a line of JSON a publish;
  /// null: none. threads: of learning, 0 for all. Mistakes go to stderr with their reasons.
  Session(std::uint32_t model, std::string cache, std::FILE* telemetry, std::uint32_t threads)
      : cache_(std::move(cache)), telemetry_(telemetry) {
    tress::c::Options options;
    options.threads = threads;
    options.user = this;
    options.on_error = [](void*, tress_result result, const char* message) {
      if (result != TRESS_FILE_MISSING) std::fprintf(stderr, "%s: %s\n", tress_result_name(result), message);
    };
    service_ = tress::c::Service::for_fibers(options);
    fibers_ = tress::c::Fibers(service_, model);
  }

  /// The host's material: widths as its own lobes look, beta_m and beta_n in [0, 1], alpha in degrees, sigma_a per
  /// radius (RGB, or three wavelengths of the host's choice). Between waves. UINT32_MAX, which is black, on failure.
  std::uint32_t add(float eta, float beta_m, float beta_n, float alpha, const std::array<float, 3>& sigma_a) {
    tress::c::Fiber fiber;
    if (tress_fiber_set_principled(&fiber, beta_m, beta_n, 0) != TRESS_OK) return UINT32_MAX;
    fiber.eta = eta;
    fiber.tilt = static_cast<float>(std::max(0.0, alpha * degree));
    std::copy(sigma_a.begin(), sigma_a.end(), fiber.sigma_a);
    std::uint32_t id = 0;
    (void)fibers_.add(fiber, &id);
    return id;
  }

  /// After the last add(), before the first wave. The rows of the cache are used if it is of this model.
  void begin() {
    if (!cache_.empty()) (void)service_.load(cache_);
    (void)service_.prepare();
  }
  /// After each wave, on one thread while no other renders. paths: the wave's camera rays.
  void end_wave(std::uint64_t paths) {
    paths_ += paths;
    if (!service_.publish_pays()) return;
    (void)service_.publish(paths_);
    paths_ = 0;
    if (telemetry_ != nullptr) std::fprintf(telemetry_, "%s\n", service_.telemetry());
  }
  /// After the last wave.
  void end() {
    if (!cache_.empty()) (void)service_.save(cache_);
  }

  const tress::c::Fibers& fibers() const { return fibers_; }

 private:
  static constexpr double degree = 0.017453292519943295;
  std::string cache_;
  std::FILE* telemetry_;
  std::uint64_t paths_ = 0;
  tress::c::Service service_;
  tress::c::Fibers fibers_;
};

/// f is what the host multiplies by |wi.z| and light; pdf is per solid angle.
struct Value {
  std::array<float, 3> f{};
  float pdf = 0;
};

/// A hit: the host's BxDF. Plain data of 500 bytes, aligned to 16; valid until the wave ends.
class Hit {
 public:
  /// h: [-1, 1] over the width, the host's, which rises towards falling azimuth. key: any hash that differs between
  /// hits and does not depend on threads, of the point and wo or of pixel, sample and depth. A sampler's dimensions
  /// (Owen-scrambled points) do as well for xi: pass them instead of uniform(0) and (1), but do not use them for
  /// anything else. throughput: luminance of the path so far.
  Hit(const Session& session, std::uint32_t fiber, const Direction& wo, float h, std::uint64_t key,
      float throughput = 1)
      : fibers_(&session.fibers()), key_(key) {
    event_ = fibers_->begin(fiber, angles(wo), uniform(0), uniform(1), -h, throughput);
  }
  /// Whether the host is to sample lights here, weighted against drawn directions by both densities.
  bool takes_lights() const { return fibers_->takes_lights(event_); }

  Value evaluate(const Direction& wi) const { return in_host(fibers_->evaluate(event_, angles(wi)), wi); }
  /// uc, u0, u1: the host's uniforms. pdf 0: nothing is drawn.
  Value sample(float uc, float u0, float u1, Direction* wi) const {
    const tress_fiber_sample drawn = fibers_->sample(event_, {uc, u0, u1, uniform(2)});
    const float theta = -drawn.direction.theta, c = std::cos(theta);
    *wi = {std::sin(theta), c * std::cos(drawn.direction.phi), c * std::sin(drawn.direction.phi)};
    return in_host(drawn.at, *wi);
  }

 private:
  /// theta has the other sign: the host's alpha turns R towards the tip, tress's tilt towards the root.
  static tress_direction angles(const Direction& w) {
    return {-std::asin(std::clamp(w.x, -1.0f, 1.0f)), std::atan2(w.z, w.y)};
  }
  /// S and Q are per dtheta dphi; the host's cosine is about the normal, not about the fiber.
  static Value in_host(const tress_fiber_value& of, const Direction& wi) {
    const float c = std::sqrt(std::max(1e-12f, 1 - wi.x * wi.x)), to_f = 1 / (c * std::max(1e-6f, std::abs(wi.z)));
    return {{of.value[0] * to_f, of.value[1] * to_f, of.value[2] * to_f}, of.pdf / c};
  }
  float uniform(std::uint64_t i) const {
    std::uint64_t x = key_ + (i + 1) * 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return static_cast<float>((x ^ (x >> 31)) >> 40) * 0x1p-24f;
  }

  tress_event event_;
  const tress::c::Fibers* fibers_;
  std::uint64_t key_;
};

}  // namespace pbrt_hair
