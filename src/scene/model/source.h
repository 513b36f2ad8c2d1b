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

/// A place on a strand, as a source asks for it.
struct StrandPlace {
  float share = 0;                ///< of the length of the strand, from the root, [0, 1]
  float root_cm = 0, tip_cm = 0;  ///< from the root and from the tip, along the strand
  std::uint64_t strand = 0;       ///< a hash of what the strand is called
  glm::vec2 root_uv{0.0f};        ///< of the root, on the scalp
  glm::vec3 attribute{0.0f};      ///< of the file
};

/// Where a value comes from. A plain value is a constant. All others but attributes and textures are made of parts,
/// which are sources themselves.
struct Source {
  enum class Kind : std::uint8_t {
    constant,
    attribute,  ///< of the file, times `value`
    texture,    ///< over the roots, times `value`
    ramp,       ///< parts at rising places, and what is between two of them by how near they are
    random,     ///< of the strand: uniform between two parts, or the second with a probability
    mix,        ///< the third part, a number in [0, 1], is the share of the second in place of the first
    sum
  };
  enum class Along : std::uint8_t { share, root_cm, tip_cm };

  Kind kind = Kind::constant;
  glm::vec3 value{0.0f};
  std::string attribute = {};  ///< its name in the file; empty: the color, by the names that the format knows
  std::string file = {};       ///< of the texture, as the scene names it
  bool is_encoded = true;      ///< whole numbers of its file are sRGB's; else they are shares of the largest
  std::shared_ptr<const Texture> texture = {};  ///< that is read from there
  std::vector<Source> parts = {};
  std::vector<float> places = {};    ///< of a ramp, one a part
  Along along = Along::share;        ///< what places of a ramp are
  bool is_smooth = false;            ///< a ramp has no corners at its parts
  std::optional<float> chance = {};  ///< of random
  std::uint64_t seed = 0;            ///< of random

  /// Any thread.
  glm::vec3 at(const StrandPlace& place) const;
  /// Whether it can differ along a strand. attribute_varies: whether that of the file does.
  bool varies_along(bool attribute_varies) const;
  /// Appends the attributes that it is made of, each once.
  void add_attributes(std::vector<std::string>* names) const;
  bool has_texture() const;

  friend bool operator==(const Source&, const Source&) = default;
};

/// A constant where all parts are the same one, else the source.
Source simplified(Source source);

}  // namespace tress::scene
