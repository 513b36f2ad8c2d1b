// Checks names and numbers of Python's keyword arguments against what the options of the command line allow.
#pragma once

#include <fmt/format.h>

#include <string>

#include "models/registry.h"
#include "python/raised.h"
#include "scene/model/parameters.h"
#include "tress/adaptive/learner.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::python {

// Each raises an error that lists the valid names.

fiber::Estimator estimator_named(const std::string& name);
const fiber::ModelInfo& model_named(const std::string& name);
/// The error for an unknown name of a model.
Error unknown_model(const std::string& name);
const adaptive::Learner* learner_named(const std::string& name);

/// The value, if the command-line option of the same meaning accepts it.
template <class T>
T in_range(const char* name, T value, const char* option) {
  const scene::Parameter& parameter = scene::option_parameter(option);
  if (!parameter.range.contains(static_cast<double>(value)))
    throw Raised({"", name, scene::words(parameter), fmt::format("{}", value)});
  return value;
}

}  // namespace tress::python
