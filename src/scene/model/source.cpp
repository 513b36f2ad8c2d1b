#include "scene/model/source.h"

#include <algorithm>
#include <glm/common.hpp>
#include <span>

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
  if (source.kind == Source::Kind::sum) return {.value = source.at({})};
  const auto values = std::span(source.parts).first(source.kind == Source::Kind::mix ? 2 : source.parts.size());
  const bool same = std::ranges::all_of(values, [&](const Source& part) { return part == values.front(); });
  return same ? values.front() : source;
}

}  // namespace tress::scene
