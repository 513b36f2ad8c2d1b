#include "models/registry.h"

#include <algorithm>
#include <array>

namespace tress::fiber {
namespace {

constexpr std::array<ModelInfo, 1> all_models{{
    {.name = "elliptical",
     .source = "Pekelis, Hery, Villemin, Ling 2015, appendix; adaptive/ESTIMATOR.md",
     .summary = "elliptical fibers, traced exactly and learned while rendering",
     .make_target = make_elliptical_target,
     .make = [](const ModelSettings& s) { return make_elliptical_model(s.estimator, s.service); },
     .conserves_energy = true},
}};

}  // namespace

std::span<const ModelInfo> models() { return all_models; }

const ModelInfo* find_model(const std::string& name) {
  const auto found =
      std::find_if(all_models.begin(), all_models.end(), [&](const ModelInfo& model) { return model.name == name; });
  return found == all_models.end() ? nullptr : &*found;
}

}  // namespace tress::fiber
