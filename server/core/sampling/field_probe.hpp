// The field at one place: trilinear value and gradient.
#pragma once

#include "common/request/probe_request.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

// Returns the value and gradient of the field at `place`. Requires a dataset with an invertible map
// to the world. There is no field outside of the data's box, nor where a sample with nonzero weight
// is void. The gradient is the central difference of the trilinear field over a sample step on
// either side; one-sided if the other side has no field, and 0 along an axis if neither has.
// Rethrows exceptions from reading a brick.
[[nodiscard]] ProbedPlace probed(const PreparedVolume& volume, CoordinateSystem coordinates,
                                 const Vec3& place);

}  // namespace multitetra
