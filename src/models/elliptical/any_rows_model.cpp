#include "models/elliptical/any_rows_model.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <vector>

#include "base/pi.h"
#include "fiber/energy_table.h"
#include "fiber/event_constants.h"
#include "models/lobes/lobe_choice.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr auto residual = static_cast<std::size_t>(Lobe::residual);

/// Probability that `corrected` traces a direction: 2^-4, decided by the leading bits of a hash.
constexpr int correction_bits = 4;
constexpr float correction_factor = 1 << correction_bits;

std::uint64_t hash_of(float a, float b, std::uint64_t before) {
  return mix_bits(before + ((std::uint64_t{std::bit_cast<std::uint32_t>(a)} << 32) | std::bit_cast<std::uint32_t>(b)));
}

}  // namespace

AnyRowsModel::AnyRowsModel(Estimator estimator, adaptive::Service* service)
    : RowModel(estimator == Estimator::exact ? nullptr : service),
      estimator_(estimator),
      fibers_(service_),
      inclinations_(elliptical_slice(1, 1.55f, 1.0f, smallest_grid_sigma)) {
  assert(estimator == Estimator::exact || service != nullptr);
  if (service_ != nullptr) uniform_share_ = service_->options().uniform_share_converged;
}

RowReader AnyRowsModel::reader_of(const FiberEvent& event, const VertexConstants& constants, std::size_t i) const {
  const auto lobe = static_cast<std::size_t>(row_lobes[i]);
  return {fibers_[event.fiber], service_, i, constants.fold.phi, channel_weights(event, lobe)};
}

std::uint64_t AnyRowsModel::hash_of_event(const FiberDirection& wr, float xi1, float xi2) const {
  return estimator_ == Estimator::corrected ? hash_of(wr.theta, wr.phi, hash_of(xi1, xi2, 0)) : 0;
}

std::optional<float> AnyRowsModel::correction(const FiberEvent& event, const VertexConstants& constants,
                                              const FiberDirection& wi) const {
  if (estimator_ != Estimator::corrected || event.is_of_mean) return {};
  const std::uint64_t hash = hash_of(wi.theta, wi.phi, constants.hash);
  if (hash >> (64 - correction_bits) != 0) return {};
  return static_cast<float>(hash & 0xffffff) * 0x1p-24f;
}

void AnyRowsModel::complete(const FiberEvent& event, const VertexConstants& constants, const Inclination& at,
                            DirectionRows& rows, Answers& answers) const {
  answers.asked = std::make_unique<std::array<adaptive::FormedLookup, 4>>();
  const EllipticalFiber& fiber = fibers_[event.fiber];
  if (!fiber.answers_by_rows) return;
  answers.all = true;
  for (std::size_t i = 0; i < row_lobes.size(); ++i) {
    if (answers.row[i] != nullptr) continue;
    adaptive::FormedLookup& found = (*answers.asked)[i] =
        rows.fetch(fiber.rows[i]->formed(), constants.runs[i].first_node + at.node, row_lobes[i]);
    answers.row[i] = static_cast<const AbsorbedRow*>(found.answer.block());
    answers.all = answers.all && found.answer;
  }
}

void AnyRowsModel::ask(const FiberEvent& event, const VertexConstants& constants, std::size_t i, const Inclination& at,
                       DirectionRows& rows, Answers& answers) const {
  adaptive::FormedLookup& found = (*answers.asked)[i];
  if (found.row.nodes != nullptr) return;
  const adaptive::FormedRows& formed = fibers_[event.fiber].rows[i]->formed();
  found = rows.ask(formed, constants.runs[i].first_node + at.node, row_lobes[i]);
  answers.row[i] = static_cast<const AbsorbedRow*>(found.answer.block());
}

float AnyRowsModel::sample_any(const FiberEvent& event, const VertexConstants& constants, int p, const Inclination& at,
                               const std::array<float, 3>& u, DirectionRows& rows, Answers& answers) const {
  const std::size_t i = row_lobe_of(p);
  const RowReader reader = reader_of(event, constants, i);
  if (service_ != nullptr) ask(event, constants, i, at, rows, answers);
  const AbsorbedRow* row = answers.row[i];
  const float x =
      row != nullptr
          ? row->sample(u[1], channel_weights(event, static_cast<std::size_t>(p)), uniform_share_)
          : reader.sample(service_ != nullptr ? &(*answers.asked)[i].row : nullptr, at.theta_d, u[0], u[1], u[2]);
  return constants.fold.absolute(x, event.wr.phi);
}

FiberValue AnyRowsModel::value_of_any(const FiberEvent& event, const VertexConstants& constants,
                                      const FiberDirection& wi, const Inclination& at, int drawn, DirectionRows& rows,
                                      Answers& answers) const {
  const EllipticalFiber& fiber = fibers_[event.fiber];
  FiberValue value;
  if (event.selection[0] > 0) {
    const ReflectionLobe::At r = constants.reflection.at(wi.phi);
    const float m = constants.reflection.longitudinal_density(r, wi.theta);
    value.s[0] = constants.reflection_gain * (r.energy_density * m);
    value.pdf += event.selection[0] * r.azimuth_pdf * m;
  }
  const float x = constants.fold.relative(wi.phi, event.wr.phi);
  const std::optional<float> correct = correction(event, constants, wi);
  // If one lobe is traced at every vertex, that trace has the rays of all lobes. `corrected` then does the same as
  // `exact`, without the noise of correcting 1 direction in 16. (The error of a furnace with e 0.5, alpha 0.05 is 0.36
  // of the mean; it would be 17.)
  const bool exact_anyway =
      estimator_ == Estimator::corrected &&
      std::any_of(fiber.proposes_only.begin(), fiber.proposes_only.end(), [](bool only) { return only; });
  const Float4 widths = constants.longitudinal.density(wi.theta);
  for (std::size_t i = 0; i < row_lobes.size(); ++i) {
    const auto lobe = static_cast<std::size_t>(row_lobes[i]);
    if (!(event.selection[lobe] > 0)) continue;
    const float m = widths[row_orders[i] - 1];
    if (service_ != nullptr && answers.row[i] == nullptr) ask(event, constants, i, at, rows, answers);
    RowValue azimuthal;
    bool asks = true, exact = false;
    if (const AbsorbedRow* row = answers.row[i]; row != nullptr) {
      azimuthal = row->evaluate(x, channel_weights(event, lobe), uniform_share_);
      asks = row->has_row();
      value.objective += row->objective();
    } else {
      const RowReader reader = reader_of(event, constants, i);
      exact = true;
      if (service_ == nullptr) {
        azimuthal = reader.evaluate_at_vertex(at.theta_d, x);
      } else {
        const adaptive::RowView& open = (*answers.asked)[i].row;
        value.objective += open.objective;
        azimuthal = reader.evaluate_open(open, x, static_cast<int>(lobe) == drawn);
      }
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
    value.s[residual] = event.energy[residual] * (inverse_two_pi_f * m);
    value.pdf += event.selection[residual] * inverse_two_pi_f * m;
  }
  value.pdf = std::max(value.pdf, smallest_pdf);
  return value;
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

// The difference between the answers of rows and a trace at the vertex, as the mean over the nodes that an event may
// choose.
namespace {

/// The answer at a node; null if its row has not converged. Counts no query. Valid until this thread's next call.
const AbsorbedRow* answer_at(const adaptive::Service& service, const ColoredRows& rows, std::uint32_t a,
                             std::uint32_t b) {
  adaptive::AnswerReader reader(nullptr);
  const adaptive::FormedRows& formed = rows.formed();
  const adaptive::RowAnswer answer = reader.read(formed.run(a), b);
  if (answer) return static_cast<const AbsorbedRow*>(answer.block());
  if (const void* block = formed.form().instead_of_row(a * formed.width() + b); block != nullptr)
    return static_cast<const AbsorbedRow*>(block);
  const adaptive::RowView row = service.peek(formed.slice(), a, b);
  if (row.state != adaptive::RowState::converged) return nullptr;
  thread_local std::vector<AbsorbedRow> memory;
  memory.resize((formed.form().bytes(row) + sizeof(AbsorbedRow) - 1) / sizeof(AbsorbedRow));
  formed.form().write(row, memory.data());
  return memory.data();
}

}  // namespace

glm::vec3 AnyRowsModel::interpolated_shape(const FiberEvent& event, const VertexConstants& constants, std::size_t i,
                                           float theta_d, float x) const {
  const EllipticalFiber& fiber = fibers_[event.fiber];
  const ColoredRows& rows = *fiber.rows[i];
  const RowGrid& grid = rows.slice().grid;
  const adaptive::SliceDescription& slice = service_->slice(rows.slice().slice);
  const RowGrid::Between a = grid.between_azimuths(constants.fold.phi), b = grid.between_inclinations(theta_d);
  glm::vec3 shape(0.0f);
  for (const bool second_a : {false, true}) {
    for (const bool second_b : {false, true}) {
      const float weight = (second_a ? a.share : 1 - a.share) * (second_b ? b.share : 1 - b.share);
      if (!(weight > 0)) continue;
      const std::uint32_t node_a = second_a ? a.second : a.first, node_b = second_b ? b.second : b.first;
      if (const AbsorbedRow* row = answer_at(*service_, rows, node_a, node_b); row != nullptr) {
        shape += weight * row->evaluate(x, glm::vec3(0.0f), 0).shape;
      } else {
        const RowReader node(fiber, service_, i, slice.axis_a[node_a], glm::vec3(0.0f));
        shape += weight * node.evaluate_at_vertex(slice.axis_b[node_b], x).shape;
      }
    }
  }
  return shape;
}

glm::vec3 AnyRowsModel::excess(const FiberEvent& event, const FiberDirection& wi, float place) const {
  glm::vec3 sum(0.0f);
  if (!tells_excess() || event.fiber == no_fiber) return sum;
  const VertexConstants& constants = constants_in<VertexConstants>(event);
  const EllipticalFiber& fiber = fibers_[event.fiber];
  const FiberDirection to = clamped(wi);
  const float theta_d = inclination_of(event, to.theta).theta_d, x = constants.fold.relative(to.phi, event.wr.phi);
  const Float4 widths = constants.longitudinal.density(to.theta);
  std::array<glm::vec3, row_lobes.size()> truth{};
  const auto is_asked = [&](std::size_t i) {
    return event.selection[static_cast<std::size_t>(row_lobes[i])] > 0 && !fiber.proposes_only[i];
  };
  // This comes before any node: the thread's last trace is then made once for all lobes.
  for (std::size_t i = 0; i < row_lobes.size(); ++i) {
    if (is_asked(i)) truth[i] = reader_of(event, constants, i).correction(glm::vec3(0.0f), theta_d, x, place);
  }
  for (std::size_t i = 0; i < row_lobes.size(); ++i) {
    if (!is_asked(i)) continue;
    const float m = widths[row_orders[i] - 1];
    const glm::vec3 more = interpolated_shape(event, constants, i, theta_d, x) - truth[i];
    sum += event.energy[static_cast<std::size_t>(row_lobes[i])] * more * m;
  }
  return sum;
}

}  // namespace tress::inline v0_2::fiber
