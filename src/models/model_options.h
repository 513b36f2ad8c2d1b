// Options that some models have and others have not. One that the model has not is refused: it never chooses another.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "models/registry.h"

namespace tress::fiber {

/// What an option asks of a model.
enum class Asks {
  rows,       ///< rows that are learned
  samples,    ///< rows that are learned from samples, whose fibers can be traced from where a ray meets them
  mixtures,   ///< rows that a learner fits, by mixtures or knots
  corrected,  ///< the estimator `corrected`
  points,     ///< a quadrature at every vertex
};

/// An option that was given, as the caller calls it ("--estimator corrected", "epsilon").
struct AskedOption {
  std::string name;
  Asks what;
};

bool has(const ModelInfo& model, Asks what);

/// The first of the options that the model has not, and what was expected of it: "a model with rows (elliptical, rough,
/// pekelis2015)". Unset: it has all of them.
struct RefusedOption {
  std::string name, expected;
  std::string remedy;  ///< a model that has it, the first
};
std::optional<RefusedOption> refused(std::span<const AskedOption> asked, const ModelInfo& model);

}  // namespace tress::fiber
