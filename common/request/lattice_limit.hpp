// The finest lattice a dataset's grid permits.
#pragma once

#include <string>

#include "common/base/result.hpp"
#include "common/dataset/dataset_info.hpp"
#include "common/mesh/lattice.hpp"
#include "common/request/isosurface_request.hpp"

namespace multitetra {

// Fails with kInvalidArgument unless lattice coordinates fit: grid exponent + lattice resolution <=
// kMaxLatticeBits.
[[nodiscard]] inline Result<void> check_lattice(const IsosurfaceRequest& request,
                                                const DatasetInfo& info) {
  const int finest = kMaxLatticeBits - info.grid_exponent;
  if (request.lattice_resolution <= finest) return {};
  return fail(ErrorCode::kInvalidArgument,
              "The lattice resolution is " + std::to_string(request.lattice_resolution) +
                  "; dataset \"" + info.name + "\" is so large that it must be at most " +
                  std::to_string(finest) + ".");
}

}  // namespace multitetra
