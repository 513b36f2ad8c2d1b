// The methods that fit the rows of a table (adaptive/ESTIMATOR.md, E6).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

namespace tress::adaptive {

class RowLearner;

/// A method that fits rows. All methods write the same table: every mixture has passed the same test, and a cache does
/// not record which method made it; knot rows are a separate kind. There is one object for each method, in static
/// storage, because options hold its address.
struct Learner {
  const char* name;     ///< its name on the command line, in telemetry and in charts
  const char* summary;  ///< half a line for help
  std::unique_ptr<RowLearner> (*make)();
  /// Whether the row is built at the end of the pass of its first query, from the traced target alone and with a known
  /// error. Its epsilon cannot depend on the light that it carries.
  bool on_first_query = false;
};

extern const Learner sketch_learner;  ///< least squares on the exact pairs of the render, after each pass
extern const Learner knot_learner;    ///< no mixture: linear knots; named `table` on the command line

/// The two methods above, the default first.
std::span<const Learner* const> shipped_learners();

}  // namespace tress::adaptive
