// The number of samples of each pixel after each pass: the same for all, or more where the picture is noisier.
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

/// If the plan is adaptive, a pass takes one sample per pixel in the mean. After the first 8, and again after a mean of
/// 64, 256, 1024 ..., it plans where samples reduce the picture's variance most for their cost. The share of a pixel is
/// the root of the variance of a path over the root of its cost, both means over the 24 pixels around it. It is between
/// half the mean and four times the mean; pixels without noise around them get the mean.
///
/// The plan is unbiased. The samples of a pixel depend on the pixels around it and not on its own paths, except for the
/// mean over all pixels. They depend only on the first 8, 32, 128 ... samples of those pixels, which are taken in any
/// case. If a pixel that is dark by chance got fewer samples, the picture would be too dark.
///
/// Thread-safety: distinct threads may call note() for distinct pixels; all else needs one thread.
class SamplePlan {
 public:
  /// possible: light that a pixel's paths may not have met counts as noise, so that no pixel gets few samples because
  /// it is dark by chance.
  SamplePlan(const image::Window& window, bool adaptive, const PossibleLight& possible = {});

  /// Number of samples of pixel (x, y) of the image after pass `pass`, which must not be before the last pass_ended().
  std::uint32_t samples_after(int pass, int x, int y) const;

  /// Call it after each sample of a pixel.
  void note(int x, int y, const PixelSums& sums) {
    if (!notes_.empty() && sums.traced() == times_.noted_samples) note_prefix(index(x, y), sums);
  }

  /// Makes a new plan if it is due. Call it between passes.
  void pass_ended(int pass);

  /// Adds the state of the plan as in Film::sections(); nothing unless it is adaptive.
  void add_sections(std::vector<std::pair<std::string, std::string_view>>* all) const;
  bool set_sections(const std::map<std::string, std::string>& sections);

 private:
  struct Note {
    float variance = 0;  ///< variance of a path, sum over the channels
    float cost = 0;      ///< cost of a path: 1 plus its vertices
  };
  struct Share {
    std::uint32_t base = 0;  ///< samples when the plan was made
    float rate = 1;          ///< samples per pass since then
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
    std::uint32_t noted_samples = 0;  ///< samples of a pixel after which its note is taken
    std::int32_t planned_pass = 0;    ///< the last pass before the plan
  };
  Times times_;
};

}  // namespace tress::integrate
