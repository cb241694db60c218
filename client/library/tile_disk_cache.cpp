#include "client/library/tile_disk_cache.hpp"

#include <algorithm>
#include <optional>
#include <span>
#include <sstream>
#include <vector>

#include "common/base/atomic_file.hpp"
#include "common/base/open_file.hpp"
#include "common/net/frame.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSuffix = ".tile";
constexpr std::string_view kFirstLine = "multitetra tile 1\n";
constexpr std::size_t kMaxHeaderBytes = 256;
// A tile was received in one frame.
constexpr std::uintmax_t kMaxFileBytes = kMaxHeaderBytes + kMaxServerFrameBytes;

struct StoredTile {
  TileSummary summary;
  int lattice_resolution = 0;
  int normal_bits = 0;
  std::string_view payload;
};

std::string header_of(const TileSummary& tile, int lattice_resolution, int normal_bits) {
  std::ostringstream text;
  text << kFirstLine << "lattice " << lattice_resolution << " cube " << tile.cube.exponent << " "
       << tile.cube.x << " " << tile.cube.y << " " << tile.cube.z << " triangles " << tile.triangles
       << " vertices " << tile.vertices << " bytes " << tile.bytes << " normals " << normal_bits
       << "\n";
  return text.str();
}

bool is_in_range(const StoredTile& tile) {
  const auto within = [](std::int64_t value, std::int64_t low, std::int64_t high) {
    return value >= low && value <= high;
  };
  const OctreeCube& cube = tile.summary.cube;
  if (!within(tile.lattice_resolution, kMinLatticeResolution, kMaxLatticeResolution)) return false;
  if (tile.normal_bits != 0 && !within(tile.normal_bits, kMinNormalBits, kMaxNormalBits)) {
    return false;
  }
  const int grid_exponent = kMaxLatticeBits - tile.lattice_resolution;
  if (!within(cube.exponent, 0, grid_exponent)) return false;
  const std::int64_t last = (std::int64_t{1} << (grid_exponent - cube.exponent)) - 1;
  return within(cube.x, 0, last) && within(cube.y, 0, last) && within(cube.z, 0, last) &&
         within(tile.summary.triangles, 1, kMaxTileTriangles) &&
         within(tile.summary.vertices, 3, 3 * std::int64_t{tile.summary.triangles}) &&
         tile.payload.size() == tile.summary.bytes;
}

// Parses a file and checks the range of every number; nullopt if the file is malformed.
std::optional<StoredTile> parse(const std::string& bytes) {
  if (!bytes.starts_with(kFirstLine)) return std::nullopt;
  const std::size_t end = bytes.find('\n', kFirstLine.size());
  if (end == std::string::npos || end >= kMaxHeaderBytes) return std::nullopt;
  std::istringstream line(bytes.substr(kFirstLine.size(), end - kFirstLine.size()));
  StoredTile tile;
  tile.payload = std::string_view(bytes).substr(end + 1);
  TileSummary& summary = tile.summary;
  const auto word = [&line](std::string_view wanted) {
    std::string found;
    return line >> found && found == wanted;
  };
  const bool is_whole =
      word("lattice") && line >> tile.lattice_resolution && word("cube") &&
      line >> summary.cube.exponent >> summary.cube.x >> summary.cube.y >> summary.cube.z &&
      word("triangles") && line >> summary.triangles && word("vertices") &&
      line >> summary.vertices && word("bytes") && line >> summary.bytes && word("normals") &&
      line >> tile.normal_bits;
  if (!is_whole || !is_in_range(tile)) return std::nullopt;
  return tile;
}

std::optional<ContentDigest> digest_in_name(const fs::path& file) {
  if (file.extension() != kSuffix) return std::nullopt;
  return ContentDigest::from_hex(file.stem().string());
}

struct TileFile {
  fs::path path;
  ContentDigest digest;
  std::uintmax_t bytes = 0;
};

std::vector<TileFile> largest_first(const fs::path& folder) {
  std::vector<TileFile> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const auto digest = digest_in_name(entry.path());
    std::error_code gone;
    if (!digest || !entry.is_regular_file(gone)) continue;
    const auto bytes = entry.file_size(gone);
    if (!gone) files.push_back({entry.path(), *digest, bytes});
  }
  std::sort(files.begin(), files.end(), [](const TileFile& a, const TileFile& b) {
    return a.bytes != b.bytes ? a.bytes > b.bytes : a.digest < b.digest;
  });
  return files;
}

// Returns null if the content is not the tile identified by the file's name.
std::shared_ptr<const LatticeMesh> mesh_in(const TileFile& file, std::uint64_t most_triangles) {
  if (file.bytes > kMaxFileBytes) return nullptr;
  const auto bytes = OpenFile(file.path).content(file.bytes);
  if (!bytes) return nullptr;
  auto tile = parse(*bytes);
  if (!tile || tile->summary.triangles > most_triangles) return nullptr;
  tile->summary.digest = file.digest;
  auto mesh =
      decode_tile(tile->payload, tile->summary, tile->lattice_resolution, tile->normal_bits);
  return mesh ? std::make_shared<const LatticeMesh>(*std::move(mesh)) : nullptr;
}

}  // namespace

TileDiskCache::TileDiskCache(fs::path folder) : folder_(std::move(folder)) {
  fs::create_directories(folder_);
}

TileDiskCache::Loaded TileDiskCache::load(DecodedTileCache& memory,
                                          std::uint64_t most_triangles) const {
  Loaded loaded;
  for (const TileFile& file : largest_first(folder_)) {
    if (memory.size() >= kMaxHeldDigests || memory.triangles() >= most_triangles) break;
    auto mesh = mesh_in(file, most_triangles - memory.triangles());
    if (!mesh) {
      ++loaded.damaged;
      continue;
    }
    memory.keep(file.digest, std::move(mesh));
    ++loaded.tiles;
  }
  return loaded;
}

void TileDiskCache::keep(const TileSummary& tile, int lattice_resolution, int normal_bits,
                         const std::string& payload) const {
  AtomicFile file(folder_ / (tile.digest.hex() + std::string(kSuffix)));
  const std::string header = header_of(tile, lattice_resolution, normal_bits);
  file.write_at(0, std::as_bytes(std::span(header)));
  file.write_at(header.size(), std::as_bytes(std::span(payload)));
  file.commit(Durability::kProcessEnd);
}

}  // namespace multitetra
