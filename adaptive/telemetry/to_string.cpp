#include "tress/adaptive/to_string.h"

#include <algorithm>
#include <cstddef>

#include "base/number_text.h"

namespace tress::inline v0_2::adaptive {
namespace {

std::string megabytes(std::uint64_t bytes) { return number_text(static_cast<double>(bytes) / (1 << 20)) + " MB"; }

}  // namespace

const char* state_name(RowState state) {
  constexpr const char* names[] = {"absent", "open", "converged", "refused"};
  return names[std::min<std::size_t>(static_cast<std::size_t>(state), 3)];
}

std::string to_string(const SliceKey& key) {
  std::string text = "lobe " + std::to_string(key.lobe) + " (";
  for (std::size_t i = 0; i < key.used_parameters().size(); ++i) {
    text += (i == 0 ? "" : ", ") + number_text(static_cast<double>(key.parameters[i]));
  }
  return text + ")";
}

std::string to_string(const SliceDescription& slice) {
  return to_string(slice.key) + ": " + std::to_string(slice.axis_a.size()) + " x " +
         std::to_string(slice.axis_b.size()) + " nodes, blur " + number_text(static_cast<double>(slice.blur_rad)) +
         " rad";
}

std::string to_string(const Options& options) {
  std::string text = std::string("learner ") + options.learner->name + ", epsilon " + number_text(options.epsilon);
  if (options.picture_error > 0) text += ", picture error " + number_text(options.picture_error);
  text += ", table memory " + megabytes(options.memory_bytes);
  text += ", " + std::to_string(options.queries_before_creation) +
          (options.queries_before_creation == 1 ? " query" : " queries") + " before creation";
  text += ", uniform share " + number_text(static_cast<double>(options.uniform_share_converged)) + " converged and " +
          number_text(static_cast<double>(options.uniform_share_open)) + " open";
  text += ", " + std::to_string(options.tests_before_refusal) + " tests before refusal";
  text += ", at most " + std::to_string(options.max_components) + " components";
  if (options.check_passes) text += ", passes checked";
  return text + ", seed " + std::to_string(options.seed);
}

std::string to_string(const PassReport& report) {
  const double share =
      report.queries == 0 ? 0 : static_cast<double>(report.answered_queries) / static_cast<double>(report.queries);
  return std::to_string(report.queries) + " queries, " + number_text(100 * share) +
         " % answered by rows; rows: " + std::to_string(report.rows_open) + " open, " +
         std::to_string(report.rows_converged) + " converged, " + std::to_string(report.rows_refused) + " refused; " +
         megabytes(report.bytes) + (report.at_ceiling ? ", at the ceiling" : "") +
         (report.misuse ? "; misuse: " + report.misuse->message() : "");
}

}  // namespace tress::inline v0_2::adaptive
