// The difference between the answers of rows and a trace at the vertex, as the mean over the nodes that an event may
// choose.
#include <array>
#include <cstddef>
#include <vector>

#include "fiber/event_constants.h"
#include "models/elliptical/any_rows_model.h"

namespace tress::inline v0_2::fiber {
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
