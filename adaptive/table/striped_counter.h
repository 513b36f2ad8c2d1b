// A counter that many threads raise without sharing a cache line.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace tress::inline v0_2::adaptive {

/// A counter of which each thread adds to its own stripe. add() may be called from any thread and is wait-free; take()
/// from one thread, while no other adds.
class StripedCounter {
 public:
  void add(std::uint64_t n) { stripes_[stripe()].count.fetch_add(n, std::memory_order_relaxed); }

  /// The sum over all threads since the last take().
  std::uint64_t take() {
    std::uint64_t sum = 0;
    for (Stripe& stripe : stripes_) sum += stripe.count.exchange(0, std::memory_order_relaxed);
    return sum;
  }
  /// The same, and it stays.
  std::uint64_t sum() const {
    std::uint64_t sum = 0;
    for (const Stripe& stripe : stripes_) sum += stripe.count.load(std::memory_order_relaxed);
    return sum;
  }

 private:
  static constexpr std::size_t stripe_count = 64;
  struct alignas(64) Stripe {
    std::atomic<std::uint64_t> count{0};
  };
  static std::size_t stripe() {
    static std::atomic<std::size_t> next{0};
    thread_local const std::size_t mine = next.fetch_add(1, std::memory_order_relaxed) % stripe_count;
    return mine;
  }
  std::array<Stripe, stripe_count> stripes_;
};

}  // namespace tress::inline v0_2::adaptive
