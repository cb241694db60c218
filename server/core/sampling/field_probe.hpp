// The field at one place: trilinear value and gradient.
#pragma once

#include "common/request/probe_request.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

// Requires a dataset whose map to the world can be inverted. There is no field outside of the
// data's box, nor where a sample that counts is void. The gradient is the central difference of the
// trilinear field over a sample step to either side, one-sided where there is no field on the
// other, and 0 along an axis where there is none on both. Throws what reading a brick throws.
[[nodiscard]] ProbedPlace probed(const PreparedVolume& volume, CoordinateSystem coordinates,
                                 const Vec3& place);

}  // namespace multitetra
