// Colors the surfaces of `extract` by a dataset, as `fetch --color-by` does.
#pragma once

#include <optional>
#include <string>

#include "common/cli/surface_options.hpp"
#include "common/cli/terminal.hpp"
#include "common/json/json_report.hpp"
#include "common/mesh/mesh.hpp"
#include "common/request/scalar_request.hpp"
#include "server/dataset/dataset.hpp"

namespace multitetra {

class VertexColors {
 public:
  // Opens the dataset of --color-by, a file or an address, if it is given. Throws ExitError
  // (kUsage) for invalid options, and as open_dataset() does.
  explicit VertexColors(const SurfaceArguments& arguments);

  // Sets the mesh's scalars: the values at its vertices, encoded as they are sent to clients. Adds
  // notices about vertices without a value, and prints the accuracy unless `quiet`. Does nothing
  // without --color-by. Throws ExitError (kUsage) if the datasets lie in different worlds.
  void add_scalars(LatticeMesh& mesh, const DatasetInfo& surface, Notices& notices,
                   bool quiet) const;
  // Colors a mesh with scalars.
  void paint(PositionedMesh& mesh) const;
  // Adds color_by and color_range to a report, if there are any.
  void describe(Json& report) const;

 private:
  const SurfaceArguments& arguments_;
  std::optional<ScalarRequest> request_;
  DatasetPtr field_;  // Null without a request.
};

}  // namespace multitetra
