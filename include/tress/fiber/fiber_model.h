// The one BCSDF interface that the integrator knows; models/ has one file per model behind it.
//
// Everything is a density in dtheta_i dphi_i (ESTIMATOR.md, E5): L_r = integral S L_i dtheta_i dphi_i.
// wr is the known direction (towards the camera), wi the sampled one. f = S / cos^2 theta_i and
// pdf_solid_angle = pdf / cos theta_i are taken at the interface only. Not reciprocal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <numbers>
#include <string>

#include "tress/fiber/lobes.h"
#include "tress/fiber/parameter_ranges.h"
#include "tress/fiber/parameters.h"

namespace tress::fiber {

using FiberId = std::uint32_t;
/// What add_fiber() gives where it refuses, an id that no fiber has: black, drawn nowhere, pdf 0.
inline constexpr FiberId no_fiber = std::numeric_limits<FiberId>::max();

/// Room for what a model keeps with an event. Opaque: only models read it (src/fiber/event_constants.h).
class alignas(16) EventConstants {
  template <class Constants>
  friend void* place_of(struct FiberEvent& event);
  template <class Constants>
  friend const Constants& constants_in(const struct FiberEvent& event);
  std::array<std::byte, 320> bytes_;
};

/// One shading event. xi1, xi2 choose the grid node of every direction of this event, light samples included:
/// sample, eval and pdf then agree, and the mean is the interpolated density. Plain data, made by begin().
struct FiberEvent {
  FiberId fiber = 0;
  FiberDirection wr;
  float xi1 = 0, xi2 = 0;                     ///< uniform in [0, 1)
  float importance = 0;                       ///< as begin() was told
  LobeColors energy{};                        ///< E_p per channel at (phi_r, |theta_r|) under the fiber's color
  std::array<float, lobe_count> selection{};  ///< probability of each lobe, sums to 1
  EventConstants constants;                   ///< of the model that began the event: of its lobes, for wr
};

/// S per lobe and the density of the sampler, at one direction.
struct FiberValue {
  LobeColors s{};                   ///< 1/rad^2, per lobe and channel
  float pdf = 0;                    ///< Q, 1/rad^2, whichever lobe was drawn
  std::uint16_t queries = 0;        ///< row lookups made
  std::uint16_t exact_queries = 0;  ///< of them answered by tracing (at the node or at the vertex)
  float objective = 0;              ///< sum over the queries of how far their rows' fits are known to be from g, >= 0:
                                    ///< adaptive::RowView::objective; 0 for `exact`, which asks no row
  glm::vec3 total() const {
    glm::vec3 sum(0.0f);
    for (const glm::vec3& lobe : s) sum += lobe;
    return sum;
  }
};

struct FiberSample {
  FiberDirection wi;
  Lobe lobe = Lobe::r;  ///< that drew it
  /// At wi; total()/pdf is the weight of the sample. It is evaluate() at wi but where the event of a row draws a path
  /// of the fiber instead (adaptive::Options::heard_share): the pdf is the row's, and the weight that of the path.
  FiberValue value;
};

/// Thread-safety: begin, sample, evaluate: any thread, during a pass. The rest: one thread, between passes.
class FiberModel {
 public:
  virtual ~FiberModel() = default;
  virtual std::string name() const = 0;
  /// Makes a fiber usable; equal parameters give the same id. no_fiber where parameters are out of their ranges
  /// (out_of_range() names which) and where the service refuses its slices, as during a pass that it checks.
  FiberId add_fiber(const FiberParameters& parameters) {
    if (out_of_range(parameters) != nullptr) return no_fiber;
    const FiberId id = make_fiber(parameters);
    if (id != no_fiber && id >= fiber_count_) fiber_count_ = id + 1;
    return id;
  }
  /// h in [-1, 1]: where the ray of wr meets the fiber, over its projected half width, towards rising azimuth. Uniform
  /// over all rays; near-field models (chiang2016, fiber3d) depend on it, far-field ones have the mean over it.
  /// importance: luminance of what a unit of light scattered here is worth to the picture, over the number of
  /// directions that will be drawn: the throughput of the path so far, 1 at its first hit. Rows are credited with it.
  /// What is out of its range is brought into it, and what is not a number is 0; an id that was not given is black.
  FiberEvent begin(FiberId fiber, const FiberDirection& wr, float xi1, float xi2, float h, float importance = 1) const {
    return begun(&FiberModel::make_event, fiber, wr, xi1, xi2, h, importance);
  }
  /// The same where the picture sees across the fiber: a model whose rows are the mean over h traces the fiber from h,
  /// without asking a row, if it can. All other models answer as after begin().
  FiberEvent begin_near(FiberId fiber, const FiberDirection& wr, float xi1, float xi2, float h,
                        float importance = 1) const {
    return begun(&FiberModel::make_near_event, fiber, wr, xi1, xi2, h, importance);
  }
  /// u: four independent uniforms in [0,1): lobe, theta, phi, spare. Cannot fail; finite for every input.
  FiberSample sample(const FiberEvent& event, const std::array<float, 4>& u) const {
    if (event.fiber >= fiber_count_) return {};
    return sample_event(event, {uniform(u[0]), uniform(u[1]), uniform(u[2]), uniform(u[3])});
  }
  /// Brings its arguments into range as sample() does.
  FiberValue evaluate(const FiberEvent& event, const FiberDirection& wi) const {
    if (event.fiber >= fiber_count_) return {};
    return evaluate_event(event, wi);
  }
  /// False: the model can only be sampled, or estimated (estimates()). Where it can only be sampled sample() gives its
  /// weight as total() over a pdf of 1, evaluate() gives 0, and no light may be sampled: light is met by sampled
  /// directions alone.
  virtual bool evaluates() const { return true; }
  /// The same of one event: false where this event can only be sampled.
  virtual bool evaluates(const FiberEvent& /*event*/) const { return evaluates(); }
  /// True where an event cannot be evaluated but estimated: evaluate() gives a random value whose mean over events is
  /// S, beside a pdf that is any positive function of the direction, the same that sample() tells. Balanced by those,
  /// lights that are sampled and lights that are met add up to an unbiased picture.
  virtual bool estimates(const FiberEvent& /*event*/) const { return estimates(); }
  /// True where all events that cannot be evaluated are estimated.
  virtual bool estimates() const { return false; }
  /// How closely sampled directions follow the fiber's lobes, 1/sr: the density that balances them against lights at an
  /// event that is estimated, at least that of any other; infinity where the model can only be sampled. Of an event
  /// that is evaluated it is the evenly spread one, since its own is known.
  virtual float balance(FiberId /*fiber*/) const {
    return evaluates() ? 1 / (4 * std::numbers::pi_v<float>) : std::numeric_limits<float>::infinity();
  }
  /// True where excess() tells something.
  virtual bool tells_excess() const { return false; }
  /// How much more the model answers at wi than it would without its rows, 1/rad^2 by channel, of either sign: the sum
  /// over lobes of the mean of S over the nodes that xi1 and xi2 may choose, minus the S that neither grid nor fit is
  /// in. The latter in the mean over `place`, uniform in [0, 1). Costs a trace, some 20 times an evaluation, and tells
  /// the service nothing.
  virtual glm::vec3 excess(const FiberEvent& /*event*/, const FiberDirection& /*wi*/, float /*place*/) const {
    return glm::vec3(0.0f);
  }
  /// Memory of fibers and energies, without what the service keeps of rows; 0 if not known.
  virtual std::size_t bytes() const { return 0; }

 private:
  using Make = FiberEvent (FiberModel::*)(FiberId, const FiberDirection&, float, float, float) const;
  FiberEvent begun(Make make, FiberId fiber, const FiberDirection& wr, float xi1, float xi2, float h,
                   float importance) const {
    if (fiber >= fiber_count_) [[unlikely]]
      return black_event();
    FiberEvent event =
        (this->*make)(fiber, wr, uniform(xi1), uniform(xi2), h >= -1 ? (h <= 1 ? h : 1.0f) : (h < -1 ? -1.0f : 0.0f));
    event.importance = importance >= 0 && importance <= std::numeric_limits<float>::max() ? importance : 0.0f;
    return event;
  }
  static FiberEvent black_event() {
    FiberEvent event{};
    event.fiber = no_fiber;
    return event;
  }
  /// Into [0, 1); what is not a number is 0.
  static float uniform(float u) { return u >= 0 ? (u < 1 ? u : 0x1.fffffep-1f) : 0.0f; }

  /// As the public ones, of parameters in their ranges and of fibers that were added. Of directions any number: what is
  /// not one is 0 (clamped() in src/fiber/event_constants.h).
  virtual FiberId make_fiber(const FiberParameters& parameters) = 0;
  virtual FiberSample sample_event(const FiberEvent& event, const std::array<float, 4>& u) const = 0;
  virtual FiberValue evaluate_event(const FiberEvent& event, const FiberDirection& wi) const = 0;
  /// begin(), but for the importance.
  virtual FiberEvent make_event(FiberId fiber, const FiberDirection& wr, float xi1, float xi2, float h) const = 0;
  /// begin_near(), but for the importance.
  virtual FiberEvent make_near_event(FiberId fiber, const FiberDirection& wr, float xi1, float xi2, float h) const {
    return make_event(fiber, wr, xi1, xi2, h);
  }

  FiberId fiber_count_ = 0;
};

}  // namespace tress::fiber
