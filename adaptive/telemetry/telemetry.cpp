#include "tress/adaptive/telemetry.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>

#include "tress/adaptive/to_string.h"
#include "tress/version.h"

// The library gets a name of our own, because the linker would merge its weak symbols with those of a host.
#define nlohmann tress_nlohmann
#include <nlohmann/json.hpp>

namespace tress::inline v0_2::adaptive {
namespace {

using Json = nlohmann::ordered_json;

constexpr int deepest_extra = 64;  // bounds the recursion of dump()

/// Bytes that are not UTF-8 become U+FFFD, and numbers that are not finite become null.
std::string to_text(const Json& fields) { return fields.dump(-1, ' ', false, Json::error_handler_t::replace); }

double share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

Json pass_fields(const PassReport& report) {
  return {{"type", "pass"},
          {"g_evaluations", report.g_evaluations},
          {"queries", report.queries},
          {"converged_query_share", share(report.converged_queries, report.queries)},
          {"answered_query_share", share(report.answered_queries, report.queries)},
          {"refits", report.refits},
          {"bad_fits", report.bad_fits},
          {"births", report.creations},
          {"traces", report.traces},
          {"top_ups", report.validation_draws},
          {"newly_converged", report.newly_converged},
          {"rows",
           {{"touched", report.rows_queried},
            {"coarse", report.rows_coarse},
            {"open", report.rows_open},
            {"converged", report.rows_converged},
            {"reopened", report.rows_reopened},
            {"refused", report.rows_refused},
            {"at_most_paths", report.rows_at_most_paths}}},
          {"objective",
           {{"p50", report.objective_p50},
            {"p90", report.objective_p90},
            {"p99", report.objective_p99},
            {"max", report.objective_max}}},
          {"objective_absorbed",
           {{"rows", report.absorbed_objective.rows},
            {"p50", report.absorbed_objective.p50},
            {"p90", report.absorbed_objective.p90},
            {"max", report.absorbed_objective.max}}},
          {"components", report.components},
          {"knots", {0, 0, 0}},
          {"bytes", report.bytes},
          {"at_ceiling", report.at_ceiling},
          {"effective_sample_size", report.effective_sample_size},
          {"bias_bound", report.bias_bound},
          {"heard_paths", report.heard_paths},
          {"learning_cpu_seconds", report.learning_cpu_seconds},
          {"ribbons", report.ribbons},
          {"unusable", report.unusable},
          {"forms_made_anew", report.forms_made_anew}};
}

Json row_fields(const RowReport& report) {
  return {{"type", "row"},
          {"page", {{"lobe", report.slice.lobe}, {"parameters", report.slice.used_parameters()}}},
          {"node", report.node},
          {"state", state_name(report.state)},
          {"objective", report.objective < 0 ? Json(nullptr) : Json(report.objective)},
          {"count", report.count},
          {"components", report.components},
          {"knots", 0},
          {"failed_tests", report.failed_tests},
          {"ribbons", report.ribbons},
          {"light", report.light}};
}

/// One line of a report's fields and the host's, which can neither break the line nor replace a field of the report.
/// Bytes that are not UTF-8 become U+FFFD, and numbers that are not finite become null.
Result<std::string> line_of(Json line, const TelemetryWriter::Extra& extra, const std::string& file) {
  for (const auto& [name, text] : extra) {
    if (line.contains(name)) return Error{file, "/" + name, "a name that the report does not use", "\"" + name + "\""};
    int deepest = 0;
    const auto note_depth = [&](int depth, Json::parse_event_t, Json&) {
      deepest = std::max(deepest, depth);
      return true;
    };
    Json value = Json::parse(text, note_depth, false);
    if (value.is_discarded() || deepest > deepest_extra) {
      return Error{file, "/" + name, "JSON text nested at most " + std::to_string(deepest_extra) + " deep",
                   text.substr(0, 60)};
    }
    line[name] = std::move(value);
  }
  return to_text(line) + "\n";
}

}  // namespace

std::string to_json(const PassReport& report) { return to_text(pass_fields(report)); }

TelemetryWriter::TelemetryWriter(std::filesystem::path file, int descriptor)
    : file_(std::move(file)), descriptor_(descriptor) {}

TelemetryWriter::~TelemetryWriter() { ::close(descriptor_); }

Result<std::unique_ptr<TelemetryWriter>> TelemetryWriter::create(const std::filesystem::path& file) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, 0666);
  if (descriptor < 0) return Error{file.string(), "", "a file that can be written", std::strerror(errno)};
  return std::unique_ptr<TelemetryWriter>(new TelemetryWriter(file, descriptor));
}

Result<std::unique_ptr<TelemetryWriter>> TelemetryWriter::resume(const std::filesystem::path& file,
                                                                 std::uint64_t bytes) {
  const int descriptor = ::open(file.c_str(), O_RDWR | O_APPEND | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return Error{file.string(), "", "a file that goes on", std::strerror(errno)};
  std::unique_ptr<TelemetryWriter> writer(new TelemetryWriter(file, descriptor));
  struct stat status{};
  if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode))
    return Error{file.string(), "", "a file that goes on", "no regular file"};
  if (static_cast<std::uint64_t>(status.st_size) < bytes) {
    return Error{file.string(), "", "the " + std::to_string(bytes) + " bytes that were written",
                 std::to_string(status.st_size)};
  }
  const auto end = static_cast<off_t>(bytes);
  char last = '\n';
  if (bytes > 0 && (::pread(descriptor, &last, 1, end - 1) != 1 || last != '\n'))
    return Error{file.string(), "byte " + std::to_string(bytes), "the end of a line", "another place"};
  if (::ftruncate(descriptor, end) != 0)
    return Error{file.string(), "", "a file that can be cut", std::strerror(errno)};
  writer->bytes_ = bytes;
  return writer;
}

std::optional<Error> TelemetryWriter::write_line(const Result<std::string>& text) {
  if (!text) return text.error();
  const std::string& line = *text;
  // Without this check, a file could lack a line in the middle.
  if (failed_) return Error{file_.string(), "", "room for a line", "an earlier write that failed"};
  std::size_t written = 0;
  while (written < line.size()) {
    const ssize_t step = ::write(descriptor_, line.data() + written, line.size() - written);
    if (step < 0 && errno == EINTR) continue;
    if (step < 0) {
      const Error error{file_.string(), "", "room for a line", std::strerror(errno)};
      failed_ = true;
      take_back(written);
      return error;
    }
    written += static_cast<std::size_t>(step);
  }
  bytes_ += written;
  return std::nullopt;
}

void TelemetryWriter::take_back(std::size_t written) {
  struct stat status{};
  const off_t end = ::lseek(descriptor_, 0, SEEK_CUR);  // fails for pipes
  if (written == 0 || end < 0 || ::fstat(descriptor_, &status) != 0 || status.st_size != end) return;
  (void)!::ftruncate(descriptor_, end - static_cast<off_t>(written));
}

std::optional<Error> TelemetryWriter::header(const Extra& fields) {
  return write_line(line_of({{"type", "header"}, {"schema", telemetry_schema_version}}, fields, file_.string()));
}
std::optional<Error> TelemetryWriter::pass(const PassReport& report, const Extra& fields) {
  return write_line(line_of(pass_fields(report), fields, file_.string()));
}
std::optional<Error> TelemetryWriter::row(const RowReport& report, const Extra& fields) {
  return write_line(line_of(row_fields(report), fields, file_.string()));
}
std::optional<Error> TelemetryWriter::summary(const Extra& fields) {
  return write_line(line_of({{"type", "summary"}}, fields, file_.string()));
}

}  // namespace tress::inline v0_2::adaptive
