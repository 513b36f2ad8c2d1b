// A scene and a fiber model whose answers are known on paper, for tests of the integrator.
#pragma once

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "integrate/renderer.h"
#include "scene/model/strand_fibers.h"
#include "tress/base/random.h"

namespace tress::integrate {

/// S = albedo cos theta_i / (4 pi): light leaves the same in all directions, L_r = albedo times the mean radiance
/// around. Drawn a `matched` part of the time in proportion to S / albedo, else uniformly in (theta, phi): at 1/2 the
/// weights S/Q go from 0 to 1.22 albedo, at 1 all are the albedo. A fiber is given by its share of each lobe, per
/// channel, which sum to the albedo. Two queries an evaluation, one of them exact,
/// of objective 0.5 together.
class WhiteFiber : public fiber::FiberModel {
 public:
  std::string name() const override { return "white"; }
  fiber::FiberId make_fiber(const fiber::FiberParameters&) override {
    return static_cast<fiber::FiberId>(shares_.size() - 1);
  }
  fiber::FiberId add_fiber(const fiber::LobeColors& shares) {
    shares_.push_back(shares);
    return FiberModel::add_fiber({});
  }
  fiber::FiberEvent make_event(fiber::FiberId fiber, const fiber::FiberDirection& wr, float xi1, float xi2,
                               float /*h*/) const override {
    if (on_begin) on_begin();
    fiber::FiberEvent event;
    event.fiber = fiber;
    event.wr = wr;
    event.xi1 = xi1;
    event.xi2 = xi2;
    event.energy = shares_[fiber];
    return event;
  }
  fiber::FiberSample sample_event(const fiber::FiberEvent& event, const std::array<float, 4>& u) const override {
    fiber::FiberSample sample;
    const float theta = u[0] < matched ? std::asin(2 * u[1] - 1) : std::numbers::pi_v<float> * (u[1] - 0.5f);
    sample.wi = {theta, 2 * std::numbers::pi_v<float> * (u[2] - 0.5f)};
    sample.value = evaluate(event, sample.wi);
    return sample;
  }
  fiber::FiberValue evaluate_event(const fiber::FiberEvent& event, const fiber::FiberDirection& wi) const override {
    fiber::FiberValue value;
    const float s = std::max(0.0f, std::cos(wi.theta)) / (4 * std::numbers::pi_v<float>);
    for (int lobe = 0; lobe < fiber::lobe_count; ++lobe) value.s[lobe] = s * shares_[event.fiber][lobe];
    value.pdf = matched * s + (1 - matched) * 0.5f / (std::numbers::pi_v<float> * std::numbers::pi_v<float>);
    value.queries = 2;
    value.exact_queries = 1;
    value.objective = 0.5f;
    return value;
  }

  float matched = 0.5f;
  std::function<void()> on_begin;  ///< called at every shading event, from any thread

 private:
  std::vector<fiber::LobeColors> shares_;
};

/// Shares of a lossless fiber, different for every lobe and channel.
inline fiber::LobeColors lossless_shares() {
  return {glm::vec3(0.5f, 0.25f, 0.125f), glm::vec3(0.25f, 0.5f, 0.125f), glm::vec3(0.125f, 0.125f, 0.5f),
          glm::vec3(0.0625f, 0.0625f, 0.125f), glm::vec3(0.0625f, 0.0625f, 0.125f)};
}

/// A tangle of `strands` strands in a ball of radius 1 cm about the origin, seen from 6 cm away along y.
inline scene::Scene tangle(int strands, int width, int height) {
  scene::Scene scene;
  scene.camera.eye = {0, -6, 0};
  scene.image.width = width;
  scene.image.height = height;
  scene.materials.resize(1);
  scene.grooms.resize(1);
  scene::Groom& groom = scene.grooms[0];
  groom.first_point = {0};
  RandomStream random(5);
  for (int strand = 0; strand < strands; ++strand) {
    glm::vec3 point, step;
    for (int axis = 0; axis < 3; ++axis) {
      point[axis] = 1.2f * random.next() - 0.6f;
      step[axis] = 0.4f * random.next() - 0.2f;
    }
    for (int i = 0; i < 5; ++i) {
      groom.points.push_back(point);
      groom.radius_cm.push_back(0.03f);
      for (int axis = 0; axis < 3; ++axis) step[axis] += 0.1f * random.next() - 0.05f;
      point += step;
    }
    groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
  }
  scene::assign_fibers(&scene);
  return scene;
}

inline const std::atomic<bool> never_stop{false};

/// render() in an arena of `threads`, whatever the machine has.
inline RenderResult render_with(const scene::Scene& scene, fiber::FiberModel& model,
                                const std::vector<fiber::FiberId>& fibers, const RenderOptions& options,
                                int threads = 1, const std::atomic<bool>& stop = never_stop,
                                const std::function<bool(const PassProgress&)>& on_pass = {},
                                adaptive::Service* service = nullptr) {
  tbb::global_control control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  RenderResult result;
  arena.execute([&] {
    const geometry::FiberScene intersector(scene);
    result = render(scene, intersector, model, fibers, service, options, stop, on_pass);
  });
  return result;
}

}  // namespace tress::integrate
