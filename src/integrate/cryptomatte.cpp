#include "integrate/cryptomatte.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

namespace tress::integrate {
namespace {

constexpr std::size_t most_ranks = 6;  ///< the number that the specification suggests
constexpr std::size_t strand_ranks = 12;

std::uint32_t turned(std::uint32_t x, int bits) { return std::rotl(x, bits); }

std::uint32_t scrambled(std::uint32_t block) { return turned(block * 0xcc9e2d51u, 15) * 0x1b873593u; }

std::uint32_t byte_at(std::string_view bytes, std::size_t i) { return static_cast<unsigned char>(bytes[i]); }

struct Rank {
  float id = 0;
  std::uint32_t paths = 0;
  std::uint32_t object = 0;  ///< the first object with this name
};

/// The ranks of a pixel. Objects with the same name share a rank.
template <class IdOf>
std::vector<Rank> ranked(std::span<const ObjectCounts::Count> counts, const IdOf& id_of) {
  std::vector<ObjectCounts::Count> met(counts.begin(), counts.end());
  std::sort(met.begin(), met.end(), [](const auto& a, const auto& b) { return a.object < b.object; });
  std::vector<Rank> ranks;
  for (const ObjectCounts::Count& count : met) {
    if (count.paths == 0) continue;
    const float id = id_of(count.object);
    const auto same = std::find_if(ranks.begin(), ranks.end(), [id](const Rank& rank) { return rank.id == id; });
    if (same == ranks.end())
      ranks.push_back({id, count.paths, count.object});
    else
      same->paths += count.paths;
  }
  std::sort(ranks.begin(), ranks.end(),
            [](const Rank& a, const Rank& b) { return a.paths != b.paths ? a.paths > b.paths : a.object < b.object; });
  return ranks;
}

/// The manifest of a kind. In names that are not UTF-8, the invalid bytes are replaced; the ids come from the original
/// bytes.
std::string manifest_of(const MatteKind& kind) {
  nlohmann::ordered_json manifest = nlohmann::ordered_json::object();
  for (const std::string& name : kind.names) manifest[name] = hex_of_id(matte_id(name));
  return manifest.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

/// Adds the layers of one kind from the counts of a film, and the entries of the header except the manifest. id_of:
/// returns the id of a counted object.
template <class IdOf>
void add_ranks(const Film& film, const ObjectCounts& counts, const MatteKind& kind, std::size_t rank_count,
               const IdOf& id_of, image::Picture* picture) {
  const std::vector<std::size_t> source = film.shown_pixels();
  const std::size_t first = picture->channels.size();
  for (std::size_t c = 0; c < 2 * rank_count; ++c) {
    const std::size_t layer = c / 4;
    picture->channels.push_back(
        {kind.name + "0" + std::to_string(layer) + "." + "RGBA"[c % 4], std::vector<float>(source.size(), 0.0f)});
  }
  for (std::size_t i = 0; i < source.size(); ++i) {
    if (source[i] == Film::no_pixel) continue;
    const std::vector<Rank> ranks = ranked(counts.of(source[i]), id_of);
    const auto samples = static_cast<double>(film.samples_of(source[i]));
    for (std::size_t rank = 0; rank < std::min(ranks.size(), rank_count); ++rank) {
      picture->channels[first + 2 * rank].pixels[i] = ranks[rank].id;
      picture->channels[first + 2 * rank + 1].pixels[i] = static_cast<float>(ranks[rank].paths / samples);
    }
  }
  const std::string prefix = "cryptomatte/" + kind.key() + "/";
  picture->metadata[prefix + "name"] = kind.name;
  picture->metadata[prefix + "hash"] = "MurmurHash3_32";
  picture->metadata[prefix + "conversion"] = "uint32_to_float32";
}

}  // namespace

std::uint32_t murmur_hash(std::string_view bytes) {
  std::uint32_t hash = 0;
  const std::size_t whole = bytes.size() / 4 * 4;
  for (std::size_t i = 0; i < whole; i += 4) {
    const std::uint32_t block =
        byte_at(bytes, i) | byte_at(bytes, i + 1) << 8 | byte_at(bytes, i + 2) << 16 | byte_at(bytes, i + 3) << 24;
    hash = turned(hash ^ scrambled(block), 13) * 5 + 0xe6546b64u;
  }
  std::uint32_t rest = 0;
  for (std::size_t i = bytes.size(); i-- > whole;) rest = rest << 8 | byte_at(bytes, i);
  hash ^= scrambled(rest);
  hash ^= static_cast<std::uint32_t>(bytes.size());
  hash = (hash ^ hash >> 16) * 0x85ebca6bu;
  hash = (hash ^ hash >> 13) * 0xc2b2ae35u;
  return hash ^ hash >> 16;
}

float matte_id(std::string_view name) {
  std::uint32_t bits = murmur_hash(name);
  const std::uint32_t exponent = bits >> 23 & 255;
  if (exponent == 0 || exponent == 255) bits ^= 1u << 23;
  return std::bit_cast<float>(bits);
}

std::string hex_of_id(float id) {
  std::string digits(8, '0');
  std::uint32_t bits = std::bit_cast<std::uint32_t>(id);
  for (auto digit = digits.rbegin(); digit != digits.rend(); ++digit, bits >>= 4)
    *digit = "0123456789abcdef"[bits & 15];
  return digits;
}

std::size_t MatteKind::ranks() const {
  const std::size_t distinct = std::set<std::string>(names.begin(), names.end()).size();
  return std::clamp<std::size_t>((distinct + 1) / 2 * 2, 2, most_ranks);
}

std::vector<MatteKind> matte_kinds(const scene::Scene& scene) {
  MatteKind objects{"CryptoObject", {}}, materials{"CryptoMaterial", {}};
  for (const scene::Groom& groom : scene.grooms) {
    objects.names.push_back(groom.object);
    materials.names.push_back(scene.materials[groom.material].name);
  }
  for (const scene::Mesh& mesh : scene.meshes) {
    objects.names.push_back(mesh.object);
    materials.names.push_back(mesh.object);
  }
  return {std::move(objects), std::move(materials)};
}

void add_mattes(const Film& film, const MatteKind& kind, image::Picture* picture) {
  std::vector<float> id_of_object;
  for (const std::string& name : kind.names) id_of_object.push_back(matte_id(name));
  add_ranks(
      film, film.object_counts(), kind, kind.ranks(), [&](std::uint32_t object) { return id_of_object[object]; },
      picture);
  picture->metadata["cryptomatte/" + kind.key() + "/manifest"] = manifest_of(kind);
}

std::uint32_t strand_matte_bits(const scene::Groom& groom, std::uint32_t instance, std::uint32_t strand) {
  const std::string place = groom.instances.empty() ? "" : fmt::format("{}/", groom.first_instance + instance);
  return std::bit_cast<std::uint32_t>(matte_id(fmt::format("{}/{}{}", groom.object, place, groom.strand_id(strand))));
}

void add_strand_mattes(const Film& film, image::Picture* picture) {
  if (!film.data_layers().has(DataLayer::strand_mattes)) return;
  const MatteKind kind{data_layer_names[static_cast<std::size_t>(DataLayer::strand_mattes)], {}};
  picture->metadata["cryptomatte/" + kind.key() + "/manifest"] = manifest_of(kind);
  add_ranks(
      film, film.strand_counts(), kind, strand_ranks, [](std::uint32_t bits) { return std::bit_cast<float>(bits); },
      picture);
}

}  // namespace tress::integrate
