// A layer of USD as a tree of prims, the same from a text and from a binary file. Values stay in the file, and those
// that the picture needs are read from there.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scene/read/grooms/groom_file.h"
#include "scene/read/grooms/usd_values.h"
#include "tress/base/error.h"

namespace tress::scene {

constexpr int deepest_prim = 200;
/// The beginning of the names of prims that hold layers of an archive, which are not part of its stage.
constexpr char usdz_graft = '@';
constexpr const char* flat_stage = "a flat stage (usdcat --flatten IN -o OUT.usda writes one)";

class UsdLayer;
struct UsdzFile;

/// The places of an attribute's values in the file, which its layer can read.
struct UsdAttribute {
  UsdLayer* layer = nullptr;
  std::optional<std::uint64_t> value = {}, samples = {};
  std::optional<AttributeScope> scope = {};
  bool is_triple = false;  ///< whether its type has three numbers
};

struct UsdPrim {
  std::string name, type;
  bool is_defined = true;
  std::optional<bool> is_active = {};  ///< unset: weaker opinions say it
  /// Paths of prims with weaker opinions. Of another layer, where those are followed: "@file@/path", or "@file@" for
  /// its default prim.
  std::vector<std::string> arcs = {};
  std::vector<std::string> prototypes = {};  ///< paths of an instancer's
  std::map<std::string, UsdAttribute, std::less<>> attributes = {};
  std::vector<UsdPrim> children = {};

  const UsdPrim* child(std::string_view named) const;
};

/// The stage metadata of a layer, with the defaults of USD: a unit of 0.01 m, and y up.
struct UsdStage {
  double cm_per_unit = 1, time_codes_per_second = 24;
  bool y_up = true;

  static bool has(std::string_view key);
  struct Fault {
    std::string expected, found;
  };
  /// Stores the value of a key for which has() is true, with its numbers as doubles.
  std::optional<Fault> take(std::string_view key, const UsdValue& value);
};

/// A time sample: its time code, and the place of its value in the file.
struct UsdSample {
  double time = 0;
  std::uint64_t at = 0;
};

/// Reads a layer. It keeps the first failure; afterwards everything is empty.
class UsdLayer {
 public:
  virtual ~UsdLayer() = default;
  /// Reads the tree, whose root is the prim without a name.
  virtual UsdPrim read() = 0;
  virtual std::vector<UsdSample> samples(std::uint64_t at) = 0;
  virtual UsdValue value(std::uint64_t at, UsdNumbers kept_as) = 0;
  virtual const std::optional<Error>& error() const = 0;

  /// The value of an attribute: samples win over the default. Samples give the first one, or the value at a frame.
  /// is_held: must not be interpolated, such as counts and ids.
  UsdValue value_of(const UsdAttribute& attribute, UsdNumbers kept_as, std::optional<double> frame, bool is_held);

  UsdStage stage = {};
  std::uint64_t prims = 0;  ///< number in the tree
  bool follows = false;     ///< whether other layers are read: set before read(); else one that is needed is an error
  std::vector<std::string> sub_layers = {};  ///< files with weaker opinions, the strongest first
  std::string default_prim = {};
  std::vector<IgnoredAttribute> ignored = {};
};

/// The readers of the two forms of a layer. The bytes of the input must outlive them.
std::unique_ptr<UsdLayer> usda_layer(const GroomInput& input);
std::unique_ptr<UsdLayer> usdc_layer(const GroomInput& input);
/// The layers of an archive as one: the root layer and those that it needs.
std::unique_ptr<UsdLayer> usdz_layer(const GroomInput& input, UsdzFile file);

/// The scope of an interpolation in USD; unset for an unknown name.
std::optional<AttributeScope> usd_scope(std::string_view interpolation);
/// Whether the key of a prim refers to other prims.
bool is_usd_arc(std::string_view key);
/// Whether the key of a prim says that other files have its time samples.
bool is_usd_clip(std::string_view key);
/// Whether colors of this space are what they are taken for: linear Rec. 709.
bool is_taken_space(std::string_view color_space);

constexpr const char* why_no_splines = "animation by splines is not read";
constexpr const char* why_one_space = "colors are taken for linear Rec. 709";
constexpr const char* why_no_clips = "time samples of other files are not read";
constexpr const char* why_no_offset = "times of what it refers to are taken as they are there";

/// Whether the bytes have the mark of a USD text, or of a crate.
bool is_usda(std::span<const unsigned char> bytes);
bool is_usdc(std::span<const unsigned char> bytes);

}  // namespace tress::scene
