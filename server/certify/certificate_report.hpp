// Formats a certificate as text and as JSON.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "server/certify/certificate.hpp"

namespace multitetra {

// Names of the compared files, and SHA-256 digests of their bytes as 64 hexadecimal digits; empty:
// unknown, such as those of folders and addresses.
struct CertifiedFiles {
  std::string mesh;
  std::string volume;
  std::string mesh_sha256 = {};
  std::string volume_sha256 = {};
  // What the file of the volume does not state, or loses when it is read, a sentence each: "samples
  // of type f64 become f32, with errors of at most 0.03".
  std::vector<std::string> volume_notices = {};
  std::vector<std::string> mesh_notices = {};  // What was converted.
};

// Returns the verdict, followed by the numbers: a table for distances and one for topology.
[[nodiscard]] std::string text_of(const Certificate& certificate, const CertifiedFiles& files,
                                  const CertifyOptions& options);

// Returns kept, mesh_file, volume, mesh_sha256 and volume_sha256 (null: unknown), isovalue, error:
// {kept (null: not requested), proven, world, voxel, lattice_allowance_world,
// rounding_allowance_world}, topology_kept, watertight, distances: {mesh_to_full and full_to_mesh:
// {world and voxel: {maximum, maximum_at_most, percentile_99, mean}, farthest_point, samples}},
// mesh and full_surface: the keys of json_report.hpp's topology and nonmanifold_vertices;
// self_intersections (null: not counted): {triangles, pairs, flat_triangles, place}. Infinite
// numbers (a surface is empty) become null. mesh_notices and volume_notices: as
// above. Distances in voxels are
// relative to the smallest spacing; places are in world coordinates.
[[nodiscard]] nlohmann::ordered_json json_of(const Certificate& certificate,
                                             const CertifiedFiles& files,
                                             const CertifyOptions& options);

}  // namespace multitetra
