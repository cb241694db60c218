// Where the samples of a NRRD file lie in the world.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.hpp"
#include "common/base/vec3.hpp"
#include "common/image/nrrd_header.hpp"

namespace multitetra {

struct NrrdPlacement {
  // The steps between samples along up to three axes, in world coordinates; 0: not stated.
  std::array<Vec3, 3> steps = {};
  // World coordinates of the first sample's center, as far as they are stated.
  std::array<std::optional<double>, 3> first = {};
  // By these signs the coordinates of a patient became LPS; absent: the space has no patient.
  std::optional<Vec3> signs = std::nullopt;
  // Units of length as they are written; empty: not stated.
  std::string unit = {};  // Of all axes.
  std::array<std::string, 3> units_of_axes = {};
};

// `axes`: those in space, up to three of as many as there are sizes. Fails with
// kInvalidArgument, naming the space, if that is unknown.
[[nodiscard]] Result<NrrdPlacement> nrrd_placement(const NrrdHeader& header,
                                                   const std::vector<std::int64_t>& sizes,
                                                   const std::vector<std::size_t>& axes);

}  // namespace multitetra
