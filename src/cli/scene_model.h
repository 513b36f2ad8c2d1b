// The fiber model of one render: the model that was asked for, its table of rows, and the fibers of the scene in it.
#pragma once

#include <memory>
#include <vector>

#include "cli/render_settings.h"
#include "integrate/renderer.h"
#include "tress/adaptive/service.h"

namespace tress::cli {

/// One thread, between passes.
class SceneModel {
 public:
  /// settings outlive it.
  explicit SceneModel(const RenderSettings& settings);

  /// Every fiber of the scene, told as it goes.
  void add_fibers(const scene::Scene& scene);

  fiber::FiberModel& model() const { return *model_; }
  /// null: no rows are asked.
  adaptive::Service* service() const { return learned_.service.get(); }
  /// Of the densities, as caches have it. There must be a service.
  std::string target_name() const { return learned_.target->model_name(); }
  /// Of each of the scene's fibers.
  const std::vector<fiber::FiberId>& fiber_ids() const { return fiber_ids_; }
  /// The same fibers without rows, where the bias is measured; null: it is not.
  const integrate::BiasAudit* audit() const { return unbiased_ ? &audit_ : nullptr; }

  /// What was learned, to the next frame. The model that asks it goes: nothing may be asked after this.
  fiber::ModelService hand_over();

 private:
  void tell_narrow_blurs(const scene::Material& material) const;

  const RenderSettings& settings_;
  const fiber::ModelInfo& info_;
  fiber::ModelService learned_;
  std::unique_ptr<fiber::FiberModel> model_, unbiased_;
  std::vector<fiber::FiberId> fiber_ids_;
  integrate::BiasAudit audit_;
};

}  // namespace tress::cli
