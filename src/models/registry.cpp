#include "models/registry.h"

#include "fiber/rough_rows.h"
#include "models/elliptical/elliptical_fibers.h"
#include "models/fiber3d.h"
#include "tress/fiber/chiang2016_model.h"

namespace tress::inline v0_2::fiber {

constinit const ModelInfo elliptical_info{
    .name = "elliptical",
    .source = "Pekelis, Hery, Villemin, Ling 2015, appendix; adaptive/ESTIMATOR.md",
    .summary = "elliptical fibers, traced exactly and learned while rendering",
    .make_target = make_elliptical_target,
    .make = [](const ModelSettings& s) { return *make_elliptical_model(s.estimator, s.service); },
    .conserves_energy = true,
    .has_corrected = true,
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
    .make = [](const ModelSettings& s) { return *make_rough_model(s.estimator, s.service); },
    .conserves_energy = true,
    .has_parts = true,
    .make_sampled_target = make_rough_target,
    .slices_of = [](const FiberParameters& fiber) { return std::vector{rough_slice(fiber)}; }};

constinit const ModelInfo chiang2016_info{
    .name = "chiang2016",
    .source = "Chiang, Bitterli, Tappan, Burley 2016",
    .summary = "near field, trimmed logistics and a geometric series: what today's renderers ship",
    .make_target = nullptr,
    .make = [](const ModelSettings&) { return make_chiang2016_model(); },
    .conserves_energy = true};

constinit const ModelInfo fiber3d_info{
    .name = "fiber3d",
    .source = "traced Beckmann facets: visible normals of Heitz and d'Eon 2014, walk of Heitz et al. 2016",
    .summary = "the ground truth: a rough elliptical fiber, path traced at every hit; no light sampling",
    .make_target = nullptr,
    .make = make_fiber3d,
    .conserves_energy = true,
    .has_parts = true};

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

}  // namespace tress::inline v0_2::fiber
