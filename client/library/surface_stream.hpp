// The surface that a viewer shows, across changes of the request and lost connections.
//
//   DecodedTileCache tiles;
//   SurfaceStream stream(client, tiles);
//   stream.open(info, {.dataset = info.name, .request = first});
//   while (...) {
//     if (isovalue_changed) stream.open(info, {.dataset = info.name, .request = next});
//     const auto news = stream.next(std::chrono::milliseconds(10));
//     draw(stream.shown());
//   }
//
// The shown surface is always a complete step that passed all checks: the last such step of the
// newest request that has one. It stays until the next step is complete, after a new request until
// the first step of that is complete, and after a cancel or a lost connection. Late messages of
// older requests are ignored.
//
// Received tiles, including those of unfinished steps, are cached and not sent again, within the
// cache's limits. Memory: the limits of DecodedTileCache, the tiles of the running stream
// (AssemblerLimits) and the shown step.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "client/library/assembler.hpp"
#include "client/library/client.hpp"
#include "client/library/decoded_tile_cache.hpp"

namespace multitetra {

// No step was completed yet; other messages may have arrived.
struct NoUpdate {};
struct StreamEnded {
  StreamOutcome outcome = StreamOutcome::kComplete;
};
using StreamUpdate = std::variant<NoUpdate, FetchedStep, StreamEnded>;

class SurfaceStream {
 public:
  // Both must outlive the stream. The client must not be used otherwise while a request runs.
  SurfaceStream(Client& client, DecodedTileCache& tiles);

  // Requests another surface, superseding any running request. Fills in request id and held tiles.
  [[nodiscard]] ClientResult<void> open(const DatasetInfo& info, OpenStream open);

  // Cancels the stream. Its end is a later update: cancelled, or complete if it was already ending.
  [[nodiscard]] ClientResult<void> cancel();

  // Waits for the next update of the running request, for at most `max_wait` plus the time to
  // process one message, so that a viewer stays responsive while many tiles arrive. 0: processes at
  // most one available message. Returns NoUpdate if no request is running. A refusal or a failed
  // check ends the request; after a network error, resume() can continue it.
  [[nodiscard]] ClientResult<StreamUpdate> next(std::chrono::milliseconds max_wait);

  // Reconnects and repeats the request that ran when the connection was lost. Steps already
  // returned are not returned again. Fails if the dataset of this name has changed, or later, as a
  // failed check, if the steps differ.
  [[nodiscard]] ClientResult<void> resume();

  // Null before the first step.
  [[nodiscard]] const CommittedStepPtr& shown() const { return shown_; }
  [[nodiscard]] bool is_running() const { return assembler_.has_value(); }
  // Totals over all requests and connections.
  [[nodiscard]] const ReceivedTiles& received() const { return received_; }

  // Called for every valid tile of the stream.
  void set_tile_listener(TileListener listener) { listener_ = std::move(listener); }

 private:
  ClientResult<void> request();
  ClientResult<std::optional<StreamUpdate>> take(const ServerMessage& message);
  ClientResult<std::optional<StreamUpdate>> take_step(const CommittedStepPtr& step);
  void keep(const ServerMessage& message);
  void keep_decoded();
  [[nodiscard]] double seconds() const;

  Client& client_;
  DecodedTileCache& tiles_;
  TileListener listener_;
  CommittedStepPtr shown_;
  ReceivedTiles received_;

  // The dataset of the latest request.
  DatasetInfo info_;
  OpenStream open_;
  std::optional<Assembler> assembler_;  // nullopt when no request is running.
  std::optional<StepBegin> begun_;      // The step whose tiles are being received.
  std::vector<ContentDigest> arrived_;  // Received tiles that are not cached yet.
  std::vector<ContentDigest> given_;    // The digests of the steps already returned, in order.
  std::chrono::steady_clock::time_point started_;
  double first_byte_seconds_ = 0;
};

}  // namespace multitetra
