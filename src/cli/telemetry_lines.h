// Telemetry of a command: it never stops the work, the first error is told, then it is silent.
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

/// A path need not be UTF-8; a line of telemetry must be.
template <class T>
std::string json_text(const T& value) {
  return nlohmann::json(value).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

class TelemetryLines {
 public:
  /// Without a file nothing is written. Error if the file cannot be.
  static Result<TelemetryLines> open(const std::optional<std::filesystem::path>& file) {
    if (!file) return TelemetryLines(nullptr);
    auto writer = adaptive::TelemetryWriter::create(*file);
    if (!writer) return writer.error();
    return TelemetryLines(std::move(*writer));
  }

  /// Goes on behind so many bytes of the file. Where that cannot be, it is told and the file begun anew.
  static Result<TelemetryLines> resume(const std::optional<std::filesystem::path>& file, std::uint64_t bytes) {
    if (!file) return TelemetryLines(nullptr);
    auto writer = adaptive::TelemetryWriter::resume(*file, bytes);
    if (writer) return TelemetryLines(std::move(*writer));
    log_warning("telemetry is begun anew: " + writer.error().message());
    return open(file);
  }
  /// Of the file so far.
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
