// A client of the service as a blocking library.
//
//   auto client = Client::connect({"127.0.0.1", 7410}, {});
//   auto datasets = client->list_datasets();
//   auto fetched = client->fetch(info, open, [](const FetchedStep& step) { ... });
//
// fetch.hpp returns the steps of a request one by one; surface_stream.hpp is for viewers, which
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
[[nodiscard]] inline tl::unexpected<ClientError> client_error(ErrorSource kind, Error error) {
  return tl::unexpected(ClientError{kind, std::move(error)});
}

template <typename T>
using ClientResult = tl::expected<T, ClientError>;

[[nodiscard]] inline tl::unexpected<ClientError> fail(ErrorSource source, Error error) {
  return tl::unexpected(ClientError{source, std::move(error)});
}

struct ClientOptions {
  // The longest time without a message. A server that answers pings is left after ten times as long
  // without progress.
  std::chrono::milliseconds timeout{60'000};
  // When everything must be over, however much comes until then; none: whenever it is.
  std::optional<std::chrono::steady_clock::time_point> deadline = {};
  std::string agent = "multitetra-client/" MULTITETRA_VERSION;
  std::string token = {};
  Trust trust = {};  // For tls:// and wss://.
  // Draco must be among them.
  std::vector<PayloadCodec> codecs = {PayloadCodec::kDracoLattice, PayloadCodec::kSampleShell};
  AssemblerLimits limits = {};
  Interrupt interrupt = {};  // Ends a wait with kCancelled, and the connection with it.
};

// A step with what it took to get it. Times count from sending the request, lost connections
// included.
struct FetchedStep {
  CommittedStepPtr step;
  double first_byte_seconds = 0;  // Until the step's StepBegin.
  double seconds = 0;             // Until the step was complete and checked.
};

// Tiles that travelled, whether or not their steps were completed.
struct ReceivedTiles {
  std::uint64_t tiles = 0;
  std::uint64_t payload_bytes = 0;
};

// Gets a tile that has what was promised of it, its step, and its bytes. Those of sample shells are
// decoded later.
using TileListener =
    std::function<void(const TileSummary& tile, const StepBegin& step, const std::string& payload)>;

struct FetchOptions {
  RetryOptions retries = {};          // After a lost connection; a new tile is progress.
  DecodedTileCache* tiles = nullptr;  // The cache of received tiles; null: one for this fetch.
  TileListener on_tile = {};
};

class Client {
 public:
  // Connects and exchanges Hello and Welcome.
  [[nodiscard]] static ClientResult<Client> connect(const Endpoint& server, ClientOptions options);
  // The same again, after the connection was lost. Nothing that was under way comes any more.
  [[nodiscard]] ClientResult<void> reconnect();

  [[nodiscard]] ClientResult<std::vector<DatasetInfo>> list_datasets();

  // Estimates the size of the reply to a request.
  [[nodiscard]] ClientResult<EstimateReply> estimate(const std::string& dataset,
                                                     const IsosurfaceRequest& request);

  // Divides the budget of the requests, which all have the same, by the estimated sizes of their
  // answers. Requires check_shared_budget (common/request/shared_budget.hpp).
  [[nodiscard]] ClientResult<void> share_budget(const std::string& dataset,
                                                std::vector<IsosurfaceRequest>& requests);

  // The field on a plane. The reply has as many pixels as requested.
  [[nodiscard]] ClientResult<SliceReply> slice(const std::string& dataset,
                                               const SliceRequest& request);
  // The field at some places. The reply has as many as requested.
  [[nodiscard]] ClientResult<ProbeReply> probe(const std::string& dataset,
                                               const ProbeRequest& request);

  // Runs one stream to its end and calls `on_step` with each step that passed all checks, once.
  // When the connection is lost it reconnects and repeats the request, naming the tiles that it
  // has: no tile is sent twice (as long as no more than kMaxHeldDigests are held, see
  // DecodedTileCache::digests_to_name). `open` gets its request id and the digests held here. Gives
  // the final step.
  [[nodiscard]] ClientResult<FetchedStep> fetch(
      const DatasetInfo& info, OpenStream open,
      const std::function<void(const FetchedStep&)>& on_step, const FetchOptions& options = {});

  // ---- the conversation itself, for surface_stream.hpp

  [[nodiscard]] ClientResult<void> send(const ClientMessage& message);
  // nullopt when no whole message came within `patience`. A server that is silent for half of
  // the timeout is pinged, to distinguish a busy server from a lost one.
  [[nodiscard]] ClientResult<std::optional<ServerMessage>> receive_within(
      std::chrono::milliseconds max_wait);
  [[nodiscard]] std::uint64_t next_request_id() { return ++last_request_id_; }
  [[nodiscard]] const ClientOptions& options() const { return options_; }

 private:
  Client(Endpoint server, TlsContextPtr tls, MessageSocket socket, ClientOptions options);

  Endpoint server_;
  TlsContextPtr tls_;  // Null without TLS.
  MessageSocket socket_;
  ClientOptions options_;
  std::uint64_t last_request_id_ = 0;
  std::chrono::steady_clock::time_point next_ping_at_ = {};  // When it is silent until then.
};

}  // namespace multitetra
