// Layered pictures: in memory, as OpenEXR and as PNG preview, and their comparison. Only this folder includes OpenEXR.
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
  int width = 0, height = 0;  ///< size of the pixels that are stored
  /// Where the picture begins in a larger image of which it is a part (EXR: the data window within the display window).
  int left = 0, top = 0;
  /// Size of that image; 0 if it is the picture itself.
  int whole_width = 0, whole_height = 0;
  std::vector<Channel> channels;
  std::map<std::string, std::string> metadata;  ///< header strings
  /// 4 x 4 matrices of the header (M44f), row by row, for row vectors: worldToCamera, worldToNDC.
  std::map<std::string, std::array<float, 16>> matrices;
  /// Width of the display window at distance 1 from the camera (screenWindowWidth); 1 for a picture without a camera.
  float screen_width = 1;
  std::array<float, 2> screen_center{0, 0};  ///< its middle there, right and up from the view's axis
  /// x, y of the red, green, blue and white of R, G, B, if the header has them; otherwise they are those of Rec. 709.
  std::optional<std::array<float, 8>> chromaticities = {};
  const Channel* find(const std::string& name) const;
  Window window() const { return {left, top, width, height}; }
  Window whole() const {
    return whole_width > 0 ? Window{0, 0, whole_width, whole_height} : Window{0, 0, width, height};
  }
};

/// The layer of a channel: the part before its last dot ("TT" for "TT.G"), "beauty" for R, G, B and A, otherwise its
/// name.
std::string layer_of(const std::string& channel);
/// Removes all layers except beauty and the named ones. A name also stands for NAME00, NAME01, ... Entries of the
/// header for removed mattes are removed, too.
void keep_layers(const std::vector<std::string>& layers, Picture* picture);

/// Bits of a channel. full: 32. half: 16 where they are enough. It keeps 32 for distances (Z), places (P, strand_uv),
/// motion (forward) and all variances, which span more, and for ids (strand_id, mattes: Crypto...). It also keeps 32
/// for layers whose halves would be infinite or coarse: with a value beyond 65504, or without a value above 1/256.
enum class Precision { half, full };

/// zip: the smallest files. none: files several times larger, written in a tenth of the time.
enum class Compression { zip, none };

/// Writes an EXR of one part with scanlines, through a temporary file that is renamed. Values that are not finite and
/// pictures that reach outside their image are errors.
std::optional<Error> write_exr(const std::filesystem::path& file, const Picture& picture,
                               Precision precision = Precision::full, Compression compression = Compression::zip);
/// Rounds all values to those that read_exr() would read from a file of that precision.
void round_as_written(Picture* picture, Precision precision);
/// Reads any EXR of one or more float or half channels and at most 2^28 pixels. Rejects values that are not finite,
/// truncated files and other formats.
Result<Picture> read_exr(const std::filesystem::path& file);

/// Chooses the channels to read from the names of all channels of a file. Channels that are not chosen may have any
/// type.
using ChooseChannels = std::function<std::vector<std::string>(const std::vector<std::string>&)>;
/// Reads some channels of an EXR, including values that are not finite. It is an error to choose no channel.
Result<Picture> read_exr_channels(const std::filesystem::path& file, const ChooseChannels& choose);
/// Settings of a preview.
struct Preview {
  bool alpha = false;         ///< whether the preview has the alpha of A, not premultiplied; otherwise it is opaque
  double exposure_stops = 0;  ///< R, G, B are scaled by 2 to the power of this
  View view = View::standard;
  std::string_view layer{};  ///< shown instead of R, G, B if the picture has it; its characters must outlive this
};

/// Writes R, G, B with 8 bits for a display with sRGB primaries. An opaque preview of a picture without background is
/// over mid-grey. The file is replaced atomically, as by write_exr.
std::optional<Error> write_png(const std::filesystem::path& file, const Picture& picture, const Preview& preview = {});

/// Difference of B from A in R, G, B, over the pixels that both have. Both must be parts of images of the same size.
struct Difference {
  double rel_mse = 0;            ///< mean of (b-a)^2 / (a^2 + 1e-2 * mean(a)^2), per channel then mean
  double mae = 0;                ///< mean |b-a|
  std::array<double, 3> bias{};  ///< mean of b - a
  double largest = 0;            ///< max |b-a|
  bool identical = false;        ///< whether all channels are equal there, to the bit
};
Result<Difference> compare(const Picture& a, const Picture& b, const std::string& name_a, const std::string& name_b);

}  // namespace tress::image
