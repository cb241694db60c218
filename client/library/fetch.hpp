// One request to its end, a step at a time, across lost connections.
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
  // The client must outlive the fetch, and nothing else may use it before the fetch has ended.
  Fetch(Client& client, const DatasetInfo& info, OpenStream open, const FetchOptions& options = {});

  // The next step that passed all checks; nullopt after the final one. After a lost connection it
  // reconnects and repeats the request, naming the tiles that it has.
  [[nodiscard]] ClientResult<std::optional<FetchedStep>> next();

  // Stops the stream and waits for its end: the client is free for another request.
  [[nodiscard]] ClientResult<void> cancel();

 private:
  Client& client_;
  DecodedTileCache own_tiles_;
  SurfaceStream stream_;
  Retries retries_;
  std::uint64_t tiles_before_ = 0;  // Received before the last lost connection.
  ClientResult<void> asked_;
};

}  // namespace multitetra
