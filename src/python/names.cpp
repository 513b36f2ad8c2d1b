#include "python/names.h"

#include "references/registry.h"

namespace tress::python {
namespace {

std::string comma(const std::string& names) { return names.empty() ? "" : ", "; }

}  // namespace

fiber::Estimator estimator_named(const std::string& name) {
  for (const auto estimator : {fiber::Estimator::fitted, fiber::Estimator::exact, fiber::Estimator::corrected})
    if (name == fiber::estimator_name(estimator)) return estimator;
  throw Raised({"", "estimator", "one of fitted, corrected, exact", "\"" + name + "\""});
}

const fiber::ModelInfo& model_named(const std::string& name) {
  if (const fiber::ModelInfo* model = references::find_model(name)) return *model;
  std::string names;
  for (const fiber::ModelInfo& known : references::models()) names += comma(names) + known.name;
  throw Raised({"", "model", "one of " + names, "\"" + name + "\""});
}

const adaptive::Learner* learner_named(const std::string& name) {
  if (const adaptive::Learner* learner = references::find_learner(name)) return learner;
  std::string names;
  for (const adaptive::Learner* known : references::learners()) names += comma(names) + known->name;
  throw Raised({"", "learner", "one of " + names, "\"" + name + "\""});
}

}  // namespace tress::python
