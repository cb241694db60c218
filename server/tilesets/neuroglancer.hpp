// Writes neuroglancer's precomputed multi-resolution meshes, with a segment for every isovalue.
//
// Manifests lie along the grid's axes, in nanometres, with sample (i, j, k) in the middle of voxel
// (i, j, k); the transform in the file "info" places them in the image (neuroglancer_image.hpp).
// The tileset's cells are the fragments of a mesh; level of detail 0 are the leaves. Fragments of
// other levels are split at the octants of their cell, as the format requires.
//
// A fragment's vertices are integers from 0 to 65535 across its cell, which differ from the
// lattice: they are rounded once more, by less than a 65535th of the cell's side along each axis.
// The errors of the levels include that.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "common/mesh/mesh.hpp"
#include "server/tilesets/tileset.hpp"

namespace multitetra {

// Returns the isovalue's bits as a 64-bit IEEE 754 number, so that every isovalue has a segment. As
// segment 0 is reserved, isovalue 0 has the segment of -0.
[[nodiscard]] std::uint64_t segment_of(double isovalue);
// Returns none unless the text is in decimal digits and stands for a finite number.
[[nodiscard]] std::optional<double> isovalue_of_segment(std::string_view segment);

// The storage of manifests and fragments: two files for each segment, or shards (mesh_shard()).
enum class MeshLayout { kFiles, kShards };
[[nodiscard]] std::string mesh_info_json(const DatasetInfo& dataset,
                                         MeshLayout layout = MeshLayout::kFiles);
// Lists the suggested isovalues as segments, with their values as labels.
[[nodiscard]] std::string segment_properties_json(const DatasetInfo& info);

// Returns Draco bytes; empty without triangles. The mesh must lie in the cell.
[[nodiscard]] std::string mesh_fragment(const LatticeMesh& mesh, const OctreeCube& cell);

// All crossed cells of the tileset, including those without triangles.
using MeshFragments = std::map<OctreeCube, std::shared_ptr<const std::string>>;

struct MeshFiles {
  std::string manifest;  // SEGMENT.index
  std::string data;      // SEGMENT: the fragments in the order of the manifest.
};
[[nodiscard]] MeshFiles mesh_files_of(const Tileset& tileset, const MeshFragments& fragments);

// Returns all segments in one shard, "0.shard": neuroglancer_uint64_sharded_v1, uncompressed.
[[nodiscard]] std::string mesh_shard(const std::map<std::uint64_t, MeshFiles>& segments);

}  // namespace multitetra
