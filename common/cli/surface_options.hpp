// Command-line options that request an isosurface, generated from the table of request fields, for
// the server's `extract` and the client's commands.
#pragma once

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "common/base/affine.hpp"
#include "common/base/result.hpp"
#include "common/cli/command.hpp"
#include "common/dataset/dataset_info.hpp"
#include "common/mesh/mesh.hpp"
#include "common/request/scalar_request.hpp"
#include "common/request/surface_query.hpp"
#include "common/wire/surface_file.hpp"

namespace multitetra {

// The reader of --threshold-grid files: programs support different formats.
struct ThresholdFiles {
  std::string formats = {};  // For --help: "A NRRD file".
  // Reads an image of thresholds and shrinks it until it fits into a request; `elsewhere` is the
  // threshold where the image has none, and `length_unit` that of the world, to which the image's
  // is converted. Need not validate the thresholds.
  std::function<Result<ThresholdGrid>(const std::filesystem::path& file, double elsewhere,
                                      const std::string& length_unit)>
      read = {};
};

struct SurfaceArguments {
  SurfaceQuery query = {};
  std::string space = "native";
  std::vector<double> shift = {};   // Added to world coordinates; empty: nothing.
  std::string threshold_grid = {};  // A file for threshold_files; empty: none.
  bool allow_empty = false;
  ThresholdFiles threshold_files = {};
};

// Adds the option of one field, such as --max-triangles; `parse` receives its values.
void add_request_option(Command& command, const RequestField& field, Command::Parse parse);

// Adds the options of all fields of these groups, and --threshold-grid with kThresholds.
void add_request_options(Command& command, SurfaceArguments& arguments,
                         std::initializer_list<FieldGroup> groups);
// Adds the group kFile, --space, --shift and --allow-empty, for commands that write a surface.
void add_output_options(Command& command, SurfaceArguments& arguments);

// Returns at least one validated request. Fails with kInvalidArgument or kLimitExceeded if a value
// is out of range, the dataset's world axes cannot be converted to the requested space, the
// threshold grid cannot be read, or no isovalue is given and the dataset suggests none.
[[nodiscard]] Result<std::vector<IsosurfaceRequest>> requests_from(
    const SurfaceArguments& arguments, const DatasetInfo& info);
// Returns the only request; also fails with kInvalidArgument if several isovalues are given. For
// commands on one surface.
[[nodiscard]] Result<IsosurfaceRequest> request_of(const SurfaceArguments& arguments,
                                                   const DatasetInfo& info);

// Maps grid coordinates to the requested ones. Requires arguments accepted by requests_from().
[[nodiscard]] Affine output_map(const SurfaceArguments& arguments, const DatasetInfo& info);
// Returns the surface in the requested coordinates, without small components.
[[nodiscard]] OutputSurface output_surface(const LatticeMesh& surface,
                                           const SurfaceArguments& arguments,
                                           const DatasetInfo& info);
// "3 of 1 204 components, those with a diagonal of 10 samples or more", and the cavities that this
// fills; empty if none was removed.
[[nodiscard]] std::string removed_text(const OutputSurface& surface);
// Returns "Colors between vertices may be off by up to 0.12, those of vertices by 0.01." for values
// that were encoded in `range`.
[[nodiscard]] std::string color_accuracy_text(const ScalarRange& range, double largest_deviation);
// Throws ExitError (kUsage) if --codec does not fit the output.
void require_codec(const SurfaceArguments& arguments, bool is_glb);
// Returns the notice that a written file has more bytes than its budget of --max-bytes (0: none);
// empty if it has not.
[[nodiscard]] std::vector<std::string> larger_file_notice(const std::string& file,
                                                          std::uint64_t max_bytes);

}  // namespace multitetra
