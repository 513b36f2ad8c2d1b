#include "base/word_packing.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "support/seed.h"
#include "tress/base/random.h"

namespace tress {
namespace {

template <class T>
std::string bytes_of(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

std::string packed(const std::string& bytes) {
  std::string out = "what was there";
  pack_words(bytes, &out);
  return out;
}

void expect_back(const std::string& bytes) {
  const std::string small = packed(bytes);
  EXPECT_LE(small.size(), most_packed_bytes(bytes.size()));
  std::string back;
  ASSERT_TRUE(unpack_words(small, bytes.size(), &back));
  EXPECT_TRUE(back == bytes);
}

TEST(WordPacking, GivesBackEveryBit) {
  RandomStream random(test::seed(2026), 1);
  for (std::size_t size = 0; size < 1200; size += 1 + size / 100) {
    std::string bytes(size, '\0');
    for (char& byte : bytes) byte = random.next_bits() % 3 == 0 ? '\0' : static_cast<char>(random.next_bits());
    expect_back(bytes);
  }
  std::vector<std::uint64_t> edges{0, 1, ~std::uint64_t{0}};
  for (int bit = 0; bit < 64; ++bit) {
    edges.push_back(std::uint64_t{1} << bit);
    edges.push_back(~std::uint64_t{0} << bit);
    edges.push_back(~std::uint64_t{0} >> bit);
  }
  expect_back(bytes_of(edges));
  expect_back(bytes_of<double>({0.0, -0.0, 0.1, -1e-310, 1e308, std::numeric_limits<double>::infinity()}));
}

TEST(WordPacking, SumsOfFloatsAndSmallCountsAreSmaller) {
  RandomStream random(test::seed(2026), 2);
  std::vector<double> sums(4096);
  for (double& sum : sums)
    for (int i = 0; i < 16; ++i) sum += static_cast<double>(static_cast<float>(random.next_bits() % 1000003) / 7.0f);
  EXPECT_LT(packed(bytes_of(sums)).size(), sums.size() * 6 + sums.size());
  EXPECT_LT(packed(bytes_of(std::vector<std::uint64_t>(4096, 200))).size(), 4096u * 2);
  EXPECT_EQ(packed(std::string(8 * 4096, '\0')).size(), 4096u / 8);
}

/// Whatever is in a damaged file, nothing is read or written past its end, and no more memory taken than is promised.
TEST(WordPacking, RefusesWhatIsCutOrTooMuch) {
  const std::string bytes = bytes_of<double>({1, 0, 0.1, 3e-5, 0, 7}) + "rest", small = packed(bytes);
  std::string back;
  for (std::size_t size = 0; size < small.size(); ++size)
    EXPECT_FALSE(unpack_words(small.substr(0, size), bytes.size(), &back)) << size;
  EXPECT_FALSE(unpack_words(small + "x", bytes.size(), &back));
  EXPECT_FALSE(unpack_words(small, std::size_t{1} << 60, &back));
  EXPECT_FALSE(unpack_words(std::string(8, '\xff') + std::string(1000, '\x08'), 512, &back)) << "an invalid code";
  EXPECT_FALSE(unpack_words(std::string(8, '\xff') + std::string(1000, '\x00'), 16, &back)) << "words past the end";
}

TEST(WordPacking, TakesAnyBytes) {
  RandomStream random(test::seed(2026), 3);
  std::string back;
  for (int round = 0; round < 2000; ++round) {
    std::string bytes(random.next_bits() % 200, '\0');
    for (char& byte : bytes) byte = random.next_bits() % 2 == 0 ? '\0' : static_cast<char>(random.next_bits());
    (void)unpack_words(bytes, random.next_bits() % 1000, &back);
  }
}

}  // namespace
}  // namespace tress
