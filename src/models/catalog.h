// Models and learners by name: those that ship, and those that a program adds before it starts.
#pragma once

#include <span>
#include <string_view>

#include "models/registry.h"
#include "tress/adaptive/learner.h"

namespace tress::fiber {

/// What a program offers by name, the default first. The spans must refer to what lives until the program ends.
struct Catalog {
  std::span<const ModelInfo> models;
  std::span<const adaptive::Learner* const> learners;

  /// Null if no model has that name.
  const ModelInfo* find_model(std::string_view name) const;
  /// Null if no learner has that name.
  const adaptive::Learner* find_learner(std::string_view name) const;
};

/// What ships.
Catalog shipped_catalog();

/// Replaces the catalog, which is shipped_catalog() until then. Call it before the first thread starts.
void use_catalog(const Catalog& catalog);

// What the catalog in use has. Any thread.
std::span<const ModelInfo> models();
std::span<const adaptive::Learner* const> learners();
const ModelInfo* find_model(std::string_view name);
const adaptive::Learner* find_learner(std::string_view name);

/// The names of models and learners that are in the laboratory (bench/lab) and not in tress.
std::span<const std::string_view> laboratory_models();
std::span<const std::string_view> laboratory_learners();

}  // namespace tress::fiber
