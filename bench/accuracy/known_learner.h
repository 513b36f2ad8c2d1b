// What --learner may name: a method of the table, and where a program fits single rows, the rival `table`.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "references/registry.h"
#include "tress/adaptive/learner.h"

namespace tress::bench {

inline const CLI::Validator known_learner(
    [](const std::string& name) {
      return references::find_learner(name) ? std::string() : "expected a learner, found " + name;
    },
    "NAME");

/// The rival without mixtures. It is no method of the table, so it makes no learner of a row.
inline constexpr adaptive::Learner knot_learner{"table", "no mixture: 32 to 128 linear knots", nullptr};

/// Null for an unknown name.
inline const adaptive::Learner* find_row_learner(const std::string& name) {
  return name == knot_learner.name ? &knot_learner : references::find_learner(name);
}

inline const CLI::Validator known_row_learner(
    [](const std::string& name) {
      return find_row_learner(name) ? std::string() : "expected a learner, found " + name;
    },
    "NAME");

}  // namespace tress::bench
