// The memory of published mixtures: blocks of exactly their size, side by side.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "tress/adaptive/mixture.h"

namespace tress::adaptive {

/// Owns all mixtures that were put into it, for its whole life. One thread.
class MixtureStore {
 public:
  const PackedMixture* put(const Mixture& fit, float objective) {
    return PackedMixture::put(block(fit.component_count), fit, objective);
  }

  /// Frees the memory for the next mixture of as many components.
  void give_back(const PackedMixture* fit) {
    if (fit != nullptr) free_[fit->component_count].push_back(const_cast<PackedMixture*>(fit));
  }

 private:
  static constexpr std::size_t chunk_words = 2048;

  void* block(std::uint32_t components) {
    if (std::vector<void*>& free = free_[components]; !free.empty()) {
      void* memory = free.back();
      free.pop_back();
      return memory;
    }
    const std::size_t words = PackedMixture::bytes_of(components) / sizeof(std::uint32_t);
    if (used_words_ + words > chunk_words) {
      chunks_.push_back(std::make_unique<std::uint32_t[]>(chunk_words));
      used_words_ = 0;
    }
    void* memory = chunks_.back().get() + used_words_;
    used_words_ += words;
    return memory;
  }

  std::vector<std::unique_ptr<std::uint32_t[]>> chunks_;
  std::size_t used_words_ = chunk_words;  ///< words used in the last chunk
  std::array<std::vector<void*>, Mixture::max_components + 1> free_;
};

}  // namespace tress::adaptive
