#include "integrate/near_rule.h"

#include <fmt/format.h>

#include <algorithm>

namespace tress::integrate {
namespace {

float width_of(const geometry::Hit& hit) { return 2 * hit.semi_axis_cm; }

}  // namespace

void measure_needs(NearOptions& options, const scene::Scene& scene, const geometry::FiberScene& fibers) {
  using Where = NearOptions::Where;
  options.needs = {};
  if (options.where == Where::nowhere || options.where == Where::everywhere) return;
  const float close = options.where == Where::usual ? NearOptions::loose : 1;
  options.needs = measured_needs(
      scene, fibers, {close, NearOptions::least_gain, NearOptions::sure_gain, options.where == Where::seen});
}

float NearOptions::share(std::size_t groom) const {
  const float gain = where == Where::usual ? needs.even * needs.lost[groom] : sure_gain;
  const auto rise = [](float x, float from, float to) { return std::clamp((x - from) / (to - from), 0.0f, 1.0f); };
  return rise(needs.closeness[groom], loose, dense) * rise(gain, least_gain, sure_gain);
}

void set_asked(const scene::Integrator& asked, NearOptions* near) {
  using Where = NearOptions::Where;
  near->pixels = asked.near_pixels.value_or(near->pixels);
  if (asked.near == "nowhere" || !(near->pixels > 0)) near->where = Where::nowhere;
  if (asked.near == "seen") near->where = Where::seen;
  if (asked.near == "touching") near->where = Where::touching;
  if (asked.near == "everywhere") near->where = Where::everywhere;
}

std::string words_of(const NearOptions& options) {
  using Where = NearOptions::Where;
  if (options.where == Where::nowhere) return "near nowhere: rows answer every hit";
  if (options.where == Where::everywhere) return "near everywhere: every hit is traced from where it is";
  std::string words = fmt::format("near where fibers are wider than {:.4g} pixels", options.pixels);
  float closest = 0, share = 0, lost = 0;
  for (std::size_t groom = 0; groom < options.needs.closeness.size(); ++groom) {
    closest = std::max(closest, options.needs.closeness[groom]);
    share = std::max(share, options.share(groom));
    lost = std::max(lost, options.needs.lost[groom]);
  }
  if (closest > NearOptions::loose) {
    switch (options.where) {
      case Where::seen:
        words += "; fibers touch, where rows may be too dark, unless \"near\" is left out or \"touching\"";
        break;
      case Where::touching:
        words += fmt::format(", and at {:.0f} % of the hits where they touch", 100 * share);
        break;
      default:
        if (share > 0)
          words += fmt::format(", and but for small lights at {:.0f} % of the hits where they touch", 100 * share);
        words += fmt::format("; rows lose about {:.2g} % of the light there, of which {:.0f} % is even", 100 * lost,
                             100 * options.needs.even);
        if (lost * (1 - options.needs.even) > NearOptions::sure_gain)
          words += "; for the rest set \"near\": \"touching\"";
    }
  }
  if (!options.needs.closeness.empty())
    words += fmt::format(" ({:.3g} % of the light that leaves one meets another within {:.4g} widths; {:.0f} count)",
                         100 * closest, close_widths, 100 * NearOptions::loose);
  return words;
}

NearRule::NearRule(const NearOptions& options) : where_(options.where), pixels_(options.pixels) {
  if (options.where != NearOptions::Where::usual && options.where != NearOptions::Where::touching) return;
  for (std::size_t groom = 0; groom < options.needs.closeness.size(); ++groom)
    by_groom_.push_back(options.share(groom));
  if (std::ranges::all_of(by_groom_, [](float share) { return share == 0; })) by_groom_.clear();
}

NearShares NearRule::of_touching(float share) const {
  return {where_ == NearOptions::Where::touching ? share : 0, share};
}

NearShares NearRule::of_seen(const geometry::Hit& hit, float pixel_cm) const {
  if (hit.is_surface || where_ == NearOptions::Where::nowhere) return {};
  if (where_ == NearOptions::Where::everywhere) return {1, 1};
  NearShares shares = of_touching(by_groom_.empty() ? 0 : by_groom_[hit.groom]);
  shares.all = std::max(shares.all, std::clamp(width_of(hit) / (pixel_cm * pixels_) - 1, 0.0f, 1.0f));
  return shares;
}

NearShares NearRule::of_later(const geometry::Hit& hit) const {
  if (hit.is_surface || where_ == NearOptions::Where::nowhere) return {};
  if (where_ == NearOptions::Where::everywhere) return {1, 1};
  if (by_groom_.empty()) return {};
  return of_touching(by_groom_[hit.groom] *
                     std::clamp(2 - hit.distance_cm / (near_widths * width_of(hit)), 0.0f, 1.0f));
}

}  // namespace tress::integrate
