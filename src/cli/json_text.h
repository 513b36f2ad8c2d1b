// Values as the JSON texts that telemetry takes.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace tress::cli {

/// A path need not be UTF-8; a line of telemetry must be.
template <class T>
std::string json_text(const T& value) {
  return nlohmann::json(value).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace tress::cli
