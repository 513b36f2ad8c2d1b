#include "fiber/row_model.h"

#include <cstddef>
#include <vector>

namespace tress::inline v0_2::fiber {

std::optional<Error> wrong_service(const adaptive::Service* service, const std::string& target,
                                   adaptive::SliceKind kind) {
  const std::string expected = "a service on a target of " +
                               std::string(kind == adaptive::SliceKind::samples ? "samples" : "densities") + ", " +
                               target;
  if (service == nullptr) return Error{"", "service", expected, "none"};
  if (!service->has_target(kind)) return Error{"", "service", expected, "one without a target of this kind"};
  if (service->model_name() != target) return Error{"", "service", expected, service->model_name()};
  return std::nullopt;
}

void DirectionRows::credit_all(const FiberValue& value) const {
  for (std::size_t i = 0; i < count_; ++i) {
    const Asked& one = asked_[i];
    adaptive::RowView row;
    row.slice = one.slice;
    row.node = one.node;
    row.pass = one.pass;
    const float s = one.part >= 0 ? one.part : luminance(value.s[static_cast<std::size_t>(one.lobe)]);
    const float light = importance_ * s / value.pdf;
    service_->credit(row, one.times == 1 ? light : light * static_cast<float>(one.times), one.times);
  }
}

const void* EventRowModel::made_anew(const EventRow& row) const {
  struct alignas(64) Line {
    std::byte bytes[64];
  };
  thread_local std::vector<Line> memory;
  const std::uint32_t width = row.formed->width();
  const adaptive::RowView view = service_->peek(row.formed->slice(), row.node / width, row.node % width);
  memory.resize((row.formed->form().bytes(view) + sizeof(Line) - 1) / sizeof(Line));
  row.formed->form().write(view, memory.data());
  return memory.data();
}

void EventRowModel::credit(const EventRow& row, float light) const {
  adaptive::RowView view;
  view.slice = row.formed->slice();
  view.node = row.node;
  view.pass = row.pass;
  service_->credit(view, light * static_cast<float>(row.times), row.times);
}

}  // namespace tress::inline v0_2::fiber
