// Places samples in the world if their file does not, or does so incorrectly.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/vec3.hpp"
#include "common/dataset/physical_meaning.hpp"
#include "server/volume/formats/stored_volume.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

// The directions of a file's x, y and z axes: each is a world axis or its opposite.
using AxisDirections = std::array<Vec3, 3>;

// Parses "x,-z,y": the file's y axis points along -z, its z axis along y. Returns nullopt unless
// each world axis occurs once.
[[nodiscard]] std::optional<AxisDirections> axis_directions_from(std::string_view text);

// Returns whether the directions mirror the volume (negative determinant).
[[nodiscard]] bool is_mirror(const AxisDirections& directions);

// Returns the rotations nearest to a mirror that keep its direction for z, as text:
// "-x,y,-z or x,-y,-z".
[[nodiscard]] std::string nearest_rotations(const AxisDirections& mirror);

// Present values replace those of the file.
struct Placement {
  // World units between samples; directions are kept.
  std::optional<Vec3> spacing = std::nullopt;
  // Rotates or mirrors all world coordinates.
  std::optional<AxisDirections> orient = std::nullopt;
  // World coordinates of the first sample.
  std::optional<Vec3> origin = std::nullopt;
  // The space of the world axes as the reader returns them. RAS coordinates are converted to LPS.
  std::optional<WorldSpace> space = std::nullopt;
  std::optional<std::string> length_unit = std::nullopt;

  friend bool operator==(const Placement&, const Placement&) = default;
};

// Replaces what `header` states by what is given, and drops its contradictions about that.
void place(ImageHeader& header, const Placement& placement);

// The header of a volume for whose placement nothing is left to state: spacings that nobody states
// are 1, coordinates of the first sample 0, and `meaning` has what is assumed. The type of samples
// is for the caller to set. Requires dims within limits.
[[nodiscard]] VolumeHeader settled(const ImageHeader& header);

// Returns a sentence for each assumption that affects lengths, and for each contradiction. `file`
// names the source.
[[nodiscard]] std::vector<std::string> fact_notices(const std::filesystem::path& file,
                                                    const ImageHeader& header);

}  // namespace multitetra
