// A blocking client of the service.
//
//   auto client = Client::connect({"127.0.0.1", 7410}, {});
//   auto datasets = client->list_datasets();
//   auto fetched = client->fetch(info, open, [](const FetchedStep& step) { ... });
//
// fetch.hpp returns the steps of a request one at a time; surface_stream.hpp serves viewers, which
// replace their request at any time.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "client/library/assembler.hpp"
#include "client/library/decoded_tile_cache.hpp"
#include "client/library/message_socket.hpp"
#include "client/library/retries.hpp"
#include "common/net/trust.hpp"

namespace multitetra {

// The source of a failure: the network, a refusal by the server, or data that failed a check.
enum class ErrorSource { kNetwork, kServer, kCheck };

struct ClientError {
  ErrorSource source = ErrorSource::kNetwork;
  Error error;
};

template <typename T>
using ClientResult = tl::expected<T, ClientError>;

[[nodiscard]] inline tl::unexpected<ClientError> fail(ErrorSource source, Error error) {
  return tl::unexpected(ClientError{source, std::move(error)});
}

struct ClientOptions {
  // The longest time without progress of a request. A stream may be without for ten times as long
  // while its server answers pings.
  std::chrono::milliseconds timeout{60'000};
  // The longest time of a request other than a stream, such as listing all datasets.
  std::chrono::milliseconds request_time{600'000};
  // The time limit for the whole conversation; nullopt: none.
  std::optional<std::chrono::steady_clock::time_point> deadline = {};
  std::string agent = "multitetra-client/" MULTITETRA_VERSION;
  std::string token = {};
  Trust trust = {};  // For tls:// and wss://.
  // Must include Draco.
  std::vector<PayloadCodec> codecs = {PayloadCodec::kDracoLattice, PayloadCodec::kSampleShell};
  AssemblerLimits limits = {};
  // Ends a wait with kCancelled and closes the connection.
  Interrupt interrupt = {};
};

// A step and its timing. Times count from sending the request and include lost connections.
struct FetchedStep {
  CommittedStepPtr step;
  // The time until the step's StepBegin.
  double first_byte_seconds = 0;
  // The time until the step was complete and checked.
  double seconds = 0;
};

// Received tiles, including those of unfinished steps.
struct ReceivedTiles {
  std::uint64_t tiles = 0;
  std::uint64_t payload_bytes = 0;
};

// Called with a tile that matches its summary, its step and payload. Shells are decoded later.
using TileListener =
    std::function<void(const TileSummary& tile, const StepBegin& step, const std::string& payload)>;

struct FetchOptions {
  // The retries after a lost connection; every new tile resets their count.
  RetryOptions retries = {};
  // The cache of received tiles; null: one for this fetch only.
  DecodedTileCache* tiles = nullptr;
  TileListener on_tile = {};
};

class Client {
 public:
  // Connects and exchanges Hello and Welcome.
  [[nodiscard]] static ClientResult<Client> connect(const Endpoint& server, ClientOptions options);
  // Reconnects after the connection was lost. Replies that were pending are lost.
  [[nodiscard]] ClientResult<void> reconnect();

  [[nodiscard]] ClientResult<std::vector<DatasetInfo>> list_datasets();

  // Estimates the size of the reply to a request.
  [[nodiscard]] ClientResult<EstimateReply> estimate(const std::string& dataset,
                                                     const IsosurfaceRequest& request);

  // Divides the common budget of the requests in proportion to the estimated sizes of their
  // replies; `datasets[i]` is the dataset of `requests[i]`. Requires check_shared_budget
  // (common/request/shared_budget.hpp).
  [[nodiscard]] ClientResult<void> share_budget(std::span<const std::string> datasets,
                                                std::span<IsosurfaceRequest> requests);

  // Samples the field on a plane. The reply has as many pixels as requested.
  [[nodiscard]] ClientResult<SliceReply> slice(const std::string& dataset,
                                               const SliceRequest& request);
  // Samples the field at the given places. The reply has as many values as requested.
  [[nodiscard]] ClientResult<ProbeReply> probe(const std::string& dataset,
                                               const ProbeRequest& request);

  // Runs one stream to its end, calls `on_step` once for each step that passed all checks, and
  // returns the final step. Fills in the request id and the held digests of `open`. After a lost
  // connection it reconnects and repeats the request, naming the tiles it holds, so that no tile is
  // sent twice as long as at most kMaxHeldDigests are held (see DecodedTileCache::digests_to_name).
  [[nodiscard]] ClientResult<FetchedStep> fetch(
      const DatasetInfo& info, OpenStream open,
      const std::function<void(const FetchedStep&)>& on_step, const FetchOptions& options = {});

  // ---- the conversation, for surface_stream.hpp

  [[nodiscard]] ClientResult<void> send(const ClientMessage& message);
  // Returns nullopt when no whole message arrived within `max_wait`. Pings a server that has been
  // silent for half of the timeout, to distinguish a busy server from a lost one.
  [[nodiscard]] ClientResult<std::optional<ServerMessage>> receive_within(
      std::chrono::milliseconds max_wait);
  [[nodiscard]] std::uint64_t next_request_id() { return ++last_request_id_; }
  [[nodiscard]] const ClientOptions& options() const { return options_; }

 private:
  [[nodiscard]] std::chrono::steady_clock::time_point request_ends() const {
    return std::chrono::steady_clock::now() + options_.request_time;
  }
  Client(Endpoint server, TlsContextPtr tls, MessageSocket socket, ClientOptions options);

  Endpoint server_;
  TlsContextPtr tls_;  // Null without TLS.
  MessageSocket socket_;
  ClientOptions options_;
  std::uint64_t last_request_id_ = 0;
  std::chrono::steady_clock::time_point next_ping_at_ = {};  // Unless a message arrives before.
};

}  // namespace multitetra
