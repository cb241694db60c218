// The surfaces that a `fetch` writes, and their files.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "client/commands/connected_request.hpp"
#include "common/cli/surface_output.hpp"
#include "common/dataset/surface_name.hpp"
#include "common/wire/mesh_files.hpp"

namespace multitetra {

struct FetchArguments {
  SurfaceOrder order;
  bool previews = false;
  int retries = 5;
  std::string resume_directory;
  std::string steps_directory;
  OutputArguments output;
};

// One of the fetched surfaces and its output files.
struct FetchPart {
  std::size_t dataset = 0;                // Its place among the datasets of a series.
  std::size_t request = 0;                // Its place among the isovalues.
  std::string isovalue;                   // "isovalue 500.5" if there are several; otherwise empty.
  std::string mesh_file;                  // Several parts may be in one GLB.
  std::filesystem::path steps_directory;  // Empty: steps are not written.
};

// Returns one part per dataset of a series and isovalue; of one dataset without a series. Names of
// files with one part include those of which there are several. A GLB contains all parts of a time.
[[nodiscard]] std::vector<FetchPart> parts_of(const FetchArguments& arguments, MeshFormat format,
                                              std::span<const DatasetRequest> series = {});

// Returns the name of a part in files.
[[nodiscard]] SurfaceName name_of(const FetchPart& part, const DatasetInfo& info, bool is_series);

}  // namespace multitetra
