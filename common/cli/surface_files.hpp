// Writes the surfaces of a command as mesh files.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/cli/surface_options.hpp"
#include "common/dataset/dataset_info.hpp"
#include "common/dataset/surface_name.hpp"
#include "common/request/mesh_codec.hpp"
#include "common/wire/mesh_files.hpp"

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

// Returns the bytes of a file with this surface alone.
[[nodiscard]] std::string file_bytes(const NamedMesh& surface, MeshFormat format, MeshCodec codec);

// Writes each surface to its file. Only a GLB may have several surfaces: of one world. Throws
// std::system_error.
void write_surfaces(std::span<const NamedMesh> surfaces, MeshFormat format, MeshCodec codec);

}  // namespace multitetra
