// Every model and every learner by its name: what ships, and the rivals that it is measured against. Linked into the
// program, the tests and the benches; never installed.
#pragma once

#include <span>
#include <string_view>

#include "models/registry.h"
#include "tress/adaptive/learner.h"

namespace tress::references {

/// All models, ours first.
std::span<const fiber::ModelInfo> models();
/// Null if there is none of that name. Any thread.
const fiber::ModelInfo* find_model(std::string_view name);

extern const adaptive::Learner ais_learner;               ///< the paper's adaptive importance sampling (section 5)
extern const adaptive::Learner em_learner;                ///< stepwise expectation maximisation
extern const adaptive::Learner appendix_learner;          ///< one sample at a time, the nearest to 9.1 that converges
extern const adaptive::Learner appendix_literal_learner;  ///< 9.1 as printed; a reference, which does not converge

/// All learners, the default first.
std::span<const adaptive::Learner* const> learners();
/// Null if there is none of that name. Any thread.
const adaptive::Learner* find_learner(std::string_view name);

}  // namespace tress::references
