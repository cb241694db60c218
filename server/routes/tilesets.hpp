// 3D Tiles tilesets, made on demand.
#pragma once

#include <optional>
#include <string>

#include "common/base/lru_map.hpp"
#include "common/wire/tile.hpp"
#include "server/http/answer.hpp"
#include "server/http/request_context.hpp"
#include "server/routes/route.hpp"
#include "server/routes/route_options.hpp"
#include "server/service/workers.hpp"
#include "server/tilesets/tileset.hpp"

namespace multitetra {

// Used on the executor's thread only.
class TilesetRoute {
 public:
  // The options must outlive the route.
  explicit TilesetRoute(const RouteOptions& options) : options_(options) {}

  // A file costs at most the surface in one cell, made by the service like any other. Makes nothing
  // for HEAD, nor if the client's copy is current. Shared caches may store a response if the permit
  // is for all clients.
  [[nodiscard]] asio::awaitable<Answer> answer(const TilesetFile& file, const HttpRequest& request,
                                               RequestContext& context);

 private:
  // Everything that determines the file's bytes.
  struct RequestedFile {
    Tileset tileset;
    OctreeCube cell;
    bool is_surface = false;  // Otherwise the cell's tileset.
    bool is_first = false;    // tileset.json, of the current dataset.
    // The dataset has a content digest.
    bool is_known = false;
    std::string key;
    // Quoted; empty if the dataset has no content digest.
    std::string tag;
  };
  using RequestedFilePtr = std::shared_ptr<const RequestedFile>;
  [[nodiscard]] Result<RequestedFilePtr> requested_file(const TilesetFile& file,
                                                        const Permit& permit);
  [[nodiscard]] static Result<RequestedFile> resolved(const TilesetFile& file, DatasetInfo info);
  [[nodiscard]] asio::awaitable<Result<SharedBytes>> make(const RequestedFile& wanted,
                                                          RequestContext& context);

  static constexpr std::size_t kMaxCachedPaths = 1024;
  static constexpr std::size_t kMaxCachedBytes = std::size_t{64} << 20;
  static constexpr std::size_t kMaxConcurrentFiles = 2;  // Files made at the same time.

  const RouteOptions& options_;
  LruMap<std::string, SharedBytes> kept_{kMaxCachedBytes};
  // Parsed paths, valid while their dataset is unchanged.
  LruMap<std::string, RequestedFilePtr> paths_{kMaxCachedPaths};
  Workers writing_{kMaxConcurrentFiles};
};

}  // namespace multitetra
