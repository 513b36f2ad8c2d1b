// Which method fits the rows of a table. The methods: adaptive/ESTIMATOR.md, E6.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

namespace tress::adaptive {

class RowLearner;

/// A method that fits rows. All write the same table: every mixture of it has passed the same test, and a cache does
/// not know the methods apart; knot rows are of a kind of their own. One object a method, with static storage: options
/// hold its address.
struct Learner {
  const char* name;     ///< as the command line, telemetry and charts call it
  const char* summary;  ///< half a line for help
  std::unique_ptr<RowLearner> (*make)();
  /// The row is built at the end of the pass of its first query, from the traced target alone, with a known error; its
  /// epsilon cannot follow the light that it carries.
  bool on_first_query = false;
};

extern const Learner sketch_learner;  ///< least squares on the exact pairs that the render leaves, after each pass
extern const Learner eager_learner;   ///< the same on pairs of its own, to the end when a row is created
extern const Learner knot_learner;    ///< no mixture: linear knots; named `table` on the command line

/// The three above, the default first.
std::span<const Learner* const> shipped_learners();

}  // namespace tress::adaptive
