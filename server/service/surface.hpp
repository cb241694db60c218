// A surface as one mesh, for use within this process.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/base/result.hpp"
#include "common/dataset/dataset_info.hpp"
#include "common/mesh/content_digest.hpp"
#include "common/mesh/mesh.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/request/isosurface_request.hpp"
#include "common/request/scalar_request.hpp"
#include "common/wire/messages.hpp"

namespace multitetra {

// A complete final step in tiles, extracted here or received from an upstream.
struct ReceivedSurface {
  StepBegin begin;
  // Either `payloads` or `meshes` has one entry per tile; the other is empty.
  std::vector<std::shared_ptr<const std::string>> payloads = {};
  std::vector<std::shared_ptr<const LatticeMesh>> meshes = {};
  // The scalar codes of every tile; empty if the surface has no scalars.
  std::vector<std::shared_ptr<const std::string>> scalars = {};
  // The digest of all tiles together.
  ContentDigest digest = {};
};
// Returns the number of triangles in all tiles of the step.
[[nodiscard]] std::uint64_t triangles_of(const StepBegin& step);

struct Surface {
  // Its error is the one that the budget allows.
  IsosurfaceRequest request = {};
  double error_bound_world = 0;
  std::int32_t finest_spacing = 1;
  std::uint32_t crossed_octants = 0;  // See StepBegin.
  std::uint64_t tetrahedra = 0;
  std::uint64_t active_tetrahedra = 0;
  std::size_t tiles = 0;
  double simplification_bound = 0;  // The largest of all tiles.
  std::optional<ScalarRange> scalars = {};
  ContentDigest digest = {};
  LatticeMesh mesh = {};  // Welded; the order depends on the tiles only.
};
// Returns the bytes that the mesh's elements occupy in memory.
[[nodiscard]] std::size_t bytes_of(const LatticeMesh& mesh);

// Welds the tiles, on all threads. Returns kDamagedData if a tile is missing or differs from its
// summary. Throws Cancelled soon after `stop` is triggered.
[[nodiscard]] Result<Surface> assembled(ReceivedSurface tiles, const std::stop_token& stop);

struct CountedSurface {
  Surface surface = {};  // Without normals and scalars.
  MeshTopology topology = {};
};
// Does the same for tiles that this process has made of the dataset, in less time: another order of
// elements, whose topology is counted on the way.
[[nodiscard]] Result<CountedSurface> assembled_and_counted(ReceivedSurface tiles,
                                                           const DatasetInfo& info,
                                                           const std::stop_token& stop);

// Returns kLimitExceeded, with advice, for a step with more triangles.
[[nodiscard]] Result<void> check_triangles(const StepBegin& step, std::uint64_t max_triangles);

}  // namespace multitetra
