// Every learner by its name: a line here and an entry of the enum is all that the rest of the program needs.
#include <algorithm>
#include <array>
#include <cassert>

#include "learner/ais_learner.h"
#include "learner/appendix_learner.h"
#include "learner/em_learner.h"
#include "learner/row_learner.h"
#include "learner/sketch_learner.h"
#include "learner/table_learner.h"

namespace tress::adaptive {
namespace {

template <class Method>
std::unique_ptr<RowLearner> make() {
  return std::make_unique<Method>();
}

struct Entry {
  LearnerInfo info;
  std::unique_ptr<RowLearner> (*make)();
};

constexpr std::array entries{
    Entry{{Learner::sketch, "sketch", "least squares on what the render leaves, after each pass"}, make<SketchLearner>},
    Entry{{Learner::eager, "eager", "the same on samples of its own, when a row is born"}, make<EagerLearner>},
    Entry{{Learner::ais, "ais", "the paper's adaptive importance sampling, when a row is born"}, make<AisLearner>},
    Entry{{Learner::table, "table", "no mixture: 32 to 128 linear knots, on first touch"}, make<TableLearner>},
    Entry{{Learner::em, "em", "stepwise expectation maximisation, after each pass"}, make<EmLearner>},
    Entry{{Learner::appendix, "appendix", "one sample at a time, the nearest to the paper's 9.1 that converges"},
          make<AppendixLearner>},
    Entry{{Learner::appendix_literal, "appendix-literal", "the paper's 9.1 as printed: it does not converge"},
          make<LiteralAppendixLearner>},
};

constexpr auto infos = [] {
  std::array<LearnerInfo, entries.size()> result{};
  for (std::size_t i = 0; i < entries.size(); ++i) result[i] = entries[i].info;
  return result;
}();

const Entry& entry_of(Learner learner) {
  const auto found = std::ranges::find(entries, learner, [](const Entry& entry) { return entry.info.learner; });
  assert(found != entries.end());
  return found != entries.end() ? *found : entries.front();
}

}  // namespace

std::span<const LearnerInfo> learners() { return infos; }

const char* learner_name(Learner learner) { return entry_of(learner).info.name; }

std::optional<Learner> find_learner(std::string_view name) {
  const auto found =
      std::ranges::find(infos, name, [](const LearnerInfo& info) { return std::string_view(info.name); });
  if (found == infos.end()) return std::nullopt;
  return found->learner;
}

std::unique_ptr<RowLearner> make_row_learner(Learner learner) { return entry_of(learner).make(); }

}  // namespace tress::adaptive
