#include "server/extraction/normal_encoder.hpp"

#include <functional>
#include <string>
#include <vector>

#include "common/request/request_key.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"
#include "server/extraction/tiled_surface.hpp"

namespace multitetra {

std::vector<UnitVector> rounded_normals(const PreparedVolume& volume, const LatticeMesh& mesh,
                                        int bits, NormalSource source) {
  if (bits == 0) return {};
  std::vector<UnitVector> normals = vertex_normals(volume, mesh.vertices, mesh.resolution, source);
  round_normals(normals, bits);
  return normals;
}

NormalEncoder::NormalEncoder(const PreparedVolume& volume, const StepRequest& step)
    : volume_(volume),
      bits_(step.request.normal_bits),
      source_(step.finest_spacing >= kSpectrumSpacing ? NormalSource::kCoarseSamples
                                                      : NormalSource::kSamples) {}

// A hash that identifies the shading; a collision would affect only the shading.
std::uint64_t NormalEncoder::appearance() const {
  if (bits_ == 0) return 0;
  const std::uint64_t dataset = std::hash<std::string>{}(key_of(volume_.info));
  return dataset * 64 + static_cast<std::uint64_t>(2 * bits_) +
         (source_ == NormalSource::kSamples ? 1U : 0U);
}

std::vector<UnitVector> NormalEncoder::normals(const TileMesh& tile) const {
  if (bits_ == 0) return {};
  return vertex_normals(volume_, tile.mesh.vertices, tile.mesh.resolution, source_);
}

std::vector<UnitVector> NormalEncoder::decoded_normals(const TileMesh& tile) const {
  return rounded_normals(volume_, tile.mesh, bits_, source_);
}

EncodedTile NormalEncoder::encoded(const TileMesh& tile, const ContentDigest& content) const {
  const std::vector<UnitVector> directions = normals(tile);
  return encode_tile(tile.mesh, tile.cube, content, encoding_speed(tile),
                     {.directions = directions, .bits = bits_});
}

}  // namespace multitetra
