// Values of a material that vary along a strand and from strand to strand.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scene/model/texture.h"

namespace tress::scene {

/// The data of a place on a strand for a source.
struct StrandPlace {
  float share = 0;                ///< share of the length of the strand, from the root, [0, 1]
  float root_cm = 0, tip_cm = 0;  ///< from the root and from the tip, along the strand
  std::uint64_t strand = 0;       ///< a hash of the strand's name
  glm::vec2 root_uv{0.0f};        ///< texture coordinates of the root on the scalp
  glm::vec3 attribute{0.0f};      ///< from the file
};

/// The origin of a value. A plain value is a constant. All others except attributes and textures have parts, which are
/// sources themselves.
struct Source {
  enum class Kind : std::uint8_t {
    constant,
    attribute,  ///< attribute of the file, times `value`
    texture,    ///< texture over the roots, times `value`
    ramp,       ///< parts at rising places, interpolated in between
    random,     ///< per strand: uniform between two parts, or the second with a probability
    normal,     ///< per strand: the first part, and the second times a number of the standard normal distribution
    mix,        ///< two parts, mixed: the third part, a number in [0, 1], is the share of the second
    hsv,        ///< the first part, a color, adjusted by the other three, numbers (hsv_adjusted)
    sum
  };
  enum class Along : std::uint8_t { share, root_cm, tip_cm };

  Kind kind = Kind::constant;
  glm::vec3 value{0.0f};
  std::string attribute = {};  ///< its name in the file; empty: the color, under the format's names for it
  std::string file = {};       ///< file of the texture, as named in the scene
  bool is_encoded = true;      ///< whether whole numbers in its file are sRGB; else they are shares of the largest
  std::shared_ptr<const Texture> texture = {};  ///< read from that file
  std::vector<Source> parts = {};
  std::vector<float> places = {};    ///< places of a ramp's parts
  Along along = Along::share;        ///< the unit of a ramp's places
  bool is_smooth = false;            ///< whether a ramp has no corners at its parts
  std::optional<float> chance = {};  ///< probability of `random`
  std::uint64_t seed = 0;            ///< seed of `random` and `normal`

  /// The value at a place. Any thread.
  glm::vec3 at(const StrandPlace& place) const;
  /// Whether it can differ along a strand. attribute_varies: whether the file's attribute does.
  bool varies_along(bool attribute_varies) const;
  /// Appends the attributes that it uses, each once.
  void add_attributes(std::vector<std::string>* names) const;
  /// Calls visit(texture) for each texture that it uses.
  template <class Visit>
  void for_each_texture(const Visit& visit) const {
    if (texture) visit(*texture);
    for (const Source& part : parts) part.for_each_texture(visit);
  }

  friend bool operator==(const Source&, const Source&) = default;
};

/// Adjusts a linear RGB color, whose channels below 0 count as 0, as MaterialX's hsvadjust does: the hue turns by `hue`
/// turns, red to green for 1/3, and the saturation, which is kept within [0, 1], and the value are multiplied by
/// factors >= 0.
glm::vec3 hsv_adjusted(const glm::vec3& given, float hue, float saturation, float value);

/// Returns a constant if all parts are the same constant, else the source.
Source simplified(Source source);

}  // namespace tress::scene
