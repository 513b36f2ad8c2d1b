#include "integrate/sample_plan.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "integrate/pass_order.h"

namespace tress::integrate {
namespace {

constexpr std::uint32_t first_samples = 8, growth = 4;  ///< notes are taken at 8, 32, 128 ... samples
constexpr int reach = 2;                                ///< pixels to each side
constexpr double least_share = 0.5, most_share = 4;     ///< in units of the mean

/// The factor for which the mean of the scaled values of `wanted` above 0, each clamped to the bounds, is 1.
double scale_of(const std::vector<float>& wanted) {
  const auto mean_at = [&](double scale) {
    double sum = 0, count = 0;
    for (const float one : wanted) {
      if (!(one > 0)) continue;
      sum += std::clamp(scale * static_cast<double>(one), least_share, most_share);
      count += 1;
    }
    return count > 0 ? sum / count : 1;
  };
  double low = 0, high = 1;
  while (mean_at(high) < 1 && high < 1e30) high *= 4;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (mean_at(middle) < 1 ? low : high) = middle;
  }
  return high;
}

}  // namespace

SamplePlan::SamplePlan(const image::Window& window, bool adaptive, const PossibleLight& possible)
    : window_(window),
      possible_(possible),
      notes_(adaptive ? static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height) : 0),
      times_{first_samples, 0} {}

std::uint32_t SamplePlan::samples_after(int pass, int x, int y) const {
  if (shares_.empty()) {
    if (pass < initial_passes) return initial_pass(x, y) <= pass ? 1 : 0;
    return sample_of_pass(pass) + 1;
  }
  // Fractions of a sample are rounded up in some pixels of a tile and down in others.
  const Share& share = shares_[index(x, y)];
  const double offset = (rank_in_tile(x & 7, y & 7) + 0.5) / 64;
  return share.base +
         static_cast<std::uint32_t>(static_cast<double>(share.rate) * (pass - times_.planned_pass) + offset);
}

void SamplePlan::note_prefix(std::size_t pixel, const PixelSums& sums) {
  const auto n = static_cast<double>(sums.samples);
  const glm::dvec3 deviations = sums.squared_deviations;
  const double variance = n > 1 ? (deviations.x + deviations.y + deviations.z) / (n - 1) : 0;
  notes_[pixel] = {static_cast<float>(std::min(variance, 1e30)),
                   1 + static_cast<float>(sums.vertices) / static_cast<float>(sums.traced())};
}

/// Values in proportion to the samples that a pixel should have; 0 if nothing around it is noisy.
std::vector<float> SamplePlan::wanted() const {
  std::vector<float> wanted(notes_.size(), 0.0f);
  const auto has_hit = [](const Note& note) { return note.cost > 1; };
  const auto hit = static_cast<double>(std::ranges::count_if(notes_, has_hit));
  const double unmet = 3 * possible_.unmet_variance(hit * times_.noted_samples);
  for (int y = 0; y < window_.height; ++y) {
    for (int x = 0; x < window_.width; ++x) {
      double variance = 0, cost = 0;
      for (int v = std::max(0, y - reach); v <= std::min(window_.height - 1, y + reach); ++v) {
        for (int u = std::max(0, x - reach); u <= std::min(window_.width - 1, x + reach); ++u) {
          if (u == x && v == y) continue;
          const Note& note = notes_[index(window_.left + u, window_.top + v)];
          variance += static_cast<double>(note.variance) + (has_hit(note) ? unmet : 0);
          cost += static_cast<double>(note.cost);
        }
      }
      if (variance > 0)
        wanted[index(window_.left + x, window_.top + y)] = static_cast<float>(std::sqrt(variance / cost));
    }
  }
  return wanted;
}

void SamplePlan::pass_ended(int pass) {
  if (notes_.empty()) return;
  // By the bounds of the shares, every pixel has its noted samples after a mean of twice as many.
  const std::uint32_t mean = pass < initial_passes ? 1 : sample_of_pass(pass) + 1;
  if (mean != (shares_.empty() ? first_samples : 2 * times_.noted_samples)) return;
  const std::uint32_t next_mean = 2 * times_.noted_samples * growth, passes = next_mean - mean;
  const std::vector<float> wanted_shares = wanted();
  const double scale = scale_of(wanted_shares);
  std::vector<Share> planned(notes_.size());
  std::vector<float> missing(notes_.size(), 0.0f);
  for (int y = window_.top; y < window_.top + window_.height; ++y) {
    for (int x = window_.left; x < window_.left + window_.width; ++x) {
      const std::size_t i = index(x, y);
      planned[i].base = samples_after(pass, x, y);
      if (!(wanted_shares[i] > 0)) continue;
      // Samples that the pixel needs until the next plan, for its share of all samples.
      const double share = std::clamp(scale * static_cast<double>(wanted_shares[i]), least_share, most_share);
      missing[i] = static_cast<float>(std::max(1e-3, (share * next_mean - planned[i].base) / passes));
    }
  }
  const double scale_of_missing = scale_of(missing);
  for (std::size_t i = 0; i < planned.size(); ++i) {
    if (missing[i] > 0)
      planned[i].rate =
          static_cast<float>(std::clamp(scale_of_missing * static_cast<double>(missing[i]), least_share, most_share));
  }
  shares_ = std::move(planned);
  times_.planned_pass = pass;
  times_.noted_samples *= growth;
}

void SamplePlan::add_sections(std::vector<std::pair<std::string, std::string_view>>* all) const {
  static_assert(std::is_trivially_copyable_v<Note> && std::is_trivially_copyable_v<Share>);
  if (notes_.empty()) return;
  all->emplace_back("plan.times", std::string_view(reinterpret_cast<const char*>(&times_), sizeof(times_)));
  all->emplace_back("plan.notes",
                    std::string_view(reinterpret_cast<const char*>(notes_.data()), notes_.size() * sizeof(Note)));
  if (shares_.empty()) return;
  all->emplace_back("plan.shares",
                    std::string_view(reinterpret_cast<const char*>(shares_.data()), shares_.size() * sizeof(Share)));
}

bool SamplePlan::set_sections(const std::map<std::string, std::string>& sections) {
  if (notes_.empty()) return true;
  const auto times = sections.find("plan.times"), notes = sections.find("plan.notes"),
             shares = sections.find("plan.shares");
  if (times == sections.end() || notes == sections.end()) return false;
  if (times->second.size() != sizeof(times_) || notes->second.size() != notes_.size() * sizeof(Note)) return false;
  if (shares != sections.end()) {
    if (shares->second.size() != notes_.size() * sizeof(Share)) return false;
    shares_.resize(notes_.size());
    std::memcpy(shares_.data(), shares->second.data(), shares->second.size());
  }
  std::memcpy(&times_, times->second.data(), sizeof(times_));
  std::memcpy(notes_.data(), notes->second.data(), notes->second.size());
  return times_.noted_samples >= first_samples && times_.planned_pass >= 0 &&
         std::ranges::all_of(notes_, [](const Note& note) { return std::isfinite(note.variance) && note.cost >= 0; }) &&
         std::ranges::all_of(shares_, [](const Share& share) { return share.rate >= 0 && share.rate <= most_share; });
}

}  // namespace tress::integrate
