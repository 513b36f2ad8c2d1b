// Random numbers of a row.
#pragma once

#include <bit>
#include <cstdint>

#include "tress/adaptive/target.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {

/// The stream of a node of a slice in a pass. Pure.
inline RandomStream row_stream(std::uint64_t seed, const SliceKey& key, std::uint32_t node, std::uint32_t pass) {
  std::uint64_t mixed = mix_bits(seed) ^ key.lobe;
  for (const float parameter : key.used_parameters())
    mixed = mix_bits(mixed) ^ std::bit_cast<std::uint32_t>(parameter + 0.0f);
  return RandomStream(mixed, node, pass);
}

}  // namespace tress::inline v0_2::adaptive
