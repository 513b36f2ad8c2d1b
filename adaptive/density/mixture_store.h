// The memory of published mixtures: blocks of exactly their size, side by side.
#pragma once

#include "density/block_store.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::adaptive {

/// Owns all mixtures that were put into it, for its whole life.
class MixtureStore {
 public:
  const PackedMixture* put(const Mixture& fit, float objective) {
    return PackedMixture::put(blocks_.take(PackedMixture::bytes_of(fit.component_count)), fit, objective);
  }
  /// Frees the memory for the next mixture of as many components.
  void give_back(const PackedMixture* fit) {
    if (fit != nullptr) blocks_.give_back(const_cast<PackedMixture*>(fit), fit->bytes());
  }

 private:
  BlockStore<alignof(PackedMixture), 2048> blocks_;
};

}  // namespace tress::inline v0_2::adaptive
