// The report of one surface: the same JSON for all commands that make or fetch surfaces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/dataset/surface_name.hpp"
#include "common/json/json_report.hpp"
#include "common/mesh/content_digest.hpp"
#include "common/request/scalar_request.hpp"

namespace multitetra {

// The whole surface, before small components are removed.
struct WholeSurface {
  MeshTopology topology = {};
  std::uint64_t tetrahedra = 0;         // Of the model.
  std::uint64_t active_tetrahedra = 0;  // Those that the surface crosses.
  std::size_t tiles = 0;
  // Bounds the distance from the full-resolution surface, in world units and without rounding to
  // the lattice; absent: nothing bounds it.
  std::optional<double> error_bound = {};
  double simplification_bound = 0;  // The part of simplification.
  ContentDigest digest = {};
};

struct SurfaceReport {
  std::string dataset = {};
  SurfaceName name = {};
  // That of the surface, whose error is what a budget allows; while there is none the requested
  // one.
  IsosurfaceRequest request = {};
  std::vector<std::string> notices = {};
  std::string coordinates = "world";  // Or "index".
  std::vector<double> shift = {};     // Added to them; empty: nothing.
  std::string color_by = {};          // The dataset of the colors; empty: none.
  std::optional<ScalarRange> colors = {};
  std::optional<WholeSurface> surface = {};  // Absent if none was made.
  // The measures of the components in the file.
  std::optional<SurfaceMeasures> measures = {};
  // The error bound with rounding to the lattice.
  std::optional<double> distance_bound = {};
  std::string open_reason = {};  // Of the dataset, see json_report.hpp.
  std::string mesh_file = {};    // Empty: none was written. The others are those of the file:
  std::optional<std::uint64_t> components_written = {};
  std::optional<std::uint64_t> triangles_written = {};
  std::optional<WrittenMesh> written = {};
  Json more = Json::object();  // Keys of the command.
};

// Keys: dataset, name, label (if it is one), parameters, notices, coordinates, shift (if any),
// color_by and color_range (if colored); if a surface was made its topology, tetrahedra,
// active_tetrahedra, tiles, error_bound_world (null: unbounded), simplification_bound_world and
// content_digest; the measures; self_intersecting_triangles (null: not counted); mesh_file,
// components_written, triangles_written and written (null: no file); those of `more`.
[[nodiscard]] Json json_of(const SurfaceReport& report);

}  // namespace multitetra
