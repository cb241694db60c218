// What `extract` and `reference` have in common: options, checks, files and reports.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/cli/surface_output.hpp"
#include "common/mesh/mesh.hpp"
#include "common/request/scalar_request.hpp"
#include "server/dataset/dataset.hpp"
#include "server/programs/progress.hpp"

namespace multitetra {

struct LocalArguments {
  std::string dataset;  // A file, an address or a folder.
  SurfaceArguments surface = {};
  OutputArguments output = {};
  int threads = 0;
};

// Adds all options.
void add_local_options(Command& command, LocalArguments& arguments, const std::string& dataset);

// Returns one file, or one for each of several isovalues; a GLB contains all surfaces.
[[nodiscard]] std::vector<std::string> files_of_isovalues(const LocalArguments& arguments);

// A surface that this process has made.
struct LocalSurface {
  IsosurfaceRequest request = {};             // Its error is the one that the budget allows.
  LatticeMesh mesh = {};                      // Welded.
  std::optional<MeshTopology> topology = {};  // Counted by LocalOutput if not set.
  // Its topology and error bound are set by LocalOutput.
  WholeSurface whole = {};
  std::int32_t finest_spacing = 1;  // See data_border().
  bool is_error_bounded = true;     // By the request's error, if that is one of distances.
  std::optional<std::size_t> common_triangles = {};  // With other surfaces.
};

class LocalOutput {
 public:
  // Opens the dataset of --color-by, a file or an address, if it is given. The arguments must
  // outlive the output. Throws std::invalid_argument for invalid colors, and as open_dataset()
  // does.
  LocalOutput(const LocalArguments& arguments, Progress& progress);

  [[nodiscard]] Notices& notices() { return notices_; }
  // Returns the valid requests of a dataset, one for each isovalue, and adds their notices. Throws
  // ExitError (kUsage).
  [[nodiscard]] std::vector<IsosurfaceRequest> requests(const DatasetInfo& info);
  // Checks a surface and makes its output. The info must outlive this object.
  void add(LocalSurface surface, const DatasetInfo& info, const std::string& file);
  // Surfaces are named by their isovalues or datasets.
  void add(LocalSurface surface, const DatasetInfo& info, const std::string& file, SurfaceName name,
           bool names_itself);
  // Writes the files. Throws ExitError (kEmptySurface), after a report, if a surface is empty; with
  // `may_lack_some` only if all are.
  void write(bool may_lack_some = false);
  // Adds keys to the report of the first surface.
  void describe(const Json& keys) { parts_.front().report.more.update(keys); }
  // Writes the reports and prints the results. Returns the exit code.
  [[nodiscard]] int report();

 private:
  // Sets the mesh's scalars: the field's values at its vertices, encoded in the returned range as
  // they are sent to clients. Prints the accuracy. Throws ExitError (kUsage) if the datasets lie in
  // different worlds.
  ScalarRange add_scalars(LatticeMesh& mesh, const DatasetInfo& surface) const;
  void write_reports();

  const LocalArguments& arguments_;
  Progress& progress_;
  std::optional<ScalarRequest> scalars_;
  DatasetPtr field_;  // Of the colors; null without them.
  Notices notices_;
  std::vector<OutputPart> parts_;
};

}  // namespace multitetra
