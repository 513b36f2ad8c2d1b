// The fiber model of one render: the requested model, its table of rows, and the fibers of the scene in it.
#pragma once

#include <memory>
#include <vector>

#include "cli/render_settings.h"
#include "integrate/renderer.h"
#include "tress/adaptive/service.h"

namespace tress::cli {

/// Use it from one thread, between passes.
class SceneModel {
 public:
  /// settings must outlive it.
  explicit SceneModel(const RenderSettings& settings);

  /// Adds every fiber of the scene and reports progress.
  void add_fibers(const scene::Scene& scene);

  fiber::FiberModel& model() const { return *model_; }
  /// null if the model has no rows.
  adaptive::Service* service() const { return learned_.service.get(); }
  /// The model name of the densities, as in caches. There must be a service.
  std::string target_name() const { return learned_.target->model_name(); }
  /// The id of each of the scene's fibers.
  const std::vector<fiber::FiberId>& fiber_ids() const { return fiber_ids_; }
  /// The same fibers in a model without rows, for measuring the bias; null if it is not measured.
  const integrate::BiasAudit* audit() const { return unbiased_ ? &audit_ : nullptr; }

  /// Passes what was learned on to the next frame. The model is destroyed: nothing may be called after this.
  fiber::ModelService hand_over();

 private:
  void log_narrow_blurs(const scene::Material& material) const;

  const RenderSettings& settings_;
  const fiber::ModelInfo& info_;
  fiber::ModelService learned_;
  std::unique_ptr<fiber::FiberModel> model_, unbiased_;
  std::vector<fiber::FiberId> fiber_ids_;
  integrate::BiasAudit audit_;
};

}  // namespace tress::cli
