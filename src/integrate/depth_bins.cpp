#include "integrate/depth_bins.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace tress::integrate {

static_assert(std::is_trivially_copyable_v<DepthBins> &&
              sizeof(DepthBin) == sizeof(glm::dvec3) + 2 * sizeof(float) + 2 * sizeof(std::uint32_t));

void DepthBins::add(const glm::dvec3& light, float distance_cm) {
  const auto end = std::find_if(bins.begin(), bins.end(), [](const DepthBin& bin) { return bin.paths == 0; });
  const auto at = std::find_if(bins.begin(), end, [&](const DepthBin& bin) { return bin.far_cm >= distance_cm; });
  if (at != end && at->near_cm <= distance_cm) {
    at->light += light;
    ++at->paths;
    return;
  }
  std::array<DepthBin, most + 1> all{};
  const auto opened = std::copy(bins.begin(), at, all.begin());
  *opened = {light, distance_cm, distance_cm, 1};
  std::copy(at, end, opened + 1);
  if (end == bins.end()) {
    std::size_t first = 0;
    for (std::size_t i = 1; i < most; ++i) {
      if (all[i + 1].far_cm - all[i].near_cm < all[first + 1].far_cm - all[first].near_cm) first = i;
    }
    const DepthBin& second = all[first + 1];
    all[first].light += second.light;
    all[first].far_cm = second.far_cm;
    all[first].paths += second.paths;
    const auto joined = all.begin() + static_cast<std::ptrdiff_t>(first);
    std::copy(joined + 2, all.end(), joined + 1);
  }
  std::copy_n(all.begin(), most, bins.begin());
}

bool DepthBins::are_sound(std::uint32_t paths) const {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < most; ++i) {
    const DepthBin& bin = bins[i];
    sum += bin.paths;
    if (bin.paths == 0) continue;
    const bool follows = i == 0 || (bins[i - 1].paths > 0 && bins[i - 1].far_cm < bin.near_cm);
    if (!follows || !(bin.near_cm <= bin.far_cm) || !std::isfinite(bin.near_cm) || !std::isfinite(bin.far_cm) ||
        !std::isfinite(bin.light.x) || !std::isfinite(bin.light.y) || !std::isfinite(bin.light.z))
      return false;
  }
  return sum <= paths;
}

}  // namespace tress::integrate
