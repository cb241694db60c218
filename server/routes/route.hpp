// Parses the path of a request into the resource that it identifies. Pure.
#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "common/base/result.hpp"
#include "common/mesh/content_digest.hpp"
#include "common/request/default_error.hpp"
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
struct IsosurfaceResource {  // /v1/datasets/{name}/isosurface
  std::string dataset;
};
struct SliceOfSamples {  // /v1/datasets/{name}/slice
  std::string dataset;
};
struct ValueAtPlaces {  // /v1/datasets/{name}/probe
  std::string dataset;
};
struct ThumbnailPicture {  // /v1/datasets/{name}/thumbnail.png
  std::string dataset;
};
struct TileBytes {  // /v1/tiles/{hash}
  ContentDigest digest;
};
// /v1/3dtiles/{name}/iso/{settings}/tileset.json, and below it {id}/{file}. Also after
// /v1/token/{token}, for viewers that send no header.
struct TilesetFile {
  std::string dataset;
  std::string settings;  // Parsed by tileset_settings_from().
  std::string id;        // Empty: the dataset's current id.
  std::string file;
  std::string token;
};
// /v1/neuroglancer/{name}/surfaces/{path}, or surfaces,error=0.5;
// /v1/neuroglancer/{name}/image/{path}. Also after a token, as for 3D Tiles.
struct NeuroglancerFile {
  std::string dataset;
  bool is_image = false;
  // The error of the finest level, in voxels.
  double error = kDefaultError;
  std::string path;
  std::string token;
};
struct ViewerFile {  // Any other path: a viewer file, or none.
  std::string path;  // The undecoded path.
};

using Route =
    std::variant<Liveness, Readiness, Metrics, Description, WebSocketStream, DatasetListing,
                 DatasetDescription, IsosurfaceResource, SliceOfSamples, ValueAtPlaces,
                 ThumbnailPicture, TileBytes, TilesetFile, NeuroglancerFile, ViewerFile>;

// Returns the target for logs: a token in its path becomes "...".
[[nodiscard]] std::string without_token(std::string_view target);

// Returns the resource's kind in one word for metrics: "isosurface", "tile" and so on.
[[nodiscard]] const char* name(const Route& route);

// Returns kInvalidArgument if a part of the path is invalid, such as a tile's digest.
[[nodiscard]] Result<Route> route_of(const Target& target);

}  // namespace multitetra
