// The elliptical model for rows in any state: absent, open, refused, traced at the vertex, corrected.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "fiber/row_model.h"
#include "models/elliptical/elliptical_fibers.h"
#include "models/elliptical/row_reader.h"
#include "models/elliptical/vertex_constants.h"
#include "tress/fiber/elliptical_model.h"
#include "tress/fiber/fiber_model.h"

namespace tress::inline v0_2::fiber {

/// Implements everything but begin() and directions whose rows have all converged. The derived model answers those in
/// lanes, and calls this one for the rest.
class AnyRowsModel : public RowModel {
 public:
  AnyRowsModel(Estimator estimator, adaptive::Service* service);

  std::string name() const override { return "elliptical"; }
  FiberId make_fiber(const FiberParameters& parameters) override { return fibers_.add(without_parts(parameters)); }
  std::size_t bytes() const override { return fibers_.bytes(); }
  bool tells_excess() const override { return estimator_ == Estimator::fitted; }
  glm::vec3 excess(const FiberEvent& event, const FiberDirection& wi, float place) const override;

 protected:
  /// The common data of all rows of one direction.
  struct Inclination {
    float theta_d;       ///< |theta_d|
    std::uint32_t node;  ///< chosen by xi2
  };
  Inclination inclination_of(const FiberEvent& event, float theta_i) const {
    const float theta_d = 0.5f * std::fabs(event.wr.theta - theta_i);
    return {theta_d, inclinations_.choose_inclination(theta_d, event.xi2)};
  }

  /// The xi2 from which the choice is the next node (FiberModel::NodeSteps).
  float step_of_inclination(const FiberDirection& wr, const FiberDirection& wi) const {
    return 1 - inclinations_.between_inclinations(0.5f * std::fabs(wr.theta - wi.theta)).share;
  }

  /// The index into row_lobes of a lobe other than R and the residual.
  static std::size_t row_lobe_of(int lobe) {
    return lobe == static_cast<int>(Lobe::glint) ? 3 : static_cast<std::size_t>(lobe) - 1;
  }

  /// The answers of the rows of one direction.
  struct Answers {
    std::array<const AbsorbedRow*, 4> row;  ///< of a converged row, or of a node without a row; null: use g of `asked`
    bool all = false;                       ///< whether all of `row` are set
    /// The rows that had no answer yet; null if there are none.
    std::unique_ptr<std::array<adaptive::FormedLookup, 4>> asked;
  };
  /// Makes the answers of converged rows that no thread has made yet, so that an event takes the same path through the
  /// code whatever other threads have done.
  void complete(const FiberEvent& event, const VertexConstants& constants, const Inclination& at, DirectionRows& rows,
                Answers& answers) const;
  /// Draws the azimuth of lobe p, whose row has not converged, by g of the node or of the vertex. u: numbers for the
  /// channel, the ray and the blur. The result is absolute, in [-pi, pi).
  float sample_any(const FiberEvent& event, const VertexConstants& constants, int p, const Inclination& at,
                   const std::array<float, 3>& u, DirectionRows& rows, Answers& answers) const;
  static constexpr int nothing_drawn = -1;
  /// S and Q at wi for rows in any state. drawn: the lobe that drew wi, if its row has not converged.
  FiberValue value_of_any(const FiberEvent& event, const VertexConstants& constants, const FiberDirection& wi,
                          const Inclination& at, int drawn, DirectionRows& rows, Answers& answers) const;

  /// Whether `corrected` traces this direction, for all lobes, and, if so, the place of its rays, in [0, 1). Both are
  /// pure functions of the event and the direction, so that sample() and evaluate() agree. Any bit of xi or of a
  /// direction changes the whole hash.
  std::optional<float> correction(const FiberEvent& event, const VertexConstants& constants,
                                  const FiberDirection& wi) const;
  /// Computes VertexConstants::hash.
  std::uint64_t hash_of_event(const FiberDirection& wr, float xi1, float xi2) const;

  Estimator estimator_;
  float uniform_share_ = 0;  ///< uniform share of the proposal of converged rows
  EllipticalFibers fibers_;

 private:
  /// The mean shape of lobe i at x, by channel, over the nodes around (folded phi_r, theta_d).
  glm::vec3 interpolated_shape(const FiberEvent& event, const VertexConstants& constants, std::size_t i, float theta_d,
                               float x) const;
  RowReader reader_of(const FiberEvent& event, const VertexConstants& constants, std::size_t i) const;
  /// Looks up the row of lobe i, which has no answer yet, unless it was looked up before: it then has an answer, or is
  /// in `asked`.
  void ask(const FiberEvent& event, const VertexConstants& constants, std::size_t i, const Inclination& at,
           DirectionRows& rows, Answers& answers) const;

  RowGrid inclinations_;  ///< used for its second axis only, which all slices share
};

}  // namespace tress::inline v0_2::fiber
