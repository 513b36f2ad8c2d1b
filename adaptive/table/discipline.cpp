// Checks of a host's calls: errors for calls at the wrong time and for nodes that do not exist.
#include <string>
#include <utility>

#include "table/table.h"

namespace tress::adaptive {

void Service::Table::note(Error error) const {
  const std::scoped_lock lock(misuse_mutex_);
  if (!misuse_) misuse_ = std::move(error);
}

std::optional<Error> Service::Table::within_pass(const char* call) const {
  if (!options_.check_passes || phase_.load() == Phase::between) return std::nullopt;
  const bool publishes = phase_.load() == Phase::publishing;
  return Error{"", call, "a call between passes", publishes ? "one inside publish()" : "one during a pass"};
}

Error Service::Table::no_such_slice(const char* call, SliceId slice) const {
  return {"", call, "a slice below " + std::to_string(slices_.size()), std::to_string(slice)};
}

bool Service::Table::is_misuse(const char* call, SliceId slice, std::uint32_t node) {
  if (slice >= slices_.size()) {
    note(no_such_slice(call, slice));
    return true;
  }
  if (const std::uint32_t count = slices_[slice]->description.node_count(); node >= count) {
    note({"", call, "a node below " + std::to_string(count) + " of slice " + std::to_string(slice),
          std::to_string(node)});
    return true;
  }
  if (!options_.check_passes) return false;
  Phase seen = Phase::between;
  phase_.compare_exchange_strong(seen, Phase::pass);
  if (seen != Phase::publishing) return false;
  note({"", call, "readers during a pass", "one inside publish()"});
  return true;
}

bool Service::Table::is_stale(const char* call, const RowView& row) {
  if (!options_.check_passes) return false;
  if (row.pass != pass_) {
    note({"", call, "a view of pass " + std::to_string(pass_), "one of pass " + std::to_string(row.pass)});
    return true;
  }
  return is_misuse(call, row.slice, row.node);
}

const TracedNodes& Service::Table::no_light() {
  static const TracedNodes none({}, 1);
  return none;
}

}  // namespace tress::adaptive
