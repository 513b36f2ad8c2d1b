#include "cli/learner_options.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "cli/option_types.h"
#include "references/registry.h"
#include "tress/adaptive/mixture.h"

namespace tress::cli {

void add_learner(CLI::App* app, adaptive::Options& table) {
  std::vector<std::string> names;
  std::string help = "how rows are learned";
  for (const adaptive::Learner* info : references::learners()) {
    help += std::string(names.empty() ? ": " : "; ") + info->name + ": " + info->summary;
    names.emplace_back(info->name);
  }
  add_choice(
      app, "--learner", names, [&table](const std::string& name) { table.learner = references::find_learner(name); },
      help);
  add_integer(
      app, "--components", 1, adaptive::Mixture::max_components,
      [&table](int n) { table.max_components = static_cast<std::uint32_t>(n); },
      "components of a row, at most or, for learners of a fixed number, exactly; default 8");
  add_number(
      app, "--epsilon", {0, 1, true}, [&table](double x) { table.epsilon = x; },
      "relative squared error under which a row is converged, default .01");
  add_number(
      app, "--table-memory", {0, 1 << 20},
      [&table](double x) { table.memory_bytes = std::size_t(x * double(1 << 20)); },
      "ceiling of the table in MB (2^20 bytes), fractions too, default 256");
}

}  // namespace tress::cli
