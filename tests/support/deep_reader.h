// Reads deep pictures by OpenEXR's own interface.
#pragma once

#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineInputFile.h>
#include <ImfHeader.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "image/deep_picture.h"

namespace tress::test {

struct ReadDeep {
  image::Window window;
  int whole_width = 0, whole_height = 0;
  std::string type;
  Imf::Compression compression = Imf::NO_COMPRESSION;
  std::vector<std::string> channels;
  std::map<std::string, std::string> metadata;
  std::vector<std::vector<image::DeepSample>> pixels;  ///< row-major
};

/// Throws what OpenEXR throws.
inline ReadDeep read_deep(const std::string& file) {
  Imf::DeepScanLineInputFile in(file.c_str());
  const Imf::Header& header = in.header();
  const Imath::Box2i data = header.dataWindow(), display = header.displayWindow();
  ReadDeep read;
  read.window = {data.min.x, data.min.y, data.max.x - data.min.x + 1, data.max.y - data.min.y + 1};
  read.whole_width = display.max.x + 1;
  read.whole_height = display.max.y + 1;
  read.type = header.type();
  read.compression = header.compression();
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) read.channels.emplace_back(it.name());
  for (auto it = header.begin(); it != header.end(); ++it)
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&it.attribute()))
      read.metadata[it.name()] = text->value();

  const auto width = static_cast<std::size_t>(read.window.width);
  const std::size_t count = width * static_cast<std::size_t>(read.window.height);
  const auto base_of = [&](auto* first) {
    const auto offset =
        static_cast<std::intptr_t>(sizeof(*first)) *
        (read.window.left + static_cast<std::intptr_t>(read.window.top) * static_cast<std::intptr_t>(width));
    return reinterpret_cast<char*>(reinterpret_cast<std::intptr_t>(first) - offset);
  };
  std::vector<unsigned> counts(count);
  std::array<std::vector<float*>, 6> pointers;
  Imf::DeepFrameBuffer frame;
  frame.insertSampleCountSlice(
      Imf::Slice(Imf::UINT, base_of(counts.data()), sizeof(unsigned), sizeof(unsigned) * width));
  constexpr std::array<const char*, 6> names{"R", "G", "B", "A", "Z", "ZBack"};
  for (std::size_t c = 0; c < names.size(); ++c) {
    pointers[c].resize(count);
    frame.insert(names[c], Imf::DeepSlice(Imf::FLOAT, base_of(pointers[c].data()), sizeof(float*),
                                          sizeof(float*) * width, sizeof(image::DeepSample)));
  }
  in.setFrameBuffer(frame);
  in.readPixelSampleCounts(data.min.y, data.max.y);
  read.pixels.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    read.pixels[i].resize(counts[i]);
    if (counts[i] == 0) continue;
    image::DeepSample& first = read.pixels[i].front();
    const std::array<float*, 6> to{&first.color.x, &first.color.y,  &first.color.z,
                                   &first.alpha,   &first.front_cm, &first.back_cm};
    for (std::size_t c = 0; c < to.size(); ++c) pointers[c][i] = to[c];
  }
  in.readPixels(data.min.y, data.max.y);
  return read;
}

/// R, G, B, A of a pixel: `over` from the farthest sample to the nearest, in floats, as a compositor does.
inline std::array<float, 4> flat(const std::vector<image::DeepSample>& samples) {
  std::array<float, 4> sum{};
  for (auto sample = samples.rbegin(); sample != samples.rend(); ++sample) {
    const std::array<float, 4> own{sample->color.x, sample->color.y, sample->color.z, sample->alpha};
    for (std::size_t c = 0; c < 4; ++c) sum[c] = own[c] + (1 - sample->alpha) * sum[c];
  }
  return sum;
}

}  // namespace tress::test
