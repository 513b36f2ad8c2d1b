// Sums over the paths of each pixel, and the layered picture made of them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/ext/vector_double2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "image/deep_picture.h"
#include "image/picture.h"
#include "integrate/depth_bins.h"
#include "integrate/heatmap.h"
#include "integrate/object_counts.h"
#include "integrate/path_sums.h"

namespace tress::integrate {

/// What beauty shows behind all objects. backdrop: the background, so every pixel is opaque. nothing: beauty is the
/// light of hair and meshes, premultiplied by the share of the pixel that they cover, which is its alpha.
enum class Ground { backdrop, nothing };

/// The number of layers, from the first, whose sum is beauty.
constexpr std::size_t beauty_layers(Ground ground) {
  return ground == Ground::backdrop ? layer_count : background_layer;
}

/// Sums of PathSums over the paths of one pixel. They are doubles because a float sum of 131,072 radiances of 0.1 is
/// off by 0.1 %, to the same side in every pixel.
struct PixelSums {
  std::array<glm::dvec3, layer_count> layers{};
  glm::dvec3 albedo{0.0}, normal{0.0}, tangent{0.0};
  double coverage = 0, distance_cm = 0, objective = 0;
  double excess = 0, excess_squares = 0;
  double opaque = 0;  ///< paths that A counts: all but held-out ones and, over Ground::nothing, those that met nothing
  /// Sum of the squared deviations of the paths' beauty from their mean (Welford 1962: no cancellation).
  glm::dvec3 squared_deviations{0.0};
  /// Beauty of the paths of odd index. Odd and even paths are stratified separately (PathTracer::trace), so they are
  /// two independent pictures.
  glm::dvec3 odd_beauty{0.0};
  std::uint64_t vertices = 0, queries = 0, exact_queries = 0;  ///< of dropped paths, too
  std::uint32_t samples = 0;                                   ///< paths in the sums
  std::uint32_t odd_samples = 0;                               ///< those of `samples` in odd_beauty
  std::uint32_t dropped = 0;  ///< paths that were not finite (PathSums::is_finite); the sums of light are without them

  /// Number of paths that were traced.
  std::uint32_t traced() const { return samples + dropped; }

  /// Adds the path, or counts it as dropped; returns whether it was added. The sums stay finite, because a double can
  /// hold 2^32 times the square of the largest float. ground: the same for all paths of a pixel. first_sample: index of
  /// the first path of the pixel.
  bool add(const PathSums& path, Ground ground = Ground::backdrop, std::uint32_t first_sample = 0);
  /// Adds later paths of the same pixel. The sums are those of one run except for the last bits of a double.
  void add(const PixelSums& later, Ground ground);
  /// Sum of the layers that beauty has, in their order.
  glm::dvec3 beauty(Ground ground = Ground::backdrop) const;
  /// Estimated variance of the pixel's mean, per channel: s^2 / n, as for n independent paths; 0 for fewer than two.
  /// The paths of a pixel are stratified, which improves their mean but not s^2, so this is an upper bound. It may
  /// exceed the largest float; a picture then has the largest float.
  glm::dvec3 variance_of_mean() const;
  /// The same variance from the difference of the two halves, which are as stratified as the paths. It has one degree
  /// of freedom, so average it over many pixels. 0 while a half has no paths.
  glm::dvec3 variance_by_halves(Ground ground = Ground::backdrop) const;
};

/// Layers of pictures with Film::Extra::halves: beauty of the paths of even and of odd index, which are two independent
/// pictures of the scene, and the estimated variance of each.
constexpr std::array<const char*, 4> half_layers{"half_a", "half_b", "half_a_variance", "half_b_variance"};

/// Removes the half_layers from a picture.
void remove_halves(image::Picture* picture);

/// A relative change of the mean luminance of hair and surfaces, without backgrounds.
struct Brightening {
  double value = 0;  ///< picture over truth, minus 1
  double error = 0;  ///< its standard error
};

/// The bias of answers that replace paths (DeepLight::learned), measured on answered paths that were still followed.
struct DeepLightBias : Brightening {
  std::uint64_t paths = 0;
};

/// Thread-safety: distinct threads may change distinct pixels; all else needs one thread.
class Film {
 public:
  /// Layers that only some scenes have.
  struct Extra {
    bool emission = false;            ///< lights that the camera sees
    std::vector<std::string> groups;  ///< light groups (scene::light_groups): one layer each; they add up to beauty
    std::size_t backdrop_group = 0;   ///< index of the group of the background
    std::uint32_t first_sample = 0;   ///< index of the first path of each pixel
    bool halves = false;              ///< whether there are half_layers
    bool deep_light = false;          ///< whether PathSums::deep_light_excess is kept
    bool depth_bins = false;          ///< whether there is a deep_picture()
    DataLayers data;
  };

  /// window: the pixels, in coordinates of the whole image. glint: whether a fiber splits off that lobe. timed: whether
  /// the time of the paths is kept. objects: number of objects in the scene, to count which of them paths meet first; 0
  /// to count nothing. moving: whether there is a layer of the motion until the next frame.
  Film(const image::Window& window, bool glint, bool timed = false, Ground ground = Ground::backdrop,
       std::size_t objects = 0, bool moving = false)
      : Film(window, glint, timed, ground, objects, moving, Extra{}) {}
  Film(const image::Window& window, bool glint, bool timed, Ground ground, std::size_t objects, bool moving,
       Extra extra);

  const image::Window& window() const { return window_; }
  /// (x, y) must be in the window.
  PixelSums& pixel(int x, int y) { return pixels_[index(x, y)]; }
  /// Calls PixelSums::add and updates the counts and layers beside it.
  bool add(int x, int y, const PathSums& path);
  const PixelSums& pixel(int x, int y) const { return pixels_[index(x, y)]; }

  /// The picture with all layers. Every value is finite. Each pixel is the mean of its samples, without dropped ones. A
  /// pixel without samples (after an interrupted sample 0, or if all were dropped) shows the sampled pixel that is
  /// nearest in steps along rows and columns; if no pixel has samples, it is black with A = 0.
  /// Beauty is the sum of its layers, in their order in the file. albedo and every color are means over all paths,
  /// where paths that met nothing count as black. N, tangent and Z are means over the paths that met something, and 0
  /// where none did; N and tangent are shorter than 1 where directions differ. forward, in a scene that moves, is such
  /// a mean, too; where no path met anything, it is the motion of the backdrop. The data layers come from DataSums.
  image::Picture picture() const;
  /// Only R, G, B and A of picture(), which is much faster.
  image::Picture beauty_picture() const;
  /// The deep picture, if Extra::depth_bins; otherwise no pixel has samples. `Over` of a pixel's samples makes R, G, B
  /// and A of picture(), before rounding to halves. A sample has the paths of one of the DepthBins. Its depths are
  /// distances along the ray, as in Z: of the first hit, or of the light that the camera sees. The background and
  /// infinitely far lights have the largest float. Paths without alpha, which have no color either, are left out.
  image::DeepPicture deep_picture() const;

  /// Counts of the objects that paths met first. Dropped paths are not in them.
  const ObjectCounts& object_counts() const { return object_counts_; }
  /// Counts of strands, by DataHit::matte_bits; empty unless their mattes are requested.
  const ObjectCounts& strand_counts() const { return strand_counts_; }
  const DataLayers& data_layers() const { return extra_.data; }
  std::uint32_t samples_of(std::size_t index) const { return pixels_[index].samples; }
  static constexpr std::size_t no_pixel = std::numeric_limits<std::size_t>::max();
  /// For each pixel, row by row, the index of the pixel that it shows in a picture, or no_pixel if it is black.
  std::vector<std::size_t> shown_pixels() const;

  /// The whole film as named bytes, which are valid until it changes. Only the same program on the same kind of machine
  /// can read them. set_sections() returns false and leaves the film unusable if they are not of a film of this window.
  std::vector<std::pair<std::string, std::string_view>> sections() const;
  bool set_sections(const std::map<std::string, std::string>& sections);
  /// Adds the sums of later samples. later: its window is within this one; both or neither move, they have the same
  /// groups and objects, and neither has Extra::depth_bins. Returns in how many pixels a count of objects or strands
  /// may be less than in one film (ObjectCounts::add).
  std::size_t add(const Film& later);

  bool timed() const { return !cpu_seconds_.empty(); }
  /// Call it only if timed().
  void add_time(int x, int y, double cpu_seconds) { cpu_seconds_[index(x, y)] += cpu_seconds; }
  /// The cost of the pixels so far. Times are 0 unless timed().
  std::vector<PixelCost> costs() const;

  /// Noise of the picture relative to its brightness: the square root of the mean variance over the mean, both over
  /// the channels of the pixels with a coverage above 0. It is 0 if there are no such pixels, or they are black, or no
  /// pixel has two samples. The variance is that by halves, and 32 pixels more with the variance of independent paths,
  /// because halves alone are a poor estimate in a picture of few pixels.
  double relative_noise() const;
  /// Sums and means over the pixels with a coverage above 0.
  struct Seen {
    double pixels = 0;
    double samples = 0, paths = 0;  ///< paths: those samples that met something
    double mean = 0;                ///< mean beauty over pixels and channels
    /// The number of paths of equal brightness that would estimate the mean over pixels as well: (sum of the beauty)^2
    /// over the sum of its squares, in the channel where it is largest.
    double light_paths = 0;
  };
  Seen seen() const;

  /// Mean luminance of hair and surfaces over all pixels.
  double brightness() const;
  /// How much brighter the errors of rows make hair and surfaces, estimated by the paths (PathSums::excess).
  Brightening excess() const;

  /// How much brighter answers that replace paths make hair and surfaces; unset unless Extra::deep_light. The estimate
  /// has no bias, whatever was learned.
  std::optional<DeepLightBias> deep_light_bias() const;

  /// Mean number of samples per pixel, without dropped ones.
  double samples_per_pixel() const;
  std::uint64_t dropped_samples() const;
  std::uint64_t queries() const;
  std::uint64_t exact_queries() const;

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y - window_.top) * static_cast<std::size_t>(window_.width) +
           static_cast<std::size_t>(x - window_.left);
  }

  /// Sums of squared deviations of beauty from the mean of each half.
  struct HalfSquares {
    glm::dvec3 even{0.0}, odd{0.0};
  };
  /// Updates halves_ after a path was added to a pixel. before: the pixel without that path.
  void add_to_halves(std::size_t index, const PixelSums& before);
  void add_halves(std::size_t index, const Film& later, std::size_t later_index);
  struct ExcessSums;
  template <class Sums, class Add>
  Sums summed(const Add& add) const;
  /// source: from shown_pixels().
  image::Picture beauty_of(const std::vector<std::size_t>& source) const;
  void add_half_channels(const std::vector<std::size_t>& source, image::Picture* picture) const;
  void add_data_channels(const std::vector<std::size_t>& source, image::Picture* picture) const;

  image::Window window_;
  bool glint_;
  Ground ground_;
  Extra extra_;
  std::vector<glm::dvec3> group_sums_;  ///< by pixel, then group
  std::vector<PixelSums> pixels_;
  ObjectCounts object_counts_;
  /// Sums over the paths that met something, and over those that met nothing; empty unless the scene moves.
  struct MotionSums {
    glm::dvec2 seen{0.0}, behind{0.0};
  };
  std::vector<MotionSums> motion_;
  std::vector<double> cpu_seconds_;  ///< empty unless timed
  /// Sums of PathSums::deep_light_excess.
  struct DeepLightSums {
    double excess = 0, squares = 0;
    std::uint64_t checks = 0;
  };
  std::vector<DeepLightSums> deep_light_;  ///< empty unless Extra::deep_light
  std::vector<HalfSquares> halves_;        ///< empty unless there are half_layers
  std::vector<DataSums> data_;             ///< empty unless one of their layers is requested
  ObjectCounts strand_counts_;
  std::vector<DepthBins> depth_bins_;  ///< empty unless Extra::depth_bins
};

}  // namespace tress::integrate
