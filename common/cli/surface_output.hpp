// The output of commands that make or fetch surfaces: mesh files, which are read back, notices, and
// a report.
//
//   OutputPart part = {.info = &info, .notices = &notices, .name = surface_name(info), .file = "head.ply"};
//   finish(part, mesh, arguments, output);
//   write_files({&part, 1}, arguments, output, /*counts_self_intersections=*/true);
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/cli/output_files.hpp"
#include "common/cli/surface_options.hpp"
#include "common/cli/terminal.hpp"
#include "common/dataset/dataset_info.hpp"
#include "common/dataset/surface_name.hpp"
#include "common/json/surface_report.hpp"
#include "common/wire/surface_file.hpp"

namespace multitetra {

struct OutputArguments {
  std::string file = {};    // Its suffix is that of a mesh format.
  std::string report = {};  // Empty: none.
  bool json = false;        // Prints the report.
  bool quiet = false;

  [[nodiscard]] bool has_report() const { return json || !report.empty(); }
};

// Adds -o, --report, --json, --quiet and those of add_output_options().
void add_output_options(Command& command, SurfaceArguments& surface, OutputArguments& output);

// Returns the format of a mesh file. Throws ExitError (kUsage) for another suffix, and for codecs
// that the format does not have.
[[nodiscard]] MeshFormat mesh_format_of(const std::string& file, const SurfaceArguments& arguments);

// Returns the file of each dataset's surface: one GLB for all of one time. Otherwise the names of
// files include those of the datasets, without the series' if it is the same for all.
[[nodiscard]] std::vector<std::string> files_of(const std::string& output, MeshFormat format,
                                                std::span<const DatasetInfo* const> datasets);

// Throws as require_outputs() does; several parts may have one file.
void require_outputs_of(std::vector<std::string> files, const OutputArguments& output,
                        const std::vector<NamedFile>& inputs, const std::string& model_file = {});

// One of the surfaces.
struct OutputPart {
  const DatasetInfo* info = nullptr;  // Neither is null, and both outlive the part.
  Notices* notices = nullptr;
  SurfaceName name = {};
  std::string file = {};         // Empty: none is written.
  std::uint64_t max_bytes = 0;   // Of the surface as it is sent, 0: no limit.
  bool names_itself = false;     // Notices have the surface's name.
  const char* product = "file";  // What notices say is made of it.
  SurfaceReport report = {};
  OutputSurface surface = {};

  void add_notices(const std::vector<std::string>& texts);
};

// Makes the output of a checked surface: requires report.surface and report.request. Adds measures,
// if there is a report, and notices of what a user may not expect.
void finish(OutputPart& part, const LatticeMesh& mesh, const SurfaceArguments& arguments,
            const OutputArguments& output);

// Returns the first part that may not be empty but is; null: none. With `may_lack_some` not all may
// be.
[[nodiscard]] const OutputPart* forbidden_empty(std::span<const OutputPart> parts,
                                                const SurfaceArguments& arguments,
                                                bool may_lack_some);

// Writes the files, and completes the reports with what they hold. Files without any triangle are
// not written, with a notice, unless --allow-empty is given. Throws std::system_error, and
// ExitError (kUsage) before writing a file whose format cannot hold the coordinates.
void write_files(std::span<OutputPart> parts, const SurfaceArguments& arguments,
                 const OutputArguments& output, bool counts_self_intersections);

// Writes the bytes of one surface's file. Throws as write_files() does.
void write_surface(const std::string& file, const NamedSurface& surface, MeshCodec codec);

// Writes and prints a report, as requested: the only one or, of several surfaces, {"surfaces":
// [...]}.
void write_report(std::vector<Json> reports, bool are_several, const OutputArguments& output);

}  // namespace multitetra
