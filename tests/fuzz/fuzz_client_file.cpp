// Files that a client caches or reads: a tile of an earlier run, and NRRD images of thresholds. The
// first byte selects the format.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>

#include "client/library/nrrd_thresholds.hpp"
#include "client/library/tile_disk_cache.hpp"
#include "common/wire/tile.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

// The first 16 bytes are the digest in the file's name. An accepted tile has that content.
void check_tile(std::string_view bytes) {
  ContentDigest promised;
  if (bytes.size() < sizeof promised) return;
  std::memcpy(&promised, bytes.data(), sizeof promised);
  const TemporaryFolder files;
  const TileDiskCache folder(files.path());
  files.file(promised.hex() + ".tile", bytes.substr(sizeof promised));
  DecodedTileCache memory;
  const TileDiskCache::Loaded loaded = folder.load(memory, /*most_triangles=*/1 << 16);
  require(loaded.tiles + loaded.damaged == 1 && memory.size() == loaded.tiles);
  for (const auto& [name, mesh] : memory.tiles()) {
    require(name == promised && digest(*mesh) == promised);
  }
}

void check_thresholds(std::string_view bytes) {
  static const TemporaryFolder folder;
  const auto grid = read_nrrd_thresholds(folder.file("t.nrrd", bytes), 1);
  if (!grid) {
    require(grid.error().code == ErrorCode::kInvalidArgument ||
            grid.error().code == ErrorCode::kLimitExceeded);
    require(grid.error().text.find("t.nrrd") != std::string::npos);
    return;
  }
  std::size_t count = 1;
  for (const auto side : grid->dims) count *= static_cast<std::size_t>(side);
  require(count > 0 && grid->thresholds.size() == count);
}

}  // namespace
}  // namespace multitetra

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multitetra;
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (data[0] % 2 == 0) {
    check_tile(bytes);
  } else {
    check_thresholds(bytes);
  }
  return 0;
}
