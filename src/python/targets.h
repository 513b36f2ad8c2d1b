// Targets of the learning service that are Python objects.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>
#include <string>
#include <vector>

#include "tress/adaptive/sampled_target.h"
#include "tress/adaptive/target.h"

namespace tress::python {

/// The common part of the calls of a target: the GIL, and the exceptions. Any thread, with or without the GIL.
class Calls {
 public:
  explicit Calls(pybind11::object target) : target_(std::move(target)) {}

  /// Calls `method` with the GIL and passes its result to `take`. The first exception is kept; after one, or once
  /// `stop` is set, nothing more is called.
  template <class Take, class... Arguments>
  void call(const char* method, const Take& take, const Arguments&... arguments) const {
    const std::atomic<bool>* stop = stop_;
    if (failed_ || (stop != nullptr && *stop)) return cancel();
    const pybind11::gil_scoped_acquire gil;
    const Inside inside;
    try {
      take(target_.attr(method)(arguments...));
    } catch (...) {
      keep(std::current_exception());
    }
  }

  /// Whether this thread is in a call of a target.
  static bool is_inside() { return depth > 0; }

  bool failed() const { return failed_; }
  /// The exception, once; null after that, and if calls were cancelled.
  std::exception_ptr take_failure();
  void set_stop(const std::atomic<bool>* stop) { stop_ = stop; }
  const pybind11::object& target() const { return target_; }

  /// Marks this thread as being in a call that may not call the service.
  struct Inside {
    Inside() { ++depth; }
    ~Inside() { --depth; }
  };

 private:
  void keep(std::exception_ptr raised) const;
  void cancel() const { failed_ = true; }

  static thread_local int depth;
  pybind11::object target_;
  std::atomic<const std::atomic<bool>*> stop_{nullptr};
  mutable std::atomic<bool> failed_{false};
  mutable std::mutex mutex_;
  mutable std::exception_ptr raised_;
};

/// The object's trace(slice, a, b) returns azimuths and weights, and optionally attributes.
class PythonTarget final : public adaptive::Target {
 public:
  PythonTarget(const Calls& calls, std::string name) : calls_(calls), name_(std::move(name)) {}
  void trace(const adaptive::SliceDescription& slice, float a, float b,
             std::vector<adaptive::TracedRay>& out) const override;
  std::string model_name() const override { return name_; }

 private:
  const Calls& calls_;
  std::string name_;
};

/// The object's draw(slice, a, b, stream, first, count) returns azimuths, heights, parts, weights, and optionally
/// attributes.
class PythonSamples final : public adaptive::SampledTarget {
 public:
  PythonSamples(const Calls& calls, std::string name, std::uint32_t parts)
      : calls_(calls), name_(std::move(name)), parts_(parts) {}
  std::uint32_t parts(const adaptive::SliceDescription&) const override { return parts_; }
  void draw(const adaptive::SliceDescription& slice, float a, float b, std::uint64_t stream, std::uint32_t first,
            std::uint32_t count, std::vector<adaptive::SampledExit>& out) const override;
  std::string model_name() const override { return name_; }

 private:
  const Calls& calls_;
  std::string name_;
  std::uint32_t parts_;
};

}  // namespace tress::python
