#include "models/elliptical/colored_rows.h"

#include <array>
#include <cassert>
#include <numbers>
#include <utility>

#include "fiber/elliptical_target.h"
#include "models/elliptical/ray_shape.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::fiber {
namespace {

const AbsorbedRow* uniform_row() {
  static const AbsorbedRow row = [] {
    AbsorbedRow uniform;
    uniform.uniform = glm::vec3(0.5f * std::numbers::inv_pi_v<float>);
    uniform.tail = AbsorbedRow::has_no_row;
    return uniform;
  }();
  return &row;
}

constexpr std::size_t most_inclinations = 32;

}  // namespace

const ColoredRows::Slot* rows_of_nothing() {
  struct Slots {
    Slots() {
      for (ColoredRows::Slot& slot : all) slot.store(&row_of_nothing, std::memory_order_relaxed);
    }
    std::array<ColoredRows::Slot, most_inclinations> all;
  };
  static const Slots slots;
  return slots.all.data();
}

const ColoredRows::Slot* no_rows() {
  static const std::array<ColoredRows::Slot, most_inclinations> slots{};
  return slots.data();
}

SliceRows::SliceRows(adaptive::Service& service, const adaptive::SliceDescription& description)
    : slice(service.add_slice(description)),
      grid(description),
      width(static_cast<std::uint32_t>(description.axis_b.size())),
      node_count(description.node_count()),
      uniform(node_count),
      converged(node_count) {
  assert(width <= most_inclinations);
  const EllipticalTarget target;
  std::vector<adaptive::TracedRay> rays;
  for (std::uint32_t node = 0; node < node_count; ++node) {
    const std::uint32_t a = node / width, b = node % width;
    rays.clear();
    target.trace(description, description.axis_a[a], description.axis_b[b], rays);
    float mass = 0;
    for (const adaptive::TracedRay& ray : rays) mass += ray.weight;
    uniform[node] = mass < smallest_row_energy;
    converged[node] = service.peek(slice, a, b).state == adaptive::RowState::converged;
  }
}

ColoredRows::ColoredRows(std::shared_ptr<const SliceRows> slice, const glm::vec3& sigma_a)
    : slice_(std::move(slice)),
      sigma_a_(sigma_a),
      rows_(std::make_unique<Slot[]>(slice_->node_count)),
      mass_memo_(std::make_unique<std::atomic<float>[]>(std::size_t{3} * slice_->node_count)) {
  for (std::size_t k = 0; k < std::size_t{3} * slice_->node_count; ++k)
    mass_memo_[k].store(-1, std::memory_order_relaxed);
}

const AbsorbedRow* ColoredRows::put(std::uint32_t node, const adaptive::RowView& view, AbsorbedRowPool& pool) const {
  const AbsorbedRow* row = view.knots != nullptr ? pool.make(*view.knots, view.objective, sigma_a_)
                                                 : pool.make(*view.fit, view.objective, sigma_a_);
  rows_[node].store(row, std::memory_order_release);
  return row;
}

const AbsorbedRow* ColoredRows::put_uniform(std::uint32_t node) const {
  rows_[node].store(uniform_row(), std::memory_order_release);
  return uniform_row();
}

void ColoredRows::forget() {
  for (std::uint32_t node = 0; node < slice_->node_count; ++node) rows_[node].store(nullptr, std::memory_order_relaxed);
}

glm::vec3 ColoredRows::absorbed_mass(std::uint32_t node, const adaptive::TracedNodes& nodes) const {
  std::atomic<float>* memo = mass_memo_.get() + std::size_t{3} * node;
  glm::vec3 mass;
  for (int c = 0; c < 3; ++c) mass[c] = memo[c].load(std::memory_order_relaxed);
  if (mass.x >= 0 && mass.y >= 0 && mass.z >= 0) return mass;
  mass = ray_mass(shape_of(nodes), sigma_a_).absorbed;
  for (int c = 0; c < 3; ++c) memo[c].store(mass[c], std::memory_order_relaxed);
  return mass;
}

}  // namespace tress::fiber
