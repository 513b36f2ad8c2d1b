// Models and learners by name: those that ship, and those that a program adds before it starts.
#pragma once

#include <span>
#include <string_view>

#include "models/registry.h"
#include "tress/adaptive/learner.h"

namespace tress::inline v0_2::fiber {

/// The models and learners of a program by name, the default first. The spans must refer to objects that live until the
/// program ends.
struct Catalog {
  std::span<const ModelInfo> models;
  std::span<const adaptive::Learner* const> learners;

  /// Null if no model has that name.
  const ModelInfo* find_model(std::string_view name) const;
  /// Null if no learner has that name.
  const adaptive::Learner* find_learner(std::string_view name) const;
};

/// The models and learners that ship.
Catalog shipped_catalog();

/// Replaces the catalog, which is shipped_catalog() until then. Call it before the first thread starts.
void use_catalog(const Catalog& catalog);

// The models of the catalog in use. Any thread.
std::span<const ModelInfo> models();
std::span<const adaptive::Learner* const> learners();
const ModelInfo* find_model(std::string_view name);
const adaptive::Learner* find_learner(std::string_view name);

/// The names of models and learners that only the laboratory (bench/lab) has.
std::span<const std::string_view> laboratory_models();
std::span<const std::string_view> laboratory_learners();

}  // namespace tress::inline v0_2::fiber
