// Trees of cells over HTTP: 3D Tiles that are made on demand.
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
#include "server/tilesets/cell_tree.hpp"

namespace multitetra {

// On the executor's thread alone.
class TilesetRoute {
 public:
  // The options outlive the route.
  explicit TilesetRoute(const RouteOptions& options) : options_(options) {}

  // Every file costs no more than the surface in one cell, which the service makes like any other;
  // nothing is made for HEAD, nor where the client has it already. Shared caches may keep a
  // response if the permit is for all clients.
  [[nodiscard]] asio::awaitable<Answer> answer(const TilesetFile& file, const HttpRequest& request,
                                               RequestContext& context);

 private:
  // Everything that determines the file's bytes.
  struct Wanted {
    CellTree tree;
    OctreeCube cell;
    bool is_surface = false;  // Else the cell's tileset.
    bool is_first = false;    // tileset.json, of the dataset as it is now.
    bool is_known = false;    // Whether the dataset has a digest of its content.
    std::string key;
    // In quotes; empty where the dataset has no digest of its content.
    std::string tag;
  };
  using WantedPtr = std::shared_ptr<const Wanted>;
  [[nodiscard]] Result<WantedPtr> wanted(const TilesetFile& file, const Permit& permit);
  [[nodiscard]] static Result<Wanted> found(const TilesetFile& file, DatasetInfo info);
  [[nodiscard]] asio::awaitable<Result<SharedBytes>> make(const Wanted& wanted,
                                                          RequestContext& context);

  static constexpr std::size_t kKeptPaths = 1024;
  static constexpr std::size_t kKeptBytes = std::size_t{64} << 20;
  static constexpr std::size_t kWriting = 2;  // Files of cells that are made at the same time.

  const RouteOptions& options_;
  LruMap<std::string, SharedBytes> kept_{kKeptBytes};
  // What paths stand for, as long as their dataset is the same.
  LruMap<std::string, WantedPtr> paths_{kKeptPaths};
  Workers writing_{kWriting};
};

}  // namespace multitetra
