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
  /// What a row of samples may have instead that carries less light (Service::credit) than the mean of those asked: at
  /// a share s of it sampled_epsilon/s^2, so that all bring the picture alike, and this at most. sampled_epsilon: all
  /// alike.
  double faint_sampled_epsilon = 0.25;
  /// In place of an epsilon for all rows alike: the relative error that the fits may make in the light of the picture,
  /// under light as of a sky; PassReport::bias_bound is at most ten times it. Each row then has an epsilon of its own
  /// by the light that it carries (Service::credit), and one that carries next to none is never fitted; epsilon is what
  /// rows of a cache are taken at before their light is known. 0: off. For learners that fit mixtures, and for rows of
  /// samples, of which each has an epsilon within [0.005, 0.5].
  double picture_error = 0;
  /// Ceiling for rows, sketches, traced nodes and their memo, and forms of rows, bytes. Past it no row is created and
  /// what is made of rows is not kept; forms make room for rows at a publish(). The index of the
  /// slices, 28 bytes a node, may take as much again, or 16 MB if that is more; a slice that has no room for one is
  /// answered by tracing whenever it is asked, and told as `at_ceiling`.
  std::size_t memory_bytes = std::size_t{256} << 20;
  /// Queries of an absent row, over all passes, before it is created: at the end of the pass of the last of them, since
  /// the published table does not change during one. For learners that wait for them: see queries_to_creation().
  std::uint32_t queries_before_creation = 8;
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
  /// that draws what is none, misuse. Called between
  /// passes only, inside add_slice(), load() and publish(), by the thread that called those. May be empty.
  std::function<void(const std::string& sentence)> log = nullptr;

  /// One epsilon for rows of every kind, whatever light they carry.
  void hold_all_to(double all) { epsilon = sampled_epsilon = faint_sampled_epsilon = all; }
  /// For a table that is used as it is, which learns nothing, the light of its rows neither: rows answer that were held
  /// to anything that these options ask of any row.
  void take_rows_as_they_are() {
    sampled_epsilon = std::max(sampled_epsilon, faint_sampled_epsilon);
    if (picture_error > 0) epsilon = sampled_epsilon = 1;
  }

  /// queries_before_creation, or 1 where the learner builds a row on its first query.
  std::uint32_t queries_to_creation() const {
    return learner->on_first_query && queries_before_creation > 1 ? 1 : queries_before_creation;
  }

  /// Scores needed for a test, and tests in a row that must pass (more below epsilon .01).
  std::uint32_t scores_per_test() const { return epsilon < 0.01 ? 24 : 16; }
  std::uint32_t tests_to_converge() const { return epsilon < 0.01 ? 3 : 2; }
};

}  // namespace tress::adaptive
