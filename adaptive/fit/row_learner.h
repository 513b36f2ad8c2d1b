// What a fitting method is to the table: one object a row, told when the row opens and when a pass ends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "convergence/stop_test.h"
#include "observations/sketch.h"
#include "tress/adaptive/knot_density.h"
#include "tress/adaptive/learner.h"
#include "tress/adaptive/mixture.h"
#include "tress/adaptive/options.h"
#include "tress/adaptive/traced_nodes.h"
#include "tress/base/random.h"

namespace tress::adaptive {

/// A row as its learner meets it, for one call. What is written here is the row's; nothing else may be queried.
struct FitContext {
  const Options& options;
  const TracedNodes& nodes;  ///< the target; ask it by g()
  Sketch& sketch;            ///< exact pairs: what the host told, and what learners offer
  StopTest& stop;            ///< the learner's own draws score here too (draw_own)
  RandomStream random;       ///< of this row and pass
  int components;            ///< D: the most of a fit, what methods of a fixed number have; 1..Mixture::max_components

  Mixture& fit;                               ///< published: the proposal of the next pass
  bool& has_fit;                              ///< whether `fit` is one
  std::unique_ptr<const KnotDensity>& knots;  ///< what close() has put in its place
  std::uint64_t& count;                       ///< g evaluations that taught the row, the host's included
  /// Azimuths that were drawn from `fit` and scored since it was published. The host's are gone: a learner that wants
  /// them one by one draws as many anew (replay), so that nothing depends on the order in which threads brought them.
  std::uint64_t own_draws = 0;

  // What the call did, for the report.
  std::uint64_t g_evaluations = 0;
  std::uint64_t fits = 0;
  std::uint64_t bad_fits = 0;  ///< of what publish() and close() were given

  /// g(x), counted.
  float g(float x);
  /// Takes over a new fit, whose weights sum to nodes.energy(). One that is not within the constraints (is_legal) is
  /// counted and replaced: by the fit that the row has, by the uniform density if it has none.
  void publish(const Mixture& mixture);
  /// Ends the row with a knot table of known relative squared L2 error: converged if that is at most epsilon, else
  /// refused, and then nothing is published. `table` is of mass nodes.energy(); one that is not, or has a density that
  /// is negative or not finite, is counted and refused.
  void close(KnotDensity table, double objective);
  /// An azimuth drawn from the proposal of `fit`, with its g, counted and scored. The learner may use the pair after
  /// stop.run(), never for the fit that it scored. Needs has_fit.
  ObservedPair draw_own();
  /// Asks g where the sketch leaves gaps (Gap fill).
  void fill_gaps();
  /// The row's test, on what was scored and what is known. False, and nothing done, while there are too few scores.
  bool test();
  /// The most that the relative squared L2 error of `fit` can be (known_error), on the steps that the row's variation
  /// was made of; where they leave open whether it is within epsilon, g is asked half way between them too. If it is
  /// not, they are offered to the sketch. Needs has_fit.
  double largest_error();
};

/// Whether a fit may be published at all: at most `components` components, weights >= 0 of sum `energy`, modes on the
/// circle, scales in [0.004, 0.5], everything finite.
bool is_legal(const Mixture& fit, int components, double energy);
/// Likewise: densities >= 0 and finite, of mass `energy`.
bool is_legal(const KnotDensity& table, double energy);

/// The method of one row, from its opening until it converges or is refused. Rows run in parallel, each on one thread.
/// Two families: methods that go on per pass (learn), and methods that run to the end when a row is created (begin
/// draws, runs FitContext::test() and repeats until it has a verdict). None decides that it has converged: StopTest
/// does, and where the error is known rather than sampled (close) by that alone. Deterministic: a pure function of the
/// contexts.
class RowLearner {
 public:
  virtual ~RowLearner() = default;

  /// A row opens: created, reopened (empty sketch), or brought by a cache, open (a sketch) or converged at a larger
  /// epsilon (has_fit). Afterwards has_fit should hold.
  virtual void begin(FitContext& context) = 0;
  /// A pass has ended, before the row's test: what the learner must ask whatever the test says.
  virtual void before_test(FitContext& context);
  /// After the test, if the row is still open.
  virtual void learn(FitContext& context) = 0;

  /// What the object keeps from one call to the next, and back: a fresh object that is given it goes on to the bit.
  /// Unset: it cannot be told, and a table of such rows cannot be saved as it is (Service::state). set_state: false,
  /// and the object of no use, if these words do not come from state().
  virtual std::optional<std::vector<std::uint64_t>> state() const;
  virtual bool set_state(std::span<const std::uint64_t> words);

  /// Memory of the object, constant: the table's ceiling counts it before a row is created.
  virtual std::size_t bytes() const = 0;
};

/// Learner::make of a method.
template <class Method>
std::unique_ptr<RowLearner> make_row_learner() {
  return std::make_unique<Method>();
}

}  // namespace tress::adaptive
