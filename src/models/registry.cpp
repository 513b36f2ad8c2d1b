#include "models/registry.h"

#include "fiber/rough_rows.h"
#include "models/elliptical/elliptical_fibers.h"
#include "models/fiber3d.h"

namespace tress::fiber {

constinit const ModelInfo elliptical_info{
    .name = "elliptical",
    .source = "Pekelis, Hery, Villemin, Ling 2015, appendix; adaptive/ESTIMATOR.md",
    .summary = "elliptical fibers, traced exactly and learned while rendering",
    .make_target = make_elliptical_target,
    .make = [](const ModelSettings& s) { return make_elliptical_model(s.estimator, s.service); },
    .conserves_energy = true,
    .slices_of =
        [](const FiberParameters& fiber) {
          std::vector<adaptive::SliceDescription> slices;
          for (const auto& slice : elliptical_slices(fiber)) {
            if (slice) slices.push_back(*slice);
          }
          return slices;
        }};

constinit const ModelInfo rough_info{
    .name = "rough",
    .source = "fiber3d, learned from samples; adaptive/ESTIMATOR.md, E9",
    .summary = "the rough fiber that fiber3d traces, learned from its paths while rendering",
    .make_target = make_elliptical_target,
    .make = [](const ModelSettings& s) { return make_rough_model(s.estimator, s.service); },
    .conserves_energy = true,
    .make_sampled_target = make_rough_target,
    .slices_of = [](const FiberParameters& fiber) { return std::vector{rough_slice(fiber)}; }};

constinit const ModelInfo fiber3d_info{
    .name = "fiber3d",
    .source = "traced Beckmann facets: visible normals of Heitz and d'Eon 2014, walk of Heitz et al. 2016",
    .summary = "the ground truth: a rough elliptical fiber, path traced at every hit; no light sampling",
    .make_target = nullptr,
    .make = make_fiber3d,
    .conserves_energy = true};

ModelService make_service(const ModelInfo& info, const adaptive::Options& options) {
  ModelService made;
  made.target = info.make_target();
  if (info.learns_samples()) {
    made.samples = info.make_sampled_target();
    made.service = std::make_unique<adaptive::Service>(options, *made.target, *made.samples);
  } else {
    made.service = std::make_unique<adaptive::Service>(options, *made.target);
  }
  return made;
}

}  // namespace tress::fiber
