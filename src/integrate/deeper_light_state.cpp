#include <cmath>
#include <cstring>
#include <utility>

#include "integrate/deeper_light.h"

namespace tress::integrate {
namespace {

struct Head {
  std::uint64_t nodes, paths_before, noted;
  double unit;
  float scale;
  std::uint32_t ready;
};

template <class Value>
void append(std::string& to, const Value* values, std::size_t count) {
  to.append(reinterpret_cast<const char*>(values), count * sizeof(Value));
}

template <class Value>
void take(std::string_view& from, Value* values, std::size_t count) {
  if (count == 0) return;
  std::memcpy(static_cast<void*>(values), from.data(), count * sizeof(Value));
  from.remove_prefix(count * sizeof(Value));
}

}  // namespace

std::string DeeperLight::state() const {
  const std::size_t count = nodes_.size();
  const Head head{count, paths_before_, noted_, unit_, scale_, ready_ ? 1u : 0u};
  std::string state;
  append(state, &head, 1);
  append(state, nodes_.data(), count);
  append(state, first_child_.data(), count);
  append(state, answers_.data(), count);
  for (std::size_t node = 0; node < count; ++node) {
    for (const Notes& notes : notes_[node]) {
      const std::array<std::uint64_t, 3> values{notes.count_and_hits, notes.light, notes.squares};
      append(state, values.data(), values.size());
    }
  }
  append(state, colors_.data(), colors_.size());
  for (std::size_t place = 0; place < colors_.size(); ++place) {
    const ColorNotes& notes = color_notes_[place];
    const std::array<std::uint64_t, 7> values{notes.light[0],  notes.light[1],  notes.light[2], notes.weight[0],
                                              notes.weight[1], notes.weight[2], notes.count};
    append(state, values.data(), values.size());
  }
  return state;
}

bool DeeperLight::set_state(std::string_view state) {
  Head head{};
  if (state.size() < sizeof(head)) return false;
  take(state, &head, 1);
  const std::size_t color_bytes = answers() ? directions * (sizeof(Color) + 7 * sizeof(std::uint64_t)) : 0;
  const std::size_t per_node = sizeof(Node) + sizeof(std::uint32_t) + sizeof(std::array<Answer, directions>) +
                               directions * 3 * sizeof(std::uint64_t) + color_bytes;
  if (head.nodes < 1 || head.nodes > most_nodes || state.size() != head.nodes * per_node) return false;
  const std::size_t count = head.nodes;
  std::vector<Node> nodes(count);
  std::vector<std::uint32_t> first_child(count);
  std::vector<std::array<Answer, directions>> of_directions(count);
  take(state, nodes.data(), count);
  take(state, first_child.data(), count);
  take(state, of_directions.data(), count);
  for (std::size_t node = 0; node < count; ++node) {
    if (node > 0 && nodes[node].parent >= node) return false;
    if (first_child[node] != 0 && (first_child[node] <= node || first_child[node] + 8u > count)) return false;
  }
  const bool known = head.unit > 0 && std::isfinite(head.unit);
  nodes_ = std::move(nodes);
  first_child_ = std::move(first_child);
  answers_ = std::move(of_directions);
  if (answers()) colors_.resize(count * directions);
  room_ = 0;
  make_room();
  for (std::size_t node = 0; node < count; ++node) {
    for (Notes& notes : notes_[node]) {
      std::array<std::uint64_t, 3> values{};
      take(state, values.data(), values.size());
      notes.count_and_hits = values[0];
      notes.light = values[1];
      notes.squares = values[2];
    }
  }
  take(state, colors_.data(), colors_.size());
  for (std::size_t place = 0; place < colors_.size(); ++place) {
    std::array<std::uint64_t, 7> values{};
    take(state, values.data(), values.size());
    for (std::size_t c = 0; c < 3; ++c) {
      color_notes_[place].light[c] = values[c];
      color_notes_[place].weight[c] = values[3 + c];
    }
    color_notes_[place].count = values[6];
  }
  paths_before_ = head.paths_before;
  noted_ = head.noted;
  unit_ = known ? head.unit : 0;
  per_unit_ = known ? static_cast<float>(1 / unit_) : 0;
  scale_ = std::isfinite(head.scale) ? head.scale : 0;
  ready_ = known && head.ready != 0 && scale_ > 0;
  can_answer_ = ready_ && asked() >= least_answered;
  return true;
}

}  // namespace tress::integrate
