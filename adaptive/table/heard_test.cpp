// Tests rows of samples against the paths that the host drew itself.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "convergence/held_out_test.h"
#include "table/table.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr std::size_t least_paths = 64;  ///< per node: a test on fewer paths shows nothing

}  // namespace

HeardTest Service::Table::test_by_heard() {
  constexpr std::size_t sets = HeldOutTest::sets;
  HeardTest all;
  double sum = 0, variance = 0;
  HeldOutCells common;
  for (SliceId id = 0; id < rows_.slice_count(); ++id) {
    Slice& slice = rows_.slice(id);
    for (std::uint32_t n = 0; n < slice.description.node_count(); ++n) {
      const std::span<const SampledExit> heard = slice.heard.at(n);
      if (heard.size() < least_paths) continue;
      const SampledAnswer answer = answer_of(slice, n);
      if (!answer) continue;
      const std::size_t paths = heard.size() / sets;  // per set; the paths are in random order
      HeldOutTest test(answer->row);
      std::array<std::vector<SampledExit>, sets> of_set;
      for (std::size_t i = 0; i < sets * paths; ++i) {
        if (heard[i].part < answer->row.parts()) of_set[i % sets].push_back(heard[i]);
      }
      for (std::size_t s = 0; s < sets; ++s) test.add(s, of_set[s]);
      const HeldOutCells cells = test.found(static_cast<std::uint32_t>(paths));
      const SampledTest found = cells.result();
      const auto weight = static_cast<double>(heard.size());
      all.paths += heard.size();
      sum += weight * found.chi2;
      variance += weight * weight * found.deviation * found.deviation;
      common.add(cells);
    }
  }
  if (all.paths == 0) return all;
  const auto weight = static_cast<double>(all.paths);
  all.chi2 = sum / weight;
  all.deviation = std::sqrt(variance) / weight;
  const SampledTest of_all = common.result();
  all.common_chi2 = of_all.chi2;
  all.common_deviation = of_all.deviation;
  return all;
}

}  // namespace tress::inline v0_2::adaptive
