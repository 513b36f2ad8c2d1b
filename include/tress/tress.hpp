// tress.h for C++17: handles that release themselves, targets as classes. It depends on nothing but tress.h, throws
// nothing, and may be used beside the C++20 headers. tress.h has units, ranges, errors and thread-safety.
//
//   Service service = Service::for_fibers();
//   Fibers fibers(service, TRESS_ROUGH);
//   if (!fibers) return tress_last_error();
//   std::uint32_t id = 0;
//   if (Status added = fibers.add(Fiber(), &id); !added) return added.message();
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tress/tress.h"

namespace tress::c {
inline namespace v0_2 {  // two releases in one program are two sets of classes

/// The result of a call: true if it did what was asked.
class [[nodiscard]] Status {
 public:
  Status(tress_result code) noexcept : code_(code) {}
  explicit operator bool() const noexcept { return code_ == TRESS_OK; }
  tress_result code() const noexcept { return code_; }
  /// Returns why the call failed. Valid until this thread's next failure.
  const char* message() const noexcept { return code_ == TRESS_OK ? "" : tress_last_error(); }

 private:
  tress_result code_;
};

// The structures of tress.h, with their defaults.
struct Options : tress_options {
  Options() noexcept { tress_options_init(this); }
};
struct Slice : tress_slice {
  Slice() noexcept { tress_slice_init(this); }
};
struct Fiber : tress_fiber {
  Fiber() noexcept { tress_fiber_init(this); }
};

/// What is to be learned. Override trace(), or draw() and parts(), or all; both are pure and called from any thread.
/// One that throws counts as one that failed (TRESS_MISUSE). It outlives its service.
class Target {
 public:
  virtual ~Target() = default;
  virtual std::string name() const = 0;
  virtual bool traces() const { return parts() == 0; }
  virtual std::uint32_t parts() const { return 0; }
  virtual void trace(const tress_place& /*place*/, std::vector<tress_ray>& /*out*/) const {}
  virtual void draw(const tress_place& /*place*/, std::uint64_t /*stream*/, std::uint32_t /*first*/,
                    std::uint32_t /*count*/, std::vector<tress_exit>& /*out*/) const {}

 private:
  friend class Service;
  template <class Item, class Call, class Add, class List>
  static int asked(const Call& call, const Add& add, List* list) noexcept {
#ifdef __cpp_exceptions
    try {
#endif
      std::vector<Item> found;
      call(found);
      add(list, found.data(), found.size());
      return 1;
#ifdef __cpp_exceptions
    } catch (...) {
      return 0;
    }
#endif
  }
  static int trace_of(void* self, const tress_place* place, tress_rays* list) {
    return asked<tress_ray>([&](auto& out) { static_cast<const Target*>(self)->trace(*place, out); }, tress_add_rays,
                            list);
  }
  static int draw_of(void* self, const tress_place* place, std::uint64_t stream, std::uint32_t first,
                     std::uint32_t count, tress_exits* list) {
    return asked<tress_exit>(
        [&](auto& out) { static_cast<const Target*>(self)->draw(*place, stream, first, count, out); }, tress_add_exits,
        list);
  }
};

/// A tress_service. False if it could not be created; every call then fails. Values of a call that failed are 0.
class Service {
 public:
  Service() = default;
  explicit Service(const Target& target, const Options& options = {}) {
    const std::string name = target.name();
    tress_target of{};
    of.name = name.c_str();
    of.user = const_cast<Target*>(&target);
    of.trace = target.traces() ? Target::trace_of : nullptr;
    of.draw = target.parts() > 0 ? Target::draw_of : nullptr;
    of.parts = target.parts();
    tress_service* made = nullptr;
    tress_service_create(&of, &options, &made);
    handle_.reset(made);
  }
  static Service for_fibers(const Options& options = {}) noexcept {
    Service service;
    tress_service* made = nullptr;
    tress_service_create_for_fibers(&options, &made);
    service.handle_.reset(made);
    return service;
  }
  explicit operator bool() const noexcept { return handle_ != nullptr; }
  tress_service* handle() const noexcept { return handle_.get(); }

  Status add_slice(const Slice& slice, std::uint32_t* id) noexcept {
    return tress_service_add_slice(handle(), &slice, id);
  }
  Status load(const std::string& path) noexcept { return tress_service_load(handle(), path.c_str()); }
  Status save(const std::string& path) noexcept { return tress_service_save(handle(), path.c_str()); }
  Status prepare() noexcept { return tress_service_prepare(handle()); }
  Status set_learning(bool on) noexcept { return tress_service_set_learning(handle(), on ? 1 : 0); }
  Status publish(std::uint64_t paths = 0, tress_report* report = nullptr) noexcept {
    return tress_service_publish(handle(), paths, report);
  }
  bool publish_pays() const noexcept { return tress_service_publish_pays(handle()) != 0; }
  const char* telemetry() const noexcept { return tress_service_telemetry(handle()); }

  tress_value sample(const tress_node& node, const std::array<float, 3>& u) const noexcept {
    tress_value value;
    tress_service_sample(handle(), node, u.data(), &value);
    return value;
  }
  tress_value evaluate(const tress_node& node, float azimuth, float height = 0) const noexcept {
    tress_value value;
    tress_service_evaluate(handle(), node, azimuth, height, &value);
    return value;
  }
  float pdf(const tress_node& node, float azimuth, float height = 0) const noexcept {
    float pdf = 0;
    tress_service_pdf(handle(), node, azimuth, height, &pdf);
    return pdf;
  }
  tress_node choose(std::uint32_t slice, float a, float b, const std::array<float, 2>& xi) const noexcept {
    tress_node node;
    tress_service_choose(handle(), slice, a, b, xi.data(), &node);
    return node;
  }
  tress_value mean(std::uint32_t slice, float a, float b, float azimuth, float height = 0) const noexcept {
    tress_value value;
    tress_service_mean(handle(), slice, a, b, azimuth, height, &value);
    return value;
  }
  tress_value sample_mean(std::uint32_t slice, float a, float b, const std::array<float, 5>& u) const noexcept {
    tress_value value;
    tress_service_sample_mean(handle(), slice, a, b, u.data(), &value);
    return value;
  }
  Status credit(const tress_node& node, float light, std::uint32_t events = 1) const noexcept {
    return tress_service_credit(handle(), node, light, events);
  }
  Status hear(const tress_node& node, const tress_exit& exit) const noexcept {
    return tress_service_hear(handle(), node, &exit);
  }

 private:
  struct Release {
    void operator()(tress_service* service) const noexcept { tress_service_release(service); }
  };
  std::unique_ptr<tress_service, Release> handle_;
};

/// A tress_fibers. False if it could not be created; every call then fails. Values of a call that failed are 0.
class Fibers {
 public:
  Fibers() = default;
  /// service: one of Service::for_fibers(); with TRESS_EXACT, it may be empty.
  Fibers(const Service& service, std::uint32_t model, std::uint32_t estimator = TRESS_FITTED) noexcept {
    tress_fibers* made = nullptr;
    tress_fibers_create(service.handle(), model, estimator, &made);
    handle_.reset(made);
  }
  explicit operator bool() const noexcept { return handle_ != nullptr; }
  tress_fibers* handle() const noexcept { return handle_.get(); }

  Status add(const Fiber& fiber, std::uint32_t* id) noexcept { return tress_fibers_add(handle(), &fiber, id); }
  std::size_t bytes() const noexcept { return tress_fibers_bytes(handle()); }

  tress_event begin(std::uint32_t fiber, const tress_direction& wr, float xi1, float xi2, float h,
                    float importance = 1) const noexcept {
    tress_event event;
    tress_fibers_begin(handle(), fiber, wr, xi1, xi2, h, importance, &event);
    return event;
  }
  tress_fiber_sample sample(const tress_event& event, const std::array<float, 4>& u) const noexcept {
    tress_fiber_sample sample;
    tress_fibers_sample(handle(), &event, u.data(), &sample);
    return sample;
  }
  tress_fiber_value evaluate(const tress_event& event, const tress_direction& wi) const noexcept {
    tress_fiber_value value;
    tress_fibers_evaluate(handle(), &event, wi, &value);
    return value;
  }
  tress_fiber_value mean(std::uint32_t fiber, const tress_direction& wr, const tress_direction& wi) const noexcept {
    tress_fiber_value value;
    tress_fibers_mean(handle(), fiber, wr, wi, &value);
    return value;
  }
  tress_fiber_sample sample_mean(std::uint32_t fiber, const tress_direction& wr, const std::array<float, 6>& u,
                                 float importance = 1) const noexcept {
    tress_fiber_sample sample;
    tress_fibers_sample_mean(handle(), fiber, wr, u.data(), importance, &sample);
    return sample;
  }
  float pdf(const tress_event& event, const tress_direction& wi) const noexcept {
    float pdf = 0;
    tress_fibers_pdf(handle(), &event, wi, &pdf);
    return pdf;
  }
  /// s and weights have as many numbers as sigma_a. Returns the pdf.
  float evaluate_spectrum(const tress_event& event, const tress_direction& wi, const float* sigma_a,
                          std::size_t channels, float* s) const noexcept {
    float pdf = 0;
    tress_fibers_evaluate_spectrum(handle(), &event, wi, sigma_a, channels, s, &pdf);
    return pdf;
  }
  tress_fiber_sample sample_spectrum(const tress_event& event, const std::array<float, 4>& u, const float* sigma_a,
                                     std::size_t channels, float* weights) const noexcept {
    tress_fiber_sample sample;
    tress_fibers_sample_spectrum(handle(), &event, u.data(), sigma_a, channels, &sample, weights);
    return sample;
  }
  bool takes_lights(const tress_event& event) const noexcept {
    return tress_fibers_takes_lights(handle(), &event) != 0;
  }

 private:
  struct Release {
    void operator()(tress_fibers* fibers) const noexcept { tress_fibers_release(fibers); }
  };
  std::unique_ptr<tress_fibers, Release> handle_;
};

}  // namespace v0_2
}  // namespace tress::c
