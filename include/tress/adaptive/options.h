// Every setting of the service and its default, in one place.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tress/adaptive/learner.h"
#include "tress/base/error.h"

namespace tress::inline v0_2::adaptive {

struct Options {
  /// The relative squared L2 error below which a row has converged: the objective integral (g - f)^2 / max(integral (g
  /// - mean g)^2, 1e-3 / 2 pi).
  double epsilon = 0.01;
  /// The same for rows of slices of samples, where the error is another quantity: chi^2 = integral (S - f)^2/f of all
  /// parts, masses included, divided by the mass of the row. Its resolution is that of the test's cells: 16 by azimuth
  /// times 8 by height, of equal mass in each part.
  double sampled_epsilon = 0.07;
  /// Whether rows of samples learn until they pass their test at sampled_epsilon, however often they are queried. If
  /// off, the number of their events decides how many paths they get, and a row that has passed is refined further
  /// where events are.
  bool learns_to_epsilon = false;
  /// Replaces one epsilon for all rows: the relative error that the fits may cause in the light of the picture, under
  /// light like that of a sky. PassReport::bias_bound of rows of densities is at most ten times it. Each row then has
  /// its own epsilon by the light that it carries (Service::credit), and one that carries almost none is never fitted.
  /// Until the light of a cached row is known, `epsilon` decides whether it is used. 0: off. Epsilons of rows of
  /// samples are within [0.005, 0.5].
  double picture_error = 0;
  /// Limit in bytes for rows, sketches, traced nodes and their memo, and forms of rows. Beyond it no row is created,
  /// and forms of rows are not kept; forms make room for rows at a publish(). The index of the slices, 33 bytes per
  /// node, may take as much again, or 16 MB if that is more. A slice that has no room for an index is traced at every
  /// query, and `at_ceiling` reports it.
  std::size_t memory_bytes = std::size_t{256} << 20;
  /// Number of queries of an absent row, over all passes, before it is created. It is created at the end of the pass of
  /// the last of them, because the published table does not change during a pass.
  std::uint32_t queries_before_creation = 8;
  /// Share of the queries of rows of samples at which a host should draw from its target instead of the row, and pass
  /// what it drew to Service::hear(). It is four times as large for rows of few paths, and smaller where it would make
  /// the picture noisier. The range is [0, 1]; 0 means never. Keep it the same from the first pass on.
  float heard_share = 1 / 64.0f;
  /// Whether the service draws paths of its own for rows of samples. If off, rows learn only from paths that were
  /// passed to Service::hear(), at most 1,024 per row, and there are no coarser rows; for nodes without a row, the host
  /// draws from the target and passes the paths on. This shows what can be learned from the host's own paths.
  bool own_paths = true;
  /// Share of the proposal that always stays uniform, for converged and open rows (it bounds the weight by 1/(1-u)).
  float uniform_share_converged = 0.02f;
  float uniform_share_open = 0.05f;
  /// Number of tests that a row may fail before it is refused and answered at the node for good. Rows of samples are
  /// refused by their number of paths instead.
  std::uint32_t tests_before_refusal = 32;
  /// The method that fits rows.
  const Learner* learner = &sketch_learner;
  /// D: the largest number of components of a fit, at most Mixture::max_components. Methods with a fixed number have
  /// this many.
  std::uint32_t max_components = 8;
  std::uint64_t seed = 0;
  /// Whether calls at a wrong time are reported by name in PassReport::misuse: readers while publish() runs, a view of
  /// an earlier pass, a slice or form added during a pass. Use it while you develop a host: all answers are
  /// then looked up one by one.
  bool check_passes = false;
  /// Called with a sentence for anything that a host may want to log and that is no error. Examples are: the memory
  /// limit holds rows back for the first time; a slice has no room for an index; cached rows no longer fit their
  /// target; a target of samples gives invalid draws; misuse. Called between passes only, inside add_slice(), load()
  /// and publish(), by the thread that called those. May be empty.
  std::function<void(const std::string& sentence)> log = nullptr;

  /// Called inside publish() and prepare(), by the thread that called those, before each portion of the work, with the
  /// share that is done, in [0, 1). If it returns false, the rest is left for later passes, and PassReport::cancelled
  /// says so: rows then depend on when it did. May be empty; one that throws counts as one that returns true, and is
  /// reported as misuse.
  std::function<bool(double done)> progress = nullptr;

  /// Called with every change of PassReport::bytes, in bytes, so that the sum is that number whenever a call between
  /// passes returns, and 0 once the service is destroyed. With post == false, the service asks before it opens a row:
  /// if the answer is false, the row is not counted, and no more rows are opened in this call. Their nodes are answered
  /// as at the memory limit, and ask again in later passes (PassReport::at_ceiling); which rows there are then depends
  /// on the answers. With post == true it reports what has changed already, such as fits and forms, and ignores the
  /// answer. By the thread of the call, between passes only, and by the destructor. May be empty; one that throws
  /// counts as one that returns true, and is reported as misuse.
  std::function<bool(std::int64_t bytes, bool post)> memory_monitor = nullptr;

  /// The host's own tasks, in place of oneTBB's, for all that publish(), prepare() and restore() do in parallel. Calls
  /// task(i) for each i below count, on any threads, and returns when those calls have returned. The bits of the table
  /// are the same as without it. A task that was left out is done by the calling thread; one that is called twice is
  /// done once. May be empty; one that throws is reported as misuse.
  std::function<void(std::size_t count, const std::function<void(std::size_t i)>& task)> parallel_for = nullptr;

  /// Sets one epsilon for rows of every kind.
  void hold_all_to(double all) {
    epsilon = sampled_epsilon = all;
    learns_to_epsilon = true;
  }
  /// Sets the options for a table that is used but learns nothing: rows whose epsilon would depend on their light are
  /// used too.
  void take_rows_as_they_are() {
    if (picture_error > 0) epsilon = sampled_epsilon = 1;
  }

  /// The number of scores needed for a test, and of tests that must pass one after the other (more below epsilon 0.01).
  std::uint32_t scores_per_test() const { return epsilon < 0.01 ? 24 : 16; }
  std::uint32_t tests_to_converge() const { return epsilon < 0.01 ? 3 : 2; }
};

/// Replaces each number that a service cannot work with by the nearest one that it can, and what is not a number or
/// null by its default. Returns an Error for each replacement, with the option's name as its place. A
/// service does this to the options that it is given, and passes the errors to Options::log.
std::vector<Error> make_usable(Options& options);

}  // namespace tress::inline v0_2::adaptive
