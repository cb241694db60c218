// Where a request goes: its path as one of the things that are here. Pure.
#pragma once

#include <string>
#include <variant>

#include "common/base/result.hpp"
#include "common/mesh/content_digest.hpp"
#include "server/http/target.hpp"

namespace multitetra {

struct Liveness {};          // /livez
struct Readiness {};         // /readyz
struct Metrics {};           // /metrics
struct Description {};       // /v1/openapi.json
struct WebSocketStream {};   // /v1/stream
struct DatasetListing {};    // /v1/datasets
struct DatasetDescription {  // /v1/datasets/{name}
  std::string dataset;
};
struct SurfaceFile {  // /v1/datasets/{name}/isosurface
  std::string dataset;
};
struct SliceOfSamples {  // /v1/datasets/{name}/slice
  std::string dataset;
};
struct ValueAtPlaces {  // /v1/datasets/{name}/value
  std::string dataset;
};
struct TileBytes {  // /v1/tiles/{hash}
  ContentDigest digest;
};
struct ViewerFile {  // Whatever else: a file of the viewer, or nothing.
  std::string path;  // As it was sent: names of files are never decoded.
};

using Route = std::variant<Liveness, Readiness, Metrics, Description, WebSocketStream,
                           DatasetListing, DatasetDescription, SurfaceFile, SliceOfSamples,
                           ValueAtPlaces, TileBytes, ViewerFile>;

// What is asked for, in a word for counting: "isosurface", "tile" and so on.
[[nodiscard]] const char* name(const Route& route);

// kInvalidArgument where a part of the path cannot be what it must be, as a tile's digest.
[[nodiscard]] Result<Route> route_of(const Target& target);

}  // namespace multitetra
