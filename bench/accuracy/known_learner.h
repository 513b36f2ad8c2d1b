// What --learner may name.
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

}  // namespace tress::bench
