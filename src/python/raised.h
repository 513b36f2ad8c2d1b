// Turns the library's errors into exceptions of Python, and lets a signal end long work.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <exception>
#include <functional>
#include <optional>
#include <utility>

#include "tress/base/error.h"

namespace tress::python {

/// Thrown with or without the GIL. It becomes a tress.Error, whose text is Error::message() and which has the four
/// parts. It is a ValueError as well; or an OSError with errno and filename, where `found` is what the system says.
struct Raised : std::exception {
  enum class Kind { value, index, call };  ///< ValueError, IndexError, RuntimeError
  explicit Raised(Error what, Kind which = Kind::value) : error(std::move(what)), kind(which) {}
  Error error;
  Kind kind;
};

template <class T>
T checked(Result<T> result) {
  if (!result) throw Raised(result.error());
  return std::move(*result);
}
inline void check(const std::optional<Error>& error) {
  if (error) throw Raised(*error);
}

/// Makes tress.Error with its kinds, and the translation of Raised.
void bind_error(pybind11::module_& module);

/// Runs work on a thread of its own without the GIL. Meanwhile the calling thread waits, checks for signals (Ctrl-C),
/// and runs the questions that the work passes to ask().
class Worker {
 public:
  /// Set once the caller wants to stop: after a signal, or an exception of Python in ask(). Any thread.
  const std::atomic<bool>& stop() const { return stop_; }

  /// Called by the work: runs `question` on the calling thread with the GIL. False if it failed or a signal came; run()
  /// then throws the exception.
  bool ask(const std::function<bool()>& question);

  /// Call it with the GIL. It returns when `work` has ended, and throws what Python threw, or else what `work` threw.
  void run(const std::function<void()>& work);

 private:
  struct Shared;
  Shared* shared_ = nullptr;  ///< set while run() runs
  std::atomic<bool> stop_{false};
};

}  // namespace tress::python
