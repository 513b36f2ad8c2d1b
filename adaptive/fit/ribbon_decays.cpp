#include "fit/ribbon_decays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace tress::adaptive {
namespace {

/// Light, and what is left of it at both rates.
struct Kept {
  double all = 0;
  std::array<double, 2> left{};
  void add(double weight, const std::array<float, 2>& decays) {
    all += weight;
    for (std::size_t r = 0; r < 2; ++r) left[r] += weight * static_cast<double>(decays[r]);
  }
};

}  // namespace

void write_decays(const RibbonLight& light, const MainLayer& main_layer, const BroadLayer& broad_layer,
                  const std::vector<float>& main_share, std::span<RibbonKnot> main, std::span<RibbonKnot> broad) {
  std::array<Kept, Ribbon::main_knots> of_main;
  std::array<Kept, Ribbon::broad_knots> of_broad;
  Kept all;
  for (const RibbonPiece& piece : light.pieces) {
    const RibbonSegment in_main = main_layer.segment(piece.main, piece.before_first),
                        in_broad = broad_layer.segment(piece.broad, false);
    for (std::uint32_t i = piece.begin; i < piece.end; ++i) {
      const std::array<float, 2> decays{std::exp(-Ribbon::decay_rates[0] * light.exits.attribute[i]),
                                        std::exp(-Ribbon::decay_rates[1] * light.exits.attribute[i])};
      const double w = static_cast<double>(light.weights[i]), m = w * static_cast<double>(main_share[i]);
      const double s = static_cast<double>((light.exits.x[i] - in_main.x0) * in_main.inverse_width);
      const double q = static_cast<double>((light.exits.x[i] - in_broad.x0) * in_broad.inverse_width);
      of_main[piece.main].add(m * (1 - s), decays);
      of_main[MainLayer::after(piece.main)].add(m * s, decays);
      of_broad[piece.broad].add((w - m) * (1 - q), decays);
      of_broad[BroadLayer::after(piece.broad)].add((w - m) * q, decays);
      all.add(w, decays);
    }
  }
  if (!(all.all > 0)) return;
  const auto write = [&](std::span<const Kept> of, std::span<RibbonKnot> knots) {
    constexpr double prior = 2;  // exits of the mean of all
    for (std::size_t k = 0; k < knots.size(); ++k) {
      for (std::size_t r = 0; r < 2; ++r) {
        const double mean = (of[k].left[r] + prior * all.left[r] / all.all) / (of[k].all + prior);
        knots[k].decays[r] = static_cast<float>(std::clamp(mean, 0.0, 1.0));
      }
    }
  };
  write(of_main, main);
  write(of_broad, broad);
}

}  // namespace tress::adaptive
