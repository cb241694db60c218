// Surfaces as one file: checks them, and writes them to memory, large ones to disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/dataset/dataset_info.hpp"
#include "common/image/color_map.hpp"
#include "common/wire/mesh_files.hpp"
#include "server/http/http_response.hpp"
#include "server/operations/byte_reservations.hpp"
#include "server/service/surface.hpp"

namespace multitetra {

// A mesh in its file format: in memory, or in an unnamed file with a reservation of disk space.
struct StoredMesh {
  Body body;
  // Header fields that describe the mesh.
  std::string fields;
};

struct MeshFileOptions {
  MeshFormat format = MeshFormat::kGlb;
  MeshCodec codec = MeshCodec::kNone;
  bool is_in_world = true;  // Otherwise in sample indices.
  // The color map for scalars, if any. Its range is that of the step's scalars.
  ColorScale colors = {.map = ColorMap::kViridis};
  std::string color_by = {};  // The dataset of the scalars, if there are any.
  double min_component = 0;   // Diagonal in samples below which components are removed.
};

// The storage for a mesh file. Files of at most `max_in_memory` bytes need none.
struct MeshStorage {
  std::uint64_t max_in_memory = 0;
  std::filesystem::path folder;
  // Reserves disk space for a number of bytes.
  std::function<Result<ByteReservations::Reservation>(std::uint64_t)> reservation;
};

// Checks and writes the surfaces, and reads the file back (common/wire/surface_file.hpp), which
// takes about 250 bytes of memory per triangle meanwhile. Returns kDamagedData if a mesh has a
// crack, the error of place.reservation() if it fails, and kCancelled soon after `stop` is
// triggered. Throws std::system_error if the folder is not writable. Several surfaces of one
// dataset become one GLB with a part for each, named by isovalue; requires that format.
[[nodiscard]] Result<StoredMesh> store_mesh(std::vector<Surface> surfaces, const DatasetInfo& info,
                                            const MeshFileOptions& form, const MeshStorage& place,
                                            const std::stop_token& stop);

}  // namespace multitetra
