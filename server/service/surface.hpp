// A surface as one mesh, as those in this process use it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/base/result.hpp"
#include "common/mesh/content_digest.hpp"
#include "common/mesh/mesh.hpp"
#include "common/request/isosurface_request.hpp"
#include "common/request/scalar_request.hpp"
#include "common/wire/messages.hpp"
#include "server/operations/byte_reservations.hpp"

namespace multitetra {

// A complete final step in tiles, however it came here.
struct SurfaceTiles {
  StepBegin begin;
  std::vector<std::shared_ptr<const std::string>> payloads = {};  // As in begin.tiles, or
  std::vector<std::shared_ptr<const LatticeMesh>> meshes = {};    // these in their place.
  std::vector<std::shared_ptr<const std::string>> scalars = {};   // Codes; where it has some.
  // The digest of all tiles together.
  ContentDigest digest = {};
};
[[nodiscard]] std::uint64_t triangles_of(const StepBegin& step);

struct Surface {
  IsosurfaceRequest request = {};  // As its budget allows it.
  double error_bound_world = 0;
  std::int32_t finest_spacing = 1;
  std::uint32_t crossed_octants = 0;        // As in StepBegin,
  std::optional<ScalarRange> scalars = {};  // and this as well.
  ContentDigest digest = {};
  LatticeMesh mesh = {};  // Welded, in an order that the tiles alone decide.
  // The reservation of the mesh's bytes.
  ByteReservations::Reservation memory = {};
};
[[nodiscard]] std::size_t bytes_of(const LatticeMesh& mesh);

// kDamagedData when a tile is missing or not what it should be. On all threads; throws Cancelled
// soon after `stop` is triggered. Reserves no memory.
[[nodiscard]] Result<Surface> assembled(SurfaceTiles tiles, const std::stop_token& stop);

// kLimitExceeded, with what to do about it, for a step of more triangles.
[[nodiscard]] Result<void> check_triangles(const StepBegin& step, std::uint64_t max_triangles);

}  // namespace multitetra
