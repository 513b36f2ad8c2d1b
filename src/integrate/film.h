// What the paths of each pixel have brought so far, and the layered picture made of it.
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

#include "image/picture.h"
#include "integrate/heatmap.h"
#include "integrate/object_counts.h"
#include "integrate/path_sums.h"

namespace tress::integrate {

/// What is behind everything in beauty. backdrop: the background, so that every pixel is opaque; nothing: beauty is
/// what the hair and the meshes send, premultiplied by the share of the pixel that they cover, which is its alpha.
enum class Ground { backdrop, nothing };

/// Layers that beauty is the sum of: the first so many.
constexpr std::size_t beauty_layers(Ground ground) {
  return ground == Ground::backdrop ? layer_count : background_layer;
}

/// Sums over the paths of one pixel, as of PathSums. In double: a float sum of 131,072 radiances of 0.1 is 0.1 % off,
/// and off to the same side in every pixel.
struct PixelSums {
  std::array<glm::dvec3, layer_count> layers{};
  glm::dvec3 albedo{0.0}, normal{0.0}, tangent{0.0};
  double coverage = 0, distance_cm = 0, objective = 0;
  double excess = 0, excess_squares = 0;
  double opaque = 0;  ///< paths that A counts: all but those that are held out, or that met nothing over no ground
  /// Sum of the squared deviations of the paths' beauty from their mean (Welford 1962: no cancellation).
  glm::dvec3 squared_deviations{0.0};
  /// Beauty of the paths of odd index. It and the rest are stratified apart (PathTracer::trace):
  /// two independent pictures.
  glm::dvec3 odd_beauty{0.0};
  std::uint64_t vertices = 0, queries = 0, exact_queries = 0;  ///< of dropped paths too: they were work
  std::uint32_t samples = 0;                                   ///< paths in the sums
  std::uint32_t odd_samples = 0;                               ///< of them, paths in odd_beauty
  std::uint32_t dropped = 0;  ///< paths that were not finite (PathSums::is_finite): in no sum above, in no mean

  /// Paths that were traced: the number of the next one.
  std::uint32_t traced() const { return samples + dropped; }

  /// Adds the path, or counts it as dropped; tells whether it was added. What is added stays finite: 2^32 times the
  /// square of the largest float is a double. Of one pixel `ground` is always the same.
  /// first_sample: index of the first path of the pixel.
  bool add(const PathSums& path, Ground ground = Ground::backdrop, std::uint32_t first_sample = 0);
  /// Adds the paths of the same pixel that came after these: sums as of one run but for the last bits of a double.
  void add(const PixelSums& later, Ground ground);
  /// Sum of the layers that beauty has, in their order.
  glm::dvec3 beauty(Ground ground = Ground::backdrop) const;
  /// Estimated variance of the pixel's mean, per channel: that of n independent paths, s^2 / n; 0 for less than two.
  /// Paths of a pixel are stratified, which makes their mean better than independent ones would, and s^2 no smaller:
  /// read it as an upper bound. May be past the largest float, which is what a picture then has.
  glm::dvec3 variance_of_mean() const;
  /// The same by the difference of the two halves: as stratified as they are, but of one degree of freedom. To be
  /// averaged over many pixels. 0 while a half has none.
  glm::dvec3 variance_by_halves(Ground ground = Ground::backdrop) const;
};

/// Layers that only pictures with Film::Extra::halves have: beauty of the paths of even index and of those of odd
/// index, two independent pictures of one scene, and the estimated variance of each.
constexpr std::array<const char*, 4> half_layers{"half_a", "half_b", "half_a_variance", "half_b_variance"};

/// Takes them out of a picture.
void remove_halves(image::Picture* picture);

/// Of the mean luminance of hair and surfaces, backgrounds not in it: relative to what it would be without.
struct Brightening {
  double value = 0;  ///< picture over truth, minus 1
  double error = 0;  ///< its standard error
};

/// Of answers in place of paths (DeepLight::learned), by the paths that were followed all the same.
struct DeepLightBias : Brightening {
  std::uint64_t paths = 0;
};

/// Thread-safety: distinct pixels from distinct threads; the rest: one thread.
class Film {
 public:
  /// Layers that only some scenes have.
  struct Extra {
    bool emission = false;            ///< lights that the camera sees
    std::vector<std::string> groups;  ///< of light (scene::light_groups): a layer each, which add up to beauty
    std::size_t backdrop_group = 0;   ///< which of them the background is of
    std::uint32_t first_sample = 0;   ///< index of the first path of each pixel
    bool halves = false;              ///< half_layers
    bool deep_light = false;          ///< PathSums::deep_light_excess is kept
    DataLayers data;
  };

  /// Of the pixels in `window`, in the coordinates of the whole image. glint: whether a fiber splits that lobe off;
  /// timed: whether the time of the paths is kept.
  /// objects: of the scene, to count which of them paths meet first; 0: not to. moving: whether there is a layer of
  /// the motion until the next frame.
  Film(const image::Window& window, bool glint, bool timed = false, Ground ground = Ground::backdrop,
       std::size_t objects = 0, bool moving = false)
      : Film(window, glint, timed, ground, objects, moving, Extra{}) {}
  Film(const image::Window& window, bool glint, bool timed, Ground ground, std::size_t objects, bool moving,
       Extra extra);

  const image::Window& window() const { return window_; }
  /// (x, y) in the window.
  PixelSums& pixel(int x, int y) { return pixels_[index(x, y)]; }
  /// PixelSums::add, and what is kept beside it.
  bool add(int x, int y, const PathSums& path);
  const PixelSums& pixel(int x, int y) const { return pixels_[index(x, y)]; }

  /// Every value is finite. Each pixel is the mean of the samples it has, dropped ones not counted. A pixel that has
  /// none (an interrupted sample 0, or all were dropped) shows the sampled pixel nearest in steps along rows and
  /// columns; if there is none at all, black with A = 0.
  /// Beauty is the sum of its layers, in their order in the file. albedo, like every color, is the mean over all
  /// paths, those that met nothing counting as black; N, tangent and Z are means over the paths that met
  /// something, 0 where none did: the first two are shorter than 1 where directions differ. forward, of a scene that
  /// moves, too; where nothing was met it is the motion of the backdrop. The data layers are of DataSums.
  image::Picture picture() const;
  /// R, G, B and A of picture(), in a small part of its time.
  image::Picture beauty_picture() const;

  /// Of the paths in the sums that met something.
  const ObjectCounts& object_counts() const { return object_counts_; }
  /// The same of strands, by DataHit::matte_bits; of nothing unless their mattes are asked for.
  const ObjectCounts& strand_counts() const { return strand_counts_; }
  const DataLayers& data_layers() const { return extra_.data; }
  std::uint32_t samples_of(std::size_t index) const { return pixels_[index].samples; }
  static constexpr std::size_t no_pixel = std::numeric_limits<std::size_t>::max();
  /// For each pixel, row by row, the index of the one that it shows in a picture; no_pixel: none, it is black.
  std::vector<std::size_t> shown_pixels() const;

  /// All that the film is, by name, as the bytes that it takes in memory, good until it changes; and back. Of one
  /// program on one kind of machine. False, and the film of no use, if they are not of a film of this window.
  std::vector<std::pair<std::string, std::string_view>> sections() const;
  bool set_sections(const std::map<std::string, std::string>& sections);
  /// Adds the sums of later samples, of a window within this one; both move or neither, and have the same groups and
  /// objects. Returns of how many pixels a count of objects or strands may lack what one film would have
  /// (ObjectCounts::add).
  std::size_t add(const Film& later);

  bool timed() const { return !cpu_seconds_.empty(); }
  /// Of a timed film.
  void add_time(int x, int y, double cpu_seconds) { cpu_seconds_[index(x, y)] += cpu_seconds; }
  /// What the pixels cost so far; times only if timed.
  std::vector<PixelCost> costs() const;

  /// Noise of the picture relative to its brightness: the square root of the mean variance over the mean, both over
  /// the channels of the pixels with a coverage above 0. 0 if there are none, or they are black, or no pixel has two
  /// samples. The variance is by halves, with that of independent paths as if of 32 pixels more: in a picture of
  /// few pixels halves alone would tell little.
  double relative_noise() const;
  /// Of the pixels with a coverage above 0.
  struct Seen {
    double pixels = 0;
    double samples = 0, paths = 0;  ///< of them, those that met something
    double mean = 0;                ///< of the pixels' beauty, of its channels
    /// As many paths of one brightness would tell as much of the mean over pixels: (sum of the beauty)^2 over the sum
    /// of its squares, of the channel where it is largest.
    double light_paths = 0;
  };
  Seen seen() const;

  /// Mean luminance of what the pixels show of hair and surfaces.
  double brightness() const;
  /// How much brighter rows make what is seen of hair and surfaces, as far as the paths could tell (PathSums::excess).
  Brightening excess() const;

  /// How much brighter answers in place of paths make it; unset unless Extra::deep_light. Whatever was learned, its
  /// mean over seeds is right.
  std::optional<DeepLightBias> deep_light_bias() const;

  /// Of the samples that are in the picture.
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
  /// Of the path that has just been added to a pixel that was `before`.
  void add_to_halves(std::size_t index, const PixelSums& before);
  void add_halves(std::size_t index, const Film& later, std::size_t later_index);
  /// source: shown_pixels().
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
  /// Of PathSums::deep_light_excess.
  struct DeepLightSums {
    double excess = 0, squares = 0;
    std::uint64_t checks = 0;
  };
  std::vector<DeepLightSums> deep_light_;  ///< empty unless Extra::deep_light
  std::vector<HalfSquares> halves_;        ///< empty unless there are half_layers
  std::vector<DataSums> data_;             ///< empty unless a layer of them is asked for
  ObjectCounts strand_counts_;
};

}  // namespace tress::integrate
