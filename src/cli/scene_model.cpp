#include "cli/scene_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <string>
#include <utility>

#include "cli/console.h"
#include "cli/progress.h"
#include "fiber/row_axes.h"

namespace tress::cli {

SceneModel::SceneModel(const RenderSettings& settings)
    : settings_(settings), info_(*fiber::find_model(settings.model)) {
  if (info_.has_rows() && settings.estimator != fiber::Estimator::exact) {
    adaptive::Options options = settings.table;
    options.seed = settings.render.seed;
    if (settings.cache_mode == CacheMode::frozen) options.take_rows_as_they_are();
    learned_ = fiber::make_service(info_, options);
  }
  model_ = info_.make({settings.estimator, service(), settings.quadrature_points.value_or(0)});
  if (settings.audited_share) unbiased_ = info_.make({fiber::Estimator::exact, nullptr});
}

void SceneModel::add_fibers(const scene::Scene& scene) {
  {
    Step step(fmt::format("energies of {} kind{} of fiber", scene.fibers.size(), scene.fibers.size() == 1 ? "" : "s"));
    for (const fiber::FiberParameters& parameters : scene.fibers) {
      fiber_ids_.push_back(model_->add_fiber(parameters));
      step.set_share(static_cast<double>(fiber_ids_.size()) / static_cast<double>(scene.fibers.size()));
    }
  }
  if (unbiased_) {
    audit_.unbiased = unbiased_.get();
    audit_.share = *settings_.audited_share;
    for (const fiber::FiberParameters& parameters : scene.fibers)
      audit_.fiber_ids.push_back(unbiased_->add_fiber(parameters));
  }
  for (const scene::Material& material : scene.materials) log_narrow_blurs(material);
  if (!service()) return;
  const std::size_t pages = service()->slice_count();
  log_note(fmt::format("{} page{} for {} fiber{}, table of at most {:.4g} MB", pages, plural(pages),
                       scene.fibers.size(), plural(scene.fibers.size()),
                       double(settings_.table.memory_bytes) / double(1 << 20)));
}

void SceneModel::log_narrow_blurs(const scene::Material& material) const {
  if (!service() || info_.learns_samples()) return;
  const std::array<float, 3> sigmas = fiber::azimuthal_sigmas(material.fiber);
  for (int lobe = 0; lobe < 3; ++lobe) {
    const float sigma = sigmas[std::size_t(lobe)];
    if (!fiber::is_below_grid(sigma)) continue;
    const double degrees = double(sigma) * 180 / std::numbers::pi;
    log_note(
        fmt::format("material {}: {} is blurred by {:.2f} degrees, less than 4: its rows only propose, and it is "
                    "traced at every vertex",
                    material.name, fiber::lobe_names[std::size_t(lobe) + 1], degrees));
  }
}

fiber::ModelService SceneModel::hand_over() {
  model_.reset();
  service()->set_row_listener({});
  return std::move(learned_);
}

}  // namespace tress::cli
