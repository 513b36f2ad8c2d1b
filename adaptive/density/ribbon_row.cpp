// The packed form of a ribbon (ESTIMATOR.md, E9). Every number is a code on a fixed scale, so that packing an unpacked
// ribbon gives the same codes.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "base/pi.h"
#include "density/layer_logs.h"
#include "tress/adaptive/ribbon.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr std::size_t header_bytes = 8, main_bytes = 9, broad_bytes = 6;
static_assert(header_bytes + Ribbon::main_knots * main_bytes + Ribbon::broad_knots * broad_bytes ==
              RibbonRow::part_bytes);

using Code = std::uint32_t;
constexpr Code largest_of(int bits) { return (Code{1} << bits) - 1; }

Code round_to_code(double x, Code largest) {
  return static_cast<Code>(std::lround(std::clamp(x, 0.0, static_cast<double>(largest))));
}

/// Error of the logarithms of LayerLogs, and of the ratio of two attributes, with a margin of 2.
constexpr double log_error = 5e-6, ratio_error = 2e-6;

/// Returns round_to_code(exact()). `near` is within `doubt` of exact(), which is evaluated only where it may round
/// differently.
template <class Exact>
Code round_near(double near, double doubt, Code largest, Exact&& exact) {
  const double at = std::clamp(near, 0.0, static_cast<double>(largest));
  const auto below = static_cast<Code>(at);
  const double rest = at - below;
  if (!(std::abs(rest - 0.5) > doubt)) return round_to_code(exact(), largest);
  return below + (rest > 0.5 ? 1 : 0);
}

/// Codes equal steps of the logarithm from `least` to `largest`.
struct Logarithmic {
  double least, largest;
  int bits;
  /// near: ln(x / least), or 0 if x is less.
  Code encode(float x, float near) const {
    return round_near(static_cast<double>(near) / step(), log_error / step(), largest_of(bits),
                      [&] { return std::log(std::max(static_cast<double>(x), least) / least) / step(); });
  }
  float decode(Code code) const { return static_cast<float>(least * std::exp(code * step())); }
  double step() const { return std::log(largest / least) / largest_of(bits); }
};
constexpr Logarithmic scales{Ribbon::least_scale, Ribbon::largest_scale, 8};

/// Codes the density relative to the largest of its layer.
struct Densities {
  static constexpr double step = 0.05;
  static constexpr Code largest = 255;
  /// near: ln(density / of).
  static Code encode(float density, float of, float near) {
    if (!(density > 0)) return 0;
    const double ratio = static_cast<double>(density) / static_cast<double>(of);
    return round_near(largest + static_cast<double>(near) / step, log_error / step, largest,
                      [&] { return largest + std::log(ratio) / step; });
  }
  static float decode(Code code) {
    return code == 0 ? 0 : static_cast<float>(std::exp((static_cast<double>(code) - largest) * step));
  }
};

/// Codes modes by equal steps of asinh: fine near 0, where narrow lobes are.
struct Modes {
  static constexpr double bend = CodeLimits::bend;
  int bits;
  double half() const { return (largest_of(bits) - 1) / 2; }
  double reach() const { return std::asinh(Ribbon::largest_mode / bend); }
  /// near: asinh(|mode| / bend).
  Code encode(float mode, float near) const {
    const double bent = static_cast<double>(mode) / bend;
    const double at = half() * (1 + std::copysign(static_cast<double>(near), bent) / reach());
    return round_near(at, log_error * half() / reach(), largest_of(bits) - 1,
                      [&] { return half() * (1 + std::asinh(bent) / reach()); });
  }
  float decode(Code code) const {
    const double mode = bend * std::sinh((code / half() - 1) * reach());
    return static_cast<float>(std::clamp(mode, -double{Ribbon::largest_mode}, double{Ribbon::largest_mode}));
  }
};
constexpr Modes main_modes{14}, broad_modes{8};

/// Codes the mean decays at two rates. Each is converted to the attribute that would give it alone, -ln(decay)/rate.
/// The first attribute is coded by steps of its logarithm, with code 0 for none; the second by its share of the first,
/// which is between the ratio of the rates and 1.
struct Decays {
  static constexpr double least = CodeLimits::least_attribute, largest = 100;
  static constexpr double first_rate = Ribbon::decay_rates[0], second_rate = Ribbon::decay_rates[1];
  static constexpr double least_share = first_rate / second_rate;
  static constexpr Code largest_share = 255;
  int bits;

  struct Codes {
    Code attribute, share;
  };
  double step() const { return std::log(largest / least) / (largest_of(bits) - 1); }
  /// near: the attributes of both rates, and the logarithm of the first over `least`.
  Codes encode(const std::array<float, 2>& decays, double near_first, double near_second, double near_log) const {
    const auto first = [&] { return attribute_of(decays[0], first_rate); };
    const auto second = [&] { return attribute_of(decays[1], second_rate); };
    const bool is_doubtful = std::abs(near_first - least / 2) < ratio_error * least;
    if ((is_doubtful ? first() : near_first) < least / 2) return {0, largest_share};
    const auto share = [&](double of_first, double of_second) {
      return (of_second / of_first - least_share) / (1 - least_share) * largest_share;
    };
    return {1 + round_near(near_log / step(), log_error / step(), largest_of(bits) - 1,
                           [&] { return std::log(std::max(first(), least) / least) / step(); }),
            round_near(share(near_first, near_second), ratio_error / (1 - least_share) * largest_share, largest_share,
                       [&] { return share(first(), second()); })};
  }
  /// The attribute that the first decay alone implies, for codes above 0.
  double first(Code attribute) const { return least * std::exp((attribute - 1) * step()); }
  static float first_decay(double first) { return static_cast<float>(std::exp(-first * first_rate)); }
  static float second_decay(double first, Code share) {
    const double second = first * (least_share + (1 - least_share) * share / largest_share);
    return static_cast<float>(std::exp(-second * second_rate));
  }
  static double attribute_of(float decay, double rate) {
    return -std::log(std::clamp(static_cast<double>(decay), double{CodeLimits::least_decay}, 1.0)) / rate;
  }
};
constexpr Decays main_decays{10}, broad_decays{8};

/// The decoded values of all codes.
struct Decoded {
  template <int bits>
  struct OfDecays {
    std::array<double, std::size_t{1} << bits> first{};
    std::array<float, std::size_t{1} << bits> first_decay{};
    explicit OfDecays(const Decays& decays) {
      for (Code code = 1; code < first.size(); ++code) {
        first[code] = decays.first(code);
        first_decay[code] = Decays::first_decay(first[code]);
      }
    }
  };
  std::array<float, 256> scale, density;
  std::array<float, std::size_t{1} << main_modes.bits> main_mode;
  std::array<float, std::size_t{1} << broad_modes.bits> broad_mode;
  OfDecays<main_decays.bits> main_decay{main_decays};
  OfDecays<broad_decays.bits> broad_decay{broad_decays};

  Decoded() {
    const auto fill = [](auto& table, auto&& decode) {
      for (Code code = 0; code < table.size(); ++code) table[code] = decode(code);
    };
    fill(scale, [](Code code) { return scales.decode(code); });
    fill(density, [](Code code) { return Densities::decode(code); });
    fill(main_mode, [](Code code) { return main_modes.decode(code); });
    fill(broad_mode, [](Code code) { return broad_modes.decode(code); });
  }
};
const Decoded& decoded() {
  static const Decoded tables;
  return tables;
}

/// The lowest `bytes` bytes of a number, the lowest first.
void put(std::byte* out, std::uint64_t number, std::size_t bytes) {
  for (std::size_t i = 0; i < bytes; ++i) out[i] = static_cast<std::byte>(number >> 8 * i & 0xff);
}
template <std::size_t bytes>
std::uint64_t get(const std::byte* in) {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < bytes; ++i) number |= static_cast<std::uint64_t>(in[i]) << 8 * i;
  return number;
}

constexpr double azimuth_steps = 65536;
float azimuth_of(Code code) { return static_cast<float>(-pi + code * (2 * pi / azimuth_steps)); }
Code code_of_azimuth(float x) {
  return round_to_code((static_cast<double>(x) + pi) * (azimuth_steps / (2 * pi)), largest_of(16));
}

constexpr Code largest_share = 65535;  // the main layer's share of the whole mass

/// A knot of a part, as codes.
struct PackedKnot {
  Code azimuth = 0, density = 0, mode = 0, scale_below = 0, scale_above = 0;
  Decays::Codes decays{0, 0};
};
struct PackedPart {
  Code law = 0, main_share = 0;
  std::array<PackedKnot, Ribbon::main_knots> main;
  std::array<PackedKnot, Ribbon::broad_knots> broad;
};

template <std::size_t count>
void encode_layer(std::span<const RibbonKnot, count> knots, const Modes& modes, const Decays& decays,
                  std::array<PackedKnot, count>& out) {
  float largest = 0;
  for (const RibbonKnot& knot : knots) largest = std::max(largest, knot.density);
  const LayerLogs::Of<count> logs = LayerLogs::of(knots, largest);
  for (std::size_t k = 0; k < count; ++k) {
    const RibbonKnot& knot = knots[k];
    out[k] = {code_of_azimuth(knot.azimuth),
              Densities::encode(knot.density, largest, logs.density[k]),
              modes.encode(knot.mode, logs.mode[k]),
              scales.encode(knot.scale_below, logs.below[k]),
              scales.encode(knot.scale_above, logs.above[k]),
              decays.encode(knot.decays, static_cast<double>(logs.attribute[k]), static_cast<double>(logs.second[k]),
                            static_cast<double>(logs.logarithm[k]))};
  }
}

template <class OfModes, class OfDecays>
void decode_layer(std::span<const PackedKnot> knots, const OfModes& modes, const OfDecays& decays,
                  std::span<RibbonKnot> out) {
  const Decoded& tables = decoded();
  for (std::size_t k = 0; k < knots.size(); ++k) {
    const PackedKnot& knot = knots[k];
    const Code attribute = knot.decays.attribute;
    out[k] = {azimuth_of(knot.azimuth),       tables.density[knot.density],   modes[knot.mode],
              tables.scale[knot.scale_below], tables.scale[knot.scale_above], {1, 1}};
    if (attribute == 0) continue;
    out[k].decays = {decays.first_decay[attribute], Decays::second_decay(decays.first[attribute], knot.decays.share)};
  }
}

double mass_of(std::span<const RibbonKnot> knots) {
  double mass = 0;
  for (std::size_t k = 0; k < knots.size(); ++k) {
    const bool last = k + 1 == knots.size();
    const RibbonKnot& next = knots[last ? 0 : k + 1];
    const double width =
        static_cast<double>(next.azimuth) - static_cast<double>(knots[k].azimuth) + (last ? 2 * pi : 0.0);
    mass += 0.5 * width * (static_cast<double>(knots[k].density) + static_cast<double>(next.density));
  }
  return mass;
}

/// Sets the codes of a layer without mass: zero density, and fixed values for all else.
void clear_layer(std::span<PackedKnot> knots) {
  for (PackedKnot& knot : knots) knot = {knot.azimuth};
}

// Bits of a knot of the main layer, from the lowest: azimuth 16, density 8, mode 14, scales 8 and 8, attribute 10; and
// the share of the decays in a byte of its own. A knot of the broad layer has a byte for each of its six codes.
void write(const PackedPart& part, std::byte* out) {
  put(out, part.law | std::uint64_t{part.main_share} << 8, header_bytes);
  out += header_bytes;
  for (const PackedKnot& knot : part.main) {
    put(out,
        knot.azimuth | std::uint64_t{knot.density} << 16 | std::uint64_t{knot.mode} << 24 |
            std::uint64_t{knot.scale_below} << 38 | std::uint64_t{knot.scale_above} << 46 |
            std::uint64_t{knot.decays.attribute} << 54,
        8);
    put(out + 8, knot.decays.share, 1);
    out += main_bytes;
  }
  for (const PackedKnot& knot : part.broad) {
    const std::array<Code, broad_bytes> codes{
        knot.density, knot.mode, knot.scale_below, knot.scale_above, knot.decays.attribute, knot.decays.share};
    for (const Code code : codes) put(out++, code, 1);
  }
}

PackedPart read(const std::byte* in) {
  PackedPart part;
  part.law = static_cast<Code>(get<1>(in));
  part.main_share = static_cast<Code>(get<2>(in + 1));
  in += header_bytes;
  for (PackedKnot& knot : part.main) {
    const std::uint64_t all = get<8>(in);
    const auto bits = [&](int from, int count) { return static_cast<Code>(all >> from) & largest_of(count); };
    knot = {bits(0, 16),           bits(16, 8),           bits(24, main_modes.bits),
            bits(38, scales.bits), bits(46, scales.bits), {bits(54, main_decays.bits), static_cast<Code>(in[8])}};
    in += main_bytes;
  }
  for (std::size_t k = 0; k < Ribbon::broad_knots; ++k) {
    const auto code = [&](int i) { return static_cast<Code>(in[i]); };
    part.broad[k] = {
        static_cast<Code>(k * (65536 / Ribbon::broad_knots)), code(0), code(1), code(2), code(3), {code(4), code(5)}};
    in += broad_bytes;
  }
  return part;
}

Ribbon decode(const PackedPart& part) {
  std::array<RibbonKnot, Ribbon::main_knots> main;
  std::array<RibbonKnot, Ribbon::broad_knots> broad;
  decode_layer(part.main, decoded().main_mode, decoded().main_decay, main);
  decode_layer(part.broad, decoded().broad_mode, decoded().broad_decay, broad);
  const double share = static_cast<double>(part.main_share) / largest_share;
  const auto scale_to = [](std::span<RibbonKnot> knots, double mass) {
    const double is = mass_of(knots), factor = is > 0 ? mass / is : 0;
    for (RibbonKnot& knot : knots) knot.density = static_cast<float>(static_cast<double>(knot.density) * factor);
  };
  scale_to(main, share);
  scale_to(broad, 1 - share);
  return Ribbon(main, part.law == 0 ? HeightLaw::normal : HeightLaw::logistic, broad);
}

/// Whether the codes are as packing leaves them: the largest density has the largest code, or a layer without light has
/// no codes.
bool is_layer(std::span<const PackedKnot> knots, bool has_mass) {
  Code largest = 0, any = 0;
  for (const PackedKnot& knot : knots) {
    largest = std::max(largest, knot.density);
    any |= knot.density | knot.mode | knot.scale_below | knot.scale_above | knot.decays.attribute | knot.decays.share;
  }
  return has_mass ? largest == Densities::largest : any == 0;
}

PackedPart encode(const Ribbon& ribbon) {
  PackedPart part;
  part.law = static_cast<Code>(ribbon.main_law());
  encode_layer(ribbon.main().first<Ribbon::main_knots>(), main_modes, main_decays, part.main);
  encode_layer(ribbon.broad().first<Ribbon::broad_knots>(), broad_modes, broad_decays, part.broad);
  part.main_share = round_to_code(static_cast<double>(ribbon.main_mass()) * largest_share, largest_share);
  // Coarse steps of the azimuth may have removed all mass of a layer that has only one knot with light.
  std::array<RibbonKnot, Ribbon::main_knots> main;
  for (std::size_t k = 0; k < main.size(); ++k) {
    main[k].azimuth = azimuth_of(part.main[k].azimuth);
    main[k].density = decoded().density[part.main[k].density];
  }
  if (!(mass_of(main) > 0)) part.main_share = 0;
  const bool no_broad =
      std::all_of(part.broad.begin(), part.broad.end(), [](const PackedKnot& k) { return k.density == 0; });
  if (part.main_share == 0 && no_broad) return encode(Ribbon());
  if (part.main_share == 0) clear_layer(part.main);
  if (part.main_share == largest_share) clear_layer(part.broad);
  return part;
}

/// Whether these bytes are those that packing makes of their decoded values.
bool is_part(const std::byte* bytes) {
  const PackedPart part = read(bytes);
  if (part.law > 1) return false;
  for (std::size_t k = 0; k + 1 < part.main.size(); ++k) {
    if (part.main[k].azimuth > part.main[k + 1].azimuth) return false;
  }
  if (!is_layer(part.main, part.main_share > 0) || !is_layer(part.broad, part.main_share < largest_share)) return false;
  std::array<std::byte, RibbonRow::part_bytes> again{};
  write(encode(decode(part)), again.data());
  return std::equal(again.begin(), again.end(), bytes);
}

}  // namespace

RibbonRow::RibbonRow(std::span<const Part> parts)
    : parts_(static_cast<std::uint32_t>(std::min<std::size_t>(parts.size(), most_parts))) {
  for (std::uint32_t p = 0; p < parts_; ++p) {
    if (!(parts[p].mass > 0)) continue;
    mass_[p] = parts[p].mass;
    write(encode(parts[p].ribbon), bytes_.data() + p * part_bytes);
  }
}

DecodedRow::DecodedRow(const RibbonRow& row) : parts(row.parts()) {
  for (std::uint32_t p = 0; p < parts; ++p) {
    mass[p] = row.mass(p);
    if (mass[p] > 0) ribbon[p] = row.ribbon(p);
  }
}

Ribbon RibbonRow::ribbon(std::uint32_t part) const {
  return mass_[part] > 0 ? decode(read(bytes_.data() + part * part_bytes)) : Ribbon();
}

float RibbonRow::total_mass() const {
  float sum = 0;
  for (const float mass : mass_) sum += mass;
  return sum;
}

bool RibbonRow::unpack(std::span<const std::byte> bytes, std::span<const float> masses) {
  if (masses.empty() || masses.size() > most_parts || bytes.size() != masses.size() * part_bytes) return false;
  float sum = 0;
  for (std::size_t p = 0; p < masses.size(); ++p) {
    if (!(masses[p] >= 0) || std::signbit(masses[p])) return false;
    sum += masses[p];
    const std::span<const std::byte> part = bytes.subspan(p * part_bytes, part_bytes);
    const bool well = masses[p] > 0
                          ? is_part(part.data())
                          : std::all_of(part.begin(), part.end(), [](std::byte b) { return b == std::byte{}; });
    if (!well) return false;
  }
  if (!(sum > 0) || !std::isfinite(sum)) return false;
  *this = RibbonRow();
  parts_ = static_cast<std::uint32_t>(masses.size());
  std::copy(masses.begin(), masses.end(), mass_.begin());
  std::copy(bytes.begin(), bytes.end(), bytes_.begin());
  return true;
}

}  // namespace tress::inline v0_2::adaptive
