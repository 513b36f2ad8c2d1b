// Reads a cache from bytes that may hold anything. Nothing is believed before it is checked: each section against its
// checksum, each count against the bytes that remain, each value against its range.
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "cache/format.h"
#include "observations/sketch.h"

namespace tress::adaptive {
namespace {

using format::Section;

const char* section_name(Section section) {
  switch (section) {
    case Section::model:
      return "section model";
    case Section::slices:
      return "section pages";
    case Section::rows:
      return "section rows";
    case Section::sketches:
      return "section sketches";
  }
  return "section";
}

/// One decoding. The first fault ends it; every method returns false from then on.
class Decoder {
 public:
  Decoder(const std::string& bytes, std::string file) : bytes_(bytes), file_(std::move(file)) {}

  bool decode(const std::string& wanted_model) {
    ByteReader reader(bytes_);
    std::uint64_t hash = 0;
    return header(reader, &hash) && section(reader, Section::model, [&](ByteReader& in) { return model(in); }) &&
           same_model(wanted_model, hash) &&
           section(reader, Section::slices, [&](ByteReader& in) { return slices(in); }) &&
           section(reader, Section::rows, [&](ByteReader& in) { return rows(in); }) &&
           section(reader, Section::sketches, [&](ByteReader& in) { return sketches(in); }) &&
           (reader.remaining() == 0 ||
            fail(byte(reader.position()), "the end of the file", std::to_string(reader.remaining()) + " more bytes"));
  }

  TableSnapshot image;
  Error error;

 private:
  static std::string byte(std::size_t position) { return "byte " + std::to_string(position); }
  std::string here(const ByteReader& in, std::size_t back = 0) const { return where_ + byte(in.position() - back); }

  bool fail(std::string place, std::string expected, std::string found) {
    error = {file_, std::move(place), std::move(expected), std::move(found)};
    return false;
  }

  static bool is_known(std::uint32_t version) {
    return version == format::version_of_mixtures || version == format::version_of_knots;
  }

  bool header(ByteReader& in, std::uint64_t* hash) {
    if (bytes_.size() < format::header_bytes) {
      return fail(byte(bytes_.size()), "a header of " + std::to_string(format::header_bytes) + " bytes",
                  "the end of the file");
    }
    if (in.text(format::magic.size()) != format::magic) return fail(byte(0), "the magic of a tress cache", "another");
    version_ = in.u32();
    if (!is_known(version_)) {
      const std::uint32_t turned =
          version_ >> 24 | (version_ >> 8 & 0xff00u) | (version_ << 8 & 0xff0000u) | version_ << 24;
      return fail(byte(8),
                  "format version " + std::to_string(format::version_of_mixtures) + " or " +
                      std::to_string(format::version_of_knots),
                  is_known(turned) ? "version " + std::to_string(turned) + " with its highest byte first"
                                   : (version_ > format::version_of_knots ? "later version " : "version ") +
                                         std::to_string(version_));
    }
    const std::uint32_t sections = in.u32();
    if (sections != format::section_count) {
      return fail(byte(12), std::to_string(format::section_count) + " sections", std::to_string(sections));
    }
    *hash = in.u64();
    return true;
  }

  bool same_model(const std::string& wanted, std::uint64_t hash) {
    const auto told = [](const std::string& name, std::uint64_t number) {
      return "model " + name + " (hash " + format::hexadecimal(number) + ")";
    };
    const std::string& expected = wanted.empty() ? image.model : wanted;
    if (hash == model_hash(expected) && image.model == expected) return true;
    return fail(byte(16), told(expected, model_hash(expected)), told(image.model, hash));
  }

  /// Frame of a section: its name, its length within the file, its checksum; then `read` must use it up.
  template <class Read>
  bool section(ByteReader& in, Section id, Read read) {
    where_ = std::string(section_name(id)) + ", ";
    if (in.remaining() < format::section_header_bytes) {
      return fail(here(in), "a section header of " + std::to_string(format::section_header_bytes) + " bytes",
                  std::to_string(in.remaining()) + " bytes");
    }
    const std::uint32_t found = in.u32();
    if (found != static_cast<std::uint32_t>(id)) {
      return fail(here(in, 4), "section " + std::to_string(static_cast<std::uint32_t>(id)), std::to_string(found));
    }
    if (const std::uint32_t zero = in.u32(); zero != 0) return fail(here(in, 4), "0", std::to_string(zero));
    const std::uint64_t length = in.u64();
    const std::uint64_t sum = in.u64();
    if (length > in.remaining()) {
      return fail(here(in, 16), "at most the " + std::to_string(in.remaining()) + " bytes that remain",
                  "a length of " + std::to_string(length));
    }
    const std::size_t start = in.position();
    const std::string_view payload = in.text(static_cast<std::size_t>(length));
    if (const std::uint64_t actual = format::checksum(payload); actual != sum) {
      return fail(where_ + byte(start), "checksum " + format::hexadecimal(sum), format::hexadecimal(actual));
    }
    ByteReader inside(payload, start);
    if (!read(inside)) return false;
    if (inside.short_of_bytes()) return fail(here(inside), "more bytes", "the end of the section");
    if (inside.remaining() != 0) {
      return fail(here(inside), "the end of the section", std::to_string(inside.remaining()) + " more bytes");
    }
    return true;
  }

  /// A count of things of at least `size` bytes each, bounded by the bytes that remain.
  bool count(ByteReader& in, std::size_t size, const char* what, std::uint32_t* number) {
    *number = in.u32();
    if (in.short_of_bytes()) return fail(here(in), std::string("the number of ") + what, "the end of the section");
    if (*number > in.remaining() / size) {
      return fail(
          here(in, 4),
          std::string("at most ") + std::to_string(in.remaining() / size) + " " + what + " in the bytes that remain",
          std::to_string(*number));
    }
    return true;
  }

  /// A float in [least, largest]; a negative zero is refused, since the encoder writes none.
  bool number(ByteReader& in, const char* what, float least, float largest, float* value) {
    *value = in.f32();
    if (in.short_of_bytes()) return fail(here(in), what, "the end of the section");
    if (*value >= least && *value <= largest && !(*value == 0 && std::signbit(*value))) return true;
    return fail(here(in, 4), std::string(what) + " in [" + std::to_string(least) + ", " + std::to_string(largest) + "]",
                std::to_string(*value));
  }
  bool finite(ByteReader& in, const char* what, float* value) { return number(in, what, -huge, huge, value); }
  bool not_negative(ByteReader& in, const char* what, float* value) { return number(in, what, 0, huge, value); }

  bool model(ByteReader& in) {
    std::uint32_t size = 0;
    if (!count(in, 1, "characters", &size)) return false;
    if (size == 0 || size > format::longest_model_name) {
      return fail(here(in, 4), "a name of 1 to " + std::to_string(format::longest_model_name) + " characters",
                  std::to_string(size));
    }
    image.model = in.text(size);
    for (const char c : image.model) {
      if (c < ' ' || c > '~') return fail(here(in, size), "a name in printable ASCII", "another character");
    }
    return true;
  }

  bool axis(ByteReader& in, const char* what, std::uint32_t size, std::vector<float>* coordinates) {
    coordinates->reserve(size);
    for (std::uint32_t i = 0; i < size; ++i) {
      float coordinate = 0;
      if (!finite(in, what, &coordinate)) return false;
      if (i > 0 && coordinate <= coordinates->back()) {
        return fail(here(in, 4), std::string(what) + " above " + std::to_string(coordinates->back()),
                    std::to_string(coordinate));
      }
      coordinates->push_back(coordinate);
    }
    return true;
  }

  bool slice(ByteReader& in, SliceDescription* slice) {
    slice->key.lobe = in.u32();
    for (float& parameter : slice->key.parameters) {
      if (!finite(in, "a finite parameter", &parameter)) return false;
    }
    if (!number(in, "blur", format::least_blur_rad, format::largest_blur_rad, &slice->blur_rad)) return false;
    const std::uint64_t a = in.u32();
    const std::uint64_t b = in.u32();
    if (in.short_of_bytes()) return fail(here(in), "the sizes of the axes", "the end of the section");
    if (a == 0 || b == 0 || a * b > format::most_nodes_of_slice) {
      return fail(here(in, 8), "1 to " + std::to_string(format::most_nodes_of_slice) + " nodes",
                  std::to_string(a) + " x " + std::to_string(b));
    }
    if (a + b > in.remaining() / 4) {
      return fail(here(in, 8), "at most " + std::to_string(in.remaining() / 4) + " coordinates", std::to_string(a + b));
    }
    return axis(in, "coordinate a", static_cast<std::uint32_t>(a), &slice->axis_a) &&
           axis(in, "coordinate b", static_cast<std::uint32_t>(b), &slice->axis_b);
  }

  bool slices(ByteReader& in) {
    std::uint32_t number = 0;
    if (!count(in, format::slice_bytes, "pages", &number)) return false;
    image.slices.resize(number);
    for (std::uint32_t i = 0; i < number; ++i) {
      const std::string start = here(in);
      if (!slice(in, &image.slices[i].description)) return false;
      if (i > 0 && !(image.slices[i - 1].description.key < image.slices[i].description.key)) {
        return fail(start, "pages in ascending order of their keys", "a key not above the one before");
      }
    }
    return true;
  }

  bool rows(ByteReader& in) {
    for (CachedSlice& slice : image.slices) {
      std::uint32_t number = 0;
      if (!count(in, format::row_bytes, "rows", &number)) return false;
      const std::uint32_t nodes = slice.description.node_count();
      if (number > nodes) {
        return fail(here(in, 4), "at most " + std::to_string(nodes) + " rows", std::to_string(number));
      }
      slice.rows.resize(number);
      for (std::uint32_t i = 0; i < number; ++i) {
        const std::uint32_t least = i == 0 ? 0 : slice.rows[i - 1].node + 1;
        if (!row(in, least, nodes, &slice.rows[i])) return false;
      }
    }
    const std::uint32_t needed = has_knots_ ? format::version_of_knots : format::version_of_mixtures;
    if (version_ == needed) return true;
    return fail(byte(8),
                "format version " + std::to_string(needed) + (has_knots_ ? " with" : " without") + " knot rows",
                std::to_string(version_));
  }

  bool row(ByteReader& in, std::uint32_t least_node, std::uint32_t nodes, CachedRow* row) {
    if (in.remaining() < format::row_bytes) return fail(here(in), "a row", "the end of the section");
    row->node = in.u32();
    if (row->node < least_node || row->node >= nodes) {
      return fail(here(in, 4), "a node in [" + std::to_string(least_node) + ", " + std::to_string(nodes) + ")",
                  std::to_string(row->node));
    }
    const std::uint32_t state = in.u8();
    if (state != static_cast<std::uint32_t>(RowState::open) &&
        state != static_cast<std::uint32_t>(RowState::converged)) {
      return fail(here(in, 1), "state 1 (open) or 2 (converged)", std::to_string(state));
    }
    row->state = static_cast<RowState>(state);
    const bool converged = row->state == RowState::converged;
    const std::uint32_t parts = in.u8();
    const std::uint32_t kind = in.u8();
    const bool knots = kind == static_cast<std::uint32_t>(format::Kind::knots);
    if (kind > (converged ? static_cast<std::uint32_t>(format::Kind::knots) : 0)) {
      return fail(here(in, 1), converged ? "kind 0 (mixture) or 1 (knots)" : "kind 0 of an open row",
                  std::to_string(kind));
    }
    const std::uint32_t most = converged ? Mixture::max_components : 0;
    if (knots && !KnotDensity::is_size(parts)) return fail(here(in, 2), "32, 64 or 128 knots", std::to_string(parts));
    if (!knots && parts > most) {
      return fail(here(in, 2), "at most " + std::to_string(most) + " components", std::to_string(parts));
    }
    if (const std::uint32_t zero = in.u8(); zero != 0) return fail(here(in, 1), "0", std::to_string(zero));
    row->generation = in.u32();
    if (!not_negative(in, "energy", &row->energy) ||
        !number(in, "objective", 0, converged ? huge : 0, &row->objective)) {
      return false;
    }
    row->count = in.u64();
    if (knots) return knot_density(in, parts, row);
    row->fit.component_count = parts;
    return !converged || mixture(in, &row->fit);
  }

  bool knot_density(ByteReader& in, std::uint32_t number_of_knots, CachedRow* row) {
    has_knots_ = true;
    const std::string start = here(in);
    if (number_of_knots > in.remaining() / format::knot_bytes) {
      return fail(start, "at most " + std::to_string(in.remaining() / format::knot_bytes) + " knots",
                  std::to_string(number_of_knots));
    }
    std::vector<Knot> knots(number_of_knots);
    double mass = 0;
    for (Knot& knot : knots) {
      if (!not_negative(in, "density", &knot.density) || !not_negative(in, "attribute", &knot.attribute_mean) ||
          !not_negative(in, "variance of the attribute", &knot.attribute_variance)) {
        return false;
      }
      mass += static_cast<double>(knot.density) * 2 * std::numbers::pi / number_of_knots;
    }
    if (!(std::abs(mass - row->energy) <= format::energy_slack * static_cast<double>(row->energy))) {
      return fail(start, "knots of mass " + std::to_string(row->energy), std::to_string(mass));
    }
    row->knots = KnotDensity(std::move(knots));
    return true;
  }

  bool mixture(ByteReader& in, Mixture* fit) {
    if (!not_negative(in, "weight of the uniform part", &fit->uniform_weight) ||
        !not_negative(in, "attribute", &fit->uniform_attribute_mean) ||
        !not_negative(in, "variance of the attribute", &fit->uniform_attribute_variance)) {
      return false;
    }
    for (std::uint32_t i = 0; i < fit->component_count; ++i) {
      Component& part = fit->components[i];
      if (!number(in, "mode", -pi, pi, &part.shape.mu) ||
          !number(in, "scale", format::least_scale, format::largest_scale, &part.shape.s_left) ||
          !number(in, "scale", format::least_scale, format::largest_scale, &part.shape.s_right) ||
          !not_negative(in, "weight", &part.weight) || !not_negative(in, "attribute", &part.attribute_mean) ||
          !not_negative(in, "variance of the attribute", &part.attribute_variance)) {
        return false;
      }
    }
    return true;
  }

  bool sketches(ByteReader& in) {
    for (CachedSlice& slice : image.slices) {
      const std::uint32_t bins = Sketch::bin_count(slice.description.blur_rad);
      for (CachedRow& row : slice.rows) {
        if (row.state == RowState::open && !sketch(in, bins, &row.sketch)) return false;
      }
    }
    return true;
  }

  bool sketch(ByteReader& in, std::uint32_t bins, std::vector<SketchBin>* sketch) {
    std::uint32_t number = 0;
    if (!count(in, format::bin_bytes, "bins", &number)) return false;
    sketch->reserve(number);
    for (std::uint32_t i = 0; i < number; ++i) {
      const std::uint32_t least = i == 0 ? 0 : sketch->back().index + 1;
      const std::uint32_t index = in.u32();
      if (index < least || index >= bins) {
        return fail(here(in, 4), "a bin in [" + std::to_string(least) + ", " + std::to_string(bins) + ")",
                    std::to_string(index));
      }
      const std::uint64_t bits = in.u64();
      const float g = std::bit_cast<float>(static_cast<std::uint32_t>(bits));
      if (!std::isfinite(g) || std::signbit(g)) return fail(here(in, 8), "g finite and >= 0", std::to_string(g));
      sketch->push_back({index, bits});
    }
    return true;
  }

  static constexpr float huge = 3.402823466e+38f;
  static constexpr float pi = std::numbers::pi_v<float>;
  const std::string& bytes_;
  std::string file_;
  std::string where_;
  std::uint32_t version_ = 0;
  bool has_knots_ = false;
};

}  // namespace

Result<TableSnapshot> decode_cache(const std::string& bytes, const std::string& model, const std::string& name) {
  Decoder decoder(bytes, name);
  if (!decoder.decode(model)) return decoder.error;
  return std::move(decoder.image);
}

}  // namespace tress::adaptive
