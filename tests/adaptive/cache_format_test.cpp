// A cache is read back as it was written, and whatever else a file may hold is refused with a reason.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>

#include "adaptive/cache_bytes.h"
#include "adaptive/cache_images.h"
#include "cache/byte_source.h"
#include "cache/format.h"
#include "cache/reader.h"
#include "observations/sketch.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr const char* model = "elliptical-test";

/// Refused, with a message of all four parts.
void expect_refused(const std::string& bytes, const std::string& why) {
  const Result<TableSnapshot> result = decode_cache(bytes, model, "hair.cache");
  ASSERT_FALSE(result.has_value()) << why;
  const Error& error = result.error();
  EXPECT_EQ(error.file, "hair.cache") << why;
  EXPECT_NE(error.place.find("byte "), std::string::npos) << why << ": " << error.message();
  EXPECT_FALSE(error.expected.empty()) << why;
  EXPECT_FALSE(error.found.empty()) << why;
}

TEST(CacheFormat, ReadsBackWhatItWrote) {
  const std::string bytes = encode_cache(small_image());
  const Result<TableSnapshot> read = decode_cache(bytes, model, "hair.cache");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(encode_cache(*read), bytes);
  ASSERT_EQ(read->slices.size(), 2u);
  ASSERT_EQ(read->slices[0].rows.size(), 2u);
  const CachedRow& row = read->slices[0].rows[0];
  EXPECT_EQ(row.node, 1u);
  EXPECT_EQ(row.state, RowState::converged);
  EXPECT_EQ(row.generation, 1u);
  EXPECT_EQ(row.energy, 0.75f);
  EXPECT_EQ(row.objective, 0.004f);
  EXPECT_EQ(row.count, 64u);
  ASSERT_EQ(row.density()->fit.component_count, 2u);
  EXPECT_EQ(row.density()->fit.components[0].shape.s_right, 0.2f);
  EXPECT_EQ(row.density()->fit.components[1].attribute_mean, 3.0f);
  EXPECT_EQ(row.density()->fit.uniform_attribute_variance, 0.5f);
  EXPECT_EQ(read->slices[0].rows[1].density()->sketch, small_image().slices[0].rows[1].density()->sketch);
  EXPECT_EQ(read->slices[0].description.axis_b, small_image().slices[0].description.axis_b);
}

// The layout of CACHE_FORMAT.md, by hand: a change of a byte's place needs a new format version.
TEST(CacheFormat, HasTheDocumentedLayout) {
  const std::string bytes = encode_cache(small_image());
  EXPECT_EQ(bytes.substr(0, 8), "\x89TRESS\r\n");
  EXPECT_EQ(bytes.substr(8, 8), std::string("\1\0\0\0\4\0\0\0", 8));
  EXPECT_EQ(get_u64(bytes, 16), model_hash(model));
  EXPECT_EQ(payload(bytes, 1), 48u);
  EXPECT_EQ(bytes.substr(48, 19), std::string("\x0f\0\0\0", 4) + model);
  EXPECT_EQ(get_u64(bytes, payload(bytes, 2) - 16), 4u + 28 + 5 * 4 + 28 + 3 * 4);
  EXPECT_EQ(get_u64(bytes, payload(bytes, 3) - 16), 4u + 28 + 12 + 2 * 24 + 28 + 4 + 28);
  EXPECT_EQ(get_u64(bytes, payload(bytes, 4) - 16), 4u + 2 * 12 + 4);
}

TEST(CacheFormat, EqualTablesAreEqualFiles) {
  TableSnapshot image = small_image();
  CachedRow& converged = image.slices[0].rows[0];
  converged.density()->fit.components[7].weight = 3;    // beyond component_count
  converged.density()->sketch = {sketch_bin(1, 1, 1)};  // a converged row keeps none
  CachedRow& open = image.slices[0].rows[1];
  open.state = RowState::refused;
  open.objective = 0.5f;
  open.density()->fit = converged.density()->fit;
  image.slices[0].description.axis_a[0] = -0.0f;
  EXPECT_EQ(encode_cache(image), encode_cache(small_image()));
  EXPECT_EQ(cache_hash(small_image()).size(), 16u);
  image.slices[0].rows[0].count += 1;
  EXPECT_NE(cache_hash(image), cache_hash(small_image()));
}

TEST(CacheFormat, RefusesEveryFlippedByte) {
  const std::string bytes = encode_cache(small_image());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (int mask = 1; mask < 256; ++mask) {
      std::string flipped = bytes;
      flipped[i] = static_cast<char>(flipped[i] ^ mask);
      expect_refused(flipped, "byte " + std::to_string(i) + " xor " + std::to_string(mask));
      EXPECT_FALSE(decode_cache(flipped, "", "hair.cache").has_value()) << "any model, byte " << i;
    }
  }
}

// A file of an earlier version, by hand: its rows of knots are checked, counted and left out.
TEST(CacheFormat, LeavesOutRowsOfKnots) {
  const std::string bytes = knot_cache();
  EXPECT_EQ(get_u64(bytes, 8) & 0xffffffffu, 2u);
  const Result<TableSnapshot> read = decode_cache(bytes, model, "hair.cache");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(encode_cache(*read), encode_cache(small_image()));
  const MemoryBytes source(bytes);
  CacheReader reader(source, "hair.cache");
  ASSERT_TRUE(reader.check(model));
  EXPECT_EQ(reader.contents().format, 2u);
  EXPECT_EQ(reader.contents().knot_rows, 1u);
  EXPECT_EQ(reader.contents().rows(), 3u);

  // The file of another version, as a program before knot rows or one that writes 2 for everything would have it.
  std::string as_one = bytes, as_two = encode_cache(small_image());
  put(&as_one, 8, 1, 4);
  put(&as_two, 8, 2, 4);
  expect_refused(as_one, "knot rows in version 1");
  expect_refused(as_two, "no knot rows in version 2");
}

TEST(CacheFormat, RefusesWrongKnotRowsBehindValidChecksums) {
  const std::string good = knot_cache();
  const std::size_t row = payload(good, 3) + 4 + 28 + 12 + 2 * 24;
  const auto with = [&](const char* why, const std::function<void(std::string*)>& change) {
    std::string bytes = good;
    change(&bytes);
    ASSERT_NE(bytes, good) << why;
    seal(&bytes, 3);
    expect_refused(bytes, why);
  };
  with("31 knots", [&](std::string* b) { put(b, row + 5, 31, 1); });
  with("no knots", [&](std::string* b) { put(b, row + 5, 0, 1); });
  with("more knots than there are bytes", [&](std::string* b) { put(b, row + 5, 128, 1); });
  with("kind 2", [&](std::string* b) { put(b, row + 6, 2, 1); });
  with("kind 3", [&](std::string* b) { put(b, row + 6, 3, 1); });
  with("a mixture of 32 components", [&](std::string* b) { put(b, row + 6, 0, 1); });
  with("byte 7", [&](std::string* b) { put(b, row + 7, 1, 1); });
  with("an open row with a kind", [&](std::string* b) { put(b, row + 4, 1, 1); });
  with("a negative density", [&](std::string* b) { put_float(b, row + 28, -0.1f); });
  with("a density that is no number", [&](std::string* b) { put_float(b, row + 28, std::nanf("")); });
  with("an infinite density", [&](std::string* b) { put_float(b, row + 28, std::numeric_limits<float>::infinity()); });
  with("a negative path", [&](std::string* b) { put_float(b, row + 32, -1); });
  with("a negative variance", [&](std::string* b) { put_float(b, row + 36, -1); });
  with("a negative zero", [&](std::string* b) { put_float(b, row + 36, -0.0f); });
}

TEST(CacheFormat, RefusesEveryFlippedByteAndTruncationOfKnots) {
  const std::string bytes = knot_cache();
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string flipped = bytes;
    flipped[i] = static_cast<char>(flipped[i] ^ 0x10);
    expect_refused(flipped, "byte " + std::to_string(i));
    expect_refused(bytes.substr(0, i), "cut to " + std::to_string(i));
  }
}

// With the checksum made right again: what is taken leaves the other rows as they were.
TEST(CacheFormat, NeverCrashesOnFlippedKnotsBehindValidChecksums) {
  const std::string bytes = knot_cache();
  const std::size_t start = payload(bytes, 3) + 4 + 28 + 12 + 2 * 24;
  for (std::size_t i = start; i < start + 28 + 32 * 12; ++i) {
    for (const int mask : {0x01, 0x02, 0x20, 0x40, 0x80, 0xff}) {
      std::string flipped = bytes;
      flipped[i] = static_cast<char>(flipped[i] ^ mask);
      seal(&flipped, 3);
      if (const Result<TableSnapshot> read = decode_cache(flipped, model, "hair.cache"); read) {
        ASSERT_EQ(encode_cache(*read), encode_cache(small_image())) << "byte " << i << " xor " << mask;
      }
    }
  }
}

TEST(CacheFormat, ReadsBackRibbons) {
  const std::string bytes = encode_cache(samples_image());
  const Result<TableSnapshot> read = decode_cache(bytes, model, "hair.cache");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(encode_cache(*read), bytes);
  ASSERT_EQ(read->slices.size(), 3u);
  EXPECT_EQ(read->slices[0].description.kind, SliceKind::density);
  EXPECT_EQ(read->slices[0].rows.at(0).ribbons(), nullptr);
  const CachedSlice& slice = read->slices[2];
  const CachedSlice wanted = slice_of_samples();
  EXPECT_EQ(slice.description.kind, SliceKind::samples);
  EXPECT_EQ(slice.description.key, wanted.description.key);
  EXPECT_EQ(slice.description.blur_rad, 0);
  ASSERT_EQ(slice.rows.size(), 3u);
  for (const std::size_t r : {0, 2}) {
    EXPECT_EQ(slice.rows[r].state, RowState::converged);
    EXPECT_EQ(slice.rows[r].count, 4096u);
    EXPECT_EQ(slice.rows[r].objective, wanted.rows[r].objective);
    EXPECT_EQ(slice.rows[r].energy, wanted.rows[r].ribbons()->total_mass());
    ASSERT_NE(slice.rows[r].ribbons(), nullptr);
    EXPECT_EQ(*slice.rows[r].ribbons(), *wanted.rows[r].ribbons());
    EXPECT_EQ(slice.rows[r].density(), nullptr);
  }
  EXPECT_EQ(slice.rows[1].state, RowState::open);
  EXPECT_EQ(slice.rows[1].ribbons(), nullptr);
}

constexpr std::size_t ribbon_bytes = 4 + RibbonRow::part_bytes;  // of a part, with its mass

/// First byte of the slice of samples in section 2 of samples_image(), and of its first row in section 3.
std::size_t samples_slice(const std::string& bytes) { return payload(bytes, 2) + 4 + (52 + 5 * 4) + (52 + 3 * 4); }
std::size_t samples_row(const std::string& bytes) {
  return payload(bytes, 3) + 4 + (28 + 12 + 2 * 24) + 28 + 4 + 28 + 4;
}

// CACHE_FORMAT.md by hand, and that only tables with slices of samples are of the version that knows of them.
TEST(CacheFormat, SlicesOfSamplesAreAKindAndAVersionOfTheirOwn) {
  const std::string bytes = encode_cache(samples_image());
  EXPECT_EQ(get_u64(bytes, 8) & 0xffffffffu, 3u);
  const std::size_t slice = samples_slice(bytes), row = samples_row(bytes);
  EXPECT_EQ(bytes.substr(slice, 8), std::string("\x10\0\0\0\1\0\0\0", 8));
  EXPECT_EQ(bytes.substr(payload(bytes, 2) + 4, 8), std::string("\1\0\0\0\0\0\0\0", 8));
  EXPECT_EQ(slice + 52 + 4 * 4, payload(bytes, 3) - format::section_header_bytes);
  EXPECT_EQ(bytes.substr(row, 8), std::string("\0\0\0\0\2\2\2\0", 8));
  EXPECT_EQ(row + 3 * 28 + 6 * ribbon_bytes, payload(bytes, 4) - format::section_header_bytes);
  EXPECT_EQ(get_u64(bytes, payload(bytes, 4) - 16), 4u + 2 * 12 + 4 + 4) << "an open row of samples has no bins";

  std::string as_two = bytes, as_three = encode_cache(small_image());
  put(&as_two, 8, 2, 4);
  put(&as_three, 8, 3, 4);
  expect_refused(as_two, "slices of samples in version 2");
  expect_refused(as_three, "no slices of samples in version 3");

  // All slices of such a file record their kind, so that no file of the version is read as another.
  TableSnapshot densities = small_image(), without_rows = small_image();
  without_rows.slices.push_back(slice_of_samples());
  without_rows.slices[2].rows.clear();
  EXPECT_EQ(get_u64(encode_cache(without_rows), 8) & 0xffffffffu, 3u);
  const Result<TableSnapshot> read = decode_cache(encode_cache(without_rows), model, "hair.cache");
  ASSERT_TRUE(read) << read.error().message();
  densities.slices = {read->slices[0], read->slices[1]};
  EXPECT_EQ(encode_cache(densities), encode_cache(small_image()));
}

TEST(CacheFormat, ParametersBeyondTheUsualOnesNeedAVersionOfTheirOwn) {
  TableSnapshot image = samples_image();
  const std::string usual = encode_cache(image);
  image.slices.back().description.key.parameters.back() = 0.5f;
  const std::string bytes = encode_cache(image);
  EXPECT_EQ(get_u64(bytes, 8) & 0xffffffffu, 4u);
  EXPECT_EQ(bytes.size(), usual.size() + 4 * 8 * image.slices.size());
  const Result<TableSnapshot> read = decode_cache(bytes, model, "hair.cache");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->slices.back().description.key, image.slices.back().description.key);
  EXPECT_EQ(encode_cache(*read), bytes);

  std::string as_three = bytes, as_four = usual;
  put(&as_three, 8, 3, 4);
  put(&as_four, 8, 4, 4);
  expect_refused(as_three, "more parameters in version 3");
  expect_refused(as_four, "the usual parameters in version 4");
}

TEST(CacheFormat, RefusesWrongSlicesAndRowsOfSamplesBehindValidChecksums) {
  const std::string good = encode_cache(samples_image());
  const std::size_t slice = samples_slice(good), row = samples_row(good), part = row + 28 + 8;
  const auto with = [&](int section, const char* why, const std::function<void(std::string*)>& change) {
    std::string bytes = good;
    change(&bytes);
    ASSERT_NE(bytes, good) << why;
    seal(&bytes, section);
    expect_refused(bytes, why);
  };
  with(2, "kind 2 of a slice", [&](std::string* b) { put(b, slice + 4, 2, 4); });
  with(2, "samples as densities", [&](std::string* b) { put(b, slice + 4, 0, 4); });
  with(2, "a parameter that is no number", [&](std::string* b) { put_float(b, slice + 36, std::nanf("")); });
  with(2, "a negative zero", [&](std::string* b) { put_float(b, slice + 28, -0.0f); });
  with(2, "a blur of samples", [&](std::string* b) { put_float(b, slice + 40, 0.2f); });
  with(2, "a fourth parameter of densities", [&](std::string* b) { put_float(b, payload(*b, 2) + 4 + 20, 1.0f); });
  with(3, "a mixture", [&](std::string* b) { put(b, row + 6, 0, 1); });
  with(3, "knots", [&](std::string* b) { put(b, row + 6, 1, 1); });
  with(3, "no ribbon", [&](std::string* b) { put(b, row + 5, 0, 1); });
  with(3, "five ribbons", [&](std::string* b) { put(b, row + 5, 5, 1); });
  with(3, "another number of ribbons", [&](std::string* b) { put(b, row + 5, 1, 1); });
  with(3, "more ribbons than there are bytes", [&](std::string* b) { put(b, row + 5, 4, 1); });
  with(3, "byte 7", [&](std::string* b) { put(b, row + 7, 1, 1); });
  with(3, "an open row with ribbons", [&](std::string* b) { put(b, row + 4, 1, 1); });
  with(3, "more energy than its parts", [&](std::string* b) { put_float(b, row + 12, 0.7501f); });
  with(3, "a negative mass", [&](std::string* b) { put_float(b, row + 28, -0.5f); });
  with(3, "an infinite mass", [&](std::string* b) { put_float(b, row + 28, HUGE_VALF); });
  with(3, "an unknown law", [&](std::string* b) { put(b, part, 2, 1); });
  with(4, "a sketch of a row of samples", [&](std::string* b) { put(b, payload(*b, 4) + 4 + 2 * 12 + 4, 1, 4); });
  // A mixture in a slice of densities as ribbons.
  with(3, "ribbons of a density", [&](std::string* b) { put(b, payload(*b, 3) + 4 + 6, 2, 1); });
}

TEST(CacheFormat, RefusesEveryFlippedByteAndTruncationOfRibbons) {
  const std::string bytes = encode_cache(samples_image());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string flipped = bytes;
    flipped[i] = static_cast<char>(flipped[i] ^ 0x10);
    expect_refused(flipped, "byte " + std::to_string(i));
    expect_refused(bytes.substr(0, i), "cut to " + std::to_string(i));
  }
}

TEST(CacheFormat, NeverCrashesOnFlippedRibbonsBehindValidChecksums) {
  const std::string bytes = encode_cache(samples_image());
  const auto flip = [&](int section, std::size_t i, int mask) {
    std::string flipped = bytes;
    flipped[i] = static_cast<char>(flipped[i] ^ mask);
    seal(&flipped, section);
    if (const Result<TableSnapshot> read = decode_cache(flipped, model, "hair.cache"); read) {
      ASSERT_EQ(encode_cache(*read), flipped) << "byte " << i << " xor " << mask;
    }
  };
  for (const int mask : {0x01, 0x02, 0x20, 0x40, 0x80, 0xff}) {
    for (std::size_t i = samples_slice(bytes); i < samples_slice(bytes) + 52 + 16; ++i) flip(2, i, mask);
    for (std::size_t i = samples_row(bytes); i < samples_row(bytes) + 28 + 2 * ribbon_bytes; ++i) flip(3, i, mask);
  }
}

// Of one key in both kinds, which two files of one model cannot have: one whole, the same for either order.
TEST(CacheFormat, AKeyOfBothKindsIsKeptAsOne) {
  TableSnapshot densities = small_image(), samples = small_image();
  samples.slices = {slice_of_samples()};
  samples.slices[0].description.key = densities.slices[0].description.key;
  const std::string one = encode_cache(merge_caches(densities, samples));
  EXPECT_EQ(encode_cache(merge_caches(samples, densities)), one);
  EXPECT_TRUE(decode_cache(one, model, "hair.cache"));
}

TEST(CacheFormat, RefusesEveryTruncationAndEveryTail) {
  const std::string bytes = encode_cache(small_image());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    expect_refused(bytes.substr(0, size), "cut to " + std::to_string(size));
  }
  expect_refused(bytes + '\0', "one byte more");
}

// With the checksums made right again, so that the checks of counts and values meet every byte.
TEST(CacheFormat, NeverCrashesOnFlipsBehindValidChecksums) {
  const std::string bytes = encode_cache(small_image());
  int taken = 0;
  for (int section = 1; section <= 4; ++section) {
    const std::size_t start = payload(bytes, section), length = get_u64(bytes, start - 16);
    for (std::size_t i = start; i < start + length; ++i) {
      for (int mask = 1; mask < 256; ++mask) {
        std::string flipped = bytes;
        flipped[i] = static_cast<char>(flipped[i] ^ mask);
        seal(&flipped, section);
        const Result<TableSnapshot> read = decode_cache(flipped, "", "hair.cache");
        if (!read) {
          EXPECT_FALSE(read.error().expected.empty());
          continue;
        }
        ++taken;  // another valid table: must be written back as it was read
        ASSERT_EQ(encode_cache(*read), flipped) << "byte " << i << " xor " << mask;
      }
    }
  }
  EXPECT_GT(taken, 0);
}

TEST(CacheFormat, RefusesForeignAndLaterFilesByName) {
  const std::string bytes = encode_cache(small_image());
  std::string later = bytes;
  put(&later, 8, format::version_of_parameters + 1, 4);
  const Error version = decode_cache(later, model, "hair.cache").error();
  EXPECT_EQ(version.message(), "hair.cache: byte 8: expected format version 1 to 4, found later version 5");

  // As a machine that writes the highest byte first would have it.
  std::string turned = bytes;
  put(&turned, 8, std::uint32_t{1} << 24, 4);
  EXPECT_EQ(decode_cache(turned, model, "hair.cache").error().message(),
            "hair.cache: byte 8: expected format version 1 to 4, found version 1 with its highest byte first");

  const Error other = decode_cache(bytes, "elliptical-2", "hair.cache").error();
  EXPECT_EQ(other.place, "byte 16");
  EXPECT_NE(other.expected.find("elliptical-2"), std::string::npos);
  EXPECT_NE(other.found.find(model), std::string::npos);
  EXPECT_TRUE(decode_cache(bytes, "", "hair.cache").has_value());

  expect_refused("", "empty");
  expect_refused(std::string(4096, '\0'), "zeros");
  expect_refused("{\"a\": \"json file of some length\"}", "text");
}

TEST(CacheFormat, RefusesValuesOutOfRangeBehindValidChecksums) {
  const std::string bytes = encode_cache(small_image());
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  const auto refused = [&](int section, const std::string& what,
                           const std::function<void(std::string*, std::size_t)>& edit) {
    std::string edited = bytes;
    edit(&edited, payload(bytes, section));
    seal(&edited, section);
    expect_refused(edited, what);
  };
  const auto with_float = [&](int section, std::size_t at, float value, const std::string& what) {
    refused(section, what, [&](std::string* b, std::size_t start) { put_float(b, start + at, value); });
  };
  const auto with_integer = [&](int section, std::size_t at, std::uint64_t value, int size, const std::string& what) {
    refused(section, what, [&](std::string* b, std::size_t start) { put(b, start + at, value, size); });
  };
  // Slices: count, lobe, three parameters, blur, sizes, axes.
  with_integer(2, 0, 0xffffffff, 4, "absurd page count");
  with_float(2, 8, nan, "NaN parameter");
  with_float(2, 8, -0.0f, "negative zero");
  with_float(2, 20, 0.0f, "no blur");
  with_float(2, 20, nan, "NaN blur");
  with_integer(2, 24, 0xffffffff, 4, "absurd axis");
  with_integer(2, 24, 0, 4, "empty axis");
  refused(2, "2^21 nodes", [](std::string* b, std::size_t start) {
    put(b, start + 24, 1 << 11, 4);
    put(b, start + 28, 1 << 10, 4);
  });
  with_float(2, 32, infinity, "infinite coordinate");
  with_float(2, 36, 0.0f, "axis that does not ascend");
  with_integer(2, 52, 0, 4, "pages out of order");
  // Rows: count; node 4, state 8, components 9, zero 10, generation 12, energy 16, objective 20, count 24;
  // uniform part 32, 36, 40; first component 44.
  with_integer(3, 0, 0xffffffff, 4, "absurd row count");
  with_integer(3, 0, 3, 4, "a row more than there are");
  with_integer(3, 4, 6, 4, "node past the page");
  with_integer(3, 4, 4, 4, "nodes that do not ascend");
  with_integer(3, 8, 0, 1, "unborn row");
  with_integer(3, 8, 3, 1, "refused row");
  with_integer(3, 8, 1, 1, "open row with components");
  with_integer(3, 9, 9, 1, "nine components");
  with_integer(3, 10, 1, 2, "padding");
  with_float(3, 16, nan, "NaN energy");
  with_float(3, 20, -0.01f, "negative objective");
  with_float(3, 32, -1.0f, "negative uniform weight");
  with_float(3, 36, infinity, "infinite attribute");
  with_float(3, 40, -1.0f, "negative variance");
  with_float(3, 44, 3.2f, "mode past pi");
  with_float(3, 48, 0.0039f, "scale below .004");
  with_float(3, 52, 0.501f, "scale above .5");
  with_float(3, 52, nan, "NaN scale");
  with_float(3, 56, -0.1f, "negative weight");
  with_float(3, 56, nan, "NaN weight");
  // Sketches: count, then index and bits of each bin.
  with_integer(4, 0, 0xffffffff, 4, "absurd bin count");
  with_integer(4, 4, Sketch::bin_count(0.2f), 4, "bin past the sketch");
  with_integer(4, 4, 90, 4, "bins that do not ascend");
  with_integer(4, 8, ~std::uint64_t{0}, 8, "an empty bin");
  with_float(4, 8, infinity, "infinite g");
  with_float(4, 8, -1.0f, "negative g");
}

TEST(CacheFormat, NamesTheModelInItsHash) {
  EXPECT_EQ(model_hash("elliptical-1"), model_hash("elliptical-1"));
  EXPECT_NE(model_hash("elliptical-1"), model_hash("elliptical-2"));
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
