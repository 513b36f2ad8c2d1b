// Which method fits the rows of a table. The methods: adaptive/ESTIMATOR.md, E6.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace tress::adaptive {

/// All write the same table. Every mixture of it has passed the same test, and the cache does not know the methods
/// apart; rows of `table` are of a kind of their own.
enum class Learner : std::uint8_t {
  sketch,            ///< least squares on the exact pairs that the render leaves, after each pass
  eager,             ///< the same on pairs of its own, to the end when a row is born
  ais,               ///< the paper's adaptive importance sampling (section 5), to the end when a row is born
  table,             ///< no mixture: a linear knot table, built at the end of the pass of the first touch
  em,                ///< stepwise expectation maximisation, after each pass
  appendix,          ///< one sample at a time, the nearest to the paper's 9.1 that converges
  appendix_literal,  ///< the paper's 9.1 as printed; a reference, which does not converge
};

struct LearnerInfo {
  Learner learner;
  const char* name;     ///< as the command line, telemetry and charts call it
  const char* summary;  ///< half a line for help
};

/// All learners, the default first.
std::span<const LearnerInfo> learners();
const char* learner_name(Learner learner);
/// Empty if there is none of that name.
std::optional<Learner> find_learner(std::string_view name);

}  // namespace tress::adaptive
