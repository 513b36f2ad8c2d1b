#include "models/catalog.h"

#include <algorithm>
#include <array>

namespace tress::inline v0_2::fiber {
namespace {

const std::array shipped_models{elliptical_info, rough_info, chiang2016_info, fiber3d_info};
constexpr std::array shipped_learners{&adaptive::sketch_learner};

Catalog& catalog() {
  static Catalog used = shipped_catalog();
  return used;
}

}  // namespace

Catalog shipped_catalog() { return {shipped_models, shipped_learners}; }

void use_catalog(const Catalog& used) { catalog() = used; }

const ModelInfo* Catalog::find_model(std::string_view name) const {
  const auto found = std::ranges::find_if(models, [&](const ModelInfo& model) { return model.name == name; });
  return found == models.end() ? nullptr : &*found;
}

const adaptive::Learner* Catalog::find_learner(std::string_view name) const {
  const auto found =
      std::ranges::find_if(learners, [&](const adaptive::Learner* learner) { return learner->name == name; });
  return found == learners.end() ? nullptr : *found;
}

std::span<const ModelInfo> models() { return catalog().models; }
std::span<const adaptive::Learner* const> learners() { return catalog().learners; }
const ModelInfo* find_model(std::string_view name) { return catalog().find_model(name); }
const adaptive::Learner* find_learner(std::string_view name) { return catalog().find_learner(name); }

std::span<const std::string_view> laboratory_models() {
  static constexpr std::array<std::string_view, 6> names{"deon2011",      "deon2022",    "ou2012",
                                                         "marschner2003", "pekelis2015", "pekelis2015-printed"};
  return names;
}

std::span<const std::string_view> laboratory_learners() {
  static constexpr std::array<std::string_view, 5> names{"eager", "ais", "em", "appendix", "appendix-literal"};
  return names;
}

}  // namespace tress::inline v0_2::fiber
