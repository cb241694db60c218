// Finds out in which other coordinates a mesh would fit its volume.
#pragma once

#include <optional>

#include "common/dataset/dataset_info.hpp"
#include "common/mesh/triangle_mesh.hpp"
#include "server/certify/certificate.hpp"

namespace multitetra {

// Tries usual units of length, the other patient space (LPS or RAS), sample indices, places
// relative to the first sample, and millimetres or metres of these. Returns the map whose distance
// between the surfaces, measured at some vertices of both, is smallest; nullopt if it is above
// `allowed` plus a voxel with all.
[[nodiscard]] std::optional<MapSuggestion> suggested_map(const TriangleMesh& mesh,
                                                         const TriangleMesh& full,
                                                         const DatasetInfo& grid, double allowed);

}  // namespace multitetra
