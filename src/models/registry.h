// Descriptions of fiber models, and those that ship: ours, in closed form and from samples, that of Principled Hair,
// and the traced reference.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "tress/adaptive/mixture.h"
#include "tress/adaptive/sampled_target.h"
#include "tress/adaptive/service.h"
#include "tress/adaptive/target.h"
#include "tress/fiber/elliptical_model.h"
#include "tress/fiber/fiber_model.h"
#include "tress/fiber/rough_model.h"

namespace tress::inline v0_2::fiber {

/// The arguments for making a model. A model reads those that it uses.
struct ModelSettings {
  Estimator estimator = Estimator::fitted;
  adaptive::Service* service = nullptr;  ///< must outlive the model; null for models that do not learn, and for `exact`
  /// Points of the quadrature over the fiber's width, for models that do one at every vertex; 0: the model's own
  /// number.
  int quadrature_points = 0;
  /// Whether light that a facet of fiber3d masks is lost (fiber::Masked::is_lost).
  bool loses_masked_light = false;
};

struct ModelInfo {
  const char* name;    ///< its name on the command line, in telemetry, in pictures and in charts
  const char* source;  ///< the publication that it implements
  const char* summary;
  /// The target of its rows. For a model whose rows are learned from samples, it is the target of other rows in the
  /// same cache. Null for a model without rows.
  std::unique_ptr<adaptive::Target> (*make_target)();
  std::unique_ptr<FiberModel> (*make)(const ModelSettings& settings);
  /// Whether it returns all light that it receives in clear hair without gains, for every known direction: the white
  /// furnace is 1. The generic tests check it.
  bool conserves_energy = false;
  bool has_quadrature = false;  ///< whether it reads ModelSettings::quadrature_points
  bool has_corrected = false;   ///< whether it has that estimator besides fitted and exact
  bool has_parts = false;       ///< whether fibers have a medulla, a cortex that scatters and water
  /// The target of its rows if it can only be sampled; null for all other models.
  std::unique_ptr<adaptive::SampledTarget> (*make_sampled_target)() = nullptr;

  /// The slices of a fiber's rows; null if the model does not provide them.
  std::vector<adaptive::SliceDescription> (*slices_of)(const FiberParameters& fiber) = nullptr;

  bool has_rows() const { return make_target != nullptr; }
  bool learns_samples() const { return make_sampled_target != nullptr; }
  /// The epsilon of its rows, which depends on the kind of their fits.
  double epsilon(const adaptive::Options& options) const {
    return learns_samples() ? options.sampled_epsilon : options.epsilon;
  }
  const char* learner_name(const adaptive::Options& options) const {
    return learns_samples() ? "samples" : options.learner->name;
  }
};

/// A service and the targets that it learns from.
struct ModelService {
  std::unique_ptr<adaptive::Target> target;
  std::unique_ptr<adaptive::SampledTarget> samples;  ///< null for models that learn no samples
  std::unique_ptr<adaptive::Service> service;
};

/// Makes the service of a model with rows.
ModelService make_service(const ModelInfo& info, const adaptive::Options& options);

extern const ModelInfo elliptical_info;
extern const ModelInfo rough_info;
extern const ModelInfo chiang2016_info;
extern const ModelInfo fiber3d_info;

}  // namespace tress::inline v0_2::fiber
