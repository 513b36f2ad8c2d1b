// Every setting of the service and its default, in one place.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "tress/adaptive/learner.h"

namespace tress::adaptive {

struct Options {
  /// Relative squared L2 error below which a row counts as converged: the objective
  /// integral (g - f)^2 / max(integral (g - mean g)^2, 1e-3 / 2 pi).
  double epsilon = 0.01;
  /// The same for rows of slices of samples, of another quantity: chi^2 = integral (S - f)^2/f of all parts, masses
  /// included, over the mass of the row, at the resolution of the test's cells (adaptive/convergence/held_out_test.h).
  double sampled_epsilon = 0.07;
  /// Rows of samples learn until they pass their test at sampled_epsilon, whatever they are asked. Off: their paths go
  /// by their events, and a row that has passed is refined further where events are.
  bool learns_to_epsilon = false;
  /// In place of an epsilon for all rows alike: the relative error that the fits may make in the light of the picture,
  /// under light as of a sky; PassReport::bias_bound is at most ten times it. Each row then has an epsilon of its own
  /// by the light that it carries (Service::credit), and one that carries next to none is never fitted; epsilon is what
  /// rows of a cache are taken at before their light is known. 0: off. For learners that fit mixtures, and for rows of
  /// samples, of which each has an epsilon within [0.005, 0.5].
  double picture_error = 0;
  /// Ceiling for rows, sketches, traced nodes and their memo, and forms of rows, bytes. Past it no row is created and
  /// what is made of rows is not kept; forms make room for rows at a publish(). The index of the
  /// slices, 32 bytes a node, may take as much again, or 16 MB if that is more; a slice that has no room for one is
  /// answered by tracing whenever it is asked, and told as `at_ceiling`.
  std::size_t memory_bytes = std::size_t{256} << 20;
  /// Queries of an absent row, over all passes, before it is created: at the end of the pass of the last of them, since
  /// the published table does not change during one. For learners that wait for them: see queries_to_creation().
  std::uint32_t queries_before_creation = 8;
  /// Share of the queries of rows of samples at which a host is to draw from its target instead of the row, and to tell
  /// Service::hear() what it drew; four times as often of rows of few paths, and less often where that would make the
  /// picture noisier. In [0, 1]; 0: never. To be kept the same from the first pass on.
  float heard_share = 1 / 64.0f;
  /// Rows of samples are taught by paths that the service draws for itself. Off: by those alone that Service::hear()
  /// was told, at most 1,024 a row, without coarser rows; what has no row yet is drawn from the target and heard. To
  /// see what the host's own paths teach.
  bool own_paths = true;
  /// Share of the proposal that stays uniform for ever, converged and open rows (bounds the weight by 1/(1-u)).
  float uniform_share_converged = 0.02f;
  float uniform_share_open = 0.05f;
  /// Tests a row may fail before it is refused and answered at the node for good. Rows of samples are refused by their
  /// paths.
  std::uint32_t tests_before_refusal = 32;
  /// How rows are fitted.
  const Learner* learner = &sketch_learner;
  /// D: the most components of a fit, at most Mixture::max_components. Methods of a fixed number have this many.
  std::uint32_t max_components = 8;
  std::uint64_t seed = 0;
  /// Tells calls outside of their time in PassReport::misuse, by name: readers while publish() runs, a view of an
  /// earlier pass, a slice or form added during a pass. For the development of a host: answers are then all looked up
  /// one by one.
  bool check_passes = false;
  /// Told in a sentence what a host may want to know or log and is no error: the first time that the ceiling holds rows
  /// back, a slice that has no room for an index, cached rows that no longer fit their target, a target of samples
  /// that draws what it must not, misuse. Called between
  /// passes only, inside add_slice(), load() and publish(), by the thread that called those. May be empty.
  std::function<void(const std::string& sentence)> log = nullptr;

  /// Holds rows of every kind to one epsilon.
  void hold_all_to(double all) {
    epsilon = sampled_epsilon = all;
    learns_to_epsilon = true;
  }
  /// For a table that is used as it is and learns nothing: rows answer whose epsilon would go by their light.
  void take_rows_as_they_are() {
    if (picture_error > 0) epsilon = sampled_epsilon = 1;
  }

  /// queries_before_creation, or 1 where the learner builds a row on its first query.
  std::uint32_t queries_to_creation() const {
    return learner->on_first_query && queries_before_creation > 1 ? 1 : queries_before_creation;
  }

  /// Scores needed for a test, and tests in a row that must pass (more below epsilon 0.01).
  std::uint32_t scores_per_test() const { return epsilon < 0.01 ? 24 : 16; }
  std::uint32_t tests_to_converge() const { return epsilon < 0.01 ? 3 : 2; }
};

}  // namespace tress::adaptive
