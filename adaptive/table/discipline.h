// When a host may call what, and what it did wrong.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>

#include "tress/base/error.h"

namespace tress::inline v0_2::adaptive {

/// Keeps the first mistake of a host until it is reported and, if passes are checked, follows the phases of a pass.
/// Thread-safe.
class Discipline {
 public:
  /// checks_passes: Options::check_passes. If false, there are no phases, and every call comes at a right time.
  explicit Discipline(bool checks_passes) : checks_passes_(checks_passes) {}

  /// Keeps the error, unless there is one already.
  void note(Error error);
  /// Returns the first error since the last call.
  std::optional<Error> take();

  /// The error of a call that is allowed only between passes; empty between passes.
  std::optional<Error> within_pass(const char* call) const;
  /// Begins a pass, unless one runs. If publish() runs, notes it as a mistake of this reader and returns false.
  bool begin_reading(const char* call);
  /// Begins publish(). Returns false, and notes a mistake, if publish() or a reader runs. Otherwise call end_publish().
  bool begin_publish();
  void end_publish() { phase_.store(Phase::between); }

  /// Counts a reader while it is inside a call.
  class Reader {
   public:
    explicit Reader(Discipline& discipline) : readers_(discipline.checks_passes_ ? &discipline.readers_ : nullptr) {
      if (readers_ != nullptr) readers_->fetch_add(1);
    }
    ~Reader() {
      if (readers_ != nullptr) readers_->fetch_sub(1);
    }
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;

   private:
    std::atomic<std::uint32_t>* readers_;
  };

 private:
  enum class Phase : std::uint8_t { between, pass, publishing };

  const bool checks_passes_;
  std::mutex mutex_;  ///< guards first_
  std::optional<Error> first_;
  std::atomic<Phase> phase_{Phase::between};
  std::atomic<std::uint32_t> readers_{0};
};

}  // namespace tress::inline v0_2::adaptive
