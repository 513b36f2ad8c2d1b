#include "references/learners/online.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>

#include "base/pi.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double uniform_at_first = 0.1;  // share of the energy
constexpr double added_to_warm = 0.02;    // share of each broad component beside those of a warm start

}  // namespace

Vector starting_parameters(const FitContext& context, int components, const Mixture* warm) {
  const double energy = context.nodes.energy();
  const int known = warm != nullptr ? std::min<int>(static_cast<int>(warm->component_count), components) : 0;
  const int broad = components - known;
  Vector v(per_component * components + 1);
  for (int d = 0; d < components; ++d) {
    auto part = v.segment<per_component>(per_component * d);
    if (d < known) {
      const Component& one = warm->components[static_cast<std::size_t>(d)];
      part << one.weight, one.shape.mu, std::log(one.shape.s_left), std::log(one.shape.s_right);
    } else {
      const double weight = known > 0 ? added_to_warm * energy : (1 - uniform_at_first) * energy / broad;
      const double scale = std::log(std::min(scale_max, 0.6 * pi / broad));
      part << weight, -pi + (2 * (d - known) + 1) * pi / broad, scale, scale;
    }
  }
  v[v.size() - 1] = known > 0 ? static_cast<double>(warm->uniform_weight) : uniform_at_first * energy;
  return v;
}

Mixture mixture_of(const Vector& v, double energy) {
  double sum = 0;
  for (Eigen::Index at = 0; at < v.size(); at += per_component)
    sum += std::max(v[at], 0.0);  // a_0 is at a multiple too
  if (!(sum > 0) || !std::isfinite(sum)) {
    Mixture flat;
    flat.uniform_weight = static_cast<float>(energy);
    return flat;
  }
  return mixture_from(v, [&](double a) { return static_cast<float>(std::max(a, 0.0) * energy / sum); });
}

std::vector<WeightedDraw> replay(FitContext& context, const Mixture& fit, std::uint64_t draws) {
  const std::uint64_t n = std::min(draws, most_replayed);
  const float share = context.options.uniform_share_open;
  std::vector<WeightedDraw> result;
  result.reserve(n);
  for (std::uint64_t i = 0; i < n; ++i) {
    const float u = (static_cast<float>(i) + context.random.next()) / static_cast<float>(n);
    const float x = fit.sample(std::min(u, 1 - 0x1p-24f), share);
    result.push_back({x, static_cast<double>(context.g(x)), static_cast<double>(fit.proposal_density(x, share))});
  }
  return result;
}

double density_and_gradient(const Vector& v, double x, Vector& gradient) {
  gradient.resize(v.size());
  const auto last = v.size() - 1;
  gradient[last] = 1 / (2 * pi);
  double f = v[last] / (2 * pi);
  for (Eigen::Index at = 0; at < last; at += per_component) {
    const Shape shape = shape_at(v, at);
    const double offset = wrap_near(x - shape.mu);
    const bool left = offset < 0;
    const double s = left ? shape.left : shape.right;
    const double y = std::abs(offset) / s;
    const double e = std::exp(-y);
    const double p = e / ((1 + e) * (1 + e)) * shape.inverse_z;
    const double t = (1 - e) / (1 + e);
    const double mass = v[at + offset_weight] * p;
    f += mass;
    gradient[at + offset_weight] = p;
    gradient[at + offset_mu] = (left ? -mass : mass) * t / s;
    gradient[at + offset_log_left] = mass * ((left ? y * t : 0) - shape.log_z_left);
    gradient[at + offset_log_right] = mass * ((left ? 0 : y * t) - shape.log_z_right);
  }
  return f;
}

void append_vector(const Vector& vector, std::vector<std::uint64_t>& words) {
  words.push_back(static_cast<std::uint64_t>(vector.size()));
  for (Eigen::Index i = 0; i < vector.size(); ++i) words.push_back(std::bit_cast<std::uint64_t>(vector[i]));
}

bool take_vector(std::span<const std::uint64_t>& words, Vector& vector) {
  if (words.empty() || words[0] > std::uint64_t{max_parameters} || words[0] >= words.size()) return false;
  if (words[0] < per_component || words[0] % per_component != 1) return false;
  const auto size = static_cast<std::size_t>(words[0]);
  vector.resize(static_cast<Eigen::Index>(size));
  for (std::size_t i = 0; i < size; ++i) {
    const auto value = std::bit_cast<double>(words[i + 1]);
    if (!std::isfinite(value)) return false;
    vector[static_cast<Eigen::Index>(i)] = value;
  }
  words = words.subspan(size + 1);
  return true;
}

}  // namespace tress::inline v0_2::adaptive
