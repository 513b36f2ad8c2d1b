// How many samples each pixel has after each pass: as many for all, or more where the picture is noisier.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "image/picture.h"
#include "integrate/film.h"
#include "integrate/possible_light.h"

namespace tress::integrate {

/// Adaptive, a pass takes one sample a pixel in the mean. After the first 8, and again after a mean of 64, 256, 1024
/// ..., samples go where they lessen the picture's variance most for their cost: a pixel's share is the root of the
/// variance of a path over that of the vertices of a path, both means over the 24 pixels around it, between a half and
/// four times the mean; pixels around which nothing was noisy have the mean.
///
/// Unbiased: the counts of a pixel depend on the pixels around it and not on its own paths (but for what one pixel does
/// to the mean over all), and of those on their first 8, 32, 128 ... samples alone, which they have in any case. Would
/// a pixel that was dark by chance get fewer samples, the picture would be too dark.
///
/// Thread-safety: note() of distinct pixels from distinct threads; the rest: one thread.
class SamplePlan {
 public:
  /// possible: what a pixel's paths may not have met counts as noise, so that none has few samples because it is dark
  /// by chance.
  SamplePlan(const image::Window& window, bool adaptive, const PossibleLight& possible = {});

  /// Of pixel (x, y) of the image, after pass `pass`, at most one publish() behind: samples traced.
  std::uint32_t samples_after(int pass, int x, int y) const;

  /// After each sample of a pixel.
  void note(int x, int y, const PixelSums& sums) {
    if (!notes_.empty() && sums.traced() == times_.noted_samples) note_prefix(index(x, y), sums);
  }

  /// Between passes: plans anew where it is time to.
  void pass_ended(int pass);

  /// All that the plan is, as Film::sections(): nothing unless it is adaptive.
  void add_sections(std::vector<std::pair<std::string, std::string_view>>* all) const;
  bool set_sections(const std::map<std::string, std::string>& sections);

 private:
  struct Note {
    float variance = 0;  ///< of a path, sum over the channels
    float cost = 0;      ///< of a path: 1 and its vertices
  };
  struct Share {
    std::uint32_t base = 0;  ///< samples when it was planned
    float rate = 1;          ///< samples a pass since
  };

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y - window_.top) * static_cast<std::size_t>(window_.width) +
           static_cast<std::size_t>(x - window_.left);
  }
  void note_prefix(std::size_t pixel, const PixelSums& sums);
  std::vector<float> wanted() const;

  image::Window window_;
  PossibleLight possible_;
  std::vector<Note> notes_;    ///< empty unless adaptive
  std::vector<Share> shares_;  ///< empty until planned
  struct Times {
    std::uint32_t noted_samples = 0;  ///< of a pixel, when its note is taken
    std::int32_t planned_pass = 0;    ///< the last one before the plan
  };
  Times times_;
};

}  // namespace tress::integrate
