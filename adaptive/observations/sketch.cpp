#include "observations/sketch.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/pi.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr std::uint64_t empty_bin = ~std::uint64_t{0};
constexpr double offset_units = 2147483647.0;  // of half a bin width: 31 bits

bool usable(float g) { return std::isfinite(g) && g >= 0; }

void lower(std::atomic<std::uint64_t>& bin, std::uint64_t bits) {
  std::uint64_t seen = bin.load(std::memory_order_relaxed);
  while (bits < seen && !bin.compare_exchange_weak(seen, bits, std::memory_order_relaxed)) {
  }
}

}  // namespace

std::uint32_t Sketch::bin_count(float blur_rad) {
  const double wanted = std::ceil(6 * two_pi / std::max(static_cast<double>(blur_rad), 1e-4));
  return static_cast<std::uint32_t>(std::max(128.0, wanted));
}

Sketch::Sketch(std::uint32_t bins)
    : bin_count_(std::max(bins, 1u)), bins_(std::make_unique<std::atomic<std::uint64_t>[]>(bin_count_)) {
  clear();
}

void Sketch::clear() {
  for (std::uint32_t i = 0; i < bin_count_; ++i) bins_[i].store(empty_bin, std::memory_order_relaxed);
}

void Sketch::offer(float x, float g) {
  if (!usable(g) || !std::isfinite(x)) return;
  const double at = (wrap_angle(x) + pi) * (bin_count_ / two_pi);  // in bin widths
  const double index = std::clamp(std::floor(at), 0.0, bin_count_ - 1.0);
  const double offset = std::clamp(2 * (at - index) - 1, -1.0, 1.0);  // in half widths
  const auto magnitude = static_cast<std::uint64_t>(std::abs(offset) * offset_units + 0.5);
  const std::uint64_t sign = offset < 0 && magnitude > 0 ? 1 : 0;
  lower(bins_[static_cast<std::size_t>(index)], magnitude << 33 | sign << 32 | std::bit_cast<std::uint32_t>(g + 0.0f));
}

void Sketch::merge(const std::vector<SketchBin>& bins) {
  for (const SketchBin& bin : bins) {
    if (bin.index < bin_count_ && usable(std::bit_cast<float>(static_cast<std::uint32_t>(bin.bits)))) {
      lower(bins_[bin.index], bin.bits);
    }
  }
}

std::vector<SketchBin> Sketch::bins() const {
  std::vector<SketchBin> result;
  for (std::uint32_t i = 0; i < bin_count_; ++i) {
    const std::uint64_t bits = bins_[i].load(std::memory_order_relaxed);
    if (bits != empty_bin) result.push_back({i, bits});
  }
  return result;
}

std::vector<ObservedPair> Sketch::pairs() const {
  const float below_pi = std::nextafter(pi_f, 0.0f);
  std::vector<ObservedPair> result;
  for (const SketchBin& bin : bins()) {
    const double magnitude = static_cast<double>(bin.bits >> 33) / offset_units;
    const double offset = (bin.bits >> 32 & 1) != 0 ? -magnitude : magnitude;
    const double azimuth = (bin.index + 0.5 * (1 + offset)) * (two_pi / bin_count_) - pi;
    result.push_back(
        {std::min(static_cast<float>(azimuth), below_pi), std::bit_cast<float>(static_cast<std::uint32_t>(bin.bits))});
  }
  return result;
}

std::uint32_t Sketch::occupied() const {
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < bin_count_; ++i) {
    count += bins_[i].load(std::memory_order_relaxed) != empty_bin ? 1 : 0;
  }
  return count;
}

std::vector<float> gap_fill_azimuths(const std::vector<ObservedPair>& pairs, float blur_rad) {
  const double widest = 2.5 * std::max(static_cast<double>(blur_rad), 1e-4);
  std::vector<float> result;
  const auto fill = [&](double start, double gap, bool with_start) {
    const auto pieces = static_cast<int>(std::ceil(gap / widest));
    for (int i = with_start ? 0 : 1; i < pieces; ++i) {
      result.push_back(wrap_angle(static_cast<float>(start + gap * i / pieces)));
    }
  };
  // Nothing is observed, so the gap has no end points, and its start must be evaluated too.
  if (pairs.empty()) fill(-pi, two_pi, true);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double next = i + 1 < pairs.size() ? pairs[i + 1].azimuth : pairs[0].azimuth + two_pi;
    fill(pairs[i].azimuth, next - pairs[i].azimuth, false);
  }
  return result;
}

}  // namespace tress::inline v0_2::adaptive
