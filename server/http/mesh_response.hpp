// A final step as one file: decoded, checked, welded, written where it takes no memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>

#include "common/request/dataset_info.hpp"
#include "common/wire/mesh_files.hpp"
#include "server/http/answer.hpp"
#include "server/http/one_shot_session.hpp"

namespace multitetra {

// A mesh in its file format, in a file without a name.
struct StoredMesh {
  SharedFile file;
  std::uint64_t bytes = 0;
  std::string fields;  // Header fields that tell what it is.
};

struct MeshForm {
  MeshFormat format = MeshFormat::kGlb;
  bool is_in_world = true;  // Else in sample indices.
};

// Takes about 120 bytes of memory a triangle while it works. kDamagedData when a check of tiles or
// mesh fails: the same that a client makes. kCancelled soon after `stop` is triggered. Throws
// DatasetFileError when `folder` cannot take it.
[[nodiscard]] Result<StoredMesh> store_mesh(const OneShotSession::Step& step,
                                            const DatasetInfo& info, const MeshForm& form,
                                            const std::filesystem::path& folder,
                                            const std::stop_token& stop);

}  // namespace multitetra
