// What every function of the C interface does: it turns errors and exceptions into codes and messages.
#pragma once

#include <cstddef>
#include <cstring>
#include <exception>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "tress/base/error.h"
#include "tress/tress.h"

namespace tress::capi {

/// The reason why a call does nothing.
struct Refusal {
  tress_result result;
  Error error;
};
using Outcome = std::optional<Refusal>;

inline Outcome invalid(const char* place, std::string expected, std::string found) {
  return Refusal{TRESS_INVALID_ARGUMENT, {"", place, std::move(expected), std::move(found)}};
}
inline Outcome null(const char* place) { return invalid(place, "a pointer", "null"); }

/// The listener that failures are passed to besides tress_last_error(): tress_options::on_error.
struct ErrorListener {
  void* user = nullptr;
  void (*call)(void* user, tress_result result, const char* message) = nullptr;
};

/// Keeps the message for tress_last_error() and passes it to the listener, which may be null. Returns `result`.
tress_result fail(const ErrorListener* listener, tress_result result, const char* message) noexcept;

/// Runs the body of a function, which returns an Outcome. Nothing that it throws gets out.
template <class Body>
tress_result guarded(const ErrorListener* listener, Body&& body) noexcept {
  try {
    const Outcome outcome = body();
    if (!outcome) [[likely]]
      return TRESS_OK;
    return fail(listener, outcome->result, outcome->error.message().c_str());
  } catch (const std::bad_alloc&) {
    return fail(listener, TRESS_OUT_OF_MEMORY, "expected memory, found none");
  } catch (const std::exception& thrown) {
    return fail(listener, TRESS_INTERNAL, thrown.what());
  } catch (...) {
    return fail(listener, TRESS_INTERNAL, "expected no exception, found one that is no std::exception");
  }
}

/// Runs a call for each item of a batch, and returns the first reason why one does nothing.
template <class One>
Outcome each(std::size_t count, One&& one) {
  Outcome first;
  for (std::size_t i = 0; i < count; ++i) {
    Outcome outcome = one(i);
    if (outcome && !first) [[unlikely]]
      first = std::move(outcome);
  }
  return first;
}

/// Sets what a call would write to zero.
template <class Item>
void clear(Item* items, std::size_t count) {
  if (items != nullptr) std::memset(items, 0, count * sizeof(Item));
}

}  // namespace tress::capi
