// What a fiber model needs and how it is made, and those that ship: ours, in closed form and from samples, that of
// Principled Hair, and the traced truth.
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

namespace tress::fiber {

/// What a model is made with. A model reads what it has a use for.
struct ModelSettings {
  Estimator estimator = Estimator::fitted;
  adaptive::Service* service = nullptr;  ///< must outlive the model; null for models that do not learn, and for `exact`
  /// Points of the quadrature over the fiber's width, of models that do one at every vertex; 0: the model's own.
  int quadrature_points = 0;
  /// Of fiber3d: light that a facet masks is lost (fiber::Masked::is_lost).
  bool loses_masked_light = false;
};

struct ModelInfo {
  const char* name;    ///< as the command line, telemetry, pictures and charts call it
  const char* source;  ///< the publication that it implements
  const char* summary;
  /// What its rows are learned from, or, of a model whose rows are learned from samples, what other rows of a cache
  /// are; null for a model without rows.
  std::unique_ptr<adaptive::Target> (*make_target)();
  std::unique_ptr<FiberModel> (*make)(const ModelSettings& settings);
  /// In clear hair without gains it returns what it receives, whatever the known direction: the white furnace is 1. The
  /// generic tests hold it to that.
  bool conserves_energy = false;
  bool has_quadrature = false;  ///< reads ModelSettings::quadrature_points
  bool has_corrected = false;   ///< the estimator of that name; else it has no other than fitted and exact
  bool has_medulla = false;     ///< a fiber's medulla scatters; else it is left out
  /// What its rows are learned from where nobody can evaluate it; null for all other models.
  std::unique_ptr<adaptive::SampledTarget> (*make_sampled_target)() = nullptr;

  /// The slices that a fiber asks rows of; null where that is not told.
  std::vector<adaptive::SliceDescription> (*slices_of)(const FiberParameters& fiber) = nullptr;

  bool has_rows() const { return make_target != nullptr; }
  bool learns_samples() const { return make_sampled_target != nullptr; }
  /// What its rows are held to, and what fits them.
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

/// Of a model with rows.
ModelService make_service(const ModelInfo& info, const adaptive::Options& options);

extern const ModelInfo elliptical_info;
extern const ModelInfo rough_info;
extern const ModelInfo chiang2016_info;
extern const ModelInfo fiber3d_info;

}  // namespace tress::fiber
