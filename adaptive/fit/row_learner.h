// The interface of a fitting method to the table: one object for each row, called when the row opens and when a pass
// ends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "convergence/stop_test.h"
#include "observations/sketch.h"
#include "tress/adaptive/learner.h"
#include "tress/adaptive/mixture.h"
#include "tress/adaptive/options.h"
#include "tress/adaptive/traced_nodes.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {

/// A row as its learner sees it during one call. The learner writes to the row through it, and must query nothing else.
struct FitContext {
  const Options& options;
  const TracedNodes& nodes;  ///< the target; evaluate it by g()
  Sketch& sketch;            ///< exact pairs: those that the host passed, and those that learners offer
  StopTest& stop;            ///< also scores draws of the learner's own
  RandomStream random;       ///< a stream for this row and pass
  int components;            ///< D: largest (or fixed) number of components of a fit; 1..Mixture::max_components

  Mixture& fit;          ///< published: the proposal of the next pass
  bool& has_fit;         ///< whether `fit` has been published
  std::uint64_t& count;  ///< evaluations of g from which the row was learned, including the host's
  /// Number of azimuths that were drawn from `fit` and scored since it was published. The host's own azimuths are not
  /// kept. A learner that wants single ones draws as many anew (replay), so that nothing depends on the order in which
  /// threads brought them.
  std::uint64_t own_draws = 0;

  // Counts of this call, for the report.
  std::uint64_t g_evaluations = 0;
  std::uint64_t fits = 0;
  std::uint64_t bad_fits = 0;  ///< number of invalid fits given to publish()

  /// Evaluates g(x) and counts it.
  float g(float x);
  /// Takes over a new fit, whose weights sum to nodes.energy(). A fit outside the constraints (is_legal) is counted and
  /// replaced: by the fit that the row has, or by the uniform density if it has none.
  void publish(const Mixture& mixture);
  /// Evaluates g in the gaps of the sketch (Gap fill).
  void fill_gaps();
  /// Runs the row's test on all scores and on largest_error(). Returns false and does nothing while there are too few
  /// scores.
  bool test();
  /// Bounds the relative squared L2 error of `fit` (known_error) from g at the steps of nodes.grid(). If these leave
  /// open whether the error is within epsilon, g is also evaluated half way between them and offered to the sketch. If
  /// the bound exceeds epsilon, the steps are offered too. Needs has_fit.
  double largest_error();
};

/// Whether a fit is valid for publication: at most `components` components, weights >= 0 of sum `energy`, modes on the
/// circle, scales in [0.004, 0.5], everything finite.
bool is_legal(const Mixture& fit, int components, double energy);

/// The method of one row, from its opening until it converges or is refused. Rows run in parallel, each on one thread.
/// There are two families: methods that continue after each pass (learn), and methods that run to the end when a row is
/// created (begin draws, runs FitContext::test() and repeats until it has a verdict). No method decides that it has
/// converged: StopTest does. Deterministic: a pure function of the contexts.
class RowLearner {
 public:
  virtual ~RowLearner() = default;

  /// Called when a row opens: it is created, reopened (with an empty sketch), or loaded from a cache, either open (with
  /// a sketch) or converged at a larger epsilon (has_fit). Afterwards has_fit should hold.
  virtual void begin(FitContext& context) = 0;
  /// Called at the end of a pass, before the row's test: evaluate here what is needed for any result of the test.
  virtual void before_test(FitContext& context);
  /// Called after the test if the row is still open.
  virtual void learn(FitContext& context) = 0;

  /// The words that the object keeps between calls; a fresh object that gets them continues to the bit. Empty if it
  /// cannot be saved: a table of such rows cannot be saved as it is (Service::state). set_state returns false, and the
  /// object must not be used, if the words do not come from state().
  virtual std::optional<std::vector<std::uint64_t>> state() const;
  virtual bool set_state(std::span<const std::uint64_t> words);

  /// The memory of the object, constant. The table counts it against its limit before a row is created.
  virtual std::size_t bytes() const = 0;
};

/// The Learner::make of a method.
template <class Method>
std::unique_ptr<RowLearner> make_row_learner() {
  return std::make_unique<Method>();
}

}  // namespace tress::inline v0_2::adaptive
