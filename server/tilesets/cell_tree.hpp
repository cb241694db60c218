// A surface as a tree of cells for viewers with view-dependent refinement: its octree cubes, the
// level of detail of each, and the request for the surface of a cell.
//
//   const CellTree tree(info, {.isovalue = 500.5, .error = 0.25});
//   root       2^N grid steps a side        a preview: at once, whatever the size of the data
//   ...        half as large each           half the error each
//   leaf       2^6 grid steps a side        the requested error
//
// The cells of one level are one complete conforming surface: their triangles meet in the same
// vertices on the cells' faces (see common/request/surface_cell.hpp). Levels of cells up to 2^8
// steps keep the topology, and their error is certified. The root, and levels of larger cells, end
// the hierarchy at a spacing that lets every cell cost about as much as any other: they are
// previews. Where cells of two levels meet there is a gap, or an overlap, of no more than both
// their errors together.
#pragma once

#include <string>
#include <string_view>

#include "common/base/result.hpp"
#include "common/mesh/octree_cube.hpp"
#include "common/request/dataset_info.hpp"
#include "common/request/default_error.hpp"
#include "common/request/isosurface_request.hpp"

namespace multitetra {

struct TreeSettings {
  double isovalue = 0;
  double error = kDefaultError;  // The error of the leaves in voxels; finite, >= 0.

  friend bool operator==(const TreeSettings&, const TreeSettings&) = default;
};

// "500.5,error=0.25", as in paths, and back; without the error where it is the usual one.
// kInvalidArgument, saying what is wrong and an example, when it is something else.
[[nodiscard]] Result<TreeSettings> tree_settings_from(std::string_view text);
[[nodiscard]] std::string text_of(const TreeSettings& settings);

// "9-0-3-1": exponent, x, y, z; the names of a cell's files, and back. None for anything else, also
// for the same numbers written otherwise.
[[nodiscard]] std::string cell_name(const OctreeCube& cell);
[[nodiscard]] std::optional<OctreeCube> cell_from(std::string_view name);

class CellTree {
 public:
  CellTree(DatasetInfo info, const TreeSettings& settings);

  [[nodiscard]] const DatasetInfo& info() const { return info_; }
  [[nodiscard]] const TreeSettings& settings() const { return settings_; }
  // Names the content of all cells of the dataset, whatever the settings: 16 hexadecimal digits.
  [[nodiscard]] std::string id() const;

  [[nodiscard]] OctreeCube root() const { return {info_.grid_exponent, 0, 0, 0}; }
  [[nodiscard]] int leaf_exponent() const;
  [[nodiscard]] bool contains(const OctreeCube& cell) const;
  [[nodiscard]] bool is_leaf(const OctreeCube& cell) const {
    return cell.exponent == leaf_exponent();
  }

  // Whether the level whose cells have that exponent is a preview. Other levels keep the topology.
  [[nodiscard]] bool is_preview(int exponent) const;
  // World units: no point of such a level is farther from the surface of the samples, nor the other
  // way round. Of a preview: the size of what may be missing in it. Falls from level to level.
  [[nodiscard]] double error_bound(int exponent) const;
  // For the surface in a cell of the tree, with normals for shading.
  [[nodiscard]] IsosurfaceRequest request(const OctreeCube& cell) const;
  // For a level's surface in an octant of one of its cells, without normals. The octants of a cell
  // fit together; they meet other cells of the level only where those are cut up as well.
  [[nodiscard]] IsosurfaceRequest octant_request(const OctreeCube& octant) const;

 private:
  [[nodiscard]] IsosurfaceRequest request(const OctreeCube& cube, int level) const;
  [[nodiscard]] std::int32_t finest_spacing(int exponent) const;
  [[nodiscard]] int lattice_resolution(int exponent) const;
  [[nodiscard]] double threshold(int exponent) const;  // Voxels.

  DatasetInfo info_;
  TreeSettings settings_;
};

}  // namespace multitetra
