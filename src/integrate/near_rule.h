// Which hits on fibers are traced from where the ray met the fiber (FiberModel::begin_near()).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "geometry/fiber_scene.h"
#include "integrate/near_hit.h"
#include "integrate/near_needs.h"
#include "scene/model/scene.h"
#include "tress/base/random.h"

namespace tress::integrate {

/// Rows are the mean over a fiber's width, so they are used where neither the picture resolves the width nor light goes
/// on to a neighbour that is so close that it matters where on the fiber it left.
struct NearOptions {
  /// seen: first hits on fibers that the picture resolves. usual: these, and directions that are drawn where fibers
  /// touch and the picture would else be darker by least_gain. touching: these, and all light where fibers touch, with
  /// several times the variance of rows under small lights.
  enum class Where { usual, seen, touching, nowhere, everywhere } where = Where::usual;
  /// Width in pixels from which first hits are traced. Their share rises evenly to all at twice the width.
  float pixels = 2;
  NearNeeds needs = {};  ///< of measure_needs(); empty if nothing was measured

  /// The share of the hits of a groom that are near because fibers touch: 0 up to the closeness `loose`, all from
  /// `dense` on. By the usual rule none of these where drawn directions would gain at most least_gain of the groom's
  /// brightness, all from sure_gain on.
  float share(std::size_t groom) const;
  static constexpr float loose = 0.12f, dense = 0.14f, least_gain = 0.015f, sure_gain = 0.035f;
};

/// Measures a scene for the rule, or for its words, where they depend on it (near_needs.h).
void measure_needs(NearOptions& options, const scene::Scene& scene, const geometry::FiberScene& fibers);
/// Sets where a scene says so.
void set_asked(const scene::Integrator& asked, NearOptions* near);
/// What the rule is in a scene, in words.
std::string words_of(const NearOptions& options);

/// The shares of hits that begin near: traced in all they are asked, and in what they draw at least.
struct NearShares {
  float all = 0, drawn = 0;
};

/// Immutable; any thread. Every share is continuous in the camera, so no edge shows. The gain is measured by random
/// rays, to a standard error of 0.003 to 0.01 where it is between least_gain and sure_gain.
class NearRule {
 public:
  NearRule() = default;
  explicit NearRule(const NearOptions& options);

  /// The shares of camera hits like this one. pixel_cm: width of a pixel there.
  NearShares of_seen(const geometry::Hit& hit, float pixel_cm) const;
  /// The same of later hits: where fibers are close, those that light reached from no farther than near_widths fiber
  /// widths, and none from twice as far.
  NearShares of_later(const geometry::Hit& hit) const;
  static constexpr float near_widths = 4;
  /// How a hit of these shares begins. It depends on these numbers only, and draws none from another stream.
  static NearHit chosen(const NearShares& shares, std::uint64_t seed, std::uint64_t first, std::uint64_t second) {
    constexpr std::uint64_t purpose = 0x6e656172ull;
    if (!(shares.all > 0) && !(shares.drawn > 0)) return NearHit::no;
    const float number = RandomStream(seed ^ purpose, first, second).next();
    return number < shares.all ? NearHit::all : (number < shares.drawn ? NearHit::drawn : NearHit::no);
  }

 private:
  NearShares of_touching(float share) const;

  NearOptions::Where where_ = NearOptions::Where::nowhere;
  float pixels_ = 0;
  std::vector<float> by_groom_;  ///< shares; empty if all are 0
};

}  // namespace tress::integrate
