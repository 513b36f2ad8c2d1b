// What the service reports about its convergence, as data and as JSON Lines (telemetry/schema.json).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "tress/adaptive/cache.h"
#include "tress/base/error.h"

namespace tress::inline v0_2::adaptive {

/// Errors of the forms of rows, at the decay rates passed to Service::add_form (hair: with the colors in use, whereas
/// `objective` is for clear hair). Relative squared L2 to the variation of the row at that rate, however little that
/// is; for each row the largest over the rates of its slice, or over four of them. They are rounded up, by at most 1 %.
/// One row in eight is measured, chosen by key, so that it takes little time.
struct AbsorbedObjective {
  std::uint64_t rows = 0;  ///< rows measured: those that converged in this session with known rates
  double p50 = 0, p90 = 0, max = 0;
  friend bool operator==(const AbsorbedObjective&, const AbsorbedObjective&) = default;
};

/// The error of rows of samples against the host's own paths (Service::hear), from which no row was learned: the
/// integral of (S - f)^2/f divided by the mass, at the resolution of Options::sampled_epsilon.
struct HeardTest {
  std::uint64_t paths = 0;  ///< number kept, at nodes with 64 of them or more
  double chi2 = 0;          ///< mean over the nodes, weighted by their paths; unbiased, so it may be below 0
  double deviation = 0;     ///< standard deviation of chi2
  /// The same for all nodes together, where each cell is summed over all of them before it is squared: the error that
  /// all rows have to one side. It is known ten times as well.
  double common_chi2 = 0, common_deviation = 0;
};

/// The result of one publish(). Counts are of this pass unless said otherwise.
struct PassReport {
  std::uint64_t queries = 0;            ///< look_up() calls
  std::uint64_t converged_queries = 0;  ///< those of converged rows
  std::uint64_t answered_queries = 0;   ///< those answered without g: by rows of samples, converged rows, coarser rows
  std::uint64_t g_evaluations = 0;      ///< observed, topped up and for coverage; for rows of samples, paths
  /// Number of nodes traced. All other fields are the same for any number of threads. This one is not at the memory
  /// limit, where the memo of a pass has no room for all nodes and some are traced at every query.
  std::uint64_t traces = 0;
  std::uint64_t refits = 0;
  std::uint64_t bad_fits =
      0;  ///< those outside the constraints, which were replaced by the last good fit or a uniform one
  std::uint64_t creations = 0;
  std::uint64_t newly_converged = 0;
  std::uint64_t validation_draws = 0;
  // totals of the table after the pass
  std::uint64_t rows_queried = 0;  ///< nodes ever queried, created or not
  std::uint64_t rows_coarse = 0;   ///< nodes of samples that were queried and are answered by coarser rows
  std::uint64_t rows_open = 0;
  std::uint64_t rows_converged = 0;
  std::uint64_t rows_reopened = 0;
  std::uint64_t rows_refused = 0;
  std::uint64_t bytes = 0;  ///< memory of the rows and of their forms
  bool at_ceiling = false;  ///< a creation waits for memory or its monitor, or a slice without an index was queried
  double objective_p50 = 0, objective_p90 = 0, objective_p99 = 0, objective_max = 0;  ///< over all tested rows so far
  AbsorbedObjective absorbed_objective;                                               ///< over the session so far
  std::array<std::uint64_t, Mixture::max_components + 1> components{};  ///< converged mixtures by number of components
  double effective_sample_size = 0;  ///< mean over scored samples of (sum w)^2/(n sum w^2), w = g/q; 0 without any
  /// Upper bound of the relative error that the converged rows may cause in the mean radiance of the picture; E8 of
  /// ESTIMATOR.md has its assumptions. 0 if no light was reported (Service::credit).
  double bias_bound = 0;
  std::uint64_t heard_paths = 0;         ///< passed to Service::hear() so far, in all
  std::uint64_t newly_heard = 0;         ///< those of this pass
  double learning_cpu_seconds = 0;       ///< CPU time inside publish()
  std::uint64_t ribbons = 0;             ///< rows of slices of samples that have an answer, in all
  std::uint64_t rows_at_most_paths = 0;  ///< those that have the largest number of paths and did not converge
  std::uint64_t unusable = 0;            ///< refused rows whose draws were invalid (SampledTarget), in all
  /// Number of answers in a form that were made but not kept, for lack of room (Options::memory_bytes).
  std::uint64_t forms_made_anew = 0;
  bool cancelled = false;  ///< whether Options::progress ended the work of this pass
  /// The first invalid call since the last publish(): a node that does not exist, a target that threw or gave rays that
  /// TracedRay does not allow; with Options::check_passes also a call at a wrong time. None of these is an error in
  /// data: the host's code must be corrected.
  std::optional<Error> misuse;
};

/// The state of one row after a publish().
struct RowReport {
  SliceKey slice;
  std::uint32_t node = 0;
  RowState state = RowState::open;
  double objective = 0;  ///< bound of the last test; negative before the first
  std::uint64_t count = 0;
  std::uint32_t components = 0;  ///< components of a mixture, otherwise 0
  std::uint32_t ribbons = 0;     ///< parts of a row of samples that has converged, otherwise 0
  std::uint32_t failed_tests = 0;
  double light = 0;  ///< its Service::light()
};

/// The object that TelemetryWriter::pass() writes without further fields, on one line.
std::string to_json(const PassReport& report);

/// Writes JSON Lines, one whole line in one write for each event, so a killed run has logged everything up to then. A
/// line that finds no room is removed from the file, and no line follows it. A pipe whose reader has gone is an error
/// if the host ignores SIGPIPE. One thread at a time.
class TelemetryWriter {
 public:
  /// Fields of a line in addition to those of the reports; values are JSON texts ("3", "\"a\"").
  using Extra = std::map<std::string, std::string>;

  static Result<std::unique_ptr<TelemetryWriter>> create(const std::filesystem::path& file);
  /// Continues an existing file after its first `bytes` bytes; the rest is cut off. Error if it has fewer bytes, or
  /// they do not end a line.
  static Result<std::unique_ptr<TelemetryWriter>> resume(const std::filesystem::path& file, std::uint64_t bytes);
  /// Bytes written to the file so far.
  std::uint64_t bytes() const { return bytes_; }
  ~TelemetryWriter();
  TelemetryWriter(const TelemetryWriter&) = delete;
  TelemetryWriter& operator=(const TelemetryWriter&) = delete;

  /// Errors (disk full) are kept and returned by the next call.
  std::optional<Error> header(const Extra& fields);
  std::optional<Error> pass(const PassReport& report, const Extra& fields);
  std::optional<Error> row(const RowReport& report, const Extra& fields);
  std::optional<Error> summary(const Extra& fields);

 private:
  TelemetryWriter(std::filesystem::path file, int descriptor);
  std::optional<Error> write_line(const Result<std::string>& text);
  void take_back(std::size_t written);
  std::filesystem::path file_;
  int descriptor_;
  std::uint64_t bytes_ = 0;
  bool failed_ = false;
};

}  // namespace tress::inline v0_2::adaptive
