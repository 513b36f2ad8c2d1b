// The telemetry of a command. It never stops the work: the first error is logged, and nothing more is written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "cli/console.h"
#include "tress/adaptive/telemetry.h"

namespace tress::cli {

/// Makes text valid UTF-8: a path need not be, but a line of telemetry must.
template <class T>
std::string json_text(const T& value) {
  return nlohmann::json(value).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

class TelemetryLines {
 public:
  /// Without a file nothing is written. Error if the file cannot be opened.
  static Result<TelemetryLines> open(const std::optional<std::filesystem::path>& file) {
    if (!file) return TelemetryLines(nullptr);
    auto writer = adaptive::TelemetryWriter::create(*file);
    if (!writer) return writer.error();
    return TelemetryLines(std::move(*writer));
  }

  /// Continues after this many bytes of the file. If that is impossible it logs a warning and starts the file anew.
  static Result<TelemetryLines> resume(const std::optional<std::filesystem::path>& file, std::uint64_t bytes) {
    if (!file) return TelemetryLines(nullptr);
    auto writer = adaptive::TelemetryWriter::resume(*file, bytes);
    if (writer) return TelemetryLines(std::move(*writer));
    log_warning("telemetry is begun anew: " + writer.error().message());
    return open(file);
  }
  /// The size of the file so far.
  std::uint64_t bytes() const { return writer_ ? writer_->bytes() : 0; }

  /// line: takes the writer and returns its error.
  template <class Write>
  void write(Write&& line) {
    if (!writer_) return;
    if (const std::optional<Error> error = line(*writer_)) {
      log_warning("telemetry stops: " + error->message());
      writer_.reset();
      failed_ = true;
    }
  }
  bool wanted() const { return writer_ != nullptr; }
  bool failed() const { return failed_; }

 private:
  explicit TelemetryLines(std::unique_ptr<adaptive::TelemetryWriter> writer) : writer_(std::move(writer)) {}

  std::unique_ptr<adaptive::TelemetryWriter> writer_;
  bool failed_ = false;
};

}  // namespace tress::cli
