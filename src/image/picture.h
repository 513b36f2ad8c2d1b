// Layered pictures: memory, OpenEXR, PNG preview, comparison. The only folder that includes OpenEXR.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "image/view_transform.h"
#include "tress/base/error.h"

namespace tress::image {

struct Channel {
  std::string name;           ///< "R", "TT.G", "ais.exact"
  std::vector<float> pixels;  ///< row-major, top row first
};

/// Pixels [left, left + width) x [top, top + height) of an image.
struct Window {
  int left = 0, top = 0, width = 0, height = 0;
  friend bool operator==(const Window&, const Window&) = default;
};

struct Picture {
  int width = 0, height = 0;  ///< of what is there
  /// A part of a larger image (EXR: the data window within the display window) begins here ...
  int left = 0, top = 0;
  /// ... in an image of this size; 0: of the picture's own.
  int whole_width = 0, whole_height = 0;
  std::vector<Channel> channels;
  std::map<std::string, std::string> metadata;  ///< header strings
  /// 4 x 4 matrices of the header (M44f), row by row, for points as row vectors: worldToCamera, worldToNDC.
  std::map<std::string, std::array<float, 16>> matrices;
  /// Of the display window at distance 1 from the camera; 1 of a picture without one (screenWindowWidth).
  float screen_width = 1;
  std::array<float, 2> screen_center{0, 0};  ///< of it there, right and up, from where the camera looks
  /// x, y of red, green, blue and white of what R, G, B are, where the header says it; else those of Rec. 709.
  std::optional<std::array<float, 8>> chromaticities = {};
  const Channel* find(const std::string& name) const;
  Window window() const { return {left, top, width, height}; }
  Window whole() const {
    return whole_width > 0 ? Window{0, 0, whole_width, whole_height} : Window{0, 0, width, height};
  }
};

/// The layer of a channel: what is before its last dot, "TT" of "TT.G"; "beauty" of R, G, B and A; else its name.
std::string layer_of(const std::string& channel);
/// Leaves beauty and the named layers; a name is that of NAME00, NAME01, ... too. What the header says of mattes that
/// are taken out goes with them.
void keep_layers(const std::vector<std::string>& layers, Picture* picture);

/// How many bits a channel has. half: 16 where they are enough; 32 for distances (Z), places (P, strand_uv), motion
/// (forward), all variances, which span more, for ids (strand_id, mattes: Crypto...), and for layers with a value
/// beyond 65504 or none above 1/256, whose halves would be infinite or coarse.
enum class Precision { half, full };

/// zip: as small as it gets. none: several times larger, and written in a tenth of the time.
enum class Compression { zip, none };

/// Scanline, one part. Written to a temporary file and renamed. A value that is not finite, or a part that reaches
/// outside its image, is an error.
std::optional<Error> write_exr(const std::filesystem::path& file, const Picture& picture,
                               Precision precision = Precision::full, Compression compression = Compression::zip);
/// What read_exr() of a file of that precision would bring.
void round_as_written(Picture* picture, Precision precision);
/// Any EXR of one or more float or half channels, at most 2^28 pixels. Rejects NaN, truncated and foreign files.
Result<Picture> read_exr(const std::filesystem::path& file);

/// Which channels of a file are read, of the names of all; fewer than all may be of any type.
using ChooseChannels = std::function<std::vector<std::string>(const std::vector<std::string>&)>;
/// The same of some channels, values that are not finite included. An error where none is chosen.
Result<Picture> read_exr_channels(const std::filesystem::path& file, const ChooseChannels& choose);
/// How a preview is made of a picture.
struct Preview {
  bool alpha = false;         ///< of A, straight: what is covered in its own color; else opaque
  double exposure_stops = 0;  ///< R, G, B are scaled by 2 to this
  View view = View::standard;
  std::string_view layer{};  ///< shown in place of R, G, B where the picture has it; its letters outlive this
};

/// 8 bits of R, G, B as a display with sRGB primaries shows them. Opaque: over what R, G, B have, or over mid-grey
/// where the picture has no background at all. Atomic like write_exr.
std::optional<Error> write_png(const std::filesystem::path& file, const Picture& picture, const Preview& preview = {});

/// B against A over R, G, B of the pixels that both have: parts of images of one size.
struct Difference {
  double rel_mse = 0;            ///< mean of (b-a)^2 / (a^2 + 1e-2 * mean(a)^2), per channel then mean
  double mae = 0;                ///< mean |b-a|
  std::array<double, 3> bias{};  ///< mean of b - a
  double largest = 0;            ///< max |b-a|
  bool identical = false;        ///< every channel of both, bit for bit, there
};
Result<Difference> compare(const Picture& a, const Picture& b, const std::string& name_a, const std::string& name_b);

}  // namespace tress::image
