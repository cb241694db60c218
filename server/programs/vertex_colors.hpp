// Colors the surfaces of `extract` by a dataset, as `fetch --color-by` does.
#pragma once

#include <optional>
#include <string>

#include "common/cli/surface_options.hpp"
#include "common/mesh/mesh.hpp"
#include "common/request/scalar_request.hpp"
#include "server/dataset/dataset.hpp"

namespace multitetra {

class VertexColors {
 public:
  // Opens the dataset of --color-by, a file or an address, if it is given. Throws ExitError
  // (kUsage) for invalid options, and as open_dataset() does.
  explicit VertexColors(const SurfaceArguments& arguments);

  // Sets the mesh's scalars: the values at its vertices, encoded in the returned range as they are
  // sent to clients. Prints the accuracy unless `quiet`. Does nothing without --color-by. Throws
  // ExitError (kUsage) if the datasets lie in different worlds.
  std::optional<ScalarRange> add_scalars(LatticeMesh& mesh, const DatasetInfo& surface,
                                         bool quiet) const;
  // Returns the dataset's name; empty without one.
  [[nodiscard]] std::string dataset() const { return field_ ? field_->info.name : std::string(); }

 private:
  std::optional<ScalarRequest> request_;
  DatasetPtr field_;  // Null without a request.
};

}  // namespace multitetra
