// Every model and every learner by its name: what ships, and the rivals that it is measured against. Linked into
// tress-lab, the tests and the benches.
#pragma once

#include <span>
#include <string_view>

#include "models/catalog.h"
#include "models/registry.h"
#include "tress/adaptive/learner.h"

namespace tress::references {

/// All of them: what ships, and the rivals. Any thread.
fiber::Catalog catalog();

// What catalog() has. Any thread.
std::span<const fiber::ModelInfo> models();
std::span<const adaptive::Learner* const> learners();
const fiber::ModelInfo* find_model(std::string_view name);
const adaptive::Learner* find_learner(std::string_view name);

extern const adaptive::Learner eager_learner;             ///< ours, run to the end when a row opens
extern const adaptive::Learner ais_learner;               ///< the paper's adaptive importance sampling (section 5)
extern const adaptive::Learner em_learner;                ///< stepwise expectation maximisation
extern const adaptive::Learner appendix_learner;          ///< one sample at a time, the nearest to 9.1 that converges
extern const adaptive::Learner appendix_literal_learner;  ///< 9.1 as printed; a reference, which does not converge

}  // namespace tress::references
