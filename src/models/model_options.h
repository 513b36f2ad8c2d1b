// Options that only some models support. An option that the model does not support is refused; it never selects another
// model.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "models/registry.h"

namespace tress::inline v0_2::fiber {

/// The feature of a model that an option needs.
enum class Asks {
  rows,       ///< learned rows
  samples,    ///< rows learned from samples of fibers that can be traced from where a ray meets them
  mixtures,   ///< rows that a learner fits by mixtures
  corrected,  ///< the estimator `corrected`
  points,     ///< a quadrature at every vertex
};

/// An option that was given, under the caller's name for it ("--estimator corrected", "epsilon").
struct AskedOption {
  std::string name;
  Asks what;
};

bool has(const ModelInfo& model, Asks what);

/// The first option that the model does not support, and what was expected: "a model with rows (elliptical, rough,
/// pekelis2015)". Empty if it supports all of them.
struct RefusedOption {
  std::string name, expected;
  std::string remedy;  ///< the first model that supports it
};
std::optional<RefusedOption> refused(std::span<const AskedOption> asked, const ModelInfo& model);

}  // namespace tress::inline v0_2::fiber
