// One query of the azimuthal shape of TT, TRT or TRRT: from a converged row, from g at the node, or at the vertex.
#pragma once

#include "models/fiber_record.h"
#include "models/vertex_trace.h"
#include "tress/fiber/fiber_model.h"

namespace tress::fiber {

/// The node that answers one direction of one event, and what the service said of it.
struct RowQuery {
  std::uint32_t node = 0;
  bool uniform = false;  ///< no row: the lobe is spread evenly
  adaptive::RowView view;
};

/// Reads rows for one lobe of one event. Plain references: lives no longer than the call that made it. Any thread.
/// `service` null: every answer is traced at the vertex.
class RowReader {
 public:
  /// folded_phi_r: of fold_azimuth(event.wr.phi). p = 1, 2, 3; the lobe's energy in `event` must have positive
  /// luminance.
  RowReader(const FiberRecord& fiber, const adaptive::Service* service, const FiberEvent& event, float folded_phi_r,
            int p);

  /// Chooses the node by xi and looks it up (one query). theta_d >= 0.
  RowQuery find(float theta_d) const;

  /// Draws x, the folded relative azimuth, from the proposal. u in [0, 1).
  float sample(const RowQuery& row, float theta_d, float u_channel, float u_ray, float u_blur) const;

  /// Shape and proposal at x, which sample() drew from this row (`drawn`) or another density did. Tells the service
  /// what an open row's g is there. Sets *exact if tracing answered.
  RowValue evaluate(const RowQuery& row, float theta_d, float x, bool drawn, bool* exact) const;

  /// What g at (phi_r, theta_d) has more than `shape`, the answer of evaluate() at x, per channel; 0 where that was
  /// traced there already. place in [0, 1): of the rays; uniform over directions.
  glm::vec3 residual(const glm::vec3& shape, float theta_d, float x, float place) const;

 private:
  const LobePage& page() const { return fiber_.pages[static_cast<std::size_t>(p_ - 1)]; }
  bool proposes_only() const { return fiber_.proposes_only[static_cast<std::size_t>(p_ - 1)]; }
  VertexKey vertex(float theta_d) const;
  RowValue at_vertex(const VertexKey& key, float x) const;
  float sample_rays(const RayShape& rays, const glm::vec3& mass, float share, float u_channel, float u_ray,
                    float u_blur) const;

  const FiberRecord& fiber_;
  const adaptive::Service* service_;
  const FiberEvent& event_;
  int p_;
  float phi_r_;                ///< folded
  glm::vec3 channel_weights_;  ///< of the luminance of the lobe's energy, sum 1
};

}  // namespace tress::fiber
