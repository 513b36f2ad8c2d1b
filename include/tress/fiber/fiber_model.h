// The BCSDF interface, the only one that the integrator uses.
//
// Everything is a density in dtheta_i dphi_i (ESTIMATOR.md, E5): L_r = integral S L_i dtheta_i dphi_i.
// wr is the known direction (towards the camera), wi the sampled one. f = S / cos^2 theta_i and
// pdf_solid_angle = pdf / cos theta_i are taken at the interface only. Not reciprocal.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "tress/fiber/lobes.h"
#include "tress/fiber/parameter_ranges.h"
#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

using FiberId = std::uint32_t;
/// The id that add_fiber() returns when it refuses. No fiber has it: it is black, is drawn nowhere and has pdf 0.
inline constexpr FiberId no_fiber = std::numeric_limits<FiberId>::max();

/// Room for the data that a model keeps with an event. Opaque: only models read it.
class alignas(16) EventConstants {
  template <class Constants>
  friend void* place_of(struct FiberEvent& event);
  template <class Constants>
  friend const Constants& constants_in(const struct FiberEvent& event);
  std::array<std::byte, 320> bytes_;
};

/// One shading event. xi1 and xi2 choose the grid node for every direction of this event, light samples included, so
/// sample, eval and pdf agree, and their mean is the interpolated density. Plain data, made by begin().
struct FiberEvent {
  FiberId fiber = 0;
  FiberDirection wr;
  float xi1 = 0, xi2 = 0;                     ///< uniform in [0, 1)
  float importance = 0;                       ///< the importance passed to begin()
  bool is_of_mean = false;                    ///< made for mean(): answered by its nodes alone
  LobeColors energy{};                        ///< E_p per channel at (phi_r, |theta_r|) under the fiber's color
  std::array<float, lobe_count> selection{};  ///< probability of each lobe, sums to 1
  EventConstants constants;                   ///< lobe constants for wr, written by the event's model
};

/// S per lobe and the density of the sampler, at one direction.
struct FiberValue {
  LobeColors s{};                   ///< 1/rad^2, per lobe and channel
  float pdf = 0;                    ///< Q, 1/rad^2, of all lobes together
  std::uint16_t queries = 0;        ///< row lookups made
  std::uint16_t exact_queries = 0;  ///< those answered by tracing (at the node or at the vertex)
  float objective = 0;              ///< sum of adaptive::RowView::objective over the queries, >= 0; 0 for `exact`
  FiberExit exit;                   ///< known if the fiber was traced from where the ray met it
  glm::vec3 total() const {
    glm::vec3 sum(0.0f);
    for (const glm::vec3& lobe : s) sum += lobe;
    return sum;
  }
};

struct FiberSample {
  FiberDirection wi;
  Lobe lobe = Lobe::r;  ///< the lobe that drew it
  /// The value at wi; total()/pdf is the weight of the sample. It equals evaluate() at wi, except where an event of a
  /// row draws a path of the fiber instead (adaptive::Options::heard_share): the pdf is then the row's, and the weight
  /// the path's.
  FiberValue value;
  /// Length of the path inside the cortex, major semi-axes, if one was traced; negative if a row was drawn from.
  float way = -1;
};

/// Thread-safety: any thread may call begin, sample and evaluate during a pass. All other functions: one thread,
/// between passes.
class FiberModel {
 public:
  virtual ~FiberModel() = default;
  virtual std::string name() const = 0;
  /// Makes a fiber usable; equal parameters give the same id. Returns no_fiber if parameters are out of their ranges
  /// (out_of_range() names one) or the service refuses its slices, for instance during a pass that it checks.
  FiberId add_fiber(const FiberParameters& parameters) {
    if (out_of_range(parameters) != nullptr) return no_fiber;
    const FiberId id = make_fiber(parameters);
    if (id != no_fiber && id >= fiber_count_) fiber_count_ = id + 1;
    return id;
  }
  /// Whether add_fiber() gave this id. Any thread.
  bool has(FiberId fiber) const { return fiber < fiber_count_; }
  /// h in [-1, 1]: where the ray of wr meets the fiber, over its projected half width, towards rising azimuth. It is
  /// uniform over all rays. Near-field models (chiang2016, fiber3d) depend on it; far-field ones have the mean over it.
  /// importance: luminance of the value of a unit of light scattered here for the picture, divided by the number of
  /// directions that will be drawn. It is the throughput of the path so far, 1 at its first hit; rows are credited with
  /// it. Values out of range are clamped, NaN counts as 0, and an unknown id gives black.
  FiberEvent begin(FiberId fiber, const FiberDirection& wr, float xi1, float xi2, float h, float importance = 1) const {
    return begun(&FiberModel::make_event, fiber, wr, xi1, xi2, h, importance);
  }
  /// The same for a fiber that the picture resolves across its width: a model whose rows are the mean over h traces the
  /// fiber from h if it can, without using a row. All other models do the same as begin().
  FiberEvent begin_near(FiberId fiber, const FiberDirection& wr, float xi1, float xi2, float h,
                        float importance = 1) const {
    return begun(&FiberModel::make_near_event, fiber, wr, xi1, xi2, h, importance);
  }
  /// The same for a fiber that touches others: sample() traces from h, since where light leaves decides which neighbour
  /// it meets; evaluate() has the mean over h, as after begin(), since light from one direction is bright from a part
  /// of the width only. The pdf is the row's plus drawn_near_density. Weigh sampled light against directions that find
  /// light by the fourth powers of densities: broad lights are then seen from h, small ones from the mean.
  FiberEvent begin_drawn_near(FiberId fiber, const FiberDirection& wr, float xi1, float xi2, float h,
                              float importance = 1) const {
    return begun(&FiberModel::make_drawn_near_event, fiber, wr, xi1, xi2, h, importance);
  }
  /// 1/sr. A light is small to begin_drawn_near() where light samples are denser than that (bench/README.md, near).
  static constexpr float drawn_near_density = 0.3f;
  /// u: four independent uniforms in [0,1): lobe, theta, phi, spare. Cannot fail; finite for every input.
  FiberSample sample(const FiberEvent& event, const std::array<float, 4>& u) const {
    if (event.fiber >= fiber_count_) return {};
    return sample_event(event, {uniform(u[0]), uniform(u[1]), uniform(u[2]), uniform(u[3])});
  }
  /// Clamps its arguments as sample() does.
  FiberValue evaluate(const FiberEvent& event, const FiberDirection& wi) const {
    if (event.fiber >= fiber_count_) return {};
    return evaluate_event(event, wi);
  }
  /// The density alone: the pdf of evaluate(), at less cost where evaluate() traces.
  float pdf(const FiberEvent& event, const FiberDirection& wi) const {
    return event.fiber < fiber_count_ ? pdf_of_event(event, wi) : 0;
  }
  /// Whether the model implements the two functions below.
  virtual bool has_spectra() const { return false; }
  /// S at wi, of all lobes, under other absorptions than the fiber's: a texture's color, or wavelengths. sigma_a: for
  /// each channel, any number of them, per major semi-axis, clamped to [0, 1e20], NaN counts as 0; s: has as many,
  /// or the shorter counts and the rest of s is 0. Gains count by their luminance. Returns the pdf, which is that of
  /// the fiber's own color: add fibers whose colors are near those to come. It counts a query of its own. Where the
  /// model has none, s is 0.
  float evaluate_spectrum(const FiberEvent& event, const FiberDirection& wi, std::span<const float> sigma_a,
                          std::span<float> s) const {
    std::ranges::fill(s, 0.0f);
    if (event.fiber >= fiber_count_) return 0;
    with_absorptions(sigma_a, s, [&](auto valid, auto out) { add_spectrum(event, wi, valid, out); });
    return pdf_of_event(event, wi);
  }
  /// sample(), and S of the same light under other absorptions: s / value.pdf are the weights.
  FiberSample sample_spectrum(const FiberEvent& event, const std::array<float, 4>& u, std::span<const float> sigma_a,
                              std::span<float> s) const {
    const FiberSample drawn = sample(event, u);
    std::ranges::fill(s, 0.0f);
    if (event.fiber >= fiber_count_) return drawn;
    with_absorptions(sigma_a, s, [&](auto valid, auto out) {
      if (drawn.way < 0) {
        add_spectrum(event, drawn.wi, valid, out);
      } else {
        recolor_path(event, drawn, valid, out);
      }
    });
    return drawn;
  }
  /// S and Q without an event: the mean over the nodes that the events of wr may choose, so a pure function of the
  /// published rows and the directions; the mean of evaluate() over xi1 and xi2. A pdf of 0 means that it is not known
  /// without an event: the fiber is unknown, or events of wr can only be sampled or estimated. `corrected` gives what
  /// `fitted` gives. h: as in begin(). Any thread, during a pass; it costs 4 evaluations or so, counts the queries of
  /// their rows, and credits no light.
  FiberValue mean(FiberId fiber, const FiberDirection& wr, const FiberDirection& wi, float h = 0) const;
  /// Draws a direction from the pdf of mean(), and gives both: u: as in sample(), then xi1, xi2. Where mean() is not
  /// known, value.pdf is 0: begin an event then. The light is credited as that of an event.
  FiberSample sample_mean(FiberId fiber, const FiberDirection& wr, const std::array<float, 6>& u, float importance = 1,
                          float h = 0) const;
  /// False if the model can only be sampled, or estimated (estimates()). If it can only be sampled, sample() gives its
  /// weight as total() over a pdf of 1, evaluate() gives 0, and no light may be sampled: only sampled directions find
  /// lights.
  virtual bool evaluates() const { return true; }
  /// The same for one event: false if this event can only be sampled.
  virtual bool evaluates(const FiberEvent& /*event*/) const { return evaluates(); }
  /// True if an event cannot be evaluated but can be estimated. evaluate() then gives a random value whose mean over
  /// events is S, with a pdf that is any positive function of the direction, the same that sample() gives. Weighted by
  /// those pdfs, sampled lights and lights that directions find add up to an unbiased picture.
  virtual bool estimates(const FiberEvent& /*event*/) const { return estimates(); }
  /// True if all events that cannot be evaluated can be estimated.
  virtual bool estimates() const { return false; }
  /// How closely sampled directions follow the fiber's lobes, 1/sr: the density that balances them against lights at an
  /// event that is estimated, at least that of any other. Infinity if the model can only be sampled. For an event that
  /// is evaluated it is the uniform density, since the event's own is known.
  virtual float balance(FiberId /*fiber*/) const {
    return evaluates() ? 1 / (4 * std::numbers::pi_v<float>) : std::numeric_limits<float>::infinity();
  }
  /// True if the model implements excess().
  virtual bool tells_excess() const { return false; }
  /// The error of the model at wi that is due to its rows, 1/rad^2 by channel, of either sign. It is the sum over lobes
  /// of the mean of S over the nodes that xi1 and xi2 may choose, minus S without grid and fit. The latter is the mean
  /// over `place`, uniform in [0, 1). It costs a trace, some 20 times an evaluation, and rows do not learn from it.
  virtual glm::vec3 excess(const FiberEvent& /*event*/, const FiberDirection& /*wi*/, float /*place*/) const {
    return glm::vec3(0.0f);
  }
  /// Memory of fibers and energies, without the rows of the service; 0 if unknown.
  virtual std::size_t bytes() const { return 0; }

 protected:
  /// Where begin() at wr, or the answer at wi, changes to other nodes as xi1 or xi2 rises through [0, 1]; 0: nowhere.
  struct NodeSteps {
    std::array<float, 4> xi1{};
    float xi2 = 0;
  };

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
  /// Clamps into [0, 1); NaN becomes 0.
  static float uniform(float u) { return u >= 0 ? (u < 1 ? u : 0x1.fffffep-1f) : 0.0f; }

  /// Calls call(sigma_a, s) for as many channels as both have, with absorptions in their range.
  template <class Call>
  static void with_absorptions(std::span<const float> sigma_a, std::span<float> s, Call&& call) {
    constexpr float most = 1e20f;  // so that products with it are finite; it leaves no light
    const std::size_t count = std::min(sigma_a.size(), s.size());
    if (count == 0) return;
    sigma_a = sigma_a.first(count);
    if (std::ranges::all_of(sigma_a, [](float one) { return one >= 0 && one <= most; }))
      return call(sigma_a, s.first(count));
    std::vector<float> valid;
    for (const float one : sigma_a) valid.push_back(one > 0 ? std::min(one, most) : 0.0f);
    call(std::span<const float>(valid), s.first(count));
  }

  /// These do the same as the public functions, for parameters in their ranges and fibers that were added. Directions
  /// may be any numbers: NaN becomes 0.
  virtual FiberId make_fiber(const FiberParameters& parameters) = 0;
  virtual FiberSample sample_event(const FiberEvent& event, const std::array<float, 4>& u) const = 0;
  virtual FiberValue evaluate_event(const FiberEvent& event, const FiberDirection& wi) const = 0;
  virtual float pdf_of_event(const FiberEvent& event, const FiberDirection& wi) const {
    return evaluate_event(event, wi).pdf;
  }
  /// Adds S by channel to s, which is 0.
  virtual void add_spectrum(const FiberEvent& /*event*/, const FiberDirection& /*wi*/,
                            std::span<const float> /*sigma_a*/, std::span<float> /*s*/) const {}
  /// Does the same for a path that sample_event() has traced.
  virtual void recolor_path(const FiberEvent& /*event*/, const FiberSample& /*drawn*/,
                            std::span<const float> /*sigma_a*/, std::span<float> /*s*/) const {}
  /// Does what begin() does, without the importance.
  virtual FiberEvent make_event(FiberId fiber, const FiberDirection& wr, float xi1, float xi2, float h) const = 0;
  /// Does what begin_near() does, without the importance.
  virtual FiberEvent make_near_event(FiberId fiber, const FiberDirection& wr, float xi1, float xi2, float h) const {
    return make_event(fiber, wr, xi1, xi2, h);
  }

  /// Does what begin_drawn_near() does, without the importance.
  virtual FiberEvent make_drawn_near_event(FiberId fiber, const FiberDirection& wr, float xi1, float xi2,
                                           float h) const {
    return make_near_event(fiber, wr, xi1, xi2, h);
  }

  /// Does the work of node_steps() in a model whose answers depend on xi by the choice of nodes alone.
  virtual NodeSteps steps_between_nodes(FiberId /*fiber*/, const FiberDirection& /*wr*/,
                                        const FiberDirection& /*wi*/) const {
    return {};
  }

  FiberId fiber_count_ = 0;
};

}  // namespace tress::inline v0_2::fiber
