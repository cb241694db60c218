#include "server/routes/route.hpp"

#include <algorithm>
#include <span>
#include <string_view>

#include "common/base/parse_number.hpp"

namespace multitetra {

const char* name(const Route& route) {
  struct Names {
    const char* operator()(const Liveness&) const { return "livez"; }
    const char* operator()(const Readiness&) const { return "readyz"; }
    const char* operator()(const Metrics&) const { return "metrics"; }
    const char* operator()(const Description&) const { return "openapi"; }
    const char* operator()(const WebSocketStream&) const { return "stream"; }
    const char* operator()(const DatasetListing&) const { return "datasets"; }
    const char* operator()(const DatasetDescription&) const { return "dataset"; }
    const char* operator()(const IsosurfaceResource&) const { return "isosurface"; }
    const char* operator()(const SliceOfSamples&) const { return "slice"; }
    const char* operator()(const ValueAtPlaces&) const { return "probe"; }
    const char* operator()(const ThumbnailPicture&) const { return "thumbnail"; }
    const char* operator()(const TileBytes&) const { return "tile"; }
    const char* operator()(const TilesetFile&) const { return "3dtiles"; }
    const char* operator()(const NeuroglancerFile&) const { return "neuroglancer"; }
    const char* operator()(const ViewerFile&) const { return "viewer"; }
  };
  return std::visit(Names{}, route);
}

namespace {

constexpr std::string_view kTokens = "/v1/token/";

// The path after the version and the optional token.
struct VersionedPath {
  std::span<const std::string> path;
  std::string token = {};
};
VersionedPath versioned(const Target& target) {
  const std::span<const std::string> path = target.path;
  if (path.empty() || path[0] != "v1") return {};
  // Tests the undecoded path, as without_token() does.
  if (path.size() > 3 && target.raw_path.starts_with(kTokens)) {
    return {.path = path.subspan(3), .token = path[2]};
  }
  return {.path = path.subspan(1)};
}

constexpr std::size_t kTilesetSegments = 5;  // 3dtiles NAME iso SETTINGS tileset.json

Result<Route> tileset_file(const VersionedPath& versioned) {
  const auto path = versioned.path;
  const bool is_first = path.size() == kTilesetSegments && path.back() == "tileset.json";
  if (path.size() < kTilesetSegments || path.size() > kTilesetSegments + 1 || path[2] != "iso" ||
      (path.size() == kTilesetSegments && !is_first)) {
    return fail(
        ErrorCode::kInvalidArgument,
        "3D Tiles are at /v1/3dtiles/DATASET/iso/ISOVALUE/tileset.json, or with the error of the "
        "finest level in voxels at /v1/3dtiles/DATASET/iso/ISOVALUE,error=ERROR/tileset.json; the "
        "tileset lists all further files.");
  }
  return TilesetFile{.dataset = path[1],
                     .settings = path[3],
                     .id = is_first ? std::string() : path[4],
                     .file = path.back(),
                     .token = versioned.token};
}

Result<Route> neuroglancer_file(const VersionedPath& versioned) {
  constexpr std::string_view kSurfaces = "surfaces";
  constexpr std::string_view kError = ",error=";
  const auto path = versioned.path;
  NeuroglancerFile file{.dataset = {}, .path = {}, .token = versioned.token};
  std::string_view what = path.size() > 2 ? std::string_view(path[2]) : std::string_view();
  file.is_image = what == "image";
  bool is_known = file.is_image;
  if (what.starts_with(kSurfaces)) {
    what.remove_prefix(kSurfaces.size());
    is_known = what.empty();
    if (what.starts_with(kError)) {
      what.remove_prefix(kError.size());
      const auto error = parse_finite(what);
      is_known = error && *error >= 0;
      file.error = error.value_or(0);
    }
  }
  if (!is_known || path.size() < 4) {
    return fail(
        ErrorCode::kInvalidArgument,
        "Neuroglancer's sources are /v1/neuroglancer/DATASET/image and "
        "/v1/neuroglancer/DATASET/surfaces, or with the error of the finest level in voxels "
        "/v1/neuroglancer/DATASET/surfaces,error=ERROR, and the files that they list.");
  }
  file.dataset = path[1];
  for (const std::string& segment : path.subspan(3)) {
    file.path.append(file.path.empty() ? "" : "/").append(segment);
  }
  return file;
}

}  // namespace

std::string without_token(std::string_view target) {
  const std::size_t at = target.find(kTokens);
  if (at == std::string_view::npos) return std::string(target);
  const std::size_t token = at + kTokens.size();
  const std::size_t end = std::min(target.find_first_of("/?", token), target.size());
  return std::string(target.substr(0, token)) + "..." + std::string(target.substr(end));
}

Result<Route> route_of(const Target& target) {
  const auto& path = target.path;
  const VersionedPath below = versioned(target);
  if (!below.path.empty() && below.path[0] == "3dtiles") return tileset_file(below);
  if (!below.path.empty() && below.path[0] == "neuroglancer") return neuroglancer_file(below);
  if (path.size() == 1) {
    if (path[0] == "livez") return Liveness{};
    if (path[0] == "readyz") return Readiness{};
    if (path[0] == "metrics") return Metrics{};
  }
  if (path.size() >= 2 && path[0] == "v1") {
    if (path.size() == 2 && path[1] == "openapi.json") return Description{};
    if (path.size() == 2 && path[1] == "stream") return WebSocketStream{};
    if (path[1] == "datasets") {
      if (path.size() == 2) return DatasetListing{};
      if (path.size() == 3) return DatasetDescription{path[2]};
      if (path.size() == 4 && path[3] == "isosurface") return IsosurfaceResource{path[2]};
      if (path.size() == 4 && path[3] == "slice") return SliceOfSamples{path[2]};
      if (path.size() == 4 && path[3] == "probe") return ValueAtPlaces{path[2]};
      if (path.size() == 4 && path[3] == "thumbnail.png") return ThumbnailPicture{path[2]};
    }
    if (path[1] == "tiles" && path.size() == 3) {
      const auto digest = ContentDigest::from_hex(path[2]);
      if (digest) return TileBytes{*digest};
      return fail(
          ErrorCode::kInvalidArgument,
          "\"" + path[2] + "\" is not the digest of a tile, which has 32 hexadecimal digits.");
    }
  }
  return ViewerFile{target.raw_path};
}

}  // namespace multitetra
