// Where samples lie in the world, where a file does not say it, or says it wrongly.
#pragma once

#include <optional>
#include <string>

#include "common/base/vec3.hpp"
#include "common/request/physical_meaning.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// What is given replaces what the file says; the rest stays.
struct Placement {
  std::optional<Vec3> spacing = std::nullopt;  // World units between samples; directions stay.
  std::optional<Vec3> origin = std::nullopt;   // The world coordinates of the first sample.
  // The world axes as the file's reader returns them. Coordinates that are RAS become LPS.
  std::optional<WorldSpace> space = std::nullopt;
  std::optional<std::string> length_unit = std::nullopt;

  friend bool operator==(const Placement&, const Placement&) = default;
};

void place(ImageHeader& header, const Placement& placement);

}  // namespace multitetra
