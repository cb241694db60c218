// Runs one request to its end, a step at a time, across lost connections.
//
//   Fetch fetch(client, info, open);
//   for (auto step = fetch.next(); step && *step; step = fetch.next()) show(**step);
#pragma once

#include <optional>

#include "client/library/client.hpp"
#include "client/library/retries.hpp"
#include "client/library/surface_stream.hpp"

namespace multitetra {

class Fetch {
 public:
  // The client must outlive the fetch and must not be used otherwise before the fetch has ended.
  Fetch(Client& client, const DatasetInfo& info, OpenStream open, const FetchOptions& options = {});

  // Returns the next step that passed all checks, or nullopt after the final one. After a lost
  // connection it reconnects and repeats the request, naming the tiles it holds.
  [[nodiscard]] ClientResult<std::optional<FetchedStep>> next();

  // Cancels the stream and waits for its end, so that the client can serve another request.
  [[nodiscard]] ClientResult<void> cancel();

 private:
  Client& client_;
  DecodedTileCache own_tiles_;
  SurfaceStream stream_;
  Retries retries_;
  std::uint64_t tiles_before_ = 0;  // Tiles received before the last lost connection.
  ClientResult<void> sent_;
};

}  // namespace multitetra
