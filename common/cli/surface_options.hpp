// Command line options that request an isosurface: the same for the server's `extract` and
// the client's commands, made from the table of request fields.
#pragma once

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "common/base/affine.hpp"
#include "common/base/result.hpp"
#include "common/cli/command.hpp"
#include "common/mesh/mesh.hpp"
#include "common/request/dataset_info.hpp"
#include "common/request/surface_query.hpp"

namespace multitetra {

// Readers of the file of --threshold-grid: programs support different formats.
struct ThresholdFiles {
  std::string formats = {};  // For --help: "A NRRD file".
  // Reads the thresholds of an image, shrunk until a request may contain them; `elsewhere` is the
  // threshold where the image has none. They need not be checked.
  std::function<Result<ThresholdGrid>(const std::filesystem::path& file, double elsewhere)> read =
      {};
};

struct SurfaceArguments {
  SurfaceQuery query = {};
  std::string space = "native";
  std::string threshold_grid = {};  // A file for threshold_files; empty: none.
  bool allow_empty = false;
  ThresholdFiles threshold_files = {};
};

// The option of one field, as --max-triangles of max_triangles; `parse` takes its values.
void add_request_option(Command& command, const RequestField& field, Command::Parse parse);

// The options of all fields of these groups, and with kThresholds --threshold-grid.
void add_request_options(Command& command, SurfaceArguments& arguments,
                         std::initializer_list<FieldGroup> groups);
// For commands that write a surface: the group kFile, --space, --allow-empty.
void add_output_options(Command& command, SurfaceArguments& arguments);

// The requests, at least one, checked. kInvalidArgument or kLimitExceeded where a value is out of
// its range, the dataset's world has no space that could become the requested one, the grid's file
// cannot be read, or no isovalue is given and the dataset suggests none.
[[nodiscard]] Result<std::vector<IsosurfaceRequest>> requests_of(const SurfaceArguments& arguments,
                                                                 const DatasetInfo& info);
// For commands about one surface: also kInvalidArgument where several isovalues are given.
[[nodiscard]] Result<IsosurfaceRequest> request_of(const SurfaceArguments& arguments,
                                                   const DatasetInfo& info);

// Grid coordinates -> the requested coordinates. Requires arguments that requests_of accepts for
// this dataset.
[[nodiscard]] Affine output_map(const SurfaceArguments& arguments, const DatasetInfo& info);
// A surface there, with its normals, without the components that are too small.
struct OutputSurface {
  PositionedMesh mesh;
  int lattice = kDefaultLatticeResolution;  // Vertices are at multiples of 2^-lattice grid steps.
  double min_component = 0;  // Components with a shorter diagonal are left out, in samples.
  // Components in the mesh.
  std::size_t components = 0;
  // Components of the whole surface.
  std::size_t components_of = 0;
  // The vertices of large components: those with a diagonal of at least an eighth of the largest
  // one's.
  std::vector<std::uint32_t> large = {};
};
[[nodiscard]] OutputSurface output_surface(const LatticeMesh& mesh,
                                           const SurfaceArguments& arguments,
                                           const DatasetInfo& info);
// "3 of 1 204 components, those with a diagonal of 10 samples or more"; empty when it is all of
// them.
[[nodiscard]] std::string left_out_text(const OutputSurface& surface,
                                        const SurfaceArguments& arguments);

}  // namespace multitetra
