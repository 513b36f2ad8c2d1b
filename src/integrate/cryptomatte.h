// Mattes of objects and materials by the Cryptomatte specification (Friedman and Jones 2015; version 1.2,
// github.com/Psyop/Cryptomatte): layers of ids and coverages by rank, and their entries in the header.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "image/picture.h"
#include "integrate/film.h"
#include "scene/model/scene.h"

namespace tress::integrate {

/// MurmurHash3_x86_32 of the bytes, seed 0 (Appleby, public domain).
std::uint32_t murmur_hash(std::string_view bytes);

/// The id of a name: the bits of its hash as a float, with the lowest bit of the exponent flipped where the exponent is
/// all zeros or all ones. An id is never 0, subnormal, infinite or NaN.
float matte_id(std::string_view name);
/// The bits of an id as 8 hexadecimal digits, as in a manifest.
std::string hex_of_id(float id);

/// One set of names: the layers NAME00, NAME01, ... and the entries cryptomatte/KEY/... of the header.
struct MatteKind {
  std::string name;                ///< "CryptoObject"
  std::vector<std::string> names;  ///< name of each object: grooms, then meshes. Equal names are one matte.

  std::string key() const { return hex_of_id(matte_id(name)).substr(0, 7); }
  /// Number of ranks that are written: that of distinct names, rounded up to even, at most 6. It is the same in every
  /// frame of a shot.
  std::size_t ranks() const;
};

/// CryptoObject and CryptoMaterial of a scene. Each mesh is a material of its own, under its name.
std::vector<MatteKind> matte_kinds(const scene::Scene& scene);

/// Adds the layers of one kind, and its entries to the metadata. Rank 0 is the object that most paths of the pixel met
/// first; channels R and G of NAME00 are its id and the share of the pixel's paths that met it. B and A are those of
/// rank 1; NAME01 has ranks 2 and 3, and so on. Equal shares are ranked in the order of the scene. A rank without an
/// object has id 0 and share 0. The shares add up to the coverage, or to less where a pixel has more names than ranks,
/// or more objects than ObjectCounts has room for.
void add_mattes(const Film& film, const MatteKind& kind, image::Picture* picture);

/// The bits of the id of a strand, whose name is GROOM/ID, or GROOM/INSTANCE/ID if the groom has instances: the groom's
/// name in mattes, the number of the instance (geometry::Hit::instance, counted on from Groom::first_instance) and the
/// strand's id.
std::uint32_t strand_matte_bits(const scene::Groom& groom, std::uint32_t instance, std::uint32_t strand);

/// Adds the layers of strands, CryptoStrand00 to CryptoStrand05, if the film counts them. Equal shares are ranked in
/// the order of their ids. The manifest is empty, which the specification allows: an id follows from its name.
void add_strand_mattes(const Film& film, image::Picture* picture);

}  // namespace tress::integrate
