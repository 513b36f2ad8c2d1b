#include "models/elliptical/colored_rows.h"

#include <array>
#include <cassert>
#include <numbers>
#include <utility>

#include "fiber/elliptical_target.h"
#include "models/elliptical/ray_shape.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::inline v0_2::fiber {
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

/// The form of a row under one absorption.
class AbsorbedForm final : public adaptive::RowForm {
 public:
  AbsorbedForm(std::shared_ptr<const SliceRows> slice, const glm::vec3& sigma_a)
      : slice_(std::move(slice)), sigma_a_(sigma_a) {}
  std::size_t bytes(const adaptive::RowView& row) const override { return absorbed_bytes(*row.fit); }
  void write(const adaptive::RowView& row, void* memory) const override {
    put_absorbed(*row.fit, row.objective, sigma_a_, memory);
  }
  const void* instead_of_row(std::uint32_t node) const override {
    return slice_->uniform[node] ? uniform_row() : nullptr;
  }

 private:
  std::shared_ptr<const SliceRows> slice_;
  glm::vec3 sigma_a_;
};

}  // namespace

adaptive::RowRun zero_density_rows() {
  struct Entries {
    Entries() {
      for (adaptive::RowEntry& entry : all) entry.put(adaptive::RowAnswer::without_row(&zero_density_row));
    }
    std::array<adaptive::RowEntry, most_inclinations> all;
  };
  static const Entries entries;
  return {entries.all.data(), 0, 0};
}

adaptive::RowRun unanswered_rows() {
  static const std::array<adaptive::RowEntry, most_inclinations> entries{};
  return {entries.data(), 0, 0};
}

SliceRows::SliceRows(adaptive::Service& service, const adaptive::SliceDescription& description)
    : slice(service.add_slice(description).value()),
      grid(description),
      width(static_cast<std::uint32_t>(description.axis_b.size())),
      node_count(description.node_count()),
      uniform(node_count) {
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
  }
}

ColoredRows::ColoredRows(adaptive::Service& service, std::shared_ptr<const SliceRows> slice, const glm::vec3& sigma_a)
    : slice_(std::move(slice)),
      sigma_a_(sigma_a),
      formed_(service
                  .add_form(slice_->slice, std::make_shared<AbsorbedForm>(slice_, sigma_a),
                            {sigma_a.x, sigma_a.y, sigma_a.z})
                  .value()),
      mass_memo_(std::make_unique<std::atomic<float>[]>(std::size_t{3} * slice_->node_count)) {
  for (std::size_t k = 0; k < std::size_t{3} * slice_->node_count; ++k)
    mass_memo_[k].store(-1, std::memory_order_relaxed);
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

}  // namespace tress::inline v0_2::fiber
