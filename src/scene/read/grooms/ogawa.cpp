#include "scene/read/grooms/ogawa.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "scene/read/grooms/groom_file.h"
#include "scene/read/grooms/number_formats.h"

namespace tress::scene {
namespace {

constexpr std::uint64_t is_data = std::uint64_t{1} << 63;
constexpr std::size_t key_bytes = 16, hash_bytes = 32;

/// Reads the bytes of headers in order.
struct HeaderBytes {
  std::span<const unsigned char> bytes;
  std::size_t at = 0;
  bool is_short = false;

  std::uint64_t number(std::size_t size) {
    if (bytes.size() - at < size) {
      is_short = true;
      at = bytes.size();
      return 0;
    }
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i) value |= std::uint64_t{bytes[at + i]} << (8 * i);
    at += size;
    return value;
  }

  std::string text(std::uint64_t size) {
    if (bytes.size() - at < size) {
      is_short = true;
      at = bytes.size();
      return {};
    }
    const auto* begin = reinterpret_cast<const char*>(bytes.data() + at);
    at += static_cast<std::size_t>(size);
    return printable({begin, begin + size});
  }
};

}  // namespace

namespace {

/// The value of a key in "key=value;key=value".
std::string_view value_in(std::string_view rest, std::string_view key) {
  while (!rest.empty()) {
    const std::string_view pair = rest.substr(0, rest.find(';'));
    rest.remove_prefix(std::min(rest.size(), pair.size() + 1));
    if (pair.size() > key.size() && pair.starts_with(key) && pair[key.size()] == '=')
      return pair.substr(key.size() + 1);
  }
  return {};
}

}  // namespace

std::string_view OgawaProperty::value_of(std::string_view key) const { return value_in(metadata, key); }

OgawaFile::OgawaFile(std::span<const unsigned char> bytes, std::string name, DoneWith done_with)
    : bytes_(bytes), name_(std::move(name)), done_with_(std::move(done_with)), left_(bytes.size() / 8) {
  if (bytes.size() < 16) {
    fail(bytes.size(), "a header of 16 bytes", "the end of the file");
  } else if (bytes[5] != 0xff) {
    fail(5, "255: an archive that was closed", fmt::format("{}", bytes[5]));
  } else if (bytes[6] != 0 || bytes[7] != 1) {
    fail(6, "version 1 of Ogawa", fmt::format("{}", 256 * bytes[6] + bytes[7]));
  } else {
    const Group root = group(read<std::uint64_t>(8));
    if (!error_ && root.children < 6) fail(root.at, "a root group of six children", fmt::format("{}", root.children));
    read_time_samplings(data(child(root, 4)));
    read_metadata(data(child(root, 5)));
    top_ = {"", "", child(root, 2)};
    const auto metadata = data(child(root, 3));
    archive_metadata_.assign(metadata.begin(), metadata.end());
  }
}

void OgawaFile::fail(std::uint64_t byte, std::string expected, std::string found) {
  if (!error_) error_ = Error{name_, fmt::format("byte {}", byte), std::move(expected), std::move(found)};
}

template <class T>
T OgawaFile::read(std::uint64_t at) {
  T value{};
  if (at > bytes_.size() || bytes_.size() - at < sizeof value) {
    fail(at, fmt::format("{} bytes", sizeof value), "the end of the file");
    return value;
  }
  std::memcpy(&value, bytes_.data() + at, sizeof value);
  return value;
}

OgawaFile::Group OgawaFile::group(std::uint64_t at) {
  if (error_ || at == 0) return {};
  if (at & is_data) {
    fail(at & ~is_data, "a group", "data");
    return {};
  }
  if (left_ == 0) {
    fail(at, "no more groups than the bytes allow", "groups that hold each other");
    return {};
  }
  --left_;
  const auto children = read<std::uint64_t>(at);
  if (error_) return {};
  if (children > (bytes_.size() - at - 8) / 8) {
    fail(at, fmt::format("at most {} children, as the bytes allow", (bytes_.size() - at - 8) / 8),
         fmt::format("{}", children));
    return {};
  }
  return {at, children};
}

std::uint64_t OgawaFile::child(const Group& group, std::uint64_t index) {
  if (error_) return 0;
  if (index >= group.children) {
    fail(group.at, fmt::format("a group of {} children or more", index + 1), fmt::format("{}", group.children));
    return 0;
  }
  return read<std::uint64_t>(group.at + 8 + 8 * index);
}

std::span<const unsigned char> OgawaFile::data(std::uint64_t child) {
  if (error_ || child == 0 || child == is_data) return {};
  if (!(child & is_data)) {
    fail(child, "data", "a group");
    return {};
  }
  const std::uint64_t at = child & ~is_data;
  const auto size = read<std::uint64_t>(at);
  if (error_) return {};
  if (size > bytes_.size() - at - 8) {
    fail(at, fmt::format("at most {} bytes of data", bytes_.size() - at - 8), fmt::format("{}", size));
    return {};
  }
  return bytes_.subspan(static_cast<std::size_t>(at) + 8, static_cast<std::size_t>(size));
}

void OgawaFile::read_metadata(std::span<const unsigned char> bytes) {
  HeaderBytes header{bytes};
  while (header.at < bytes.size() && !header.is_short) metadata_.push_back(header.text(header.number(1)));
  if (header.is_short) fail(8, "metadata that end", "metadata that are cut off");
}

void OgawaFile::read_time_samplings(std::span<const unsigned char> bytes) {
  constexpr std::size_t head = 16;  // the number of samples (also stored elsewhere), the period, the number of times
  while (bytes.size() >= head) {
    TimeSampling sampling;
    std::uint32_t count = 0;
    std::memcpy(&sampling.period, bytes.data() + 4, sizeof(double));
    std::memcpy(&count, bytes.data() + 12, sizeof count);
    bytes = bytes.subspan(head);
    if (count == 0 || bytes.size() / sizeof(double) < count)
      return fail(8, "as many times as a time sampling says", fmt::format("{}", bytes.size() / sizeof(double)));
    sampling.times.resize(count);
    std::memcpy(sampling.times.data(), bytes.data(), count * sizeof(double));
    bytes = bytes.subspan(count * sizeof(double));
    time_samplings_.push_back(std::move(sampling));
  }
}

double OgawaFile::TimeSampling::of(std::uint64_t sample) const {
  const std::uint64_t periods = sample / times.size();
  const double since = periods == 0 ? 0 : period * static_cast<double>(periods);
  return times[static_cast<std::size_t>(sample % times.size())] + since;
}

std::optional<double> OgawaFile::frames_per_second() const {
  const std::string_view said = value_in(archive_metadata_, "_ai_DCC_FPS");
  double rate = 0;
  if (const auto [end, fault] = std::from_chars(said.data(), said.data() + said.size(), rate);
      fault == std::errc() && rate > 0 && rate < 1e6)
    return rate;
  constexpr double usual = 24, rounding = 1e-3;
  for (const TimeSampling& sampling : time_samplings_) {
    const double step = usual * sampling.period, times = step < 1 ? 1 / step : step;
    const bool is_uniform = sampling.times.size() == 1 && sampling.period > 1e-4 && sampling.period < 0.5;
    if (is_uniform && std::abs(times - std::round(times)) > rounding * times) return 1 / sampling.period;
  }
  return std::nullopt;
}

std::string OgawaFile::text(const OgawaProperty& property) {
  const auto bytes = property.is_text() ? sample(property) : std::span<const unsigned char>();
  return {bytes.begin(), std::find(bytes.begin(), bytes.end(), 0)};
}

double OgawaFile::seconds_of(const OgawaProperty& property, std::uint64_t sample) const {
  return property.time_sampling < time_samplings_.size() ? time_samplings_[property.time_sampling].of(sample) : 0;
}

OgawaMoment OgawaFile::around(const OgawaProperty& property, double seconds) const {
  OgawaMoment moment;
  if (property.samples < 2 || property.time_sampling >= time_samplings_.size()) return moment;
  const TimeSampling& sampling = time_samplings_[property.time_sampling];
  std::uint64_t end = property.samples;  // the first sample that is known to be later
  while (end - moment.before > 1) {
    const std::uint64_t middle = moment.before + (end - moment.before) / 2;
    (sampling.of(middle) <= seconds ? moment.before : end) = middle;
  }
  moment.after = std::min(moment.before + 1, property.samples - 1);
  const double from = sampling.of(moment.before), to = sampling.of(moment.after);
  moment.share = to > from && seconds > from ? std::min((seconds - from) / (to - from), 1.0) : 0;
  constexpr double rounding = 1e-6;  // a frame's time is a quotient; within this tolerance it is its sample's time
  if (moment.share > 1 - rounding) moment = {moment.after, moment.after, 0};
  if (!(moment.share >= rounding)) moment = {moment.before, moment.before, 0};
  return moment;
}

std::vector<OgawaObject> OgawaFile::children(const OgawaObject& object) {
  std::vector<OgawaObject> out;
  const Group here = group(object.group);
  if (here.children < 2) return out;
  const auto bytes = data(child(here, here.children - 1));
  if (bytes.size() < hash_bytes) return out;
  HeaderBytes header{bytes.first(bytes.size() - hash_bytes)};
  while (header.at < header.bytes.size() && !error_) {
    OgawaObject one;
    one.name = header.text(header.number(4));
    const std::uint64_t index = header.number(1);
    if (index == 255)
      one.metadata = header.text(header.number(4));
    else if (index < metadata_.size())
      one.metadata = metadata_[index];
    else
      fail(here.at, "metadata that the archive has", fmt::format("number {} of {}", index, metadata_.size()));
    if (header.is_short) fail(here.at, "headers of objects that end", "headers that are cut off");
    if (error_) break;
    one.group = child(here, out.size() + 1);
    out.push_back(std::move(one));
  }
  return error_ ? std::vector<OgawaObject>() : out;
}

std::vector<OgawaProperty> OgawaFile::properties(const OgawaObject& object) {
  const Group here = group(object.group);
  return here.children == 0 ? std::vector<OgawaProperty>() : properties_of(child(here, 0));
}

std::vector<OgawaProperty> OgawaFile::properties(const OgawaProperty& compound) {
  if (compound.kind != OgawaProperty::Kind::compound) return {};
  return properties_of(compound.group);
}

std::vector<OgawaProperty> OgawaFile::properties_of(std::uint64_t at) {
  std::vector<OgawaProperty> out;
  const Group here = group(at);
  if (here.children == 0) return out;
  HeaderBytes header{data(child(here, here.children - 1))};
  while (header.at < header.bytes.size() && !error_) {
    OgawaProperty one;
    const auto info = static_cast<std::uint32_t>(header.number(4));
    const std::size_t size = std::size_t{1} << std::min((info >> 2) & 3u, 2u);
    one.kind = (info & 3) == 0   ? OgawaProperty::Kind::compound
               : (info & 3) == 1 ? OgawaProperty::Kind::scalar
                                 : OgawaProperty::Kind::array;
    if (one.kind != OgawaProperty::Kind::compound) {
      one.pod = static_cast<std::uint8_t>((info >> 4) & 15);
      one.extent = std::max((info >> 12) & 255u, 1u);
      one.samples = header.number(size);
      one.last_change = one.samples == 0 ? 0 : one.samples - 1;
      if (info & (1u << 9)) {
        one.first_change = header.number(size);
        one.last_change = header.number(size);
      } else if (info & (1u << 11)) {
        one.first_change = one.last_change = 0;
      }
      if (info & (1u << 8)) one.time_sampling = static_cast<std::uint32_t>(header.number(size));
      if (one.samples > 1 && one.time_sampling >= time_samplings_.size() && !header.is_short)
        fail(here.at, fmt::format("one of the {} time samplings of the archive", time_samplings_.size()),
             fmt::format("number {}", one.time_sampling));
    }
    one.name = header.text(header.number(size));
    const std::uint32_t index = (info >> 20) & 255;
    if (index == 255)
      one.metadata = header.text(header.number(size));
    else if (index < metadata_.size())
      one.metadata = metadata_[index];
    else
      fail(here.at, "metadata that the archive has", fmt::format("number {} of {}", index, metadata_.size()));
    if (header.is_short) fail(here.at, "headers of properties that end", "headers that are cut off");
    if (error_) break;
    one.group = child(here, out.size());
    out.push_back(std::move(one));
  }
  return error_ ? std::vector<OgawaProperty>() : out;
}

std::span<const unsigned char> OgawaFile::sample(const OgawaProperty& property, std::uint64_t index) {
  if (property.kind == OgawaProperty::Kind::compound || property.samples == 0) return {};
  const Group here = group(property.group);
  if (here.children == 0) return {};
  const std::uint64_t first = property.first_change, last = std::max(first, property.last_change);
  std::uint64_t stored = 0;
  if (index >= first && property.last_change > 0) stored = std::min(index, last) - first + 1;
  if (property.kind == OgawaProperty::Kind::array) stored *= 2;  // each sample is followed by its dimensions
  const auto bytes = data(child(here, stored));
  return bytes.size() < key_bytes ? std::span<const unsigned char>() : bytes.subspan(key_bytes);
}

template <class T>
std::vector<T> OgawaFile::numbers(const OgawaProperty& property, std::uint64_t index) {
  std::vector<T> out;
  const auto bytes = sample(property, index);
  const auto format = static_cast<NumberFormat>(property.pod);
  const std::size_t size = property.is_text() ? 0 : bytes_of(format);
  if (bytes.empty()) return out;
  if (size == 0 || bytes.size() % (size * property.extent) != 0) {
    fail(property.group, fmt::format("values of {} numbers in {}", property.extent, property.name.substr(0, 64)),
         size == 0 ? "texts" : fmt::format("{} bytes", bytes.size()));
    return out;
  }
  out.resize(bytes.size() / size);
  convert_numbers(bytes, format, out.data());
  if (done_with_ && bytes.size() >= done_block) done_with_(bytes);
  return out;
}

std::vector<float> OgawaFile::floats(const OgawaProperty& property, std::uint64_t index) {
  return numbers<float>(property, index);
}
std::vector<double> OgawaFile::doubles(const OgawaProperty& property, std::uint64_t index) {
  return numbers<double>(property, index);
}
std::vector<std::int64_t> OgawaFile::integers(const OgawaProperty& property, std::uint64_t index) {
  return numbers<std::int64_t>(property, index);
}

}  // namespace tress::scene
