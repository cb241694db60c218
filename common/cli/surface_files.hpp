// Writes the surfaces of a command as mesh files, and reports what the files hold.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/cli/surface_options.hpp"
#include "common/dataset/dataset_info.hpp"
#include "common/dataset/surface_name.hpp"
#include "common/json/json_report.hpp"
#include "common/request/mesh_codec.hpp"
#include "common/wire/mesh_files.hpp"
#include "common/wire/written_mesh.hpp"

namespace multitetra {

struct NamedMesh {
  std::string file;  // Empty: the surface is not written.
  SurfaceName name = {};
  const OutputSurface* surface = nullptr;  // Not null.
};

// Returns the file of each dataset's surface: one GLB for all of one time. Otherwise the names of
// files include those of the datasets, without the series' if it is the same for all.
[[nodiscard]] std::vector<std::string> files_of(const std::string& output, MeshFormat format,
                                                std::span<const DatasetInfo* const> datasets);

// Clears the names of files without any triangle. Returns a notice that names their surfaces, if
// there are any.
[[nodiscard]] std::vector<std::string> leave_out_empty_files(std::span<NamedMesh> surfaces);

// Writes each surface to its file, and returns what the bytes of each hold (read_back()): nothing
// for those without a file or triangles. Only a GLB may have several surfaces: of one world. Throws
// std::system_error, and ExitError (kUsage) before writing a file whose format cannot hold the
// coordinates.
[[nodiscard]] std::vector<WrittenMesh> write_surfaces(std::span<const NamedMesh> surfaces,
                                                      MeshFormat format, MeshCodec codec,
                                                      bool counts_self_intersections = false);

// Returns the notices that 3D printers reject a file: it is open where the data ends, or triangles
// intersect others.
[[nodiscard]] std::vector<std::string> printing_notices(const std::string& file,
                                                        const WrittenMesh& written,
                                                        const DatasetInfo& info);

// Adds the keys of a written file: mesh_file, components_written, triangles_written and written.
void add_file(Json& report, const std::string& file, const OutputSurface& output,
              const WrittenMesh& written);

}  // namespace multitetra
