// What the service tells of its convergence, as data and as JSON Lines (telemetry/schema.json).
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
#include "tress/adaptive/knot_density.h"
#include "tress/base/error.h"

namespace tress::adaptive {

/// Errors of rows as their forms show them, at the decay rates told to Service::add_form (hair: under the colors that
/// are asked, where `objective` is of clear hair). Relative squared L2 to the variation of the row at that rate,
/// whatever little that is; of each row the largest over the rates of its slice, or over four of them. To 1 %, rounded
/// up. Of one row in eight, chosen by key, so that it takes little time.
struct AbsorbedObjective {
  std::uint64_t rows = 0;  ///< measured: converged in this session while rates were known, so none of a cache
  double p50 = 0, p90 = 0, max = 0;
  friend bool operator==(const AbsorbedObjective&, const AbsorbedObjective&) = default;
};

/// How far the rows of samples are from the host's own paths (Service::hear), which no row was taught by: the integral
/// of (S - f)^2/f over the mass, at the resolution of the cells of adaptive/convergence/held_out_test.h.
struct HeardTest {
  std::uint64_t paths = 0;  ///< kept, at nodes with 64 of them or more
  double chi2 = 0;          ///< mean over the nodes by their paths, unbiased; may be below 0
  double deviation = 0;     ///< standard deviation of chi2
  /// The same of all nodes together, each cell in all of them summed before it is squared: what all rows have wrong to
  /// one side. Known ten times as well.
  double common_chi2 = 0, common_deviation = 0;
};

/// What one publish() did. Counts are of this pass unless said otherwise.
struct PassReport {
  std::uint64_t queries = 0;            ///< look_up() calls
  std::uint64_t converged_queries = 0;  ///< of them on converged rows
  std::uint64_t answered_queries = 0;  ///< of them answered without g: by rows of samples, converged rows, coarser rows
  std::uint64_t g_evaluations = 0;     ///< observed, topped up and by coverage; paths of rows of samples
  /// Nodes traced. All else here is the same for any number of threads; at the ceiling, where the memo of a pass has no
  /// room for all and some are traced at every query, this is not.
  std::uint64_t traces = 0;
  std::uint64_t refits = 0;
  std::uint64_t bad_fits =
      0;  ///< of them: left the constraints, and were replaced by the last good fit or a uniform one
  std::uint64_t creations = 0;
  std::uint64_t newly_converged = 0;
  std::uint64_t validation_draws = 0;
  // totals of the table after the pass
  std::uint64_t rows_queried = 0;  ///< nodes ever asked for, created or not
  std::uint64_t rows_coarse = 0;   ///< nodes of samples that were asked and are answered by coarser rows
  std::uint64_t rows_open = 0;
  std::uint64_t rows_converged = 0;
  std::uint64_t rows_reopened = 0;
  std::uint64_t rows_refused = 0;
  std::uint64_t bytes = 0;  ///< of the rows and of what is made of them
  bool at_ceiling = false;  ///< a creation was put off for want of memory, or a slice without an index was asked
  double objective_p50 = 0, objective_p90 = 0, objective_p99 = 0, objective_max = 0;  ///< running, of tested rows
  AbsorbedObjective absorbed_objective;                                               ///< running, of the session
  std::array<std::uint64_t, Mixture::max_components + 1> components{};  ///< converged mixtures by number of components
  std::array<std::uint64_t, KnotDensity::sizes> knots{};  ///< converged knot tables by number of knots: 32, 64, 128
  double effective_sample_size = 0;  ///< mean over scored samples of (sum w)^2/(n sum w^2), w = g/q; 0 if none
  /// What the converged rows may do to the mean radiance of the picture, relative: E8 of ESTIMATOR.md has what it rests
  /// on. 0 without light told (Service::credit).
  double bias_bound = 0;
  std::uint64_t heard_paths = 0;         ///< told to Service::hear() so far, in all
  std::uint64_t newly_heard = 0;         ///< of them, in this pass
  double learning_cpu_seconds = 0;       ///< CPU time inside publish()
  std::uint64_t ribbons = 0;             ///< rows of slices of samples that answer, in all
  std::uint64_t rows_at_most_paths = 0;  ///< of them, those that have all the paths they may have and did not converge
  std::uint64_t unusable = 0;            ///< refused rows whose draws were none (SampledTarget), in all
  /// Answers in a form that were made and not kept, for want of room (Options::memory_bytes).
  std::uint64_t forms_made_anew = 0;
  /// The first call since the last publish() that the service could not make sense of: a node that is not there, a
  /// target that threw or gave rays that TracedRay does not allow, with Options::check_passes also calls outside of
  /// their time. None is a mistake of data: the host is to be mended.
  std::optional<Error> misuse;
};

/// One row as it stands after a publish().
struct RowReport {
  SliceKey slice;
  std::uint32_t node = 0;
  RowState state = RowState::open;
  double objective = 0;  ///< bound of the last test; negative before the first
  std::uint64_t count = 0;
  std::uint32_t components = 0;  ///< of a mixture, 0 for all others
  std::uint32_t knots = 0;       ///< of a knot table, 0 for all others
  std::uint32_t ribbons = 0;     ///< parts of a row of samples that has converged, 0 for all others
  std::uint32_t failed_tests = 0;
  double light = 0;  ///< Service::light() of it
};

/// Writes JSON Lines, one write of a whole line an event: a killed run has told what it knew. Of a line that finds no
/// room nothing stays in a file, and none follows. A pipe whose reader has gone is an error where the host ignores
/// SIGPIPE. One thread at a time.
class TelemetryWriter {
 public:
  /// Fields of a line beyond those of the reports; values are JSON texts ("3", "\"a\"").
  using Extra = std::map<std::string, std::string>;

  static Result<std::unique_ptr<TelemetryWriter>> create(const std::filesystem::path& file);
  /// Goes on behind the first so many bytes of a file that is there; what follows them is cut off. Error if they are
  /// not there, or do not end a line.
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
  std::optional<Error> write_line(const std::string& line);
  void take_back(std::size_t written);
  std::filesystem::path file_;
  int descriptor_;
  std::uint64_t bytes_ = 0;
  bool failed_ = false;
};

}  // namespace tress::adaptive
