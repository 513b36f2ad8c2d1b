// The options that say how rows are learned, of every command that learns.
#pragma once

#include <CLI/CLI.hpp>

#include "tress/adaptive/options.h"

namespace tress::cli {

/// --learner, --components, --epsilon and --table-memory; parsing fills `table`, which must outlive it.
void add_learner(CLI::App* app, adaptive::Options& table);

}  // namespace tress::cli
