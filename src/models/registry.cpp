#include "models/registry.h"

#include "models/fiber3d.h"

namespace tress::fiber {

constinit const ModelInfo elliptical_info{
    .name = "elliptical",
    .source = "Pekelis, Hery, Villemin, Ling 2015, appendix; adaptive/ESTIMATOR.md",
    .summary = "elliptical fibers, traced exactly and learned while rendering",
    .make_target = make_elliptical_target,
    .make = [](const ModelSettings& s) { return make_elliptical_model(s.estimator, s.service); },
    .conserves_energy = true};

constinit const ModelInfo fiber3d_info{
    .name = "fiber3d",
    .source = "traced Beckmann facets: visible normals of Heitz and d'Eon 2014, walk of Heitz et al. 2016",
    .summary = "the ground truth: a rough elliptical fiber, path traced at every hit; no light sampling",
    .make_target = nullptr,
    .make = make_fiber3d,
    .conserves_energy = true};

}  // namespace tress::fiber
