// Surfaces as one file: checked, and written where they take no memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/image/color_map.hpp"
#include "common/request/dataset_info.hpp"
#include "common/wire/mesh_files.hpp"
#include "server/http/answer.hpp"
#include "server/operations/byte_reservations.hpp"
#include "server/service/surface.hpp"

namespace multitetra {

// A mesh in its file format, in a file without a name, with a reservation of disk space.
struct StoredMesh {
  SharedFile file;
  std::uint64_t bytes = 0;
  // Header fields that describe the mesh.
  std::string fields;
};

struct MeshForm {
  MeshFormat format = MeshFormat::kGlb;
  bool is_in_world = true;  // Else in sample indices.
  // The color map of scalars, if any; its ends are those of the step's scalars.
  ColorScale colors = {.map = ColorMap::kViridis};
  double min_component = 0;  // Components of a shorter diagonal, in samples, are left out.
};

// The file that is written, and its memory reservation.
struct MeshPlace {
  std::filesystem::path folder;
  // Room for so many bytes, as long as the reservation lives.
  std::function<Result<ByteReservations::Reservation>(std::uint64_t)> reservation;
};

// Takes about 120 bytes of memory a triangle while it works. kDamagedData when the mesh has a
// crack; what place.room() says where there is none. kCancelled soon after `stop` is triggered.
// Throws std::system_error when the folder cannot take it. Several surfaces, of one dataset, become
// one GLB with a part for each, named by its isovalue; requires that format for them.
[[nodiscard]] Result<StoredMesh> store_mesh(std::vector<Surface> surfaces, const DatasetInfo& info,
                                            const MeshForm& form, const MeshPlace& place,
                                            const std::stop_token& stop);

}  // namespace multitetra
