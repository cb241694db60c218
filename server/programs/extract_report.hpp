// The report of `extract` on one dataset: as JSON, and as text for the terminal.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/cli/json_report.hpp"
#include "common/cli/surface_options.hpp"
#include "common/mesh/content_digest.hpp"
#include "common/mesh/mesh_measures.hpp"
#include "common/request/isosurface_request.hpp"
#include "server/extraction/tiled_surface.hpp"

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

// What `extract` has made and found.
struct ExtractResult {
  IsosurfaceRequest request;  // As its budget allows it.
  TiledSurface surface;
  MeshTopology topology;
  ContentDigest content;
  std::optional<std::size_t> self_intersecting = {};  // Triangles, if they were counted.
  // Only for JSON reports: the measures of the output.
  std::optional<SurfaceMeasures> measures = {};
  // World units, including the lattice; none if unbounded.
  std::optional<double> distance_bound = {};
  bool is_full_resolution = false;
  std::optional<WrittenModel> model = {};
};

// Sets the measures of the output, and its distance to the full-resolution surface.
void add_measures(ExtractResult& result, const ExtractArguments& arguments, const LatticeMesh& mesh,
                  const DatasetInfo& info);

// Returns the report of a result whose mesh was not written.
[[nodiscard]] Json json_of(const ExtractResult& result, const ExtractArguments& arguments,
                           const std::vector<std::string>& notices, const Json& seconds);

// Adds the written mesh and model to a report.
void add_files(Json& report, const ExtractResult& result, const ExtractArguments& arguments,
               const OutputSurface& written);

// Writes the report to the file and prints it, as requested.
void write_report(const Json& report, const ExtractArguments& arguments);

// Prints the result for people.
void print_result(const ExtractResult& result, const ExtractArguments& arguments,
                  const OutputSurface& written);

}  // namespace multitetra
