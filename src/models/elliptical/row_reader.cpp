#include "models/elliptical/row_reader.h"

#include <glm/geometric.hpp>

#include "base/pi.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr float vertex_uniform_share = 0.05f;  // uniform share of a vertex trace's proposal
constexpr int correction_rays = 128;           // rays of the trace that corrects all lobes; 512 change nothing
constexpr float darkest_mass = 1e-30f;         // a channel with less light counts as dark: its shape is set to uniform

glm::vec3 normalised(const glm::vec3& density, const glm::vec3& mass) {
  glm::vec3 shape;
  for (int c = 0; c < 3; ++c) shape[c] = mass[c] > darkest_mass ? density[c] / mass[c] : inverse_two_pi_f;
  return shape;
}

}  // namespace

float RowReader::sample_rays(const RayShape& rays, const glm::vec3& mass, float share, float u_channel, float u_ray,
                             float u_blur) const {
  if (u_channel < share) return -pi_f + 2 * pi_f * u_ray;
  const float u = (u_channel - share) / (1 - share);
  const int c = u < channel_weights_.x ? 0 : u < channel_weights_.x + channel_weights_.y ? 1 : 2;
  if (!(mass[c] > darkest_mass)) return -pi_f + 2 * pi_f * u_ray;
  return draw_azimuth(rays, fiber_.parameters.sigma_a[c], mass[c], u_ray, u_blur);
}

float RowReader::sample(const adaptive::RowView* row, float theta_d, float u_channel, float u_ray, float u_blur) const {
  if (row == nullptr) {
    const VertexTrace& trace = VertexTrace::at(vertex(theta_d));
    if (trace.mass(row_lobe_).clear < smallest_row_energy) return -pi_f + 2 * pi_f * u_ray;
    return sample_rays(trace.shape(row_lobe_, fiber_.sigma[row_lobe_]), trace.mass(row_lobe_).absorbed,
                       vertex_uniform_share, u_channel, u_ray, u_blur);
  }
  const float share = service_->options().uniform_share_open;
  if (row->fit != nullptr) return row->fit->sample(u_ray, share);
  const adaptive::TracedNodes& nodes = *row->nodes;
  return sample_rays(shape_of(nodes), rows().absorbed_mass(row->node, nodes), share, u_channel, u_ray, u_blur);
}

VertexKey RowReader::vertex(float theta_d) const {
  const FiberParameters& parameters = fiber_.parameters;
  return {parameters.eta,     parameters.eccentricity, phi_r_, theta_d,
          fiber_.vertex_rays, parameters.sigma_a,      0.5f,   parameters.split_glint ? fiber_.sigma[1] : 0};
}

RowValue RowReader::at_vertex(const VertexKey& key, float x) const {
  const VertexTrace& trace = VertexTrace::at(key);
  if (trace.mass(row_lobe_).clear < smallest_row_energy) return {glm::vec3(inverse_two_pi_f), inverse_two_pi_f};
  const RayShape rays = trace.shape(row_lobe_, fiber_.sigma[row_lobe_]);
  RowValue value;
  value.shape = normalised(ray_density(rays, fiber_.parameters.sigma_a, x).absorbed, trace.mass(row_lobe_).absorbed);
  value.proposal =
      (1 - vertex_uniform_share) * glm::dot(channel_weights_, value.shape) + vertex_uniform_share * inverse_two_pi_f;
  return value;
}

RowValue RowReader::evaluate_at_vertex(float theta_d, float x) const { return at_vertex(vertex(theta_d), x); }

RowValue RowReader::evaluate_open(const adaptive::RowView& row, float x, bool drawn) const {
  const adaptive::TracedNodes& nodes = *row.nodes;
  const ClearAndAbsorbed g = ray_density(shape_of(nodes), fiber_.parameters.sigma_a, x);
  RowValue value;
  value.shape = normalised(g.absorbed, rows().absorbed_mass(row.node, nodes));
  const float share = service_->options().uniform_share_open;
  value.proposal = row.fit != nullptr
                       ? row.fit->proposal_density(x, share)
                       : (1 - share) * glm::dot(channel_weights_, value.shape) + share * inverse_two_pi_f;
  if (drawn && row.fit != nullptr) {
    service_->score(row, x, g.clear, value.proposal);
  } else {
    service_->observe(row, x, g.clear);
  }
  return value;
}

glm::vec3 RowReader::correction(const glm::vec3& shape, float theta_d, float x, float place) const {
  VertexKey key = vertex(theta_d);
  key.rays = correction_rays;
  key.place = place;
  return at_vertex(key, x).shape - shape;
}

}  // namespace tress::inline v0_2::fiber
