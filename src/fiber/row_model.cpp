#include "fiber/row_model.h"

#include <cstddef>

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

void EventRowModel::credit(const EventRow& row, float light) const {
  adaptive::RowView view;
  view.slice = row.formed->slice();
  view.node = row.node;
  view.pass = row.pass;
  service_->credit(view, light * static_cast<float>(row.times), row.times);
}

}  // namespace tress::inline v0_2::fiber
