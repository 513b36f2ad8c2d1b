#include "integrate/deeper_light.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <limits>
#include <utility>

#include "scene/model/groom_bounds.h"

namespace tress::integrate {
namespace {

constexpr double fixed_point = 1 << 20;
constexpr double most_light = 1 << 10;  ///< bound of the noted light of one copy, in the unit
constexpr int hit_bits = 36;
constexpr std::uint64_t most_noted_hits = 1 << 20;  ///< bound of the noted hits of one copy
/// Factor on the number of copies that the rule gives. Few paths have often not met the brightest light yet, and too
/// few copies cost more than too many (bench/README.md, what lies deeper).
constexpr double more_copies = 1.5;
/// Least variance of a sample over the squared mean. Below it, a picture has almost no noise except rounding.
constexpr double least_variance = 1e-4;
const glm::dvec3 least_weight(1e-12);  ///< prevents 0 over 0
constexpr int first_levels = 2;        ///< initial levels of the octree below its root

std::int64_t to_fixed(double value) { return static_cast<std::int64_t>(std::nearbyint(value * fixed_point)); }

/// The class of a direction, 0..23: by the axis that it is nearest to, then by the signs along the others.
int direction_class(const glm::vec3& direction) {
  const glm::vec3 size = glm::abs(direction);
  const int axis = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
  const auto sign = [&](int at) { return direction[at % 3] < 0 ? 1 : 0; };
  return ((axis * 2 + sign(axis)) * 2 + sign(axis + 1)) * 2 + sign(axis + 2);
}

}  // namespace

DeeperLight::DeeperLight(const scene::Scene& scene, bool answers) {
  glm::vec3 low(std::numeric_limits<float>::max()), high(-std::numeric_limits<float>::max());
  const auto include_point = [&](const glm::vec3& point) {
    low = glm::min(low, point);
    high = glm::max(high, point);
  };
  const auto include = [&](const std::vector<glm::vec3>& points) { std::ranges::for_each(points, include_point); };
  for (const scene::Groom& groom : scene.grooms) scene::for_each_bounding_point(groom, include_point);
  for (const scene::Mesh& mesh : scene.meshes) {
    include(mesh.positions);
    for (const scene::MeshMoment& moment : mesh.later) include(moment.positions);
  }
  const float edge = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
  low_ = low;
  per_edge_ = edge > 0 ? 1 / edge : 0;
  nodes_.resize(1);
  first_child_.resize(1);
  if (answers) colors_.resize(directions);
  std::size_t from = 0;
  for (int level = 0; level < first_levels; ++level) {
    const std::size_t to = nodes_.size();
    for (; from < to; ++from) add_children(static_cast<std::uint32_t>(from));
  }
  refine();
}

std::size_t DeeperLight::place(const glm::vec3& point, const glm::vec3& direction) const {
  glm::vec3 at = (point - low_) * per_edge_;
  std::uint32_t node = 0;
  while (first_child_[node] != 0) {
    std::uint32_t child = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const bool upper = at[axis] >= 0.5f;
      child = child * 2 + (upper ? 1 : 0);
      at[axis] = 2 * at[axis] - (upper ? 1.0f : 0.0f);
    }
    node = first_child_[node] + child;
  }
  return node * std::size_t{directions} + static_cast<std::size_t>(direction_class(direction));
}

float DeeperLight::copies(std::size_t place, const glm::vec3& throughput) const {
  const Answer& answer = answers_[place / directions][place % directions];
  const float square = throughput.x * throughput.x + throughput.y * throughput.y + throughput.z * throughput.z;
  const float worth = scale_ * std::sqrt(square / 3);
  float copies = worth * answer.of_square;
  if (copies > 1) copies = std::max(1.0f, worth * answer.of_variance);
  return copies > least_copies ? std::min(copies, most_copies) : least_copies;
}

void DeeperLight::note(std::size_t place, const glm::vec3& light, std::uint64_t hits) const {
  if (!(per_unit_ > 0)) return;
  const glm::dvec3 relative = glm::dvec3(light) * static_cast<double>(per_unit_);
  const double mean = (relative.x + relative.y + relative.z) / 3;
  const double square = (relative.x * relative.x + relative.y * relative.y + relative.z * relative.z) / 3;
  if (!std::isfinite(square)) return;
  Notes& notes = notes_[place / directions][place % directions];
  // The sums are of unsigned integers, which wrap, so they have the bits of sums of signed integers.
  const std::uint64_t count_and_hits = std::uint64_t{1} << hit_bits | std::min(hits, most_noted_hits);
  notes.count_and_hits.fetch_add(count_and_hits, std::memory_order_relaxed);
  notes.light.fetch_add(static_cast<std::uint64_t>(to_fixed(std::clamp(mean, -most_light, most_light))),
                        std::memory_order_relaxed);
  notes.squares.fetch_add(static_cast<std::uint64_t>(to_fixed(std::min(square, most_light * most_light))),
                          std::memory_order_relaxed);
}

void DeeperLight::note_for_answers(std::size_t place, const glm::vec3& light, const glm::vec3& weight) const {
  if (!(per_unit_ > 0)) return;
  ColorNotes& notes = color_notes_[place];
  for (int c = 0; c < 3; ++c) {
    const double worth = std::clamp(static_cast<double>(weight[c]), 0.0, most_light);
    const double relative = static_cast<double>(light[c]) * static_cast<double>(per_unit_);
    if (!std::isfinite(relative) || !std::isfinite(worth)) continue;
    const auto at = static_cast<std::size_t>(c);
    const std::int64_t fixed = to_fixed(worth * std::clamp(relative, -most_light, most_light));
    notes.light[at].fetch_add(static_cast<std::uint64_t>(fixed), std::memory_order_relaxed);
    notes.weight[at].fetch_add(static_cast<std::uint64_t>(to_fixed(worth)), std::memory_order_relaxed);
  }
  notes.count.fetch_add(1, std::memory_order_relaxed);
}

glm::vec3 DeeperLight::answer(std::size_t place) const { return glm::vec3(colors_[place].expected * unit_); }

void DeeperLight::update(const PictureSoFar& picture, std::uint64_t paths) {
  paths_before_ = paths;
  if (unit_ > 0) {
    gather();
    expect();
    refine();
    const bool known = picture.variance > least_variance * picture.mean * picture.mean &&
                       std::isfinite(picture.variance) && picture.hits > 0;
    scale_ = known ? static_cast<float>(more_copies * unit_ * std::sqrt(picture.hits / picture.variance)) : 0.0f;
    ready_ = static_cast<double>(noted_) >= least_notes && scale_ > 0 && std::isfinite(scale_);
    can_answer_ = ready_ && asked() >= least_answered;
  } else if (picture.mean > 0 && std::isfinite(picture.mean)) {
    const auto per_unit = static_cast<float>(1 / picture.mean);
    if (!(per_unit > 0) || !std::isfinite(per_unit)) return;
    unit_ = picture.mean;
    per_unit_ = per_unit;
  }
}

DeeperLight::Sums DeeperLight::taken(Notes& notes) {
  const std::uint64_t count_and_hits = notes.count_and_hits.exchange(0, std::memory_order_relaxed);
  if (count_and_hits == 0) return {};
  const auto light = static_cast<std::int64_t>(notes.light.exchange(0, std::memory_order_relaxed));
  const std::uint64_t squares = notes.squares.exchange(0, std::memory_order_relaxed);
  return {static_cast<double>(count_and_hits >> hit_bits), static_cast<double>(light) / fixed_point,
          static_cast<double>(squares) / fixed_point,
          static_cast<double>(count_and_hits & ((std::uint64_t{1} << hit_bits) - 1))};
}

DeeperLight::ColorSums DeeperLight::ColorNotes::taken() {
  ColorSums sums;
  const auto take = [](std::atomic<std::uint64_t>& sum) {
    return static_cast<double>(static_cast<std::int64_t>(sum.exchange(0, std::memory_order_relaxed))) / fixed_point;
  };
  for (int c = 0; c < 3; ++c) {
    sums.light[c] = take(light[static_cast<std::size_t>(c)]);
    sums.weight[c] = take(weight[static_cast<std::size_t>(c)]);
  }
  sums.count = static_cast<double>(count.exchange(0, std::memory_order_relaxed));
  return sums;
}

/// Notes belong to leaves. The sums of a node include all notes within it, also those from before it had children.
void DeeperLight::gather() {
  for (std::size_t node = 0; node < nodes_.size(); ++node) {
    if (first_child_[node] != 0) continue;
    for (std::size_t direction = 0; direction < directions; ++direction) {
      const Sums more = taken(notes_[node][direction]);
      if (!(more.count > 0)) continue;
      noted_ += static_cast<std::uint64_t>(more.count);
      const ColorSums color = answers() ? color_notes_[node * directions + direction].taken() : ColorSums{};
      for (std::size_t up = node;; up = nodes_[up].parent) {
        Sums& sums = nodes_[up].sums[direction];
        sums.count += more.count;
        sums.light += more.light;
        sums.squares += more.squares;
        sums.hits += more.hits;
        if (answers()) colors_[up * directions + direction].sums.add(color);
        if (up == 0) break;
      }
    }
  }
}

/// The prior of a direction is the mean over all directions at the root, and the parent's direction at other nodes.
void DeeperLight::expect() {
  if (noted_ == 0) return;
  Sums all;
  for (const Sums& sums : nodes_[0].sums) {
    all.count += sums.count;
    all.light += sums.light;
    all.squares += sums.squares;
    all.hits += sums.hits;
  }
  all = {1, all.light / all.count, all.squares / all.count, all.hits / all.count};
  ColorSums all_colors;
  for (std::size_t direction = 0; answers() && direction < directions; ++direction)
    all_colors.add(colors_[direction].sums);
  // The weight of answer_prior mean paths.
  const glm::dvec3 prior_weight = answer_prior / std::max(all_colors.count, 1.0) * all_colors.weight;
  for (std::size_t node = 0; node < nodes_.size(); ++node) {
    for (std::size_t direction = 0; direction < directions; ++direction) {
      const Sums& own = nodes_[node].sums[direction];
      const Sums& around = node == 0 ? all : nodes_[nodes_[node].parent].expected[direction];
      const double per = 1 / (own.count + prior);
      const Sums expected{1, (own.light + prior * around.light) * per, (own.squares + prior * around.squares) * per,
                          std::max(1.0, (own.hits + prior * around.hits) * per)};
      nodes_[node].expected[direction] = expected;
      const double variance = std::max(0.0, expected.squares - expected.light * expected.light);
      answers_[node][direction] = {static_cast<float>(std::sqrt(expected.squares / expected.hits)),
                                   static_cast<float>(std::sqrt(variance / expected.hits))};
      if (!answers()) continue;
      Color& color = colors_[node * directions + direction];
      // Few paths are met where answers are used, so the ratio to the cell around comes from all notes.
      const double shape = around.light > 0 ? std::clamp(expected.light / around.light, 0.25, 4.0) : 1;
      const glm::dvec3 around_color =
          shape * (node == 0 ? all_colors.light / glm::max(all_colors.weight, least_weight)
                             : colors_[nodes_[node].parent * directions + direction].expected);
      color.expected =
          (color.sums.light + prior_weight * around_color) / glm::max(color.sums.weight + prior_weight, least_weight);
    }
  }
}

double DeeperLight::asked() const {
  double count = 0;
  for (std::size_t direction = 0; answers() && direction < directions; ++direction)
    count += colors_[direction].sums.count;
  return count;
}

void DeeperLight::add_children(std::uint32_t node) {
  first_child_[node] = static_cast<std::uint32_t>(nodes_.size());
  first_child_.resize(first_child_.size() + 8);
  for (int child = 0; child < 8; ++child) {
    nodes_.emplace_back();
    nodes_.back().parent = node;
    nodes_.back().expected = nodes_[node].expected;
    if (!answers()) continue;
    for (std::size_t direction = 0; direction < directions; ++direction) {
      const glm::dvec3 expected = colors_[node * directions + direction].expected;
      colors_.push_back({{}, expected});
    }
  }
}

/// Gives children to leaves that are met often. The children start with the estimates of their parent.
void DeeperLight::refine() {
  const std::size_t old = nodes_.size();
  for (std::size_t node = 0; node < old && nodes_.size() + 8 <= most_nodes; ++node) {
    if (first_child_[node] != 0) continue;
    double count = 0;
    for (const Sums& sums : nodes_[node].sums) count += sums.count;
    if (count >= refine_from) add_children(static_cast<std::uint32_t>(node));
  }
  answers_.resize(nodes_.size());
  for (std::size_t node = old; node < nodes_.size(); ++node) answers_[node] = answers_[nodes_[node].parent];
  make_room();
}

void DeeperLight::make_room() {
  if (nodes_.size() <= room_) return;
  room_ = std::min(most_nodes, 2 * nodes_.size());
  notes_ = std::make_unique<std::array<Notes, directions>[]>(room_);  // gather() has taken the old notes
  if (answers()) color_notes_ = std::make_unique<ColorNotes[]>(room_ * directions);
}

std::size_t DeeperLight::bytes() const {
  const std::size_t colors = colors_.size() * (sizeof(Color) + sizeof(ColorNotes));
  return colors + nodes_.size() * (sizeof(Node) + sizeof(first_child_[0]) + sizeof(answers_[0]) + sizeof(notes_[0]));
}

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
