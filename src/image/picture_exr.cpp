// Reads and writes OpenEXR.
#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfCompression.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfMatrixAttribute.h>
#include <ImfOutputFile.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <half.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <list>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include "image/deep_picture.h"
#include "image/exr_header.h"
#include "image/picture.h"
#include "tress/base/replace_file.h"

namespace tress::image {
namespace {

constexpr std::int64_t most_pixels = std::int64_t{1} << 28;
constexpr int longest_side = 1 << 17;
constexpr std::size_t most_channels = 1024;
constexpr float least_of_halves = 1.0f / 256;  ///< a layer of halves has a value above this; steps are then 2e-5 of it
constexpr int rows_at_a_time = 256;            ///< memory then grows with the data, not with the claims of the header

/// Largest number of bytes of floats in a file of this size. Deflate expands a byte to at most 1032, and halves double
/// to floats; DWA also codes flat blocks of 64 values. A picture that claims more is damaged.
std::uint64_t most_bytes(Imf::Compression compression, std::uint64_t file_bytes) {
  const bool dwa = compression == Imf::DWAA_COMPRESSION || compression == Imf::DWAB_COMPRESSION;
  const std::uint64_t slack = std::uint64_t{64} << 20, cap = std::uint64_t{8} << 30;
  return std::min(cap, slack + std::min(file_bytes, cap) * (dwa ? 65536 : 4096));
}

/// The place of the first value that is not finite, as "channel X, pixel (x, y)"; empty if all are finite.
std::string find_not_finite(const Channel& channel, int width) {
  const auto bad =
      std::find_if(channel.pixels.begin(), channel.pixels.end(), [](float x) { return !std::isfinite(x); });
  if (bad == channel.pixels.end()) return "";
  const auto index = bad - channel.pixels.begin();
  return fmt::format("channel {}, pixel ({}, {})", channel.name, index % width, index / width);
}

std::optional<Error> check_window(const std::filesystem::path& file, const Picture& picture) {
  const auto error = [&](std::string place, std::string expected, std::string found) {
    return Error{file.string(), std::move(place), std::move(expected), std::move(found)};
  };
  if (picture.width < 1 || picture.height < 1 || std::int64_t{picture.width} * picture.height > most_pixels)
    return error("size", fmt::format("1 to {} pixels", most_pixels),
                 fmt::format("{} x {}", picture.width, picture.height));
  const Window part = picture.window(), whole = picture.whole();
  if (part.left < 0 || part.top < 0 || part.left > whole.width - part.width || part.top > whole.height - part.height)
    return error("window", fmt::format("a part of {} x {} pixels", whole.width, whole.height),
                 fmt::format("{} x {} from ({}, {})", part.width, part.height, part.left, part.top));
  return std::nullopt;
}

std::optional<Error> check_layout(const std::filesystem::path& file, const Picture& picture) {
  const auto error = [&](std::string place, std::string expected, std::string found) {
    return Error{file.string(), std::move(place), std::move(expected), std::move(found)};
  };
  if (auto wrong = check_window(file, picture)) return wrong;
  if (picture.channels.empty()) return error("channels", "one or more", "none");
  const auto pixels = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
  std::set<std::string> names;
  for (const auto& channel : picture.channels) {
    if (channel.name.empty() || !names.insert(channel.name).second)
      return error("channels", "distinct names", "'" + channel.name + "' again");
    if (channel.pixels.size() != pixels)
      return error("channel " + channel.name, fmt::format("{} pixels", pixels),
                   fmt::format("{}", channel.pixels.size()));
    if (const auto place = find_not_finite(channel, picture.width); !place.empty())
      return error(place, "a finite value", "NaN or infinity");
  }
  return std::nullopt;
}

/// The layers that are written as halves (Precision::half).
std::set<std::string> layers_of_halves(const Picture& picture) {
  std::map<std::string, float> largest;
  for (const Channel& channel : picture.channels) {
    if (channel.name == "A") continue;  // alpha fits in halves and does not show how bright R, G, B are
    float& most = largest[layer_of(channel.name)];
    for (const float x : channel.pixels) most = std::max(most, std::abs(x));
  }
  std::set<std::string> layers;
  if (!largest.contains(layer_of("A"))) layers.insert(layer_of("A"));  // alpha alone
  for (const auto& [layer, most] : largest) {
    const bool spans_more = layer == "Z" || layer.ends_with("variance") || layer == "forward" || layer == "samples" ||
                            layer == "P" || layer == "strand_uv" || layer == "strand_id" || layer.starts_with("Crypto");
    if (!spans_more && (most == 0 || (most >= least_of_halves && most <= HALF_MAX))) layers.insert(layer);
  }
  return layers;
}

/// A slice of rows of `width` floats or halves, of which the first begins at pixel (left, top). Its base is the address
/// of pixel (0, 0), which may lie outside the rows and is therefore computed as an integer.
template <class Value>
Imf::Slice slice(Value* rows, int left, std::int64_t top, int width) {
  const auto row_bytes = static_cast<std::int64_t>(sizeof(Value)) * width;
  const auto offset = static_cast<std::int64_t>(sizeof(Value)) * left + row_bytes * top;
  auto* base = reinterpret_cast<char*>(reinterpret_cast<std::intptr_t>(rows) - static_cast<std::intptr_t>(offset));
  return Imf::Slice(std::is_same_v<Value, half> ? Imf::HALF : Imf::FLOAT, base, sizeof(Value),
                    static_cast<std::size_t>(row_bytes));
}

Imath::M44f matrix_of(const std::array<float, 16>& rows) {
  Imath::M44f matrix;
  std::copy(rows.begin(), rows.end(), matrix.getValue());
  return matrix;
}

/// The header of a picture, without channels.
Imf::Header header_of(const Picture& picture) {
  const Window part = picture.window(), whole = picture.whole();
  const Imath::Box2i display({0, 0}, {whole.width - 1, whole.height - 1});
  const Imath::Box2i data({part.left, part.top}, {part.left + part.width - 1, part.top + part.height - 1});
  Imf::Header header(display, data);
  for (const auto& [key, value] : picture.metadata) header.insert(key, Imf::StringAttribute(value));
  for (const auto& [key, value] : picture.matrices) header.insert(key, Imf::M44fAttribute(matrix_of(value)));
  header.screenWindowWidth() = picture.screen_width;
  header.screenWindowCenter() = {picture.screen_center[0], picture.screen_center[1]};
  return header;
}

/// A file in memory. OpenEXR's own stream loses errors of its last buffer, and its destructors lose all errors.
class MemoryStream : public Imf::OStream {
 public:
  MemoryStream() : Imf::OStream("picture") {}

  void write(const char bytes[], int size) override {
    const auto count = static_cast<std::size_t>(size);
    if (bytes_.size() < position_ + count) bytes_.resize(position_ + count);
    std::copy_n(bytes, count, bytes_.begin() + static_cast<std::ptrdiff_t>(position_));
    position_ += count;
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = static_cast<std::size_t>(position); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  std::size_t position_ = 0;
};

}  // namespace

std::optional<Error> write_exr(const std::filesystem::path& file, const Picture& picture, Precision precision,
                               Compression compression) {
  if (auto error = check_layout(file, picture)) return error;
  MemoryStream stream;
  try {
    const Window part = picture.window();
    Imf::Header header = header_of(picture);
    header.compression() = compression == Compression::zip ? Imf::ZIP_COMPRESSION : Imf::NO_COMPRESSION;
    Imf::FrameBuffer frame;
    std::set<std::string> of_halves;
    if (precision == Precision::half) of_halves = layers_of_halves(picture);
    std::list<std::vector<half>> halves;  // the frame points to them
    for (const auto& channel : picture.channels) {
      if (of_halves.contains(layer_of(channel.name))) {
        halves.emplace_back(channel.pixels.begin(), channel.pixels.end());
        header.channels().insert(channel.name, Imf::Channel(Imf::HALF));
        frame.insert(channel.name, slice(halves.back().data(), part.left, part.top, part.width));
        continue;
      }
      header.channels().insert(channel.name, Imf::Channel(Imf::FLOAT));
      frame.insert(channel.name, slice(const_cast<float*>(channel.pixels.data()), part.left, part.top, part.width));
    }
    Imf::OutputFile out(stream, header);
    out.setFrameBuffer(frame);
    out.writePixels(picture.height);
  } catch (const std::exception& exception) {
    return Error{file.string(), "", "a picture that can be encoded", exception.what()};
  }
  return replace_file(file, stream.bytes());
}

std::optional<Error> write_deep_exr(const std::filesystem::path& file, const DeepPicture& deep, const Picture& header) {
  if (auto error = check_window(file, header)) return error;
  const auto width = static_cast<std::size_t>(header.width);
  std::uint64_t count = 0;
  for (const std::uint32_t samples : deep.counts) count += samples;
  if (deep.counts.size() != width * static_cast<std::size_t>(header.height) || count != deep.samples.size())
    return Error{file.string(), "samples", fmt::format("{} of {} x {} pixels", count, header.width, header.height),
                 fmt::format("{} of {} pixels", deep.samples.size(), deep.counts.size())};
  for (const DeepSample& sample : deep.samples) {
    const glm::vec3& color = sample.color;
    if (!std::isfinite(color.x) || !std::isfinite(color.y) || !std::isfinite(color.z) || !std::isfinite(sample.alpha) ||
        !std::isfinite(sample.front_cm) || !std::isfinite(sample.back_cm))
      return Error{file.string(), fmt::format("sample {}", &sample - deep.samples.data()), "finite values",
                   "NaN or infinity"};
  }
  MemoryStream stream;
  try {
    Imf::Header deep_header = header_of(header);
    deep_header.setType(Imf::DEEPSCANLINE);
    deep_header.compression() = Imf::ZIPS_COMPRESSION;
    // By channel, the address of the first sample of each pixel of a row, as OpenEXR takes it.
    using Pointers = std::vector<const float*>;
    std::map<std::string, Pointers> rows;
    for (const char* name : {"R", "G", "B", "A", "Z", "ZBack"}) {
      deep_header.channels().insert(name, Imf::Channel(Imf::FLOAT));
      rows.emplace(name, Pointers(width));
    }
    Imf::DeepScanLineOutputFile out(stream, deep_header);
    // Every row is at the same addresses, so a step of 0 leads from one to the next.
    const auto base_of = [&](auto* first) {
      const auto left = static_cast<std::intptr_t>(sizeof(*first)) * header.left;
      return reinterpret_cast<char*>(reinterpret_cast<std::intptr_t>(first) - left);
    };
    std::vector<std::uint32_t> counts(width);
    Imf::DeepFrameBuffer frame;
    frame.insertSampleCountSlice(Imf::Slice(Imf::UINT, base_of(counts.data()), sizeof(std::uint32_t), 0));
    for (auto& [name, row] : rows)
      frame.insert(name, Imf::DeepSlice(Imf::FLOAT, base_of(row.data()), sizeof(float*), 0, sizeof(DeepSample)));
    out.setFrameBuffer(frame);
    const DeepSample* next = deep.samples.data();
    for (std::size_t y = 0; y < static_cast<std::size_t>(header.height); ++y) {
      for (std::size_t x = 0; x < width; ++x) {
        counts[x] = deep.counts[y * width + x];
        if (counts[x] == 0) continue;
        for (auto& [name, row] : rows) {
          row[x] = name == "R"   ? &next->color.x
                   : name == "G" ? &next->color.y
                   : name == "B" ? &next->color.z
                   : name == "A" ? &next->alpha
                   : name == "Z" ? &next->front_cm
                                 : &next->back_cm;
        }
        next += counts[x];
      }
      out.writePixels(1);
    }
  } catch (const std::exception& exception) {
    return Error{file.string(), "", "a picture that can be encoded", exception.what()};
  }
  return replace_file(file, stream.bytes());
}

void round_as_written(Picture* picture, Precision precision) {
  if (precision == Precision::full) return;
  const std::set<std::string> of_halves = layers_of_halves(*picture);
  for (Channel& channel : picture->channels) {
    if (!of_halves.contains(layer_of(channel.name))) continue;
    for (float& x : channel.pixels) x = half(x);
  }
}

namespace {

Result<Picture> read_channels(const std::filesystem::path& file, const ChooseChannels& choose, bool must_be_finite) {
  const auto error = [&](std::string place, std::string expected, std::string found) {
    return Error{file.string(), std::move(place), std::move(expected), std::move(found)};
  };
  std::error_code code;
  const auto status = std::filesystem::status(file, code);
  if (!std::filesystem::exists(status)) return error("", "an EXR picture", "no such file");
  if (!std::filesystem::is_regular_file(status)) return error("", "an EXR picture", "not a regular file");
  if (std::filesystem::file_size(file, code) == 0 && !code) return error("byte 0", "an EXR picture", "an empty file");

  static std::once_flag limits_set;
  std::call_once(limits_set, [] { Imf::Header::setMaxImageSize(longest_side, longest_side); });

  if (auto claim = check_exr_header(file, most_pixels)) return *claim;

  int first_row_not_read = 0;
  try {
    Imf::InputFile in(file.c_str());
    const auto window = in.header().dataWindow();
    const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
    const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
    if (width < 1 || height < 1 || width * height > most_pixels)
      return error("header dataWindow", fmt::format("1 to {} pixels", most_pixels),
                   fmt::format("{} x {}", width, height));
    Picture picture;
    picture.width = static_cast<int>(width);
    picture.height = static_cast<int>(height);
    const auto display = in.header().displayWindow();
    if (display != window) {
      const std::int64_t left = std::int64_t{window.min.x} - display.min.x,
                         top = std::int64_t{window.min.y} - display.min.y;
      const std::int64_t across = std::int64_t{display.max.x} - display.min.x + 1;
      const std::int64_t down = std::int64_t{display.max.y} - display.min.y + 1;
      constexpr std::int64_t most = 1 << 30;
      if (across < 1 || down < 1 || across > most || down > most || std::max(std::abs(left), std::abs(top)) > most)
        return error("header displayWindow", fmt::format("sides of 1 to {} pixels about the data", most),
                     fmt::format("{} x {}, the data from ({}, {})", across, down, left, top));
      picture.left = static_cast<int>(left);
      picture.top = static_cast<int>(top);
      picture.whole_width = static_cast<int>(across);
      picture.whole_height = static_cast<int>(down);
    }
    std::vector<std::string> names;
    for (auto it = in.header().channels().begin(); it != in.header().channels().end(); ++it) names.push_back(it.name());
    const std::vector<std::string> chosen = choose ? choose(names) : names;
    if (chosen.empty() && !names.empty())
      return error("channels", "R, G and B, a layer of them, or Y alone", fmt::format("{}", fmt::join(names, ", ")));
    for (auto it = in.header().channels().begin(); it != in.header().channels().end(); ++it) {
      if (std::ranges::find(chosen, it.name()) == chosen.end()) continue;
      const std::string place = fmt::format("channel {}", it.name());
      if (it.channel().type != Imf::FLOAT && it.channel().type != Imf::HALF)
        return error(place, "float or half pixels", "unsigned integers");
      if (it.channel().xSampling != 1 || it.channel().ySampling != 1)
        return error(place, "one value per pixel", "a subsampled channel");
      picture.channels.push_back({it.name(), {}});
    }
    if (picture.channels.empty()) return error("header channels", "one or more", "none");
    if (picture.channels.size() > most_channels)
      return error("header channels", fmt::format("at most {}", most_channels),
                   fmt::format("{}", picture.channels.size()));
    const auto claimed = static_cast<std::uint64_t>(width * height) * picture.channels.size() * sizeof(float);
    const auto most = most_bytes(in.header().compression(), std::filesystem::file_size(file));
    if (claimed > most)
      return error("header dataWindow", fmt::format("at most {} bytes of pixels in a file of this size", most),
                   fmt::format("{} x {} with {} channels", width, height, picture.channels.size()));
    if (Imf::hasChromaticities(in.header())) {
      const Imf::Chromaticities& c = Imf::chromaticities(in.header());
      picture.chromaticities = {c.red.x, c.red.y, c.green.x, c.green.y, c.blue.x, c.blue.y, c.white.x, c.white.y};
    }
    picture.screen_width = in.header().screenWindowWidth();
    picture.screen_center = {in.header().screenWindowCenter().x, in.header().screenWindowCenter().y};
    for (auto it = in.header().begin(); it != in.header().end(); ++it) {
      if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&it.attribute()))
        if (std::string(it.name()) != "type") picture.metadata[it.name()] = text->value();
      if (const auto* matrix = dynamic_cast<const Imf::M44fAttribute*>(&it.attribute()))
        std::copy_n(matrix->value().getValue(), 16, picture.matrices[it.name()].begin());
    }

    const auto row_floats = static_cast<std::size_t>(width);
    const int step = picture.channels.size() * row_floats > (std::size_t{1} << 20) ? 16 : rows_at_a_time;
    std::vector<std::vector<float>> block(picture.channels.size());
    for (int row = 0; row < picture.height; row += step) {
      const int rows = std::min(step, picture.height - row);
      Imf::FrameBuffer frame;
      for (std::size_t c = 0; c < block.size(); ++c) {
        block[c].resize(row_floats * static_cast<std::size_t>(rows));
        frame.insert(picture.channels[c].name,
                     slice(block[c].data(), window.min.x, std::int64_t{window.min.y} + row, picture.width));
      }
      first_row_not_read = row;
      in.setFrameBuffer(frame);
      in.readPixels(window.min.y + row, window.min.y + row + rows - 1);
      for (std::size_t c = 0; c < block.size(); ++c)
        picture.channels[c].pixels.insert(picture.channels[c].pixels.end(), block[c].begin(), block[c].end());
    }
    for (const auto& channel : picture.channels)
      if (const auto place = find_not_finite(channel, picture.width); must_be_finite && !place.empty())
        return error(place, "a finite value", "NaN or infinity");
    return picture;
  } catch (const std::exception& exception) {
    return error(first_row_not_read > 0 ? fmt::format("row {}", first_row_not_read) : "", "a whole EXR picture",
                 exception.what());
  }
}

}  // namespace

Result<Picture> read_exr(const std::filesystem::path& file) { return read_channels(file, {}, true); }

Result<Picture> read_exr_channels(const std::filesystem::path& file, const ChooseChannels& choose) {
  return read_channels(file, choose, false);
}

}  // namespace tress::image
