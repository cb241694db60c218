// One client's conversation as pure logic: messages in, actions out. It uses no socket, no thread
// and no clock; the owner of the connection performs the actions in their order.
//
//   Session session(catalogue, {});
//   for (const Action& action : session.receive(message)) perform(action);
//
// Guarantees: at most one stream runs at a time, StopStream always names the one that runs, and
// nothing follows a Close. A bad request is answered with an ErrorReply and changes nothing else:
// not even its request id is used up.
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
#include "server/service/permit.hpp"

namespace multitetra {

struct Send {
  ServerMessage message;
};
// Drop what is left of the running stream; its last message is StreamEnd with this outcome.
struct StopStream {
  std::uint64_t request_id = 0;
  StreamOutcome outcome = StreamOutcome::kCancelled;
};
// Send all earlier messages, then close the connection.
struct Close {
  std::string reason;  // For the log.
};
using Action = std::variant<Send, StartStream, RunQuery, StopStream, Close>;
using Actions = std::vector<Action>;

struct SessionOptions {
  std::string agent = "multitetra-server/" MULTITETRA_VERSION;  // Sent in Welcome.
  // After Welcome.
  std::size_t max_message_bytes = kMaxClientFrameBytes;
  std::size_t max_held_digests = kMaxHeldDigests;  // In one OpenStream.
  std::size_t max_queries = 4;                     // Answered at the same time.
};

class Session {
 public:
  // The catalogue that there is now, where it may change.
  using LatestCatalogue = std::function<CataloguePtr()>;

  // `access` has the datasets that each token may see; null: all. Without `latest` the catalogue is
  // constant; with it a client has the datasets as they were when it last listed them.
  Session(CataloguePtr catalogue, SessionOptions options, AccessListPtr access = nullptr,
          LatestCatalogue latest = {}, RequestLimits limits = {});

  // A message that parsed.
  [[nodiscard]] Actions receive(const ClientMessage& message);
  // A whole frame whose content is no message, or has a field outside its range.
  [[nodiscard]] Actions receive(const ParseError& error);
  // The connection must end: a broken frame, a handshake that takes too long, a server that
  // stops.
  [[nodiscard]] Actions end(const Error& error);
  // Another list holds from now on: a client whose token it does not know any more is sent away.
  // Running requests continue.
  [[nodiscard]] Actions renew(AccessListPtr access);
  // The catalogue of this client, where it is determined after its Hello: before that is received.
  void offer(CataloguePtr catalogue) { catalogue_ = std::move(catalogue); }
  // From now on every stream and query is refused with this error.
  void refuse_work(Error why) { permit_.refuse_work(std::move(why)); }

  // The running stream has sent its last message.
  void stream_ended(std::uint64_t request_id);
  // A query was answered.
  void query_ended() { --queries_; }

  [[nodiscard]] std::uint32_t max_message_bytes() const {
    return static_cast<std::uint32_t>(options_.max_message_bytes);
  }
  [[nodiscard]] bool is_welcomed() const { return is_welcomed_; }
  [[nodiscard]] bool is_closed() const { return is_closed_; }
  [[nodiscard]] const AccessListPtr& access() const { return access_; }
  [[nodiscard]] const Permit& permit() const { return permit_; }  // After Welcome.

 private:
  Actions answer(const Hello& hello);
  Actions answer(const ListDatasets& list);
  Actions answer(const OpenStream& open);
  Actions answer(const Cancel& cancel);
  Actions answer(const Ping& ping);
  Actions answer(const Estimate& estimate);
  Actions answer(const Slice& slice);
  Actions answer(const Probe& probe);
  Actions ask(DatasetQuery query);

  CataloguePtr catalogue_;
  LatestCatalogue latest_;  // May be empty.
  SessionOptions options_;
  RequestLimits limits_;
  AccessListPtr access_;
  Permit permit_;  // After Welcome.
  bool is_welcomed_ = false;
  bool is_closed_ = false;
  // The largest id of all streams so far.
  std::uint64_t last_request_id_ = 0;
  std::optional<std::uint64_t> running_;  // The stream that runs.
  std::size_t queries_ = 0;               // Queries that are being answered.
};

}  // namespace multitetra
