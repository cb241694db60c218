// How an isosurface is asked for on a command line: the same options for the server's `extract` and
// the client's `fetch`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/base/affine.hpp"
#include "common/base/result.hpp"
#include "common/cli/command.hpp"
#include "common/mesh/mesh.hpp"
#include "common/request/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"
#include "common/request/local_thresholds.hpp"

namespace multitetra {

// What reads the file of --threshold-grid: programs know different formats.
struct ThresholdFiles {
  std::string formats = {};  // For --help: "A NRRD file".
  // The thresholds of an image, shrunk until a request may carry them; `elsewhere` is the one where
  // the image says nothing. They need not be checked.
  std::function<Result<ThresholdGrid>(const std::filesystem::path& file, double elsewhere)> read =
      {};
};

struct SurfaceArguments {
  std::vector<double> isovalues = {};  // None: the dataset's first suggestion.
  double error = 0.25;
  std::string unit = "voxel";
  std::string bound = "certified";
  std::string topology_rule = "exact";
  double topology_tolerance = 0;
  int lattice_resolution = kDefaultLatticeResolution;
  std::string coordinates = "world";
  std::string space = "native";
  std::vector<std::string> regions = {};  // As parse_region reads them.
  std::string region_unit = "world";
  std::string view = {};            // As parse_view reads it; empty: none.
  std::string threshold_grid = {};  // A file for threshold_files; empty: none.
  std::string combination = "order";
  std::uint64_t max_triangles = 0;
  std::uint64_t max_bytes = 0;
  int normal_bits = 0;
  std::string simplify = "on";
  bool embedded = false;
  bool allow_empty = false;
  double min_component = 0;  // Samples of diagonal.
  ThresholdFiles threshold_files = {};
};

enum class Isovalues { kOne, kSeveral };
void add_surface_options(Command& command, SurfaceArguments& arguments,
                         Isovalues isovalues = Isovalues::kOne);
// For commands that write a surface: --allow-empty, --min-component.
void add_output_options(Command& command, SurfaceArguments& arguments);

// The request, checked. kInvalidArgument or kLimitExceeded where a value is out of its range or not
// understood, the dataset's world has no space that could become the one asked for, the grid's file
// cannot be read, or no isovalue is given and the dataset suggests none.
[[nodiscard]] Result<IsosurfaceRequest> request_of(const SurfaceArguments& arguments,
                                                   const DatasetInfo& info);
// One for every isovalue, at least one; a budget is that of each.
[[nodiscard]] Result<std::vector<IsosurfaceRequest>> requests_of(const SurfaceArguments& arguments,
                                                                 const DatasetInfo& info);

// Grid coordinates -> the coordinates that were asked for. Requires arguments that request_of found
// good for this dataset.
[[nodiscard]] Affine output_map(const SurfaceArguments& arguments, const DatasetInfo& info);
// A surface there, with its normals, without the components that are too small.
struct OutputSurface {
  PositionedMesh mesh;
  std::size_t components = 0;               // That are in it,
  std::size_t components_of = 0;            // of so many of the surface.
  std::vector<std::uint32_t> largest = {};  // The vertices of the largest component.
};
[[nodiscard]] OutputSurface output_surface(const LatticeMesh& mesh,
                                           const SurfaceArguments& arguments,
                                           const DatasetInfo& info);
// "3 of 1 204 components, those with a diagonal of 10 samples or more"; empty when it is all of
// them.
[[nodiscard]] std::string left_out_text(const OutputSurface& surface,
                                        const SurfaceArguments& arguments);

}  // namespace multitetra
