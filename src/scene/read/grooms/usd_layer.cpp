#include "scene/read/grooms/usd_layer.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <type_traits>
#include <utility>

namespace tress::scene {
namespace {

/// Adds to numbers a share of the way to those after them; false if their counts differ.
bool meet(UsdValue after, float share, bool are_quaternions, UsdValue* value) {
  const auto add = [&](auto& numbers, const auto& later) {
    using Number = std::remove_cvref_t<decltype(numbers[0])>;
    constexpr bool is_double = std::is_same_v<Number, double>;
    for (std::size_t i = 0; i < numbers.size(); ++i)
      numbers[i] += static_cast<std::conditional_t<is_double, double, float>>(share) * (later[i] - numbers[i]);
  };
  if (value->numbers.size() != after.numbers.size() || value->precise.size() != after.precise.size() ||
      value->triples.size() != after.triples.size())
    return false;
  for (std::size_t q = 0; are_quaternions && q + 3 < after.precise.size(); q += 4) {  // both signs are one rotation
    double cosine = 0;
    for (std::size_t i = q; i < q + 4; ++i) cosine += after.precise[i] * value->precise[i];
    for (std::size_t i = q; i < q + 4 && cosine < 0; ++i) after.precise[i] = -after.precise[i];
  }
  add(value->numbers, after.numbers);
  add(value->precise, after.precise);
  add(value->triples, after.triples);
  return true;
}

}  // namespace

const UsdPrim* UsdPrim::child(std::string_view named) const {
  const auto found = std::ranges::find(children, named, &UsdPrim::name);
  return found == children.end() ? nullptr : &*found;
}

bool UsdStage::has(std::string_view key) {
  return key == "metersPerUnit" || key == "timeCodesPerSecond" || key == "upAxis";
}

std::optional<UsdStage::Fault> UsdStage::take(std::string_view key, const UsdValue& value) {
  const std::string text = value.texts.empty() ? "" : value.texts[0].substr(0, 32);
  const double number = value.precise.size() == 1 ? value.precise[0] : 0;
  const bool is_positive = number > 0 && number < 1e9;
  if (key == "upAxis") {
    if (text != "Y" && text != "Z") return Fault{"upAxis \"Y\" or \"Z\"", "\"" + printable(text) + "\""};
    y_up = text == "Y";
  } else if (key == "metersPerUnit") {
    if (!is_positive) return Fault{"metersPerUnit > 0", fmt::format("{:g}", number)};
    cm_per_unit = 100 * number;
  } else if (is_positive) {
    time_codes_per_second = number;
  }
  return std::nullopt;
}

UsdValue UsdLayer::value_of(const UsdAttribute& attribute, UsdNumbers kept_as, std::optional<double> frame,
                            bool is_held) {
  if (attribute.layer != nullptr && attribute.layer != this)
    return attribute.layer->value_of(attribute, kept_as, frame, is_held);
  const bool are_quaternions = kept_as == UsdNumbers::quaternions;
  if (are_quaternions) kept_as = UsdNumbers::doubles;
  UsdValue value;
  if (error() || (!attribute.samples && !attribute.value)) return value;
  if (!attribute.samples) {
    value = this->value(*attribute.value, kept_as);
  } else {
    const std::vector<UsdSample> all = samples(*attribute.samples);
    const UsdSample *from = nullptr, *to = nullptr;  // around the frame: the last that is not later, the first that is
    for (const UsdSample& sample : all) {
      const bool is_later = frame ? sample.time > *frame : from != nullptr;
      if (!is_later && (!from || sample.time >= from->time)) from = &sample;
      if (is_later && frame && (!to || sample.time < to->time)) to = &sample;
    }
    if (const UsdSample* only = from ? from : to) value = this->value(only->at, kept_as);
    const bool is_on_sample = from && frame && *frame == from->time;
    const bool is_met = is_on_sample || (from && to && !is_held &&
                                         meet(this->value(to->at, kept_as),
                                              static_cast<float>((*frame - from->time) / (to->time - from->time)),
                                              are_quaternions, &value));
    if (from && frame && !is_met) value.held_since = from->time;
    value.is_animated = all.size() > 1;
  }
  value.scope = attribute.scope;
  return value;
}

std::optional<AttributeScope> usd_scope(std::string_view interpolation) {
  if (interpolation == "constant") return AttributeScope::constant;
  if (interpolation == "uniform") return AttributeScope::uniform;
  if (interpolation == "varying") return AttributeScope::varying;
  if (interpolation == "vertex") return AttributeScope::vertex;
  return std::nullopt;
}

bool is_usd_arc(std::string_view key) {
  static constexpr std::string_view keys[] = {"references", "payload", "inherits", "inheritPaths", "specializes"};
  return std::ranges::find(keys, key) != std::end(keys);
}

bool is_taken_space(std::string_view color_space) {
  static constexpr std::string_view spaces[] = {"", "lin_rec709_scene", "lin_rec709", "lin_srgb", "raw", "data"};
  return std::ranges::find(spaces, color_space) != std::end(spaces);
}

bool is_usd_clip(std::string_view key) { return key == "clips" || key == "clipAssetPaths"; }

}  // namespace tress::scene
