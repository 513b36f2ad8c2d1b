#include "capi/calls.h"

#include <cstdio>

#include "tress/version.h"

namespace tress::capi {
namespace {

// Not a std::string: there is always room for a message, and nothing to destroy when a thread ends.
thread_local char last_message[1024] = "";

}  // namespace

tress_result fail(const ErrorListener* listener, tress_result result, const char* message) noexcept {
  std::snprintf(last_message, sizeof last_message, "%s", message);
  if (listener == nullptr || listener->call == nullptr) return result;
  try {
    listener->call(listener->user, result, last_message);
  } catch (...) {  // a host's mistake that may not cross the interface; the code and the message stay
  }
  return result;
}

}  // namespace tress::capi

extern "C" {

uint32_t tress_version() noexcept { return TRESS_VERSION; }

const char* tress_last_error() noexcept { return tress::capi::last_message; }

const char* tress_result_name(tress_result result) noexcept {
  switch (result) {
    case TRESS_OK:
      return "TRESS_OK";
    case TRESS_INVALID_ARGUMENT:
      return "TRESS_INVALID_ARGUMENT";
    case TRESS_INVALID_CALL:
      return "TRESS_INVALID_CALL";
    case TRESS_FILE_MISSING:
      return "TRESS_FILE_MISSING";
    case TRESS_FILE_INVALID:
      return "TRESS_FILE_INVALID";
    case TRESS_MISUSE:
      return "TRESS_MISUSE";
    case TRESS_CANCELLED:
      return "TRESS_CANCELLED";
    case TRESS_OUT_OF_MEMORY:
      return "TRESS_OUT_OF_MEMORY";
    case TRESS_INTERNAL:
      return "TRESS_INTERNAL";
  }
  return "unknown";
}
}
