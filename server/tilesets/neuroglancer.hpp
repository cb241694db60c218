// A tree of cells in neuroglancer's precomputed formats: multi-resolution meshes with a segment for
// every isovalue, and the volume itself as an image.
//
// Neuroglancer's volumes have no directions: image and surfaces lie along the grid's axes, in
// nanometres, with sample (i, j, k) in the middle of voxel (i, j, k). A mesh has the cells of a
// tree as fragments: level of detail 0 are the leaves. Fragments of other levels are cut at the
// octants of their cell, as the format requires.
//
// A fragment's vertices are whole numbers from 0 to 65535 across its cell, which is not the
// lattice: they are rounded once more, by less than a 65535th of the cell's side along each axis,
// and the errors of the levels include that.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "common/mesh/mesh.hpp"
#include "server/tilesets/cell_tree.hpp"

namespace multitetra {

// The isovalue's bits as IEEE 754 has them for 64 bits, so that every isovalue has a segment. 0 is
// no segment there: the isovalue 0 has that of -0.
[[nodiscard]] std::uint64_t segment_of(double isovalue);
// None for what is no finite number, or is written otherwise than in decimal digits.
[[nodiscard]] std::optional<double> isovalue_of_segment(std::string_view segment);

// The files of the segments' manifests and fragments: two files each, or shards (mesh_shard()).
enum class MeshLayout { kFiles, kShards };
[[nodiscard]] std::string mesh_info_json(MeshLayout layout = MeshLayout::kFiles);
// The suggested isovalues as segments, with their values as labels.
[[nodiscard]] std::string segment_properties_json(const DatasetInfo& info);
[[nodiscard]] std::string image_info_json(const DatasetInfo& info);

// A piece of the image: "0-64_64-128_0-16" of the scale "4_4_4" is every fourth sample.
struct ImageChunk {
  std::int32_t step = 1;                // Samples between two voxels of the scale.
  std::array<std::int32_t, 3> first{};  // Voxels of the scale.
  std::array<std::int32_t, 3> size{};
};
// None for what image_info_json() does not offer.
[[nodiscard]] std::optional<ImageChunk> image_chunk_from(const DatasetInfo& info,
                                                         std::string_view scale,
                                                         std::string_view chunk);

// ---- meshes

// Draco bytes; empty without triangles. The mesh lies in the cell.
[[nodiscard]] std::string mesh_fragment(const LatticeMesh& mesh, const OctreeCube& cell);

// By cell: all cells of the tree that are crossed, those without triangles included.
using MeshFragments = std::map<OctreeCube, std::shared_ptr<const std::string>>;

struct MeshFiles {
  std::string manifest;  // SEGMENT.index
  std::string data;      // SEGMENT: the fragments one after the other, as the manifest has them.
};
[[nodiscard]] MeshFiles mesh_files_of(const CellTree& tree, const MeshFragments& fragments);

// All segments in one shard, "0.shard": neuroglancer_uint64_sharded_v1, nothing in it compressed.
[[nodiscard]] std::string mesh_shard(const std::map<std::uint64_t, MeshFiles>& segments);

}  // namespace multitetra
