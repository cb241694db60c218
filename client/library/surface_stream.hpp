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
// What is shown is always a complete step that passed all checks: the last one of the newest
// request that had one. It stays while the next step comes, after a new request until that has its
// first step, after a cancel and after a lost connection. Messages of an older request that are
// still under way are passed over.
//
// Tiles that came, also those of steps that were never finished, are kept in the memory and not
// sent again within its limits. Memory: what DecodedTileCache allows, the tiles of the running
// stream (AssemblerLimits), and the step shown.
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

// No step was completed yet; there may have been messages.
struct NoUpdate {};
struct StreamEnded {
  StreamOutcome outcome = StreamOutcome::kComplete;
};
using StreamUpdate = std::variant<NoUpdate, FetchedStep, StreamEnded>;

class SurfaceStream {
 public:
  // Both must outlive the stream, and nothing else may use the client while a request runs.
  SurfaceStream(Client& client, DecodedTileCache& tiles);

  // Requests another surface, which supersedes a running one. The request id and the tiles held are
  // filled in here.
  [[nodiscard]] ClientResult<void> open(const DatasetInfo& info, OpenStream open);

  // Cancels the stream. Its end arrives as news: cancelled, or complete if it was sooner.
  [[nodiscard]] ClientResult<void> cancel();

  // Waits for the next update of the running request, at most `patience` and the time that one
  // message takes (0: takes one message, if it is there): a viewer has its turn also while many
  // tiles come. Without a running request there is nothing new. After a refusal or a failed check
  // the request is over; after an error of the network, resume() may continue it.
  [[nodiscard]] ClientResult<StreamUpdate> next(std::chrono::milliseconds max_wait);

  // Reconnects and repeats the request that ran when the connection was lost. Steps that were
  // given already are not given again. An error when the server now has another dataset under the
  // name, or (as a failed check, when they come) other steps.
  [[nodiscard]] ClientResult<void> resume();

  // Null before the first step.
  [[nodiscard]] const CommittedStepPtr& shown() const { return shown_; }
  [[nodiscard]] bool is_running() const { return assembler_.has_value(); }
  // Over all requests and connections.
  [[nodiscard]] const ReceivedTiles& received() const { return received_; }

  // Called for every valid tile of the stream.
  void set_tile_listener(TileListener listener) { listener_ = std::move(listener); }

 private:
  ClientResult<void> ask();
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
  std::optional<Assembler> assembler_;  // None when no request runs.
  std::optional<StepBegin> begun_;      // The step whose tiles come.
  std::vector<ContentDigest> arrived_;  // Tiles that are not in the memory yet.
  std::vector<ContentDigest> given_;    // The digests of the steps that were given, in order.
  std::chrono::steady_clock::time_point started_;
  double first_byte_seconds_ = 0;
};

}  // namespace multitetra
