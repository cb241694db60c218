// The protocol for one client as pure logic: messages in, actions out. It uses no socket, thread or
// clock; the owner performs the actions in order.
//
//   Session session(catalogue, {});
//   for (const Action& action : session.receive(message)) perform(action);
//
// Guarantees: at most one stream runs at a time, StopStream always names the running one, and
// nothing follows a Close. An invalid request gets an ErrorReply and has no other effect; even its
// request id stays unused.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/net/frame.hpp"
#include "common/wire/messages.hpp"
#include "server/operations/access_list.hpp"
#include "server/service/client_access.hpp"

namespace multitetra {

struct Send {
  ServerMessage message;
};
// Drop the rest of the running stream and finish it with a StreamEnd of this outcome, or with an
// error.
struct StopStream {
  std::uint64_t request_id = 0;
  std::variant<StreamOutcome, Error> outcome = StreamOutcome::kCancelled;
};
// Send all earlier messages, then close the connection.
struct Close {
  std::string reason;  // For the log.
};
using Action = std::variant<Send, ValidatedStream, ValidatedQuery, StopStream, Close>;
using Actions = std::vector<Action>;

struct SessionOptions {
  std::string agent = "multitetra-server/" MULTITETRA_VERSION;  // Sent in Welcome.
  // The limit after Welcome.
  std::size_t max_message_bytes = kMaxClientFrameBytes;
  std::size_t max_held_digests = kMaxHeldDigests;  // Per OpenStream.
  std::size_t max_queries = 4;                     // Concurrent queries.
};

class Session {
 public:
  // Returns the current catalogue, if it can change.
  using LatestCatalogue = std::function<CataloguePtr()>;

  // `access` lists the datasets that each token may see; null: all. Without `latest` the catalogue
  // is constant; with it, a client keeps the datasets of its latest list, if it has requested one.
  Session(CataloguePtr catalogue, SessionOptions options, AccessListPtr access = nullptr,
          LatestCatalogue latest = {}, RequestLimits limits = {});

  [[nodiscard]] Actions receive(const ClientMessage& message);
  // Handles a complete frame with an invalid message or a field outside its range.
  [[nodiscard]] Actions receive(const ParseError& error);
  // Ends the connection: after a broken frame, a handshake timeout, or when the server stops.
  [[nodiscard]] Actions end(const Error& error);
  // Replaces the access list. Disconnects a client whose token is no longer in it; otherwise
  // running requests continue.
  [[nodiscard]] Actions renew(AccessListPtr access);
  // Sets the client's catalogue. Must be called before receive(Hello), which uses it.
  void offer(CataloguePtr catalogue) { catalogue_ = std::move(catalogue); }
  // Rejects all further streams and queries with this error.
  void reject_requests(Error why) { client_access_.reject_requests(std::move(why)); }

  // Reports that the running stream has sent its last message.
  void stream_ended(std::uint64_t request_id);
  void query_ended() { --queries_; }

  [[nodiscard]] std::uint32_t max_message_bytes() const {
    return static_cast<std::uint32_t>(options_.max_message_bytes);
  }
  [[nodiscard]] bool is_welcomed() const { return is_welcomed_; }
  [[nodiscard]] bool is_closed() const { return is_closed_; }
  [[nodiscard]] const AccessListPtr& access() const { return access_; }
  [[nodiscard]] const ClientAccess& client_access() const {
    return client_access_;
  }  // Valid after Welcome.

 private:
  Actions answer(const Hello& hello);
  Actions answer(const ListDatasets& list);
  Actions answer(const OpenStream& open);
  Actions answer(const Cancel& cancel);
  Actions answer(const Ping& ping);
  Actions answer(const Estimate& estimate);
  Actions answer(const Slice& slice);
  Actions answer(const Probe& probe);
  Actions accept_query(DatasetQuery query);
  void follow_latest();

  CataloguePtr catalogue_;
  LatestCatalogue latest_;  // May be empty.
  CataloguePtr listed_;  // The catalogue of the last list; null: none, or there are no later ones.
  SessionOptions options_;
  RequestLimits limits_;
  AccessListPtr access_;
  ClientAccess client_access_;
  bool is_welcomed_ = false;
  bool is_closed_ = false;
  // The largest id of all previous streams.
  std::uint64_t last_request_id_ = 0;
  std::optional<std::uint64_t> running_;
  std::size_t queries_ = 0;  // Queries in progress.
};

}  // namespace multitetra
