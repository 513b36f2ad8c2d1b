#include "scene/read/grooms/number_formats.h"

#include <cmath>
#include <cstring>
#include <type_traits>

#include "scene/read/grooms/groom_file.h"

namespace tress::scene {
namespace {

/// A number of 16 bits: IEEE 754 binary16.
struct Half {
  std::uint16_t bits;
};

float to_number(Half half) {
  const int exponent = (half.bits >> 10) & 31, mantissa = half.bits & 1023;
  const float sign = half.bits & 0x8000 ? -1.0f : 1.0f;
  if (exponent == 31) return mantissa ? NAN : sign * INFINITY;
  return sign * (exponent ? std::ldexp(static_cast<float>(mantissa + 1024), exponent - 25)
                          : std::ldexp(static_cast<float>(mantissa), -24));
}

template <class From>
From to_number(From x) {
  return x;
}

template <class To, class From>
To converted(From x) {
  if constexpr (std::is_integral_v<To> && std::is_floating_point_v<From>)
    return std::abs(x) < From(1e15) ? static_cast<To>(x) : To{-1};  // NaN too
  else if constexpr (std::is_same_v<To, float> && std::is_same_v<From, double>)
    return to_float(x);
  else
    return static_cast<To>(x);
}

template <class From, class To>
void convert(std::span<const unsigned char> bytes, To* out) {
  const std::size_t count = bytes.size() / sizeof(From);
  if constexpr (std::is_same_v<From, To>) {
    if (count > 0) std::memcpy(out, bytes.data(), count * sizeof(From));
  } else {
    for (std::size_t i = 0; i < count; ++i) {
      From x;
      std::memcpy(&x, bytes.data() + i * sizeof x, sizeof x);
      out[i] = converted<To>(to_number(x));
    }
  }
}

}  // namespace

std::size_t bytes_of(NumberFormat format) {
  static constexpr std::uint8_t sizes[] = {1, 1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8};
  return sizes[static_cast<std::size_t>(format)];
}

template <class To>
void convert_numbers(std::span<const unsigned char> bytes, NumberFormat format, To* out) {
  using enum NumberFormat;
  switch (format) {
    case boolean:
    case u8:
      return convert<std::uint8_t>(bytes, out);
    case i8:
      return convert<std::int8_t>(bytes, out);
    case u16:
      return convert<std::uint16_t>(bytes, out);
    case i16:
      return convert<std::int16_t>(bytes, out);
    case u32:
      return convert<std::uint32_t>(bytes, out);
    case i32:
      return convert<std::int32_t>(bytes, out);
    case u64:
      return convert<std::uint64_t>(bytes, out);
    case i64:
      return convert<std::int64_t>(bytes, out);
    case f16:
      return convert<Half>(bytes, out);
    case f32:
      return convert<float>(bytes, out);
    case f64:
      return convert<double>(bytes, out);
  }
}

template void convert_numbers(std::span<const unsigned char>, NumberFormat, float*);
template void convert_numbers(std::span<const unsigned char>, NumberFormat, double*);
template void convert_numbers(std::span<const unsigned char>, NumberFormat, std::int64_t*);

}  // namespace tress::scene
