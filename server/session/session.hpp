// One client's conversation as pure logic: messages in, actions out. It knows no socket, no thread
// and no clock; whoever owns the connection performs the actions in their order.
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
#include "server/stream/dataset_catalogue.hpp"
#include "server/stream/questions.hpp"

namespace multitetra {

struct Send {
  ServerMessage message;
};
// Begin the stream of a request that was found good.
struct StartStream {
  OpenStream open;
  std::shared_ptr<const StepSource> source;
  std::shared_ptr<const StepSource> scalars = nullptr;  // Of open.scalars; null without.
};
// Find the answer to a question that was found good, and send it.
struct AnswerQuestion {
  Question question;
  std::shared_ptr<const StepSource> source;
};
// Drop what is left of the running stream; its last message is StreamEnd with this outcome.
struct StopStream {
  std::uint64_t request_id = 0;
  StreamOutcome outcome = StreamOutcome::kCancelled;
};
// Send what was said before, then end the connection.
struct Close {
  std::string reason;  // For the log.
};
using Action = std::variant<Send, StartStream, AnswerQuestion, StopStream, Close>;
using Actions = std::vector<Action>;

struct SessionOptions {
  std::string agent = "multitetra-server/" MULTITETRA_VERSION;  // Told in Welcome.
  std::uint32_t max_message_bytes = kMaxClientFrameBytes;       // Told in Welcome.
  std::size_t max_held_digests = kMaxHeldDigests;               // In one OpenStream.
  std::size_t max_questions = 4;                                // Answered at the same time.
  std::size_t max_regions = kMaxThresholdRegions;               // Of one threshold map.
};

// What is wrong with a request that is beyond what this server allows, though the protocol would
// allow it.
[[nodiscard]] Result<void> check_limits(const SessionOptions& options,
                                        const IsosurfaceRequest& request);

class Session {
 public:
  // The catalogue that there is now, where it may change.
  using LatestCatalogue = std::function<CataloguePtr()>;

  // `access` says what a client may see by the token of its Hello; null: everything. Without
  // `latest` the catalogue is always the same one; with it a client has the datasets as they were
  // when it last listed them, and knows of no other version.
  Session(CataloguePtr catalogue, SessionOptions options, AccessListPtr access = nullptr,
          LatestCatalogue latest = {});

  // A message that parsed.
  [[nodiscard]] Actions receive(const ClientMessage& message);
  // A whole frame whose content is no message, or has a field outside its range.
  [[nodiscard]] Actions receive(const ParseError& error);
  // The connection cannot go on: a broken frame, a handshake that takes too long, a server that
  // stops.
  [[nodiscard]] Actions end(const Error& error);
  // Another list holds from now on: a client whose token it does not know any more is sent away.
  // What runs goes on.
  [[nodiscard]] Actions renew(AccessListPtr access);
  // What there is for this client, where that is found out when it says Hello: before that is
  // received.
  void offer(CataloguePtr catalogue) { catalogue_ = std::move(catalogue); }
  // From now on every stream and question is refused with this error.
  void refuse_work(Error why) { no_work_ = std::move(why); }

  // The running stream has sent its last message.
  void stream_ended(std::uint64_t request_id);
  // A question was answered.
  void question_ended() { --questions_; }

  [[nodiscard]] bool is_welcomed() const { return is_welcomed_; }
  [[nodiscard]] bool is_closed() const { return is_closed_; }
  [[nodiscard]] const AccessListPtr& access() const { return access_; }
  [[nodiscard]] const AccessRights& rights() const { return rights_; }  // Of a welcomed client.
  // Whether those are the rights of a token that it showed.
  [[nodiscard]] bool has_token() const { return access_ && !token_.empty(); }

 private:
  Actions answer(const Hello& hello);
  Actions answer(const ListDatasets& list);
  Actions answer(const OpenStream& open);
  Actions answer(const Cancel& cancel);
  Actions answer(const Ping& ping);
  Actions answer(const Estimate& estimate);
  Actions answer(const Slice& slice);
  Actions answer(const Probe& probe);
  // `source` is where the question finds its answer, or why it cannot.
  Actions ask(Question question, Result<std::shared_ptr<const StepSource>> source);
  // A dataset that there is for this client, or why there is none.
  [[nodiscard]] Result<std::shared_ptr<const StepSource>> source_of(
      const std::string& dataset) const;
  // The field that shall colour a surface.
  [[nodiscard]] Result<std::shared_ptr<const StepSource>> field_for(
      const ScalarRequest& scalars, const DatasetInfo& surface) const;
  // The same as source_of where a valid request for it can be met.
  [[nodiscard]] Result<std::shared_ptr<const StepSource>> source_of(
      const std::string& dataset, const IsosurfaceRequest& request) const;

  CataloguePtr catalogue_;
  LatestCatalogue latest_;  // May be empty.
  SessionOptions options_;
  AccessListPtr access_;
  std::string token_;    // Of Hello.
  AccessRights rights_;  // Of that token.
  std::optional<Error> no_work_;
  bool is_welcomed_ = false;
  bool is_closed_ = false;
  std::uint64_t last_request_id_ = 0;     // Of all streams ever started.
  std::optional<std::uint64_t> running_;  // The stream that runs.
  std::size_t questions_ = 0;             // That are being answered.
};

}  // namespace multitetra
