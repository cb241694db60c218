#include "server/http/route.hpp"

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
    const char* operator()(const SurfaceFile&) const { return "isosurface"; }
    const char* operator()(const SliceOfSamples&) const { return "slice"; }
    const char* operator()(const ValueAtPlaces&) const { return "probe"; }
    const char* operator()(const TileBytes&) const { return "tile"; }
    const char* operator()(const ViewerFile&) const { return "viewer"; }
  };
  return std::visit(Names{}, route);
}

Result<Route> route_of(const Target& target) {
  const auto& path = target.path;
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
      if (path.size() == 4 && path[3] == "isosurface") return SurfaceFile{path[2]};
      if (path.size() == 4 && path[3] == "slice") return SliceOfSamples{path[2]};
      if (path.size() == 4 && path[3] == "value") return ValueAtPlaces{path[2]};
    }
    if (path[1] == "tiles" && path.size() == 3) {
      const auto digest = ContentDigest::from_hex(path[2]);
      if (digest) return TileBytes{*digest};
      return fail(ErrorCode::kInvalidArgument,
                  "\"" + path[2] + "\" is no tile's digest, which has 32 hexadecimal digits.");
    }
  }
  return ViewerFile{target.raw_path};
}

}  // namespace multitetra
