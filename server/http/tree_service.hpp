// Trees of cells over HTTP: 3D Tiles that are made while somebody looks at them.
#pragma once

#include <optional>
#include <string>

#include "common/wire/tile.hpp"
#include "server/http/answer.hpp"
#include "server/http/http_options.hpp"
#include "server/http/one_shot_session.hpp"
#include "server/http/request_context.hpp"
#include "server/http/route.hpp"
#include "server/stream/lru_map.hpp"
#include "server/stream/workers.hpp"
#include "server/trees/cell_tree.hpp"

namespace multitetra {

// On the executor's thread alone.
class TreeService {
 public:
  // The options outlive the service.
  explicit TreeService(const HttpOptions& options) : options_(options) {}

  // `one_shot` is greeted. Every file costs no more than the surface in one cell, which is asked of
  // the session like any other; nothing is made for HEAD, nor where the client has it already.
  // `is_for_all`: whether proxies may keep the answer for everybody.
  [[nodiscard]] asio::awaitable<Answer> answer(const TreeFile& file, const HttpRequest& request,
                                               OneShotSession& one_shot, RequestContext& context,
                                               bool is_for_all);

 private:
  // What was asked for, in all that the file is a function of.
  struct Wanted {
    CellTree tree;
    OctreeCube cell;
    bool is_surface = false;  // Else the cell's tileset.
    bool is_first = false;    // tileset.json, of the dataset as it is now.
    bool is_known = false;    // Whether the dataset tells its content.
    std::string key;
  };
  [[nodiscard]] asio::awaitable<Result<Wanted>> wanted(const TreeFile& file,
                                                       OneShotSession& one_shot);
  [[nodiscard]] asio::awaitable<Result<SharedBytes>> make(const Wanted& wanted,
                                                          OneShotSession& one_shot,
                                                          RequestContext& context);

  static constexpr std::size_t kKeptBytes = std::size_t{64} << 20;
  static constexpr std::size_t kWriting = 2;  // Files of cells that are made at the same time.

  const HttpOptions& options_;
  LruMap<std::string, SharedBytes> kept_{kKeptBytes};
  Workers writing_{kWriting};
};

}  // namespace multitetra
