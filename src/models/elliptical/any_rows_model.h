// The elliptical model whatever its rows have become: absent, open, refused, traced at the vertex, corrected.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "models/elliptical/fiber_store.h"
#include "models/elliptical/row_reader.h"
#include "models/elliptical/vertex_constants.h"
#include "tress/fiber/elliptical_model.h"
#include "tress/fiber/fiber_model.h"

namespace tress::fiber {

/// Everything but begin(), and but the directions whose rows have all converged: the model derived from it answers
/// those in lanes, and asks here for the rest.
class AnyRowsModel : public FiberModel {
 public:
  AnyRowsModel(Estimator estimator, adaptive::Service* service);

  std::string name() const override { return "elliptical"; }
  FiberId add_fiber(const FiberParameters& parameters) override { return fibers_.add(parameters); }
  void rows_changed() override { fibers_.rows_changed(); }
  std::size_t bytes() const override { return fibers_.bytes(); }

 protected:
  /// What all rows of one direction have in common.
  struct Inclination {
    float theta_d;       ///< |theta_d|
    std::uint32_t node;  ///< that xi2 chose
  };
  Inclination inclination_of(const FiberEvent& event, float theta_i) const {
    const float theta_d = 0.5f * std::fabs(event.wr.theta - theta_i);
    return {theta_d, inclinations_.choose_inclination(theta_d, event.xi2)};
  }

  /// Index into row_lobes of a lobe other than R and the residual.
  static std::size_t row_lobe_of(int lobe) {
    return lobe == static_cast<int>(Lobe::glint) ? 3 : static_cast<std::size_t>(lobe) - 1;
  }
  /// Shares of the channels in the luminance of a lobe's energy. The lobe is selected.
  static glm::vec3 channel_weights(const FiberEvent& event, std::size_t lobe);

  /// Copies the converged row of lobe i of row_lobes, if it is one: the copies that another thread has made are not to
  /// decide which way an answer is computed. Queries that the service counted.
  std::uint32_t fetch(const FiberEvent& event, const VertexConstants& constants, std::size_t i,
                      const Inclination& at) const;
  /// What draws the azimuth of lobe p at the inclination theta_i: a row that is not there yet, g of a node or the
  /// vertex. u: for the channel, the ray and the blur.
  FiberSample sample_any(const FiberEvent& event, const VertexConstants& constants, int p, float theta_i,
                         const Inclination& at, const std::array<float, 3>& u) const;
  /// S and Q at wi, whatever answers for each row. fetched: queries of these rows that fetch() had counted.
  FiberValue value_of_any(const FiberEvent& event, const VertexConstants& constants, const FiberDirection& wi,
                          const Inclination& at, std::uint32_t fetched) const {
    return value_of_any(event, constants, wi, at, nothing_drawn, nullptr, fetched);
  }

  /// Tells the service what light a drawn direction brings by each row, in proportion to the importance of the event:
  /// S/Q of its lobe, whose mean over directions is the lobe's energy. Always of rows that have not converged; of those
  /// that have at one event in light_interval, as many times.
  void tell_light(const FiberEvent& event, const VertexConstants& constants, const Inclination& at,
                  const FiberValue& value) const {
    const bool tells_all = static_cast<std::uint32_t>(event.xi1 * 0x1p24f) % light_interval == 0;
    if (tells_all || value.exact_queries != 0) [[unlikely]]
      tell_light(event, constants, at, value, tells_all);
  }

  /// Whether `corrected` traces this direction, for all lobes, and where its rays are placed, in [0, 1): pure functions
  /// of the event and the direction, so that sample() and evaluate() agree. Any bit of xi or of a direction changes the
  /// whole hash.
  std::optional<float> correction(const VertexConstants& constants, const FiberDirection& wi) const;
  /// VertexConstants::hash.
  std::uint64_t hash_of_event(const FiberDirection& wr, float xi1, float xi2) const;

  static constexpr float smallest_pdf = 1e-30f;  ///< where every lobe has underflowed; S is 0 there

  Estimator estimator_;
  adaptive::Service* service_;  ///< null for `exact`
  float uniform_share_ = 0;     ///< of the proposal of converged rows
  FiberStore fibers_;

 private:
  static constexpr std::uint32_t light_interval = 16;  ///< decided by the last bits of xi1, which choose no node
  void tell_light(const FiberEvent& event, const VertexConstants& constants, const Inclination& at,
                  const FiberValue& value, bool tells_all) const;
  static constexpr int nothing_drawn = -1;
  /// drawn: the lobe that drew wi, whose query (if it makes any) is then `known`.
  FiberValue value_of_any(const FiberEvent& event, const VertexConstants& constants, const FiberDirection& wi,
                          const Inclination& at, int drawn, const RowQuery* known, std::uint32_t fetched) const;
  RowReader reader_of(const FiberEvent& event, const VertexConstants& constants, std::size_t i) const;
  /// A node that has no copy, or that sample_any() has just asked for: `known`; without a service, the trace at the
  /// vertex.
  RowValue trace_or_ask(const FiberEvent& event, const VertexConstants& constants, std::size_t i, const Inclination& at,
                        float x, const RowQuery* known, FiberValue& value, bool& asks, bool& exact) const;

  RowGrid inclinations_;  ///< read along its second axis, which all slices share
};

}  // namespace tress::fiber
