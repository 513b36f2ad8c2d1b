#include "scene/read/groom_looks.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "tress/base/random.h"

namespace tress::scene {
namespace {

/// Returns the root of a strand, where shares are evaluated.
StrandPlace root_of(const Groom& groom, std::uint32_t strand, std::uint64_t salt) {
  StrandPlace root;
  root.strand = mix_bits(salt ^ static_cast<std::uint64_t>(groom.strand_id(strand)));
  if (!groom.root_uv.empty()) root.root_uv = groom.root_uv[strand];
  const bool is_per_point = groom.color.size() == groom.points.size();
  if (!groom.color.empty()) root.attribute = groom.color[is_per_point ? groom.first_point[strand] : strand];
  return root;
}

/// Per strand: 0 for the groom's own material, k + 1 for the look k.
std::vector<std::uint32_t> looks_of(const Groom& groom, const std::vector<GroomLook>& looks) {
  std::uint64_t salt = 0x6c6f6f6b73;
  for (const unsigned char c : groom.object) salt = mix_bits(salt ^ (c + 0x9e3779b97f4a7c15ull));
  std::vector<std::uint32_t> chosen(groom.strand_count(), 0);
  for (std::uint32_t strand = 0; strand < chosen.size(); ++strand) {
    const StrandPlace root = root_of(groom, strand, salt);
    const float u = RandomStream(salt, root.strand).next();
    float sum = 0;
    for (std::uint32_t k = 0; k < looks.size() && chosen[strand] == 0; ++k) {
      sum += std::clamp(looks[k].share.at(root).x, 0.0f, 1.0f);
      if (u < sum) chosen[strand] = k + 1;
    }
  }
  return chosen;
}

template <class Item>
void keep(const std::vector<bool>& kept, std::vector<Item>* items) {
  std::size_t next = 0;
  for (std::size_t i = 0; i < items->size(); ++i)
    if (kept[i]) (*items)[next++] = (*items)[i];
  items->resize(next);
  items->shrink_to_fit();
}

void keep_strands(const std::vector<bool>& strands, Groom* groom) {
  std::vector<bool> points;
  points.reserve(groom->points.size());
  std::vector<std::uint32_t> first{0};
  for (std::uint32_t s = 0; s < strands.size(); ++s) {
    const std::uint32_t count = groom->first_point[s + 1] - groom->first_point[s];
    points.insert(points.end(), count, strands[s]);
    if (strands[s]) first.push_back(first.back() + count);
  }
  keep(groom->color.size() == points.size() ? points : strands, &groom->color);
  keep(points, &groom->points);
  keep(points, &groom->radius_cm);
  keep(points, &groom->minor_axis);
  keep(strands, &groom->id);
  keep(strands, &groom->root_uv);
  for (StrandMoment& moment : groom->later) {
    keep(points, &moment.points);
    keep(points, &moment.radius_cm);
  }
  groom->first_point = std::move(first);
}

}  // namespace

std::vector<Groom> divided(Groom groom, const std::vector<GroomLook>& looks) {
  std::vector<Groom> parts;
  if (looks.empty()) {
    parts.push_back(std::move(groom));
    return parts;
  }
  const std::vector<std::uint32_t> chosen = looks_of(groom, looks);
  if (groom.id.empty())
    for (std::uint32_t strand = 0; strand < chosen.size(); ++strand) groom.id.push_back(strand);
  for (std::uint32_t k = 0; k <= looks.size(); ++k) {
    std::vector<bool> strands;
    for (const std::uint32_t look : chosen) strands.push_back(look == k);
    if (std::ranges::count(strands, true) == 0) continue;
    Groom part = groom;
    if (k > 0) part.material = looks[k - 1].material;
    keep_strands(strands, &part);
    parts.push_back(std::move(part));
  }
  return parts;
}

}  // namespace tress::scene
