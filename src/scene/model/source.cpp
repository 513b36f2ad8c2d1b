#include "scene/model/source.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <span>

#include "base/normal_quantile.h"
#include "tress/base/random.h"

namespace tress::scene {
namespace {

glm::vec3 ramp_at(const Source& ramp, const StrandPlace& place) {
  const float x = ramp.along == Source::Along::share     ? place.share
                  : ramp.along == Source::Along::root_cm ? place.root_cm
                                                         : place.tip_cm;
  const auto next = static_cast<std::size_t>(std::ranges::upper_bound(ramp.places, x) - ramp.places.begin());
  if (next == 0) return ramp.parts.front().at(place);
  if (next == ramp.places.size()) return ramp.parts.back().at(place);
  const float before = ramp.places[next - 1], share = (x - before) / (ramp.places[next] - before);
  return glm::mix(ramp.parts[next - 1].at(place), ramp.parts[next].at(place),
                  ramp.is_smooth ? share * share * (3 - 2 * share) : share);
}

}  // namespace

glm::vec3 hsv_adjusted(const glm::vec3& given, float hue, float saturation, float value) {
  const glm::vec3 color = glm::max(given, 0.0f);
  const float most = std::max({color.x, color.y, color.z}), range = most - std::min({color.x, color.y, color.z});
  if (!(range > 0)) return value * color;
  float sixths = most == color.x   ? (color.y - color.z) / range
                 : most == color.y ? 2 + (color.z - color.x) / range
                                   : 4 + (color.x - color.y) / range;
  sixths += 6 * hue;
  const float adjusted = value * most, chroma = adjusted * std::clamp(saturation * range / most, 0.0f, 1.0f);
  glm::vec3 found;
  for (int c = 0; c < 3; ++c) {
    const float turned = sixths + static_cast<float>(5 - 2 * c), k = turned - 6 * std::floor(turned / 6);
    found[c] = adjusted - chroma * std::clamp(std::min(k, 4 - k), 0.0f, 1.0f);
  }
  return found;
}

glm::vec3 Source::at(const StrandPlace& place) const {
  switch (kind) {
    case Kind::constant:
      return value;
    case Kind::attribute:
      return value * place.attribute;
    case Kind::texture:
      return value * texture->at(place.root_uv);
    case Kind::ramp:
      return ramp_at(*this, place);
    case Kind::random: {
      const float u = RandomStream(seed, place.strand).next();
      if (chance) return parts[u < *chance ? 1 : 0].at(place);
      return glm::mix(parts[0].at(place), parts[1].at(place), u);
    }
    case Kind::normal:
      return parts[0].at(place) +
             normal_quantile(RandomStream(seed, place.strand).next() + 0x1p-25f) * parts[1].at(place);
    case Kind::hsv:
      return hsv_adjusted(parts[0].at(place), parts[1].at(place).x, parts[2].at(place).x, parts[3].at(place).x);
    case Kind::mix:
      return glm::mix(parts[0].at(place), parts[1].at(place), std::clamp(parts[2].at(place).x, 0.0f, 1.0f));
    case Kind::sum:
      break;
  }
  glm::vec3 sum(0.0f);
  for (const Source& part : parts) sum += part.at(place);
  return sum;
}

bool Source::varies_along(bool attribute_varies) const {
  return kind == Kind::ramp || (kind == Kind::attribute && attribute_varies) ||
         std::ranges::any_of(parts, [=](const Source& part) { return part.varies_along(attribute_varies); });
}

void Source::add_attributes(std::vector<std::string>* names) const {
  if (kind == Kind::attribute && std::ranges::find(*names, attribute) == names->end()) names->push_back(attribute);
  for (const Source& part : parts) part.add_attributes(names);
}

Source simplified(Source source) {
  const auto is_constant = [](const Source& part) { return part.kind == Source::Kind::constant; };
  if (source.parts.empty() || !std::ranges::all_of(source.parts, is_constant)) return source;
  if (source.kind == Source::Kind::sum || source.kind == Source::Kind::hsv) return {.value = source.at({})};
  if (source.kind == Source::Kind::normal) return source.parts[1].value == glm::vec3(0.0f) ? source.parts[0] : source;
  const auto values = std::span(source.parts).first(source.kind == Source::Kind::mix ? 2 : source.parts.size());
  const bool same = std::ranges::all_of(values, [&](const Source& part) { return part == values.front(); });
  return same ? values.front() : source;
}

}  // namespace tress::scene
