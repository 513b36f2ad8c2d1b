#include "models/elliptical/any_rows_model.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <numbers>

#include "base/color.h"
#include "fiber/energy_table.h"
#include "tress/base/random.h"

namespace tress::fiber {
namespace {

constexpr float inverse_two_pi = 0.5f * std::numbers::inv_pi_v<float>;
constexpr auto residual = static_cast<std::size_t>(Lobe::residual);

/// Probability that `corrected` traces a direction: 2^-4, decided by the leading bits of a hash.
constexpr int correction_bits = 4;
constexpr float correction_factor = 1 << correction_bits;

std::uint64_t hash_of(float a, float b, std::uint64_t before) {
  return mix_bits(before + ((std::uint64_t{std::bit_cast<std::uint32_t>(a)} << 32) | std::bit_cast<std::uint32_t>(b)));
}

}  // namespace

AnyRowsModel::AnyRowsModel(Estimator estimator, adaptive::Service* service)
    : estimator_(estimator),
      service_(estimator == Estimator::exact ? nullptr : service),
      fibers_(service_),
      inclinations_(elliptical_slice(1, 1.55f, 1.0f, smallest_grid_sigma)) {
  assert(estimator == Estimator::exact || service != nullptr);
  if (service_ != nullptr) uniform_share_ = service_->options().uniform_share_converged;
}

glm::vec3 AnyRowsModel::channel_weights(const FiberEvent& event, std::size_t lobe) {
  const glm::vec3 terms = luminance_terms(event.energy[lobe]);
  return terms * (1 / (terms.x + terms.y + terms.z));
}

RowReader AnyRowsModel::reader_of(const FiberEvent& event, const VertexConstants& constants, std::size_t i) const {
  const auto lobe = static_cast<std::size_t>(row_lobes[i]);
  return {fibers_[event.fiber], service_, fibers_.pool(), i, constants.fold.phi, channel_weights(event, lobe)};
}

std::uint64_t AnyRowsModel::hash_of_event(const FiberDirection& wr, float xi1, float xi2) const {
  return estimator_ == Estimator::corrected ? hash_of(wr.theta, wr.phi, hash_of(xi1, xi2, 0)) : 0;
}

std::optional<float> AnyRowsModel::correction(const VertexConstants& constants, const FiberDirection& wi) const {
  if (estimator_ != Estimator::corrected) return {};
  const std::uint64_t hash = hash_of(wi.theta, wi.phi, constants.hash);
  if (hash >> (64 - correction_bits) != 0) return {};
  return static_cast<float>(hash & 0xffffff) * 0x1p-24f;
}

std::uint32_t AnyRowsModel::fetch(const FiberEvent& event, const VertexConstants& constants, std::size_t i,
                                  const Inclination& at) const {
  const FiberRecord& fiber = fibers_[event.fiber];
  if (!fiber.answers_by_rows || !(event.selection[static_cast<std::size_t>(row_lobes[i])] > 0)) return 0;
  const std::uint32_t node = constants.first_node[i] + at.node;
  const SliceRows& slice = fiber.rows[i]->slice();
  if (fiber.rows[i]->find(node) != nullptr || !(slice.uniform[node] || slice.converged[node])) return 0;
  return reader_of(event, constants, i).ask(node).counted ? 1 : 0;
}

FiberSample AnyRowsModel::sample_any(const FiberEvent& event, const VertexConstants& constants, int p, float theta_i,
                                     const Inclination& at, const std::array<float, 3>& u) const {
  const std::size_t i = row_lobe_of(p);
  const RowReader reader = reader_of(event, constants, i);
  std::uint32_t node = 0;
  RowQuery query;
  if (service_ != nullptr) {
    node = constants.first_node[i] + at.node;
    query.row = fibers_[event.fiber].rows[i]->find(node);
    if (query.row == nullptr) query = reader.ask(node);
  }
  FiberSample sample;
  sample.lobe = static_cast<Lobe>(p);
  sample.wi.theta = theta_i;
  sample.wi.phi = constants.fold.absolute(reader.sample(query, node, at.theta_d, u[0], u[1], u[2]), event.wr.phi);
  sample.value = value_of_any(event, constants, sample.wi, at, p, &query, 0);
  return sample;
}

FiberValue AnyRowsModel::value_of_any(const FiberEvent& event, const VertexConstants& constants,
                                      const FiberDirection& wi, const Inclination& at, int drawn, const RowQuery* known,
                                      std::uint32_t fetched) const {
  const FiberRecord& fiber = fibers_[event.fiber];
  FiberValue value;
  if (event.selection[0] > 0) {
    const ReflectionLobe::At r = constants.reflection.at(wi.phi);
    const float m = constants.reflection.longitudinal_density(r, wi.theta);
    value.s[0] = constants.reflection_gain * (r.energy_density * m);
    value.pdf += event.selection[0] * r.azimuth_pdf * m;
  }
  const float x = constants.fold.relative(wi.phi, event.wr.phi);
  const std::optional<float> correct = correction(constants, wi);
  // Where a lobe is traced at every vertex, one trace has the rays of all: `corrected` is then `exact`, and has none of
  // the noise of correcting 1 direction of 16 (of a furnace of e .5, alpha .05: 17 means, now .36).
  const bool exact_anyway =
      estimator_ == Estimator::corrected &&
      std::any_of(fiber.proposes_only.begin(), fiber.proposes_only.end(), [](bool only) { return only; });
  const int counted = known != nullptr && known->counted ? drawn : nothing_drawn;
  std::uint32_t from_copies = 0;
  const Float4 widths = constants.longitudinal.density(wi.theta);
  for (std::size_t i = 0; i < row_lobes.size(); ++i) {
    const auto lobe = static_cast<std::size_t>(row_lobes[i]);
    if (!(event.selection[lobe] > 0)) continue;
    const float m = widths[row_orders[i] - 1];
    const AbsorbedRow* row = service_ != nullptr && static_cast<int>(lobe) != counted
                                 ? fiber.rows[i]->find(constants.first_node[i] + at.node)
                                 : nullptr;
    RowValue azimuthal;
    bool asks = true, exact = false;
    if (row != nullptr) {
      azimuthal = row->evaluate(x, channel_weights(event, lobe), uniform_share_);
      asks = row->has_row();
      from_copies += asks ? 1 : 0;
      value.objective += row->objective();
    } else {
      azimuthal = trace_or_ask(event, constants, i, at, x, static_cast<int>(lobe) == drawn ? known : nullptr, value,
                               asks, exact);
    }
    value.queries += asks ? 1 : 0;
    if ((correct || exact_anyway || fiber.proposes_only[i]) && service_ != nullptr) {
      const RowReader reader = reader_of(event, constants, i);
      if (exact_anyway || fiber.proposes_only[i]) {
        azimuthal.shape = reader.evaluate_at_vertex(at.theta_d, x).shape;
      } else {
        azimuthal.shape += correction_factor * reader.correction(azimuthal.shape, at.theta_d, x, *correct);
      }
      exact = true;
    }
    value.exact_queries += asks && exact ? 1 : 0;
    value.s[lobe] = event.energy[lobe] * azimuthal.shape * m;
    value.pdf += event.selection[lobe] * azimuthal.proposal * m;
  }
  if (event.selection[residual] > 0) {
    const float m = widths[2];
    value.s[residual] = event.energy[residual] * (inverse_two_pi * m);
    value.pdf += event.selection[residual] * inverse_two_pi * m;
  }
  if (from_copies > fetched) service_->count_converged(from_copies - fetched);
  value.pdf = std::max(value.pdf, smallest_pdf);
  return value;
}

RowValue AnyRowsModel::trace_or_ask(const FiberEvent& event, const VertexConstants& constants, std::size_t i,
                                    const Inclination& at, float x, const RowQuery* known, FiberValue& value,
                                    bool& asks, bool& exact) const {
  const RowReader reader = reader_of(event, constants, i);
  exact = true;
  if (service_ == nullptr) return reader.evaluate_at_vertex(at.theta_d, x);
  const std::uint32_t node = constants.first_node[i] + at.node;
  const RowQuery asked = known == nullptr ? reader.ask(node) : RowQuery{};
  const RowQuery& query = known == nullptr ? asked : *known;
  if (query.row != nullptr) {
    asks = query.row->has_row();
    exact = false;
    value.objective += query.row->objective();
    const auto lobe = static_cast<std::size_t>(row_lobes[i]);
    return query.row->evaluate(x, channel_weights(event, lobe), uniform_share_);
  }
  value.objective += query.view.objective;
  return reader.evaluate_open(query, node, x, known != nullptr);
}

void AnyRowsModel::tell_light(const FiberEvent& event, const VertexConstants& constants, const Inclination& at,
                              const FiberValue& value, bool tells_all) const {
  if (service_ == nullptr) return;
  const FiberRecord& fiber = fibers_[event.fiber];
  for (std::size_t i = 0; i < row_lobes.size(); ++i) {
    // By now every row that has converged is copied, whichever thread did it.
    const AbsorbedRow* row = constants.slots[i][at.node].load(std::memory_order_acquire);
    if (!fiber.rows[i] || (row != nullptr && !(tells_all && row->has_row()))) continue;
    const float light = event.importance * luminance(value.s[static_cast<std::size_t>(row_lobes[i])]) / value.pdf;
    service_->carry(fiber.rows[i]->slice().slice, constants.first_node[i] + at.node,
                    row == nullptr ? light : light * static_cast<float>(light_interval));
  }
}

const char* estimator_name(Estimator estimator) {
  switch (estimator) {
    case Estimator::fitted:
      return "fitted";
    case Estimator::exact:
      return "exact";
    case Estimator::corrected:
      break;
  }
  return "corrected";
}

}  // namespace tress::fiber
