// Any bytes as a .hair file: refused, or strands that a groom can be made of, whose every number is finite.
#include <cmath>

#include "fuzz/fuzz.h"
#include "scene/read/assembly.h"
#include "scene/read/grooms/given_basis.h"
#include "scene/read/grooms/groom_formats.h"
#include "scene/read/grooms/hair_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tress;
  const auto hair = scene::parse_hair_file(fuzz::bytes_of(data, size), "some.hair");
  if (!hair) {
    fuzz::require_message(hair, "some.hair");
    return 0;
  }
  for (const bool y_up : {false, true}) {
    scene::GroomPlacement placement;
    placement.guess_up = !y_up;
    placement.basis = scene::kind_of_basis(scene::basis_names()[size % scene::basis_names().size()]);
    if (y_up) placement.y_up = placement.colors = true;
    std::vector<std::string> notes, warnings;
    const auto groom = scene::assemble_groom(*hair, placement, "some.hair", &notes, &warnings);
    if (!groom) fuzz::require_message(groom, "some.hair");
  }
  return 0;
}
