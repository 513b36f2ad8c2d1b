// The methods that fit the rows of a table (adaptive/ESTIMATOR.md, E6).
#pragma once

#include <memory>

namespace tress::inline v0_2::adaptive {

class RowLearner;

/// A method that fits rows. All methods write the same table: every mixture has passed the same test, and a cache does
/// not record which method made it. There is one object for each method, in static
/// storage, because options hold its address.
struct Learner {
  const char* name;     ///< its name on the command line, in telemetry and in charts
  const char* summary;  ///< half a line for help
  std::unique_ptr<RowLearner> (*make)();
};

extern const Learner sketch_learner;  ///< least squares on the exact pairs of the render, after each pass

}  // namespace tress::inline v0_2::adaptive
