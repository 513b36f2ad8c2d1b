#include "capi/calls.h"

#include <cstddef>
#include <cstdio>
#include <iterator>

#include "tress/version.h"

namespace tress::capi {
namespace {

// Not a std::string: there is always room for a message, and nothing to destroy when a thread ends.
thread_local char last_message[1024] = "";
thread_local bool is_listening = false;  ///< whether a listener of this thread is being called

}  // namespace

tress_result fail(const ErrorListener* listener, tress_result result, const char* message) noexcept {
  std::snprintf(last_message, sizeof last_message, "%s", message);
  if (listener == nullptr || listener->call == nullptr || is_listening) return result;
  is_listening = true;
  try {
    listener->call(listener->user, result, last_message);
  } catch (...) {  // a host's mistake that may not cross the interface; the code and the message stay
  }
  is_listening = false;
  return result;
}

}  // namespace tress::capi

extern "C" {

uint32_t tress_version() noexcept { return TRESS_VERSION; }

const char* tress_last_error() noexcept { return tress::capi::last_message; }

const char* tress_result_name(tress_result result) noexcept {
  static constexpr const char* names[] = {"TRESS_OK",           "TRESS_INVALID_ARGUMENT", "TRESS_INVALID_CALL",
                                          "TRESS_FILE_MISSING", "TRESS_FILE_INVALID",     "TRESS_MISUSE",
                                          "TRESS_CANCELLED",    "TRESS_OUT_OF_MEMORY",    "TRESS_INTERNAL"};
  const auto index = static_cast<std::size_t>(result);
  return index < std::size(names) ? names[index] : "unknown";
}
}
