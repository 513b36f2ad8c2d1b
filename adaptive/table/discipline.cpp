#include "table/discipline.h"

#include <utility>

namespace tress::inline v0_2::adaptive {

void Discipline::note(Error error) {
  const std::scoped_lock lock(mutex_);
  if (!first_) first_ = std::move(error);
}

std::optional<Error> Discipline::take() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(first_, std::nullopt);
}

std::optional<Error> Discipline::within_pass(const char* call) const {
  const Phase phase = phase_.load();
  if (phase == Phase::between) return std::nullopt;
  return Error{"", call, "a call between passes",
               phase == Phase::publishing ? "one inside publish()" : "one during a pass"};
}

bool Discipline::begin_reading(const char* call) {
  if (!checks_passes_) return true;
  Phase seen = Phase::between;
  phase_.compare_exchange_strong(seen, Phase::pass);
  if (seen != Phase::publishing) return true;
  note({"", call, "readers during a pass", "one inside publish()"});
  return false;
}

bool Discipline::begin_publish() {
  if (!checks_passes_) return true;
  const bool publishes = phase_.load() == Phase::publishing;
  if (publishes || readers_.load() != 0) {
    note({"", "publish", "no reader left", publishes ? "publish() itself" : "one in look_up"});
    return false;
  }
  phase_.store(Phase::publishing);
  return true;
}

}  // namespace tress::inline v0_2::adaptive
