// The report of `extract` on one dataset: as JSON, and as text for the terminal.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/cli/surface_options.hpp"
#include "common/json/json_report.hpp"
#include "common/mesh/content_digest.hpp"
#include "server/extraction/tiled_surface.hpp"
#include "server/programs/measured_surface.hpp"

namespace multitetra {

struct ExtractArguments {
  std::string file;
  std::string output;
  SurfaceArguments surface = {};
  std::string errors = "spectrum";
  std::optional<int> level = {};
  std::string report = {};
  std::string model_file = {};
  std::string model_scope = "all";
  int threads = 0;
  bool json = false;
  bool quiet = false;
};

// The model file written with the mesh.
struct WrittenModel {
  std::string file;
  std::size_t tetrahedra = 0;
  std::size_t points = 0;
};

struct ExtractResult {
  IsosurfaceRequest request;  // Its error is the one that the budget allows.
  TiledMesh surface = {};
  MeasuredSurface measured = {};
  ContentDigest content = {};
  std::optional<WrittenModel> model = {};
};

// Returns the largest bound of all tiles.
[[nodiscard]] double simplification_bound(const TiledMesh& surface);

// Returns the report, without the mesh file: its key "mesh_file" is null.
[[nodiscard]] Json json_of(const ExtractResult& result, const ExtractArguments& arguments,
                           const std::vector<std::string>& notices, const Json& seconds);

// Writes the report to the file and prints it, as requested.
void write_report(const Json& report, const ExtractArguments& arguments);

// Prints the result in `file` for people.
void print_result(const ExtractResult& result, const OutputSurface& written,
                  const std::string& file);

}  // namespace multitetra
