// The octree of a surface for viewers with view-dependent refinement: its cubes (cells), their
// levels of detail, and the request for the surface in a cell.
//
//   const Tileset tileset(info, {.isovalue = 500.5, .error = 0.25});
//   root       2^N grid steps a side        a preview, fast for data of any size
//   ...        half as large each           a quarter of the error each
//   leaf       2^6 grid steps a side        the requested error
//
// The cells of one level form one complete conforming surface: their triangles meet in the same
// vertices on the cells' faces (see common/request/surface_cell.hpp). Levels of cells up to 2^8
// steps keep the topology and have a certified error. The root and levels of larger cells are
// previews: their finest spacing is chosen so that all cells cost about the same. Between cells of
// different levels there may be a gap or an overlap, of at most the sum of both errors.
#pragma once

#include <string>
#include <string_view>

#include "common/base/result.hpp"
#include "common/dataset/dataset_info.hpp"
#include "common/mesh/octree_cube.hpp"
#include "common/request/default_error.hpp"
#include "common/request/isosurface_request.hpp"
#include "common/wire/lattice_glb.hpp"

namespace multitetra {

struct TilesetSettings {
  double isovalue = 0;
  double error = kDefaultError;         // Error of the leaves in voxels; finite, >= 0.
  CellCodec codec = CellCodec::kDraco;  // Of 3D Tiles.

  friend bool operator==(const TilesetSettings&, const TilesetSettings&) = default;
};

// Parses and formats settings such as "500.5,error=0.5,codec=meshopt", as used in paths, in this
// order. Defaults are omitted. Invalid text gives kInvalidArgument, with the reason and an example.
[[nodiscard]] Result<TilesetSettings> tileset_settings_from(std::string_view text);
[[nodiscard]] std::string text_of(const TilesetSettings& settings);

// Format and parse the name of a cell's files, "9-0-3-1": exponent, x, y, z. Only the canonical
// form is parsed.
[[nodiscard]] std::string cell_name(const OctreeCube& cell);
[[nodiscard]] std::optional<OctreeCube> cell_from(std::string_view name);

class Tileset {
 public:
  Tileset(DatasetInfo info, const TilesetSettings& settings);

  [[nodiscard]] const DatasetInfo& info() const { return info_; }
  [[nodiscard]] const TilesetSettings& settings() const { return settings_; }
  // Returns 16 hexadecimal digits that identify the content of all cells of the dataset,
  // independent of the settings.
  [[nodiscard]] std::string id() const;

  [[nodiscard]] OctreeCube root() const { return {info_.grid_exponent, 0, 0, 0}; }
  [[nodiscard]] int leaf_exponent() const;
  [[nodiscard]] bool contains(const OctreeCube& cell) const;
  [[nodiscard]] bool is_leaf(const OctreeCube& cell) const {
    return cell.exponent == leaf_exponent();
  }

  // Returns whether the level of cells with that exponent is a preview. Other levels keep the
  // topology.
  [[nodiscard]] bool is_preview(int exponent) const;
  // Returns the two-sided Hausdorff distance bound of a level to the full-resolution surface, in
  // world units. For a preview, the size of features that may be missing. Decreases from level to
  // level.
  [[nodiscard]] double error_bound(int exponent) const;
  // Returns the request for the surface in a cell of the tileset, with normals for shading.
  [[nodiscard]] IsosurfaceRequest request(const OctreeCube& cell) const;
  // Returns the requests for a cell's surface without normals: a leaf in one piece, other cells in
  // octants, which fit together; they fit other cells of the level only if those are split too.
  [[nodiscard]] std::vector<IsosurfaceRequest> fragment_requests(const OctreeCube& cell) const;

 private:
  [[nodiscard]] IsosurfaceRequest request(const OctreeCube& cube, int level) const;
  [[nodiscard]] std::int32_t finest_spacing(int exponent) const;
  [[nodiscard]] int lattice_resolution(int exponent) const;
  [[nodiscard]] double threshold(int exponent) const;  // In voxels.

  DatasetInfo info_;
  TilesetSettings settings_;
};

}  // namespace multitetra
