// Strands that a file draws at several places.
#pragma once

#include <optional>
#include <string>

#include "scene/model/framed_points.h"
#include "scene/read/grooms/groom_file.h"

namespace tress::scene {

/// Moves the points of shared strands, of every moment, to where their first instance is when the shutter opens; places
/// are counted from there. Those that are drawn once move to where they are at each moment, and are not shared any
/// more.
void settle(GroomFile* file);

/// Writes out all instances of a file without later moments, one after the other. Fails if there are more points than a
/// file may have; `name` is the file for the message.
std::optional<Error> write_out(const std::string& name, GroomFile* file);

/// The box of strands at all their places, in the file's axes, of a file that is settled, as box_of_strands(); stray
/// strands are found among those that are shared together. Empty without points.
std::optional<Box> box_of_instances(const GroomFile& file, StrandBasis basis);

}  // namespace tress::scene
