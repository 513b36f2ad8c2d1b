#include "python/names.h"

#include <algorithm>
#include <span>
#include <string_view>

#include "models/catalog.h"

namespace tress::python {
namespace {

std::string comma(const std::string& names) { return names.empty() ? "" : ", "; }

/// The name that was found, and a hint if the laboratory has it.
std::string found(const std::string& name, std::span<const std::string_view> in_laboratory) {
  const bool has = std::ranges::find(in_laboratory, name) != in_laboratory.end();
  return "\"" + name + "\"" + (has ? ", which only tress-lab has" : "");
}

}  // namespace

fiber::Estimator estimator_named(const std::string& name) {
  for (const auto estimator : {fiber::Estimator::fitted, fiber::Estimator::exact, fiber::Estimator::corrected})
    if (name == fiber::estimator_name(estimator)) return estimator;
  throw Raised({"", "estimator", "one of fitted, corrected, exact", "\"" + name + "\""});
}

const fiber::ModelInfo& model_named(const std::string& name) {
  if (const fiber::ModelInfo* model = fiber::find_model(name)) return *model;
  throw Raised(unknown_model(name));
}

Error unknown_model(const std::string& name) {
  std::string names;
  for (const fiber::ModelInfo& known : fiber::models()) names += comma(names) + known.name;
  return {"", "model", "one of " + names, found(name, fiber::laboratory_models())};
}

const adaptive::Learner* learner_named(const std::string& name) {
  if (const adaptive::Learner* learner = fiber::find_learner(name)) return learner;
  std::string names;
  for (const adaptive::Learner* known : fiber::learners()) names += comma(names) + known->name;
  throw Raised({"", "learner", "one of " + names, found(name, fiber::laboratory_learners())});
}

}  // namespace tress::python
