// The normals of a step's tiles, if it has normals.
#pragma once

#include <cstdint>
#include <vector>

#include "common/wire/tile.hpp"
#include "server/core/planning/refinement_plan.hpp"
#include "server/core/spectrum/prepared_volume.hpp"
#include "server/core/surface/cube_surface.hpp"
#include "server/core/surface/vertex_normals.hpp"

namespace multitetra {

// Returns one normal per vertex, or none for 0 bits, rounded as by encoding and decoding tiles:
// files are equal whether their surface was sent or not.
[[nodiscard]] std::vector<UnitVector> rounded_normals(const PreparedVolume& volume,
                                                      const LatticeMesh& mesh, int bits,
                                                      NormalSource source);

class NormalEncoder {
 public:
  // The volume must outlive this object.
  NormalEncoder(const PreparedVolume& volume, const StepRequest& step);

  // Returns the appearance for TileKey.
  [[nodiscard]] std::uint64_t appearance() const;
  // Returns the rounded normals.
  [[nodiscard]] std::vector<UnitVector> decoded_normals(const TileMesh& tile) const;
  // Returns the encoded tile; `content` must be the digest of its mesh.
  [[nodiscard]] EncodedTile encoded(const TileMesh& tile, const ContentDigest& content) const;

 private:
  [[nodiscard]] std::vector<UnitVector> normals(const TileMesh& tile) const;

  const PreparedVolume& volume_;
  int bits_;
  NormalSource source_;
};

}  // namespace multitetra
