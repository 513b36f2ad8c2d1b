// One query of the azimuthal shape of TT, TRT, TRRT or GLINT: from g at the node of a row, or from a trace at the
// vertex.
#pragma once

#include "models/elliptical/elliptical_fiber.h"
#include "models/elliptical/vertex_trace.h"

namespace tress::inline v0_2::fiber {

/// Reads rows for one lobe of one event. It has plain references and must not outlive the call that made it. Any
/// thread. `service` null: every answer is traced at the vertex.
class RowReader {
 public:
  /// folded_phi_r: from fold_azimuth(event.wr.phi). row_lobe: index into row_lobes. channel_weights: the shares of the
  /// channels in the luminance of the lobe's energy, sum 1.
  RowReader(const EllipticalFiber& fiber, const adaptive::Service* service, std::size_t row_lobe, float folded_phi_r,
            const glm::vec3& channel_weights)
      : fiber_(fiber),
        service_(service),
        row_lobe_(row_lobe),
        phi_r_(folded_phi_r),
        channel_weights_(channel_weights) {}

  /// Draws x, the folded relative azimuth, from the proposal of a row that has not converged. row null: from a trace at
  /// the vertex, for a model without a service. u in [0, 1).
  float sample(const adaptive::RowView* row, float theta_d, float u_channel, float u_ray, float u_blur) const;

  /// Shape and proposal at x of a row that has not converged; `drawn`: whether sample() drew x from it. Passes g there
  /// to the service.
  RowValue evaluate_open(const adaptive::RowView& row, float x, bool drawn) const;

  /// The same, traced at (phi_r, theta_d).
  RowValue evaluate_at_vertex(float theta_d, float x) const;

  /// The difference per channel between g at (phi_r, theta_d) and `shape`, the answer at x. place: of each ray in its
  /// share of h, uniform in [0, 1) over directions.
  glm::vec3 correction(const glm::vec3& shape, float theta_d, float x, float place) const;

 private:
  VertexKey vertex(float theta_d) const;
  RowValue at_vertex(const VertexKey& key, float x) const;
  float sample_rays(const RayShape& rays, const glm::vec3& mass, float share, float u_channel, float u_ray,
                    float u_blur) const;
  const ColoredRows& rows() const { return *fiber_.rows[row_lobe_]; }

  const EllipticalFiber& fiber_;
  const adaptive::Service* service_;
  std::size_t row_lobe_;
  float phi_r_;  ///< folded
  glm::vec3 channel_weights_;
};

}  // namespace tress::inline v0_2::fiber
