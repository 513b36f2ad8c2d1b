// What a fiber model needs and how it is made, and those that ship: ours and the traced truth.
#pragma once

#include <cstdint>
#include <memory>

#include "tress/adaptive/mixture.h"
#include "tress/adaptive/service.h"
#include "tress/adaptive/target.h"
#include "tress/fiber/elliptical_model.h"
#include "tress/fiber/fiber_model.h"

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
  /// What its rows are learned from; null for a model without rows.
  std::unique_ptr<adaptive::Target> (*make_target)();
  std::unique_ptr<FiberModel> (*make)(const ModelSettings& settings);
  /// In clear hair without gains it returns what it receives, whatever the known direction: the white furnace is 1. The
  /// generic tests hold it to that.
  bool conserves_energy = false;
  bool has_quadrature = false;  ///< reads ModelSettings::quadrature_points
};

extern const ModelInfo elliptical_info;
extern const ModelInfo fiber3d_info;

}  // namespace tress::fiber
