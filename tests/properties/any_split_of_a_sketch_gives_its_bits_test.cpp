// One pass equals its pieces: the same observations, in any order, dealt out to any number of sketches or threads, give
// the same bits.
#include <cstddef>
#include <cstdint>
#include <thread>
#include <utility>
#include <vector>

#include "observations/sketch.h"
#include "properties/generators.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

struct Observation {
  float x, g;
};

/// Azimuths in many turns, bunched so that bins are fought for; values equal now and then.
std::vector<Observation> observations(std::uint32_t count, std::uint64_t seed) {
  std::vector<Observation> all;
  for (std::uint32_t i = 0; i < count; ++i) {
    RandomStream random(seed, i);
    const float width = random.next() < 0.5f ? 0.3f : 20.0f;
    const float x = width * (random.next() - 0.5f);
    all.push_back({x, random.next() < 0.2f ? 0.5f : random.next()});
  }
  return all;
}

/// Drawn as three numbers: how many, of which seed, how they are dealt out.
RC_GTEST_PROP(Sketch, OfAPassEqualsThoseOfItsPieces, ()) {
  const std::vector<std::uint32_t> drawn = *any_numbers(3, 400);
  std::vector<Observation> all = observations(drawn[0], drawn[1]);
  const std::uint32_t bins = 128;
  Sketch one(bins);
  for (const Observation& seen : all) one.offer(seen.x, seen.g);

  RandomStream random(drawn[2]);
  for (std::size_t i = all.size(); i > 1; --i) std::swap(all[i - 1], all[random.next_bits() % i]);
  const std::size_t pieces = 1 + drawn[2] % 8;
  Sketch shared(bins), joined(bins);
  std::vector<std::vector<SketchBin>> apart(pieces);
  std::vector<std::thread> threads;
  for (std::size_t piece = 0; piece < pieces; ++piece) {
    threads.emplace_back([&, piece] {
      Sketch own(bins);
      for (std::size_t i = piece; i < all.size(); i += pieces) {
        shared.offer(all[i].x, all[i].g);
        own.offer(all[i].x, all[i].g);
      }
      apart[piece] = own.bins();
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t piece = pieces; piece-- > 0;) joined.merge(apart[piece]);
  RC_ASSERT(shared.bins() == one.bins());
  RC_ASSERT(joined.bins() == one.bins());
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
