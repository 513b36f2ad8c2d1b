// What is behind tress_service: the targets, the service on them, and when it may be called.
#pragma once

#include <tbb/task_arena.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "capi/calls.h"
#include "tress/adaptive/service.h"

namespace tress::capi {

/// Shared by the handle and by all fibers on it.
struct Session {
  explicit Session(const tress_options& settings);

  /// Runs a call that must be the only one: refuses it if another such call runs, or if it comes from inside one of the
  /// session's callbacks. Parallel work inside it has the session's number of threads.
  template <class Call>
  Outcome alone(const char* name, Call&& call) {
    if (Outcome early = refused(name)) return early;
    if (is_busy.exchange(true)) return being_changed(name);
    struct End {
      Session& session;
      ~End() {
        session.epoch.fetch_add(1);  // events of before end here
        session.is_busy.store(false);
      }
    } const end{*this};
    return arena.execute([&]() -> Outcome { return call(); });
  }

  /// Why no reader may call now; empty if it may. Any thread.
  Outcome refuses_readers(const char* name) {
    if (is_busy.load(std::memory_order_acquire)) [[unlikely]]
      return being_changed(name);
    if (Outcome early = refused(name)) [[unlikely]]
      return early;
    if (!is_asked.load(std::memory_order_relaxed)) is_asked.store(true, std::memory_order_relaxed);
    return {};
  }

  ErrorListener listener;
  tbb::task_arena arena;
  std::shared_ptr<const adaptive::Target> densities;
  std::shared_ptr<const adaptive::SampledTarget> samples;  ///< a host's target may be both
  std::unique_ptr<adaptive::Service> service;
  bool is_for_fibers = false;
  std::string telemetry;
  std::atomic<bool> is_busy{false};
  std::atomic<bool> is_asked{false};          ///< whether there was a query: no cache may be loaded then
  std::atomic<bool> progress_ended{false};    ///< whether on_progress has ended the call that runs
  std::atomic<std::uint64_t> epoch{1};        ///< raised by every call that ends what readers have got
  static thread_local const Session* inside;  ///< whose target is being asked by this thread

 private:
  static Outcome being_changed(const char* name);
  Outcome refused(const char* name) const;
};

}  // namespace tress::capi

struct tress_service {
  std::shared_ptr<tress::capi::Session> session;
};
