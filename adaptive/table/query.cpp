#include "tress/adaptive/query.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tress::inline v0_2::adaptive {
namespace {

/// Clamps into [0, 1); NaN becomes 0.
float uniform(float u) { return u >= 0 ? (u < 1 ? u : 0x1.fffffep-1f) : 0.0f; }

float finite(float x) { return std::isfinite(x) ? x : 0; }

void set_parts(const RibbonRow& row, NodeValue& value) {
  for (std::uint32_t part = 0; part < row.parts(); ++part) {
    if (!(row.mass(part) > 0)) continue;
    value.parts[part] = row.mass(part) * row.ribbon(part).density(value.azimuth, value.height);
    value.density += value.parts[part];
  }
  value.pdf = value.density / row.total_mass();
  value.answered = true;
}

void draw_place(const RibbonRow& row, const std::array<float, 3>& u, NodeValue& value) {
  float below = uniform(u[0]) * row.total_mass();
  std::uint32_t part = 0;
  while (part + 1 < row.parts() && below >= row.mass(part)) below -= row.mass(part++);
  while (part > 0 && !(row.mass(part) > 0)) --part;  // rounding may lead to a last part without mass
  const Ribbon::Place place = row.ribbon(part).sample(uniform(u[1]), uniform(u[2]));
  value.azimuth = place.azimuth;
  value.height = place.height;
}

void set_density(const RowView& row, float share, NodeValue& value) {
  const bool is_fit = row.state == RowState::converged;
  value.density = value.parts[0] =
      is_fit || row.nodes == nullptr ? row.density(value.azimuth) : row.nodes->density(value.azimuth);
  value.pdf = is_fit ? row.fit->proposal_density_at(value.density, share) : row.proposal_density(value.azimuth, share);
  value.answered = true;
}

float share_of(const Service& service, const RowView& row) {
  const Options& options = service.options();
  return row.state == RowState::converged ? options.uniform_share_converged : options.uniform_share_open;
}

/// The node below a place on an axis, and the share of the one above it.
struct Along {
  std::uint32_t below = 0;
  float share = 0;
};

Along along(const std::vector<float>& axis, float at) {
  if (axis.size() < 2 || !(at > axis.front())) return {};
  const auto above = std::upper_bound(axis.begin() + 1, axis.end() - 1, at);
  const float below = *(above - 1);
  return {static_cast<std::uint32_t>(above - axis.begin()) - 1, std::min((at - below) / (*above - below), 1.0f)};
}

}  // namespace

NodeValue sample(const Service& service, const Node& node, const std::array<float, 3>& u) {
  const RowView row = service.look_up(node.slice, node.a, node.b);
  NodeValue value;
  value.state = row.state;
  if (row.ribbons != nullptr) {
    draw_place(*row.ribbons, u, value);
    set_parts(*row.ribbons, value);
  } else if (row.node != RowView::no_node && service.slice(node.slice).kind == SliceKind::density) {
    const float share = share_of(service, row);
    if (row.state == RowState::converged) {
      const auto [azimuth, density, pdf] = row.fit->draw(uniform(u[0]), share);
      value.azimuth = azimuth;
      value.density = value.parts[0] = density;
      value.pdf = pdf;
      value.answered = true;
      return value;
    }
    value.azimuth = row.sample(uniform(u[0]), share);
    set_density(row, share, value);
    service.score(row, value.azimuth, value.density, value.pdf);
  }
  return value;
}

NodeValue evaluate(const Service& service, const Node& node, float azimuth, float height) {
  const RowView row = service.look_up(node.slice, node.a, node.b);
  NodeValue value;
  value.state = row.state;
  value.azimuth = wrap_angle(finite(azimuth));
  if (row.node == RowView::no_node) return value;
  if (service.slice(node.slice).kind == SliceKind::samples) {
    value.height = finite(height);
    if (row.ribbons != nullptr) set_parts(*row.ribbons, value);
    return value;
  }
  set_density(row, share_of(service, row), value);
  if (row.state != RowState::converged) service.observe(row, value.azimuth, value.density);
  return value;
}

float pdf(const Service& service, const Node& node, float azimuth, float height) {
  if (service.slice(node.slice).kind == SliceKind::samples) return evaluate(service, node, azimuth, height).pdf;
  const RowView row = service.peek(node.slice, node.a, node.b);
  return row.node == RowView::no_node ? 0 : row.proposal_density(wrap_angle(finite(azimuth)), share_of(service, row));
}

Node choose(const Service& service, SliceId id, float a, float b, float xi1, float xi2) {
  const SliceDescription& slice = service.slice(id);
  const Along at_a = along(slice.axis_a, a), at_b = along(slice.axis_b, b);
  return {id, at_a.below + (uniform(xi1) < at_a.share ? 1 : 0), at_b.below + (uniform(xi2) < at_b.share ? 1 : 0)};
}

NodeValue mean(const Service& service, SliceId id, float a, float b, float azimuth, float height) {
  const SliceDescription& slice = service.slice(id);
  const Along at_a = along(slice.axis_a, a), at_b = along(slice.axis_b, b);
  NodeValue mean;
  mean.state = RowState::converged;
  mean.azimuth = wrap_angle(finite(azimuth));
  mean.height = slice.kind == SliceKind::samples ? finite(height) : 0;
  for (const std::uint32_t i : {0u, 1u}) {
    for (const std::uint32_t j : {0u, 1u}) {
      const float share = (i == 0 ? 1 - at_a.share : at_a.share) * (j == 0 ? 1 - at_b.share : at_b.share);
      if (!(share > 0)) continue;
      const NodeValue one = evaluate(service, {id, at_a.below + i, at_b.below + j}, azimuth, height);
      if (!one.answered) return one;
      if (one.state != RowState::converged) mean.state = one.state;
      for (std::size_t part = 0; part < mean.parts.size(); ++part) mean.parts[part] += share * one.parts[part];
      mean.density += share * one.density;
      mean.pdf += share * one.pdf;
    }
  }
  mean.answered = true;
  return mean;
}

NodeValue sample_mean(const Service& service, SliceId slice, float a, float b, const std::array<float, 5>& u) {
  const NodeValue drawn = sample(service, choose(service, slice, a, b, u[3], u[4]), {u[0], u[1], u[2]});
  return drawn.answered ? mean(service, slice, a, b, drawn.azimuth, drawn.height) : drawn;
}

void sample(const Service& service, std::span<const Node> nodes, std::span<const std::array<float, 3>> u,
            std::span<NodeValue> values) {
  const std::size_t count = std::min({values.size(), nodes.size(), u.size()});
  for (std::size_t i = 0; i < count; ++i) values[i] = sample(service, nodes[i], u[i]);
  std::ranges::fill(values.subspan(count), NodeValue{});
}

void evaluate(const Service& service, std::span<const Node> nodes, std::span<const std::array<float, 2>> places,
              std::span<NodeValue> values) {
  const std::size_t count = std::min({values.size(), nodes.size(), places.size()});
  for (std::size_t i = 0; i < count; ++i) values[i] = evaluate(service, nodes[i], places[i][0], places[i][1]);
  std::ranges::fill(values.subspan(count), NodeValue{});
}

}  // namespace tress::inline v0_2::adaptive
